//! Content hashes: what a robot, a scene or a path is, whatever it is called.

use sha2::{Digest as _, Sha256};

use crate::math::{Pose, Vec3};

/// Vertices or triangles that are hashed by one call.
const PORTION: usize = 4096;

/// Numbers that are.
const NUMBERS: usize = 512;

/// Collects content; equal content gives equal hashes on every machine.
#[derive(Default)]
pub(crate) struct ContentHasher(Sha256);

impl ContentHasher {
    /// Text, closed by a zero byte so that neighbours cannot run together.
    pub fn text(&mut self, text: &str) -> &mut Self {
        self.0.update(text.as_bytes());
        self.0.update([0]);
        self
    }

    /// Exact bits of numbers.
    pub fn floats(&mut self, values: &[f64]) -> &mut Self {
        // In portions: a call for each number would cost more than the hash.
        let mut bytes = [0; 8 * NUMBERS];
        for part in values.chunks(NUMBERS) {
            for (bits, value) in bytes.chunks_exact_mut(8).zip(part) {
                bits.copy_from_slice(&value.to_bits().to_le_bytes());
            }
            self.0.update(&bytes[..8 * part.len()]);
        }
        self
    }

    /// Exact bits of single numbers.
    pub fn singles(&mut self, values: &[f32]) -> &mut Self {
        let mut bytes = [0; 4 * NUMBERS];
        for part in values.chunks(NUMBERS) {
            for (bits, value) in bytes.chunks_exact_mut(4).zip(part) {
                bits.copy_from_slice(&value.to_bits().to_le_bytes());
            }
            self.0.update(&bytes[..4 * part.len()]);
        }
        self
    }

    /// Bytes as they are.
    pub fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        self.0.update(bytes);
        self
    }

    /// A number of things that follow.
    pub fn count(&mut self, count: usize) -> &mut Self {
        self.0.update((count as u64).to_le_bytes());
        self
    }

    /// A whole number.
    pub fn number(&mut self, number: u64) -> &mut Self {
        self.0.update(number.to_le_bytes());
        self
    }

    /// A pose.
    pub fn pose(&mut self, pose: &Pose) -> &mut Self {
        self.floats(&pose.translation.to_array())
            .floats(&pose.rotation.to_array())
    }

    /// Vertices and triangles of a mesh.
    pub fn mesh(&mut self, vertices: &[Vec3], triangles: &[[u32; 3]]) -> &mut Self {
        // In portions: a call for each number would cost more than the hash.
        for part in vertices.chunks(PORTION) {
            let numbers = part.iter().flat_map(|vertex| vertex.to_array());
            self.0.update(
                numbers
                    .flat_map(|value| value.to_bits().to_le_bytes())
                    .collect::<Vec<u8>>(),
            );
        }
        for part in triangles.chunks(PORTION) {
            let indices = part.iter().flatten();
            self.0.update(
                indices
                    .flat_map(|index| index.to_le_bytes())
                    .collect::<Vec<u8>>(),
            );
        }
        self
    }

    /// A name, led by its length: whatever is in it, it cannot run into what follows.
    pub fn name(&mut self, name: &str) -> &mut Self {
        self.count(name.len());
        self.0.update(name.as_bytes());
        self
    }

    /// What a digest stands for.
    pub fn digest(&mut self, digest: &Digest) -> &mut Self {
        for word in digest {
            self.0.update(word.to_le_bytes());
        }
        self
    }

    /// First 8 bytes of the SHA-256, so that the first hex digits of both agree.
    pub fn finish(self) -> u64 {
        self.0
            .finalize()
            .iter()
            .take(8)
            .fold(0, |hash, byte| hash << 8 | u64::from(*byte))
    }

    /// All of the SHA-256.
    pub fn finish_digest(self) -> Digest {
        let bytes = self.0.finalize();
        let mut words = bytes.chunks_exact(8);
        std::array::from_fn(|_| {
            words.next().map_or(0, |word| {
                word.iter()
                    .rfold(0, |sum, &byte| sum << 8 | u64::from(byte))
            })
        })
    }
}

/// A number of a text, with a point or an exponent: the words of [`ContentHasher::text`] are hashed for
/// good, so no library chooses them.
pub(crate) fn number(value: f64) -> String {
    let is_plain = value == 0.0 || (1e-4..1e16).contains(&value.abs());
    match (is_plain || !value.is_finite(), value.fract() == 0.0) {
        (true, true) => format!("{value:.1}"),
        (true, false) => value.to_string(),
        (false, _) => format!("{value:e}"),
    }
}

/// A name within a text, in quotes, in the same words for good.
pub(crate) fn quoted(name: &str) -> String {
    let escaped = name.chars().map(|letter| match letter {
        '\'' => letter.to_string(),
        _ => letter.escape_debug().to_string(),
    });
    format!("\"{}\"", escaped.collect::<String>())
}

/// A SHA-256, its words from the least.
pub(crate) type Digest = [u64; 4];

/// A set of facts, whatever order they came in: the sum of their digests modulo 2^256, so that a
/// fact comes and goes without a look at the others. Two sets of one sum are as hard to find as two
/// contents of one 64-bit hash: about 2^32 steps either way (by Wagner's birthday for sums, and by
/// the plain one).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct FactSum(Digest);

impl FactSum {
    /// A fact comes.
    pub fn add(&mut self, fact: &Digest) {
        let mut carry = false;
        for (word, more) in self.0.iter_mut().zip(fact) {
            (*word, carry) = word.carrying_add(*more, carry);
        }
    }

    /// A fact that is in the set goes.
    pub fn subtract(&mut self, fact: &Digest) {
        let mut borrow = false;
        for (word, less) in self.0.iter_mut().zip(fact) {
            (*word, borrow) = word.borrowing_sub(*less, borrow);
        }
    }

    /// The sum.
    pub fn digest(&self) -> &Digest {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first hashes were of what the standard library prints.
    #[test]
    fn numbers_and_names_are_written_as_in_the_first_hashes() {
        let mut rng = fastrand::Rng::with_seed(7);
        let mut values = vec![
            0.0,
            -0.0,
            1.0,
            1e-4,
            9e-5,
            1e16,
            9.99e15,
            -2.5,
            f64::INFINITY,
        ];
        values.extend((0..2000).map(|_| f64::from_bits(rng.u64(..))));
        values.extend((0..2000).map(|_| (rng.f64() - 0.5) * 10_f64.powi(rng.i32(-8..20))));
        for value in values {
            assert_eq!(number(value), format!("{value:?}"));
        }
        for name in [
            "joint 1",
            "it's \"quoted\"",
            "tab\t\\",
            "größe",
            "e\u{301}",
            "\u{301}x",
        ] {
            assert_eq!(quoted(name), format!("{name:?}"));
        }
    }
}
