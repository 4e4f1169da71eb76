//! What a viewer draws. Viewers know a few forms; every other shape reaches them as triangles, so
//! that a new kind of shape needs no viewer.

use std::borrow::Cow;

use super::kind::Shape;
use super::mesh::Mesh;
use crate::math::Vec3;

/// A shape as viewers have it, in its own frame, axis along z (m).
#[derive(Clone, Debug)]
pub enum Drawn<'a> {
    /// A box of full sizes.
    Box {
        /// Along x, y and z.
        size: Vec3,
    },
    /// A ball.
    Sphere {
        /// Its radius.
        radius: f64,
    },
    /// A cylinder with flat ends.
    Cylinder {
        /// Its radius.
        radius: f64,
        /// Its full height.
        length: f64,
    },
    /// A cylinder with round ends.
    Capsule {
        /// Its radius.
        radius: f64,
        /// Its height without the ends.
        length: f64,
    },
    /// Triangles.
    Mesh(Cow<'a, Mesh>),
}

impl Shape {
    /// What a viewer draws.
    pub fn drawn(&self) -> Drawn<'_> {
        match self {
            Self::Sphere { radius } => Drawn::Sphere { radius: *radius },
            Self::Box { half_extents } => Drawn::Box {
                size: *half_extents * 2.0,
            },
            Self::Cylinder {
                radius,
                half_height,
            } => Drawn::Cylinder {
                radius: *radius,
                length: 2.0 * half_height,
            },
            Self::Capsule {
                radius,
                half_length,
            } => Drawn::Capsule {
                radius: *radius,
                length: 2.0 * half_length,
            },
            Self::Mesh(mesh) => Drawn::Mesh(Cow::Borrowed(mesh)),
        }
    }
}
