//! Shapes at their places; meshes and clouds lie elsewhere.

use serde::{Deserialize, Serialize};
use taut::math::Vec3;
use taut::shape::{PlacedShape, Shape};

use super::apart::Find;
use super::plain::PoseRecord;

/// A shape at its place.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct ShapeRecord {
    pose: PoseRecord,
    shape: Kind,
}

/// New kinds stand last: files name a kind by its number.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
enum Kind {
    Sphere { radius: f64 },
    Box { half_extents: [f64; 3] },
    Cylinder { radius: f64, half_height: f64 },
    Capsule { radius: f64, half_length: f64 },
    Mesh { hash: u64 },
    Cloud { hash: u64 },
}

impl From<&Shape> for Kind {
    fn from(shape: &Shape) -> Self {
        match *shape {
            Shape::Sphere { radius } => Self::Sphere { radius },
            Shape::Box { half_extents } => Self::Box {
                half_extents: half_extents.to_array(),
            },
            Shape::Cylinder {
                radius,
                half_height,
            } => Self::Cylinder {
                radius,
                half_height,
            },
            Shape::Capsule {
                radius,
                half_length,
            } => Self::Capsule {
                radius,
                half_length,
            },
            Shape::Mesh(ref mesh) => Self::Mesh { hash: mesh.hash() },
            Shape::Cloud(ref cloud) => Self::Cloud { hash: cloud.hash() },
        }
    }
}

impl Kind {
    fn restore(self, find: &mut dyn Find) -> Result<Shape, String> {
        Ok(match self {
            Self::Sphere { radius } => Shape::Sphere { radius },
            Self::Box { half_extents } => Shape::Box {
                half_extents: Vec3::from_array(half_extents),
            },
            Self::Cylinder {
                radius,
                half_height,
            } => Shape::Cylinder {
                radius,
                half_height,
            },
            Self::Capsule {
                radius,
                half_length,
            } => Shape::Capsule {
                radius,
                half_length,
            },
            Self::Mesh { hash } => Shape::Mesh(find.mesh(hash)?),
            Self::Cloud { hash } => Shape::Cloud(find.cloud(hash)?),
        })
    }
}

/// The records of shapes.
pub(super) fn records<'a>(shapes: impl IntoIterator<Item = &'a PlacedShape>) -> Vec<ShapeRecord> {
    shapes
        .into_iter()
        .map(ShapeRecord::from)
        .collect()
}

impl From<&PlacedShape> for ShapeRecord {
    fn from(placed: &PlacedShape) -> Self {
        Self {
            pose: placed.pose.into(),
            shape: Kind::from(&placed.shape),
        }
    }
}

impl ShapeRecord {
    fn restore(&self, find: &mut dyn Find) -> Result<PlacedShape, String> {
        Ok(PlacedShape {
            pose: self.pose.into(),
            shape: self.shape.restore(find)?,
        })
    }
}

/// The shapes of records.
///
/// # Errors
/// A mesh or cloud that is not found.
pub(super) fn restored(
    shapes: &[ShapeRecord],
    find: &mut dyn Find,
) -> Result<Vec<PlacedShape>, String> {
    let shapes = shapes.iter();
    shapes
        .map(|record| record.restore(find))
        .collect()
}
