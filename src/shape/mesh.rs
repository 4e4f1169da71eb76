//! Triangle meshes: what a mesh file becomes once it is checked.

use super::edges::{Edges, Triangle};
use super::parts::Parts;
use super::volume::{is_flat, volume};
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
    triangles: Vec<Triangle>,
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

impl MeshError {
    pub(super) fn unreadable(name: impl Into<String>, reason: String) -> Self {
        let name = name.into();
        Self::Unreadable { name, reason }
    }

    pub(super) fn empty(name: String, triangles: usize) -> Self {
        Self::Empty { name, triangles }
    }
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
    pub fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }
    /// Memory of vertices and triangles (bytes).
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.vertices) + size_of_val(&*self.triangles)
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
        is_flat(&self.vertices, &self.triangles)
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

    /// The same mesh with what is odd about it.
    pub(super) fn with_oddities(self, warnings: Vec<Warning>) -> Self {
        Self { warnings, ..self }
    }

    /// Hash of vertices and triangles, whatever the file is called.
    pub fn hash(&self) -> u64 {
        self.hash
    }

    /// One vertex of every connected part of the surface.
    pub fn parts(&self) -> Vec<Vec3> {
        let mut parts = Parts::apart(self.vertices.len());
        for triangle in &self.triangles {
            parts.join(triangle.iter().map(|&i| i as usize));
        }
        let first_corners = self
            .triangles
            .iter()
            .map(|triangle| triangle[0] as usize);
        let mut used: Vec<usize> = first_corners.map(|i| parts.of(i)).collect();
        used.sort_unstable();
        used.dedup();
        used.into_iter()
            .map(|i| self.vertices[i])
            .collect()
    }

    /// Volume that the surface encloses (m³); negative where its triangles face inwards.
    pub fn signed_volume(&self) -> f64 {
        volume(&self.vertices, &self.triangles)
    }

    /// A mesh as [`Self::new`] made it once, from what was kept of it: nothing is merged or dropped
    /// again, and `warnings` are what was found odd then.
    ///
    /// # Errors
    /// As [`Self::new`], and a triangle without an area, which no such mesh has.
    pub fn restore(
        name: String,
        vertices: Vec<Vec3>,
        triangles: Vec<Triangle>,
        warnings: Vec<Warning>,
    ) -> Result<Self, MeshError> {
        check(&name, &vertices, &triangles)?;
        if let Some(bad) = triangles
            .iter()
            .position(|t| !has_area(&vertices, *t))
        {
            return Err(MeshError::unreadable(
                name,
                format!("triangle {bad} has no area"),
            ));
        }
        if triangles.is_empty() {
            return Err(MeshError::empty(name, 0));
        }
        let edges = Edges::of(&triangles);
        Ok(Self {
            warnings,
            ..Self::checked(name, vertices, triangles, &edges)
        })
    }

    /// Of vertices and triangles that are checked; `edges` are theirs.
    pub(super) fn checked(
        name: String,
        vertices: Vec<Vec3>,
        triangles: Vec<Triangle>,
        edges: &Edges,
    ) -> Self {
        let hash = hash_of(&vertices, &triangles);
        let has_inside = edges.are_closed() && !is_flat(&vertices, &triangles);
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

/// Refuses vertices that are not finite and triangles of vertices that are not there.
pub(super) fn check(
    name: &str,
    vertices: &[Vec3],
    triangles: &[Triangle],
) -> Result<(), MeshError> {
    if let Some(bad) = vertices
        .iter()
        .position(|vertex| !vertex.is_finite())
    {
        let reason = format!("vertex {bad} is not finite");
        return Err(MeshError::unreadable(name, reason));
    }
    let count = vertices.len();
    if let Some(bad) = first_beyond(count, triangles) {
        let reason = format!("triangle {bad} names a vertex beyond the {count} read");
        return Err(MeshError::unreadable(name, reason));
    }
    Ok(())
}

fn first_beyond(vertices: usize, triangles: &[Triangle]) -> Option<usize> {
    triangles
        .iter()
        .position(|triangle| triangle.iter().any(|&i| i as usize >= vertices))
}

/// Whether a triangle has an area.
pub(super) fn has_area(vertices: &[Vec3], triangle: Triangle) -> bool {
    let [a, b, c] = corners(vertices, triangle);
    (b - a).cross(c - a).length() > 0.0
}

fn hash_of(vertices: &[Vec3], triangles: &[Triangle]) -> u64 {
    let mut hasher = ContentHasher::default();
    hasher.mesh(vertices, triangles);
    hasher.finish()
}

fn corners(vertices: &[Vec3], triangle: Triangle) -> [Vec3; 3] {
    triangle.map(|i| vertices[i as usize])
}
