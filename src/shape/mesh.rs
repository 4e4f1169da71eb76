//! Triangle meshes: what a mesh file becomes once it is checked.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use super::oddities::{self, Edges, Making};
use super::sides::{self, Mended};
use crate::hash::ContentHasher;
use crate::math::Vec3;
use crate::warning::Warning;

/// A checked triangle mesh (m), scale already applied.
///
/// Every vertex is finite, every index in range, there is at least one triangle with an area.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    name: String,
    vertices: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    warnings: Vec<Warning>,
    has_inside: bool,
    // Kept: a scene that only moves a large mesh need not read all of it again.
    hash: u64,
}

/// Why a mesh was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// The file cannot be read or decoded.
    #[error("mesh {name}: {reason}")]
    Unreadable {
        /// File.
        name: String,
        /// What is wrong with it.
        reason: String,
    },
    /// No triangle with an area.
    #[error("mesh {name} has no triangle with an area ({triangles} triangles read)")]
    Empty {
        /// File.
        name: String,
        /// Triangles read before degenerate ones were dropped.
        triangles: usize,
    },
}

impl Mesh {
    /// File name, for messages.
    pub fn name(&self) -> &str {
        &self.name
    }
    /// Vertices (m) in the mesh's own frame.
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }
    /// Vertex indices of each triangle.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }
    /// What is odd about the mesh, a line each with its name and size: it may be in millimetres,
    /// its surface is open or faces inwards or both ways, some of its triangles have no area.
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// Whether the surface is closed, its triangles face the same way and it has a volume, so that
    /// every place is inside or outside for sure.
    pub fn has_inside(&self) -> bool {
        self.has_inside
    }

    /// Whether its surface, closed or not, has no volume on any side.
    pub(super) fn encloses_nothing(&self) -> bool {
        sides::is_flat(&self.vertices, &self.triangles)
    }

    /// The same mesh with more to say about the file that it was read from.
    #[must_use]
    pub(super) fn with_warnings(mut self, words: Vec<String>) -> Self {
        let name = &self.name;
        self.warnings.extend(
            words
                .into_iter()
                .map(|text| Warning::uncovered(format!("mesh {name} {text}"))),
        );
        self
    }

    /// Hash of vertices and triangles, whatever the file is called.
    pub fn hash(&self) -> u64 {
        self.hash
    }

    /// One vertex of every connected part of the surface.
    pub fn parts(&self) -> Vec<Vec3> {
        let mut parent: Vec<usize> = (0..self.vertices.len()).collect();
        fn root(parent: &mut [usize], mut i: usize) -> usize {
            while parent[i] != i {
                parent[i] = parent[parent[i]];
                i = parent[i];
            }
            i
        }
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|i| root(&mut parent, i as usize));
            let least = a.min(b).min(c);
            parent[a] = least;
            parent[b] = least;
            parent[c] = least;
        }
        let mut used: Vec<usize> = self
            .triangles
            .iter()
            .map(|t| root(&mut parent, t[0] as usize))
            .collect();
        used.sort_unstable();
        used.dedup();
        used.into_iter().map(|i| self.vertices[i]).collect()
    }

    /// Volume that the surface encloses (m³); negative where its triangles face inwards.
    pub fn signed_volume(&self) -> f64 {
        sides::volume(&self.vertices, self.triangles.iter())
    }

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
        triangles: Vec<[u32; 3]>,
    ) -> Result<Self, MeshError> {
        let name = name.into();
        check(&name, &vertices, &triangles)?;
        let (vertices, mut welded) = weld(&vertices, &triangles);
        // Before slivers are dropped: they have no area, but they do close the surface.
        let edges = Edges::of(&welded);
        let mended = sides::mend(&vertices, &mut welded, &edges);
        let left = if mended == Mended::default() {
            edges
        } else {
            Edges::of(&welded)
        };
        let before = triangles.len() - mended.repeated - mended.doubled;
        welded.retain(|t| has_area(&vertices, *t));
        if welded.is_empty() {
            return Err(MeshError::Empty {
                name,
                triangles: triangles.len(),
            });
        }
        let dropped = before - welded.len();
        let known = if dropped == 0 {
            left
        } else {
            Edges::of(&welded)
        };
        let mut mesh = Self::checked(name, vertices, welded, &known);
        mesh.warnings = oddities::of(
            &mesh,
            &Making {
                edges,
                dropped,
                mended,
                left,
            },
        );
        Ok(mesh)
    }

    /// A mesh as [`Self::new`] made it once, from what was kept of it: nothing is merged or dropped
    /// again, and `warnings` are what was found odd then.
    ///
    /// # Errors
    /// As [`Self::new`], and a triangle without an area, which no such mesh has.
    pub fn restore(
        name: String,
        vertices: Vec<Vec3>,
        triangles: Vec<[u32; 3]>,
        warnings: Vec<Warning>,
    ) -> Result<Self, MeshError> {
        check(&name, &vertices, &triangles)?;
        if let Some(bad) = triangles.iter().position(|t| !has_area(&vertices, *t)) {
            return Err(MeshError::Unreadable {
                name,
                reason: format!("triangle {bad} has no area"),
            });
        }
        if triangles.is_empty() {
            return Err(MeshError::Empty { name, triangles: 0 });
        }
        let edges = Edges::of(&triangles);
        Ok(Self {
            warnings,
            ..Self::checked(name, vertices, triangles, &edges)
        })
    }

    fn checked(name: String, vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>, edges: &Edges) -> Self {
        let hash = hash_of(&vertices, &triangles);
        let has_inside = edges.open + edges.turned == 0 && !sides::is_flat(&vertices, &triangles);
        Self {
            name,
            vertices,
            triangles,
            warnings: Vec::new(),
            has_inside,
            hash,
        }
    }
}

