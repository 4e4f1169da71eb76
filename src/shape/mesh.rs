//! Triangle meshes: what a mesh file becomes once it is checked.

use std::collections::HashMap;

use crate::hash::ContentHasher;
use crate::math::Vec3;

/// A mesh larger than this (m) was probably drawn in millimetres.
const SUSPICIOUS_SIZE_M: f64 = 10.0;

/// A checked triangle mesh (m), scale already applied.
///
/// Every vertex is finite, every index in range, there is at least one triangle with an area.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    name: String,
    vertices: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    warnings: Vec<String>,
    // Kept: a scene that only moves a large mesh need not read all of it again.
    hash: u64,
}

/// Why a mesh was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
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
    /// What is odd about the mesh, a line each: its size, holes in its surface, a surface turned inside out.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
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
            (parent[a], parent[b], parent[c]) = (least, least, least);
        }
        let mut used: Vec<usize> = self.triangles.iter().map(|t| root(&mut parent, t[0] as usize)).collect();
        used.sort_unstable();
        used.dedup();
        used.into_iter().map(|i| self.vertices[i]).collect()
    }

    /// Volume that the surface encloses (m³); negative where its triangles face inwards.
    pub fn signed_volume(&self) -> f64 {
        let origin = self.vertices[self.triangles[0][0] as usize];
        let six_fold = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| self.vertices[i as usize] - origin);
            a.dot(b.cross(c))
        };
        self.triangles.iter().map(six_fold).sum::<f64>() / 6.0
    }

    /// Checks and takes vertices and triangles.
    ///
    /// Vertices that are exactly equal are merged (STL repeats them) and degenerate triangles dropped.
    ///
    /// # Errors
    /// A vertex that is not finite, an index out of range, no triangle with an area.
    pub fn new(name: impl Into<String>, vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        let name = name.into();
        if let Some(bad) = vertices.iter().position(|v| !v.is_finite()) {
            return Err(MeshError::Unreadable { name, reason: format!("vertex {bad} is not finite") });
        }
        let in_range = |t: &[u32; 3]| t.iter().all(|&i| (i as usize) < vertices.len());
        if let Some(bad) = triangles.iter().position(|t| !in_range(t)) {
            let reason = format!("triangle {bad} names a vertex beyond the {} read", vertices.len());
            return Err(MeshError::Unreadable { name, reason });
        }
        let (vertices, mut welded) = weld(&vertices, &triangles);
        // Before slivers are dropped: they have no area, but they do close the surface.
        let edges = edges(&welded);
        let area = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a).length();
        welded.retain(|t| area(corners(&vertices, *t)) > 0.0);
        if welded.is_empty() {
            return Err(MeshError::Empty { name, triangles: triangles.len() });
        }
        let mut hasher = ContentHasher::default();
        hasher.mesh(&vertices, &welded);
        let mut mesh = Self { name, vertices, triangles: welded, warnings: Vec::new(), hash: hasher.finish() };
        mesh.warnings = oddities(&mesh, edges);
        Ok(mesh)
    }
}

/// Merges equal vertices and drops triangles that this leaves with two corners.
fn weld(vertices: &[Vec3], triangles: &[[u32; 3]]) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut known: HashMap<[u64; 3], u32> = HashMap::with_capacity(vertices.len());
    let mut kept = Vec::new();
    let merged: Vec<u32> = vertices
        .iter()
        .map(|vertex| {
            // Adding 0 makes one zero of both.
            *known.entry(vertex.to_array().map(|c| (c + 0.0).to_bits())).or_insert_with(|| {
                kept.push(*vertex);
                (kept.len() - 1) as u32
            })
        })
        .collect();
    let renamed = triangles.iter().map(|t| t.map(|i| merged[i as usize]));
    (kept, renamed.filter(|[a, b, c]| a != b && b != c && c != a).collect())
}

fn corners(vertices: &[Vec3], triangle: [u32; 3]) -> [Vec3; 3] {
    triangle.map(|i| vertices[i as usize])
}

fn oddities(mesh: &Mesh, (edges, open): (usize, usize)) -> Vec<String> {
    let (mut found, name) = (Vec::new(), &mesh.name);
    let bounds = |(low, high): (Vec3, Vec3), v: &Vec3| (low.min(*v), high.max(*v));
    let (low, high) = mesh.vertices.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), bounds);
    let size = high - low;
    if size.max_element() > SUSPICIOUS_SIZE_M {
        let text = format!("is {:.1} × {:.1} × {:.1} m large", size.x, size.y, size.z);
        found.push(format!("mesh {name} {text}; if it was drawn in millimetres, give it the scale 0.001"));
    }
    let volume = mesh.signed_volume();
    if open > 0 {
        let text = format!("is not closed: {open} of {edges} edges do not belong to exactly two triangles");
        found.push(format!("mesh {name} {text}; a point inside it may count as outside"));
    } else if volume < 0.0 {
        let text = format!("faces inwards (signed volume {volume:.3e} m³)");
        found.push(format!("mesh {name} {text}; it is taken as the solid that its surface encloses"));
    }
    found
}

/// Number of edges, and of those that do not belong to exactly two triangles.
fn edges(triangles: &[[u32; 3]]) -> (usize, usize) {
    let mut uses: HashMap<(u32, u32), u32> = HashMap::new();
    for &[a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *uses.entry((from.min(to), from.max(to))).or_default() += 1;
        }
    }
    (uses.len(), uses.values().filter(|count| **count != 2).count())
}
