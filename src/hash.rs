//! Content hashes: what a robot, a scene or a path is, whatever it is called.

use sha2::{Digest, Sha256};

use crate::math::{Pose, Vec3};
use crate::shape::{PlacedShape, Shape};

/// Vertices or triangles that are hashed by one call.
const PORTION: usize = 4096;

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
        for value in values {
            self.0.update(value.to_bits().to_le_bytes());
        }
        self
    }

    /// A number of things that follow.
    pub fn count(&mut self, count: usize) -> &mut Self {
        self.0.update((count as u64).to_le_bytes());
        self
    }

    /// A pose.
    pub fn pose(&mut self, pose: &Pose) -> &mut Self {
        self.floats(&pose.translation.to_array()).floats(&pose.rotation.to_array())
    }

    /// A placed shape, mesh content included, mesh name left out.
    pub fn shape(&mut self, placed: &PlacedShape) -> &mut Self {
        self.pose(&placed.pose);
        match &placed.shape {
            Shape::Mesh(mesh) => {
                self.text("mesh");
                self.0.update(mesh.hash().to_le_bytes());
            }
            primitive => {
                self.text(&format!("{primitive:?}"));
            }
        }
        self
    }

    /// Vertices and triangles of a mesh.
    pub fn mesh(&mut self, vertices: &[Vec3], triangles: &[[u32; 3]]) -> &mut Self {
        // In portions: a call for each number would cost more than the hash.
        for part in vertices.chunks(PORTION) {
            let numbers = part.iter().flat_map(|vertex| vertex.to_array());
            self.0.update(numbers.flat_map(|value| value.to_bits().to_le_bytes()).collect::<Vec<u8>>());
        }
        for part in triangles.chunks(PORTION) {
            let indices = part.iter().flatten();
            self.0.update(indices.flat_map(|index| index.to_le_bytes()).collect::<Vec<u8>>());
        }
        self
    }

    /// First 8 bytes of the SHA-256, so that the first hex digits of both agree.
    pub fn finish(self) -> u64 {
        self.0.finalize().iter().take(8).fold(0, |hash, byte| hash << 8 | u64::from(*byte))
    }
}