fn check(name: &str, vertices: &[Vec3], triangles: &[[u32; 3]]) -> Result<(), MeshError> {
    let refuse = |reason| {
        Err(MeshError::Unreadable {
            name: name.to_owned(),
            reason,
        })
    };
    if let Some(bad) = vertices.iter().position(|v| !v.is_finite()) {
        return refuse(format!("vertex {bad} is not finite"));
    }
    let in_range = |t: &[u32; 3]| t.iter().all(|&i| (i as usize) < vertices.len());
    if let Some(bad) = triangles.iter().position(|t| !in_range(t)) {
        return refuse(format!(
            "triangle {bad} names a vertex beyond the {} read",
            vertices.len()
        ));
    }
    Ok(())
}

fn has_area(vertices: &[Vec3], triangle: [u32; 3]) -> bool {
    let [a, b, c] = corners(vertices, triangle);
    (b - a).cross(c - a).length() > 0.0
}

fn hash_of(vertices: &[Vec3], triangles: &[[u32; 3]]) -> u64 {
    let mut hasher = ContentHasher::default();
    hasher.mesh(vertices, triangles);
    hasher.finish()
}

/// Merges equal vertices and drops triangles that this leaves with two corners.
fn weld(vertices: &[Vec3], triangles: &[[u32; 3]]) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut known: HashMap<[u64; 3], u32, BuildHasherDefault<CoordinateHasher>> =
        HashMap::default();
    let mut kept = Vec::new();
    let merged: Vec<u32> = vertices
        .iter()
        .map(|vertex| {
            // Adding 0 makes one zero of both.
            *known
                .entry(vertex.to_array().map(|c| (c + 0.0).to_bits()))
                .or_insert_with(|| {
                    kept.push(*vertex);
                    (kept.len() - 1) as u32
                })
        })
        .collect();
    let renamed = triangles.iter().map(|t| t.map(|i| merged[i as usize]));
    (
        kept,
        renamed
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .collect(),
    )
}

fn corners(vertices: &[Vec3], triangle: [u32; 3]) -> [Vec3; 3] {
    triangle.map(|i| vertices[i as usize])
}

/// Hashes the bits of coordinates: meshes have them by the hundred thousand, and nobody chooses
/// them to collide.
#[derive(Default)]
struct CoordinateHasher(u64);

impl Hasher for CoordinateHasher {
    fn write(&mut self, bytes: &[u8]) {
        bytes.chunks(8).for_each(|chunk| {
            let word = chunk
                .iter()
                .rev()
                .fold(0, |word, byte| word << 8 | u64::from(*byte));
            // Steele, Lea and Flood's mixer (2014): coordinates that are round in binary differ in
            // few bits.
            let mixed = (self.0 ^ word).wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mixed = (mixed ^ mixed >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            self.0 = mixed ^ mixed >> 27;
        });
    }
    fn finish(&self) -> u64 {
        let mixed = self.0.wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ mixed >> 31
    }
}
