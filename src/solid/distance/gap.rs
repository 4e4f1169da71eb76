//! Support gaps: what a direction says of the distance of two pieces, and the nearest of several
//! pairs of points.

use crate::math::Vec3;
use crate::solid::core::Core;
use crate::solid::piece::Piece;

/// `min_A n·a − max_B n·b` for a unit `normal`: a lower bound of the distance whatever the normal.
pub fn gap_along(a: &Piece, b: &Piece, normal: Vec3) -> f64 {
    gap_of_cores(&a.core, &b.core, normal) - a.radius - b.radius
}

pub(super) fn gap_of_cores(a: &Core, b: &Core, normal: Vec3) -> f64 {
    normal.dot(a.support(-normal) - b.support(normal))
}

/// Whether the support gap says that no points are closer, up to rounding. Of several
/// pairs that are as near as rounding can tell, only the right one has a direction that says so.
pub(super) fn is_certain(a: &Core, b: &Core, (on_a, on_b): (Vec3, Vec3)) -> bool {
    let offset = on_a - on_b;
    let length = offset.length();
    length > 0.0 && gap_of_cores(a, b, offset / length) >= length - 1e-13 * (1.0 + length)
}

/// The nearest of several pairs of points.
pub(super) struct Nearest {
    /// The points, one of either core.
    pub points: (Vec3, Vec3),
    square: f64,
}

impl Default for Nearest {
    fn default() -> Self {
        Self {
            points: (Vec3::ZERO, Vec3::INFINITY),
            square: f64::INFINITY,
        }
    }
}

impl Nearest {
    /// Both at one point.
    pub fn common(point: Vec3) -> Self {
        Self {
            points: (point, point),
            square: 0.0,
        }
    }

    /// Takes the pair if it is nearer than all before; says whether it is.
    pub fn offer(&mut self, points: (Vec3, Vec3)) -> bool {
        let square = points.0.distance_squared(points.1);
        let is_nearer = square < self.square;
        if is_nearer {
            *self = Self { points, square };
        }
        is_nearer
    }
}
