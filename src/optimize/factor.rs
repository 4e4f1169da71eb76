//! The Cholesky factor of a matrix that grows and shrinks by single lines.

/// A line is dependent when its squared pivot is at most this part of its diagonal entry.
const DEPENDENT: f64 = 1e-10;

/// Lower triangle L of `M = L Lᵀ`, line after line.
#[derive(Clone, Debug, Default)]
pub struct Factor {
    entries: Vec<f64>,
    size: usize,
}

/// Where a line starts.
fn line(index: usize) -> usize {
    index * (index + 1) / 2
}

impl Factor {
    /// Lines.
    #[cfg(test)]
    pub fn len(&self) -> usize {
        self.size
    }

    /// Adds the line of M that starts with `column` and ends with `diagonal`, unless it depends on
    /// those before it: the pivot tells. Says whether it did. O(m²).
    pub fn append(&mut self, column: &[f64], diagonal: f64) -> bool {
        let start = self.entries.len();
        self.push_line(column);
        let line = &self.entries[start..];
        let pivot = diagonal - dot(line, line);
        // The pivot is what is left of the line beside those before it, so it is also the rank test: no
        // second decomposition is needed.
        let independent = diagonal > 0.0 && pivot > DEPENDENT * diagonal;
        if independent {
            self.entries.push(pivot.sqrt());
            self.size += 1;
        } else {
            self.entries.truncate(start);
        }
        independent
    }

    /// Pushes the entries of a new line left of the diagonal, by forward substitution.
    fn push_line(&mut self, column: &[f64]) {
        let start = self.entries.len();
        for (i, coupling) in column.iter().enumerate() {
            let known = dot(self.left_of_diagonal(i), &self.entries[start..]);
            let entry = (coupling - known) / self.diagonal(i);
            self.entries.push(entry);
        }
    }

    /// The entries of a line before its diagonal.
    #[inline]
    fn left_of_diagonal(&self, index: usize) -> &[f64] {
        &self.entries[line(index)..][..index]
    }

    fn diagonal(&self, index: usize) -> f64 {
        self.entries[line(index) + index]
    }

    /// Keeps the first `count` lines.
    pub fn truncate(&mut self, count: usize) {
        self.size = count.min(self.size);
        self.entries.truncate(line(self.size));
    }

    /// Takes a line and its column out of M, by turning the lines below back into a triangle.
    /// O(m²).
    pub fn remove(&mut self, index: usize) {
        for below in index + 1..self.size {
            self.move_up(below);
        }
        self.close_gap(index);
    }

    /// Line `below` moves up; its entry right of the new diagonal is turned away.
    fn move_up(&mut self, below: usize) {
        let upper = line(below) + below - 1;
        let rotation = Rotation::onto_first(self.entries[upper], self.entries[upper + 1]);
        for row in below..self.size {
            let at = line(row) + below - 1;
            let (x, y) = rotation.turn(self.entries[at], self.entries[at + 1]);
            self.entries[at] = x;
            self.entries[at + 1] = y;
        }
    }

    /// Drops line `index` and the last entry of each line below it.
    fn close_gap(&mut self, index: usize) {
        let mut end = line(index);
        for row in index + 1..self.size {
            self.entries
                .copy_within(line(row)..line(row) + row, end);
            end += row;
        }
        self.size -= 1;
        self.entries.truncate(end);
    }

    /// Solves `L Lᵀ x = b` in place.
    pub fn solve(&self, x: &mut [f64]) {
        self.solve_lower(x);
        self.solve_upper(x);
    }

    #[inline]
    fn solve_lower(&self, x: &mut [f64]) {
        for i in 0..x.len() {
            x[i] = (x[i] - dot(self.left_of_diagonal(i), &x[..i])) / self.diagonal(i);
        }
    }

    #[inline]
    fn solve_upper(&self, x: &mut [f64]) {
        for i in (0..x.len()).rev() {
            x[i] /= self.diagonal(i);
            let solved = x[i];
            let above = x[..i].iter_mut().zip(self.left_of_diagonal(i));
            above.for_each(|(x, entry)| *x -= entry * solved);
        }
    }
}

/// Σ aᵢ bᵢ.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// A Givens rotation of two columns.
struct Rotation {
    cosine: f64,
    sine: f64,
}

impl Rotation {
    /// Turns (a, b) onto the first axis.
    fn onto_first(a: f64, b: f64) -> Self {
        // `hypot` neither overflows nor loses small entries, as a sum of squares would.
        let length = a.hypot(b);
        Self {
            cosine: a / length,
            sine: b / length,
        }
    }

    #[inline]
    fn turn(&self, x: f64, y: f64) -> (f64, f64) {
        (
            self.cosine * x + self.sine * y,
            self.cosine * y - self.sine * x,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A random positive definite matrix, dense.
    fn matrix(seed: u64, size: usize) -> Vec<Vec<f64>> {
        let mut random = fastrand::Rng::with_seed(seed);
        let rows: Vec<Vec<f64>> = (0..size)
            .map(|_| {
                (0..size + 2)
                    .map(|_| random.f64() - 0.5)
                    .collect()
            })
            .collect();
        rows.iter()
            .map(|a| rows.iter().map(|b| dot(a, b)).collect())
            .collect()
    }

    proptest! {
        #[test]
        fn what_is_left_after_lines_are_removed_is_solved(seed: u64, size in 1usize..12, removals in 0usize..8) {
            let m = matrix(seed, size);
            let mut factor = Factor::default();
            for i in 0..size {
                prop_assert!(factor.append(&m[i][..i], m[i][i]));
            }
            let mut random = fastrand::Rng::with_seed(!seed);
            let mut left: Vec<usize> = (0..size).collect();
            for _ in 0..removals.min(size - 1) {
                let index = random.usize(..left.len());
                factor.remove(index);
                left.remove(index);
            }
            let x: Vec<f64> = left.iter().map(|_| random.f64() - 0.5).collect();
            let mut b: Vec<f64> =
                left.iter().map(|&i| left.iter().zip(&x).map(|(&j, x)| m[i][j] * x).sum()).collect();
            factor.solve(&mut b);
            prop_assert_eq!(factor.len(), left.len());
            for (found, x) in b.iter().zip(&x) {
                prop_assert!((found - x).abs() < 1e-6, "{found} instead of {x}");
            }
        }
    }
}
