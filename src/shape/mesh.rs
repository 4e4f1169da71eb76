//! Triangle meshes: what a mesh file becomes once it is checked.

use crate::math::Vec3;

/// A checked triangle mesh [m], scale already applied.
///
/// Every vertex is finite, every index in range, there is at least one triangle with an area.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    name: String,
    vertices: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
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
    /// Vertices [m] in the mesh's own frame.
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }
    /// Vertex indices of each triangle.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }
    /// Checks and takes vertices and triangles; degenerate triangles are dropped.
    pub fn new(name: impl Into<String>, vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        let name = name.into();
        if let Some(bad) = vertices.iter().position(|v| !v.is_finite()) {
            return Err(MeshError::Unreadable { name, reason: format!("vertex {bad} is not finite") });
        }
        let count = triangles.len();
        let in_range = |t: &[u32; 3]| t.iter().all(|&i| (i as usize) < vertices.len());
        if let Some(bad) = triangles.iter().position(|t| !in_range(t)) {
            let reason = format!("triangle {bad} names a vertex beyond the {} read", vertices.len());
            return Err(MeshError::Unreadable { name, reason });
        }
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| vertices[i as usize]);
            (b - a).cross(c - a).length()
        };
        let triangles: Vec<_> = triangles.into_iter().filter(|t| area(t) > 0.0).collect();
        if triangles.is_empty() {
            return Err(MeshError::Empty { name, triangles: count });
        }
        Ok(Self { name, vertices, triangles })
    }
}
