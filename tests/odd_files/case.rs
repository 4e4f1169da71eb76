//! A file of the corpus, and what is asked of it.

use sha2::{Digest, Sha256};

/// A file, made by the tests, and what it shall be to us.
pub struct Case {
    /// Where it stands below the corpus: its folder says its kind.
    pub name: String,
    /// Its content.
    pub bytes: Vec<u8>,
    /// What is asked.
    pub stance: Stance,
}

/// What a file shall be to us.
pub enum Stance {
    /// Read, as most of the independent readers read it: at least two.
    Read,
    /// Read as this reader reads it, which is not what most do, or which nobody else reads; and
    /// why.
    ReadAs(&'static str, &'static str),
    /// Refused with a line that holds all of these; and why.
    Refused(&'static [&'static str], &'static str),
}

impl Case {
    pub fn new(name: impl Into<String>, content: impl Into<Vec<u8>>) -> Self {
        Self {
            name: name.into(),
            bytes: content.into(),
            stance: Stance::Read,
        }
    }

    /// The same with its text changed.
    pub fn with(self, change: impl Fn(String) -> String) -> Self {
        let text = String::from_utf8(self.bytes).expect("a text");
        Self {
            bytes: change(text).into_bytes(),
            ..self
        }
    }

    pub fn read_as(self, reader: &'static str, why: &'static str) -> Self {
        Self {
            stance: Stance::ReadAs(reader, why),
            ..self
        }
    }

    pub fn refused(self, parts: &'static [&'static str], why: &'static str) -> Self {
        Self {
            stance: Stance::Refused(parts, why),
            ..self
        }
    }

    /// Kind of file: the folder that it stands in.
    pub fn kind(&self) -> &str {
        self.name.split('/').next().unwrap_or_default()
    }

    /// Says whether the table was made of this very content.
    pub fn digest(&self) -> String {
        Sha256::digest(&self.bytes)
            .iter()
            .take(8)
            .map(|byte| format!("{byte:02x}"))
            .collect()
    }
}

/// Surfaces that several formats write.
pub mod triangles {
    type Point = [f64; 3];

    /// A ball of so many rings and segments, turned outwards.
    pub fn ball(radius: f64, rings: usize, segments: usize) -> Vec<[Point; 3]> {
        let at = |ring: usize, segment: usize| {
            let polar = std::f64::consts::PI * ring as f64 / rings as f64;
            let turn = std::f64::consts::TAU * (segment % segments) as f64 / segments as f64;
            // In steps that every machine's sine rounds to alike.
            [
                polar.sin() * turn.cos(),
                polar.sin() * turn.sin(),
                polar.cos(),
            ]
            .map(|c| (c * radius * 1048576.0).round() / 1048576.0)
        };
        let mut faces = Vec::new();
        for ring in 0..rings {
            for segment in 0..segments {
                let [a, b] = [at(ring, segment), at(ring, segment + 1)];
                let [c, d] = [at(ring + 1, segment), at(ring + 1, segment + 1)];
                if ring > 0 {
                    faces.push([a, c, b]);
                }
                if ring + 1 < rings {
                    faces.push([b, c, d]);
                }
            }
        }
        faces
    }
}
