//! Shapes as files name them, and the convex parts that they are.

use super::make::mesh::Mesh;
use super::pose::{Pose, Quaternion, Vector, of_quaternion};
use super::solid::{Convex, Part};

/// A shape of a robot or a scene (m).
#[derive(Clone, Debug)]
pub enum Geometry {
    Box(Vector),
    Sphere {
        radius: f64,
    },
    Cylinder {
        length: f64,
        radius: f64,
    },
    /// `length` of its straight part.
    Capsule {
        length: f64,
        radius: f64,
    },
    Mesh(Box<Mesh>),
}

impl Geometry {
    /// Its parts, where its frame stands at `pose`.
    pub fn parts(&self, pose: &Pose) -> Vec<Part> {
        let one = |shape| vec![Part::new(*pose, shape)];
        match self {
            Self::Box(size) => one(Convex::cuboid(*size)),
            Self::Sphere { radius } => one(Convex::Sphere { radius: *radius }),
            Self::Cylinder { length, radius } => one(Convex::Cylinder {
                half: length / 2.0,
                radius: *radius,
            }),
            Self::Capsule { length, radius } => one(Convex::Capsule {
                half: length / 2.0,
                radius: *radius,
            }),
            Self::Mesh(mesh) => {
                let solid = pose.then(&Pose::shift(mesh.offset));
                mesh.column
                    .parts()
                    .into_iter()
                    .map(|part| Part::new(solid, part))
                    .collect()
            }
        }
    }

    /// Where the origin of its frame must stand so that the shape itself stands at `wanted`.
    pub fn origin_for(&self, wanted: &Pose) -> Vector {
        match self {
            Self::Mesh(mesh) => wanted.point(mesh.offset.map(|x| -x)),
            Self::Box(_) | Self::Sphere { .. } | Self::Cylinder { .. } | Self::Capsule { .. } => {
                wanted.at
            }
        }
    }

    pub fn mesh(&self) -> Option<&Mesh> {
        match self {
            Self::Mesh(mesh) => Some(mesh),
            Self::Box(_) | Self::Sphere { .. } | Self::Cylinder { .. } | Self::Capsule { .. } => {
                None
            }
        }
    }
}

/// A pose as a scene says it.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    pub at: Vector,
    pub turn: Quaternion,
}

impl Placement {
    pub fn pose(&self) -> Pose {
        Pose {
            rotation: of_quaternion(self.turn),
            at: self.at,
        }
    }
}
