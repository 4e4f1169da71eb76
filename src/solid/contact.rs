//! Where two bodies are closest.

use crate::math::Vec3;

/// Closest points of two bodies A and B at one configuration, in the world's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Point of A (m); for a collision, the contact point.
    pub point_a: Vec3,
    /// Point of B (m); for a collision, the contact point.
    pub point_b: Vec3,
    /// Unit vector from B towards A.
    pub normal: Vec3,
    /// Distance (m), negative depth for a collision.
    pub distance: f64,
}

/// Distances at or below this are contact (m).
pub const TOUCHING_M: f64 = 1e-9;

impl Contact {
    /// The same seen from the other body, for a contact whose points are one.
    pub(super) fn reversed(self) -> Self {
        Self {
            normal: -self.normal,
            ..self
        }
    }

    /// The deeper one of two, or this one.
    pub(super) fn deeper(self, other: Self) -> Self {
        if other.distance < self.distance {
            other
        } else {
            self
        }
    }
}
