//! How vertices and triangles become a mesh: merged, mended, without triangles that have no area.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use super::edges::{Edges, Triangle};
use super::mesh::{Mesh, MeshError, check, has_area};
use super::oddities::{self, Making};
use super::sides::{self, Mended};
use crate::math::Vec3;

impl Mesh {
    /// Checks and takes vertices and triangles.
    ///
    /// Vertices that are exactly equal are merged (STL repeats them) and degenerate triangles
    /// dropped. Triangles that come twice are kept once, and those that face another way than the
    /// surface around them are turned over.
    ///
    /// # Errors
    /// A vertex that is not finite, an index out of range, no triangle with an area.
    pub fn new(
        name: impl Into<String>,
        vertices: Vec<Vec3>,
        triangles: Vec<Triangle>,
    ) -> Result<Self, MeshError> {
        let name = name.into();
        check(&name, &vertices, &triangles)?;
        let (vertices, mut welded) = weld(&vertices, &triangles);
        let making = make(&vertices, &mut welded, triangles.len());
        if welded.is_empty() {
            return Err(MeshError::empty(name, triangles.len()));
        }
        let known = edges_then(making.dropped > 0, &welded, making.left);
        let mesh = Self::checked(name, vertices, welded, &known);
        let warnings = oddities::of(&mesh, &making);
        Ok(mesh.with_oddities(warnings))
    }
}

/// Mends the triangles and leaves out those without an area; `read` were there.
fn make(vertices: &[Vec3], triangles: &mut Vec<Triangle>, read: usize) -> Making {
    // Before slivers are dropped: they have no area, but they do close the surface.
    let edges = Edges::of(triangles);
    let mended = sides::mend(vertices, triangles, &edges);
    let left = edges_then(mended != Mended::default(), triangles, edges);
    let before = read - mended.repeated - mended.doubled;
    triangles.retain(|triangle| has_area(vertices, *triangle));
    Making {
        dropped: before - triangles.len(),
        edges,
        mended,
        left,
    }
}

/// The edges after a step: those known before, unless it has changed something.
fn edges_then(has_changed: bool, triangles: &[Triangle], before: Edges) -> Edges {
    if has_changed {
        Edges::of(triangles)
    } else {
        before
    }
}

/// Merges equal vertices and drops triangles that this leaves with two corners.
fn weld(vertices: &[Vec3], triangles: &[Triangle]) -> (Vec<Vec3>, Vec<Triangle>) {
    let mut places = Places::default();
    let merged: Vec<u32> = vertices
        .iter()
        .map(|vertex| places.of(*vertex))
        .collect();
    let renamed = triangles
        .iter()
        .map(|t| t.map(|i| merged[i as usize]));
    let left = renamed.filter(|[a, b, c]| a != b && b != c && c != a);
    (places.kept, left.collect())
}

/// Different places, in the order in which they come.
#[derive(Default)]
struct Places {
    known: HashMap<[u64; 3], u32, BuildHasherDefault<CoordinateHasher>>,
    kept: Vec<Vec3>,
}

impl Places {
    fn of(&mut self, vertex: Vec3) -> u32 {
        // Adding 0 makes one zero of both.
        let bits = vertex.to_array().map(|c| (c + 0.0).to_bits());
        *self.known.entry(bits).or_insert_with(|| {
            self.kept.push(vertex);
            (self.kept.len() - 1) as u32
        })
    }
}

/// Hashes the bits of coordinates: meshes have them by the hundred thousand, and nobody chooses
/// them to collide.
#[derive(Default)]
struct CoordinateHasher(u64);

impl Hasher for CoordinateHasher {
    fn write(&mut self, bytes: &[u8]) {
        for chunk in bytes.chunks(8) {
            let bytes = chunk.iter().rev();
            self.mix(bytes.fold(0, |word, byte| word << 8 | u64::from(*byte)));
        }
    }
    fn finish(&self) -> u64 {
        let mixed = self.0.wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ mixed >> 31
    }
}

impl CoordinateHasher {
    /// Steele, Lea and Flood's mixer (2014): coordinates that are round in binary differ in few
    /// bits.
    fn mix(&mut self, word: u64) {
        let mixed = (self.0 ^ word).wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (mixed ^ mixed >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        self.0 = mixed ^ mixed >> 27;
    }
}
