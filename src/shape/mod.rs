//! Shapes of links and obstacles, and the meshes they may be. Knows neither robots nor scenes.

// A new kind of shape, core or joint is an error here, not another one's arm.
#![deny(clippy::wildcard_enum_match_arm)]

pub mod cloud;
mod collada;
mod drawn;
mod edges;
mod kind;
mod making;
pub mod mesh;
pub mod mesh_file;
mod obj;
mod oddities;
mod parts;
mod patches;
mod polygon;
pub mod sensed;
mod sides;
mod stl;
mod surface;
mod volume;

use std::sync::Arc;

use crate::hash::ContentHasher;
use crate::math::{Pose, Vec3};
pub use cloud::{Cloud, CloudError, Voxel};
pub use drawn::Drawn;
pub use kind::{Description, PRIMITIVES, PrimitiveKind, Shape, ShapeError};
pub use mesh::{Mesh, MeshError};
pub use volume::solid_angle;

/// Why a shape cannot be had at another size.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ScaleError {
    /// A mesh loses its triangles.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A cloud becomes none.
    #[error(transparent)]
    Cloud(#[from] CloudError),
}

/// A shape at a fixed place in the frame of a link or of the world.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedShape {
    /// Pose of the shape's frame.
    pub pose: Pose,
    /// The shape.
    pub shape: Shape,
}

impl PlacedShape {
    /// Hashes it, mesh content included, mesh name left out.
    pub(crate) fn tell(&self, hasher: &mut ContentHasher) {
        hasher.pose(&self.pose);
        match self.shape.mesh() {
            Some(mesh) => hasher.text("mesh").number(mesh.hash()),
            None => hasher.text(&self.shape.words()),
        };
    }

    /// The same shape so many times as large, about its own centre; a mesh or cloud about the mean of its
    /// vertices or cells (as MoveIt scales links).
    ///
    /// # Errors
    /// A mesh whose triangles this leaves without an area; a cloud that becomes too wide.
    pub fn scaled(&self, scale: f64) -> Result<Self, ScaleError> {
        let shape = match self.shape.description() {
            Description::Primitive(kind, dimensions) => {
                kind.of(dimensions.map(|size| size * scale))
            }
            Description::Mesh(mesh) => Shape::Mesh(Arc::new(scaled(mesh, scale)?)),
            Description::Cloud(cloud) => Shape::Cloud(Arc::new(cloud.scaled(scale)?)),
        };
        Ok(Self {
            pose: self.pose,
            shape,
        })
    }
}

/// The mesh about the mean of its vertices.
fn scaled(mesh: &Mesh, scale: f64) -> Result<Mesh, MeshError> {
    let center = mesh.vertices().iter().sum::<Vec3>() / mesh.vertices().len() as f64;
    let moved = |vertex: &Vec3| center + (*vertex - center) * scale;
    let vertices = mesh.vertices().iter().map(moved).collect();
    Mesh::new(mesh.name(), vertices, mesh.triangles().to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_are_scaled_about_their_own_centres() {
        let pose = Pose::from_translation(Vec3::X);
        let scaled = |shape: Shape| PlacedShape { pose, shape }.scaled(2.0).unwrap();
        assert_eq!(
            scaled(Shape::sphere(0.1).unwrap()),
            PlacedShape {
                pose,
                shape: Shape::sphere(0.2).unwrap()
            }
        );
        assert_eq!(
            scaled(Shape::cuboid(Vec3::ONE).unwrap()).shape,
            Shape::cuboid(Vec3::ONE * 2.0).unwrap()
        );
        assert_eq!(
            scaled(Shape::cylinder(1.0, 0.1).unwrap()).shape,
            Shape::cylinder(2.0, 0.2).unwrap()
        );
        assert_eq!(
            scaled(Shape::capsule(1.0, 0.1).unwrap()).shape,
            Shape::capsule(2.0, 0.2).unwrap()
        );
        let corners =
            [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z].map(|corner| corner + Vec3::splat(3.0));
        let faces = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let mesh = Arc::new(Mesh::new("corner", corners.to_vec(), faces).unwrap());
        let Shape::Mesh(large) = scaled(Shape::Mesh(mesh.clone())).shape else {
            panic!("a mesh")
        };
        assert!((large.signed_volume() - 8.0 * mesh.signed_volume()).abs() < 1e-12);
        let mean = |mesh: &Mesh| mesh.vertices().iter().sum::<Vec3>() / 4.0;
        assert!((mean(&large) - mean(&mesh)).length() < 1e-12);
        let placed = PlacedShape {
            pose,
            shape: Shape::Mesh(mesh),
        };
        assert!(placed.scaled(1e-200).is_err(), "all corners are one");
    }
}
