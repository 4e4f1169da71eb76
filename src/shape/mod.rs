//! Shapes of links and obstacles, and the meshes they may be. Knows neither robots nor scenes.

mod collada;
pub mod mesh;
pub mod mesh_file;
mod obj;
mod oddities;
mod polygon;
mod sides;
mod stl;
mod surface;

use std::sync::Arc;

use crate::math::{Pose, Vec3};
pub use mesh::{Mesh, MeshError};
pub use sides::solid_angle;

/// A solid in its own frame (m). Symmetric shapes are centred at the origin, axis along z.
///
/// Build one with the checked constructors: every size is finite and positive.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Shape {
    /// Ball.
    Sphere {
        /// Radius (m).
        radius: f64,
    },
    /// Box.
    Box {
        /// Half of each full size (m).
        half_extents: Vec3,
    },
    /// Cylinder with flat ends.
    Cylinder {
        /// Radius (m).
        radius: f64,
        /// Half of the full height (m).
        half_height: f64,
    },
    /// Segment along z swept by a ball.
    Capsule {
        /// Radius (m).
        radius: f64,
        /// Half of the segment's length (m) (the whole capsule is `2 (half_length + radius)` long).
        half_length: f64,
    },
    /// Triangle mesh, an exact solid: a point inside its surface is inside the shape.
    Mesh(Arc<Mesh>),
}

/// A shape at a fixed place in the frame of a link or of the world.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedShape {
    /// Pose of the shape's frame.
    pub pose: Pose,
    /// The shape.
    pub shape: Shape,
}

/// A size that no solid can have.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{shape}: {size} is {value}, it must be finite and greater than 0")]
pub struct ShapeError {
    /// Kind of shape.
    pub shape: &'static str,
    /// Which size.
    pub size: &'static str,
    /// Its value.
    pub value: f64,
}

impl Shape {
    /// Ball of `radius` (m).
    pub fn sphere(radius: f64) -> Result<Self, ShapeError> {
        positive("sphere", "radius", radius)?;
        Ok(Self::Sphere { radius })
    }

    /// Box of full sizes x, y, z (m).
    pub fn cuboid(size: Vec3) -> Result<Self, ShapeError> {
        for (name, value) in [("x size", size.x), ("y size", size.y), ("z size", size.z)] {
            positive("box", name, value)?;
        }
        Ok(Self::Box {
            half_extents: size / 2.0,
        })
    }

    /// Cylinder of full `height` (m) along z (MoveIt's order of dimensions: height, radius).
    pub fn cylinder(height: f64, radius: f64) -> Result<Self, ShapeError> {
        positive("cylinder", "height", height)?;
        positive("cylinder", "radius", radius)?;
        Ok(Self::Cylinder {
            radius,
            half_height: height / 2.0,
        })
    }

    /// Capsule whose segment has full `length` (m) along z.
    pub fn capsule(length: f64, radius: f64) -> Result<Self, ShapeError> {
        positive("capsule", "length", length)?;
        positive("capsule", "radius", radius)?;
        Ok(Self::Capsule {
            radius,
            half_length: length / 2.0,
        })
    }
}

impl PlacedShape {
    /// The same shape so many times as large, about its own centre; a mesh about the mean of its
    /// vertices (as MoveIt scales links).
    ///
    /// # Errors
    /// A mesh whose triangles this leaves without an area.
    pub fn scaled(&self, scale: f64) -> Result<Self, MeshError> {
        let shape = match &self.shape {
            Shape::Sphere { radius } => Shape::Sphere {
                radius: radius * scale,
            },
            Shape::Box { half_extents } => Shape::Box {
                half_extents: *half_extents * scale,
            },
            Shape::Cylinder {
                radius,
                half_height,
            } => Shape::Cylinder {
                radius: radius * scale,
                half_height: half_height * scale,
            },
            Shape::Capsule {
                radius,
                half_length,
            } => Shape::Capsule {
                radius: radius * scale,
                half_length: half_length * scale,
            },
            Shape::Mesh(mesh) => {
                let center = mesh.vertices().iter().sum::<Vec3>() / mesh.vertices().len() as f64;
                let vertices = mesh
                    .vertices()
                    .iter()
                    .map(|vertex| center + (*vertex - center) * scale)
                    .collect();
                Shape::Mesh(Arc::new(Mesh::new(
                    mesh.name(),
                    vertices,
                    mesh.triangles().to_vec(),
                )?))
            }
        };
        Ok(Self {
            pose: self.pose,
            shape,
        })
    }
}

fn positive(shape: &'static str, size: &'static str, value: f64) -> Result<(), ShapeError> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(ShapeError { shape, size, value })
    }
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
