//! How deep two pieces overlap: parry's expanding polytope, for messages and rows, never for a proof.

use parry3d_f64::query::epa::EPA;
use parry3d_f64::query::gjk::{self, CsoPoint, VoronoiSimplex};
use parry3d_f64::shape::SupportMap;

use crate::collision::piece::Core;
use crate::math::{Pose, Vec3};

impl SupportMap for Core {
    fn local_support_point(&self, direction: Vec3) -> Vec3 {
        self.support(direction)
    }
}

/// Points of two overlapping cores that are deepest in the other, and the unit direction along which A
/// leaves B soonest; `None` where none was found.
pub(super) fn deepest(a: &Core, b: &Core) -> Option<(Vec3, Vec3, Vec3)> {
    let mut simplex = VoronoiSimplex::new();
    let here = Pose::identity();
    simplex.reset(CsoPoint::from_shapes(&here, a, b, Vec3::X));
    // GJK leaves the simplex around the origin, from which EPA grows.
    let _ = gjk::closest_points(&here, a, b, f64::MAX, true, &mut simplex);
    let (on_a, on_b, normal) = EPA::new().closest_points(&here, a, b, &simplex)?;
    // Parry's normal points from the first shape out, along which the first must not move.
    Some((on_a, on_b, -normal))
}
