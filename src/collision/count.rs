//! What solids are made of, counted.

use std::collections::HashSet;
use std::sync::Arc;

use crate::shape::PlacedShape;

/// Shapes, counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Count {
    /// Links or objects that have shapes.
    pub bodies: usize,
    /// Meshes, each as often as it is used.
    pub meshes: usize,
    /// Triangles of these.
    pub triangles: usize,
    /// Memory of the meshes (bytes), each once.
    pub mesh_bytes: usize,
}

impl Count {
    /// Counts the shapes of links or objects.
    pub fn of<'a>(bodies: impl Iterator<Item = &'a [PlacedShape]>) -> Self {
        let mut count = Self::default();
        let mut known = HashSet::new();
        for shapes in bodies.filter(|shapes| !shapes.is_empty()) {
            count.bodies += 1;
            for mesh in shapes
                .iter()
                .filter_map(|placed| placed.shape.mesh())
            {
                count.meshes += 1;
                count.triangles += mesh.triangles().len();
                if known.insert(Arc::as_ptr(mesh)) {
                    count.mesh_bytes += mesh.bytes();
                }
            }
        }
        count
    }
}
