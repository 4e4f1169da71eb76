//! Numbers in bytes, by what a file says of them.

use crate::math::Vec3;

/// How floats lie in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Floats {
    /// 4 or 8.
    pub size: usize,
    /// Whether the first byte weighs most.
    pub is_big_endian: bool,
}

impl Floats {
    /// The number that begins at an offset, whose bytes are there.
    pub fn at(self, bytes: &[u8], offset: usize) -> f64 {
        match self.size {
            4 => {
                let raw = self.raw::<4>(bytes, offset);
                f64::from(f32::from_le_bytes(raw))
            }
            _ => f64::from_le_bytes(self.raw::<8>(bytes, offset)),
        }
    }

    fn raw<const N: usize>(self, bytes: &[u8], offset: usize) -> [u8; N] {
        let mut raw = [0; N];
        raw.copy_from_slice(&bytes[offset..offset + N]);
        if self.is_big_endian {
            raw.reverse();
        }
        raw
    }
}

/// Where one coordinate of all points is: that of point `i` begins at `first + i * step`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Column {
    pub floats: Floats,
    pub first: usize,
    pub step: usize,
}

impl Column {
    fn at(&self, bytes: &[u8], index: usize) -> f64 {
        self.floats
            .at(bytes, self.first + index * self.step)
    }
}

/// The points of three columns, all of whose bytes are there.
pub(super) fn points<'a>(
    bytes: &'a [u8],
    columns: &'a [Column; 3],
    count: usize,
) -> impl Iterator<Item = Vec3> + 'a {
    let point = |index| Vec3::from_array(columns.each_ref().map(|c| c.at(bytes, index)));
    (0..count).map(point)
}

/// The three first words of a line as a point.
pub(super) fn point_of_words(words: [&str; 3]) -> Result<Vec3, String> {
    let mut point = [0.0; 3];
    for (number, word) in point.iter_mut().zip(words) {
        *number = word
            .parse()
            .map_err(|_| format!("{word:?} is no number"))?;
    }
    Ok(Vec3::from_array(point))
}

/// Refuses bytes that are not as many as what they say needs: up to `stray` more are harmless.
pub(super) fn check_size(given: usize, needed: usize, stray: usize) -> Result<(), String> {
    if (needed..=needed + stray).contains(&given) {
        return Ok(());
    }
    let what = if given < needed {
        "cut short"
    } else {
        "longer than it says"
    };
    Err(format!(
        "{what}: its points need {needed} bytes after the header, the file has {given}"
    ))
}
