//! The matrix `M = J H⁻¹ Jᵀ` of half-spaces, which grows by a line at a time.

/// A symmetric matrix, all of it: a line is what every row feels of one.
#[derive(Clone, Debug, Default)]
pub struct Gram {
    entries: Vec<f64>,
    /// Numbers between the beginnings of two lines.
    stride: usize,
    size: usize,
}

impl Gram {
    /// Forgets all lines, but keeps its memory.
    pub fn clear(&mut self) {
        self.size = 0;
    }

    /// What each row feels of one, in order.
    pub fn line(&self, row: usize) -> &[f64] {
        &self.entries[row * self.stride..][..self.size]
    }

    /// The entry at two rows.
    pub fn entry(&self, a: usize, b: usize) -> f64 {
        self.entries[a * self.stride + b]
    }

    /// Adds a line: the entries with the rows before it, then that on the diagonal.
    pub fn push(&mut self, couplings: impl Iterator<Item = f64>, diagonal: f64) {
        let new = self.size;
        self.make_room();
        for (row, entry) in couplings
            .chain(std::iter::once(diagonal))
            .enumerate()
        {
            self.entries[new * self.stride + row] = entry;
            self.entries[row * self.stride + new] = entry;
        }
        self.size += 1;
    }

    fn make_room(&mut self) {
        if self.size < self.stride {
            return;
        }
        let stride = (2 * self.stride).max(32);
        let mut wider = vec![0.0; stride * stride];
        for row in 0..self.size {
            wider[row * stride..][..self.size].copy_from_slice(self.line(row));
        }
        self.entries = wider;
        self.stride = stride;
    }
}
