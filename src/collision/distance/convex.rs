//! What parry is asked: how deep two pieces overlap, for messages and rows, and in which direction two clouds of
//! points lie apart. Nothing that it says is taken for a bound.

use parry3d_f64::query::epa::EPA;
use parry3d_f64::query::gjk::{self, CsoPoint, GJKResult, VoronoiSimplex};
use parry3d_f64::shape::SupportMap;

use crate::collision::piece::{Core, Transform};
use crate::math::{Pose, Vec3};

impl SupportMap for Core {
    fn local_support_point(&self, direction: Vec3) -> Vec3 {
        self.support(direction)
    }
}

/// Points, seen from the frame in which `at` places theirs.
struct Cloud<'a> {
    points: &'a [Vec3],
    at: Transform,
}

impl SupportMap for Cloud<'_> {
    fn local_support_point(&self, direction: Vec3) -> Vec3 {
        let direction = self.at.rotation.transpose() * direction;
        let (mut farthest, mut most) = (Vec3::ZERO, f64::NEG_INFINITY);
        for point in self.points {
            let along = point.dot(direction);
            if along > most {
                (farthest, most) = (*point, along);
            }
        }
        self.at.point(farthest)
    }
}

/// Unit vector from B's points towards A's, which `relative` places in B's frame, where the two convex hulls are
/// about closest; `None` where they overlap.
pub fn direction_between(a: &[Vec3], relative: &Transform, b: &[Vec3]) -> Option<Vec3> {
    let (a, b) = (Cloud { points: a, at: *relative }, Cloud { points: b, at: Transform::IDENTITY });
    let mut simplex = VoronoiSimplex::new();
    let here = Pose::identity();
    let start = (relative.point(middle(a.points)) - middle(b.points)).try_normalize().unwrap_or(Vec3::X);
    simplex.reset(CsoPoint::from_shapes(&here, &a, &b, -start));
    match gjk::closest_points(&here, &a, &b, f64::MAX, true, &mut simplex) {
        GJKResult::ClosestPoints(on_a, on_b, _) => (on_a - on_b).try_normalize(),
        _ => None,
    }
}

fn middle(points: &[Vec3]) -> Vec3 {
    points.iter().sum::<Vec3>() / points.len().max(1) as f64
}

/// At most how far a point is from the convex hull of `points` (m), but for rounding: the distance to a point of it.
pub fn from_hull(points: &[Vec3], point: Vec3) -> f64 {
    let hull = Cloud { points, at: Transform::IDENTITY };
    let mut simplex = VoronoiSimplex::new();
    let here = Pose::identity();
    let point = Core::Point(point);
    simplex.reset(CsoPoint::from_shapes(&here, &hull, &point, Vec3::X));
    match gjk::closest_points(&here, &hull, &point, f64::MAX, true, &mut simplex) {
        GJKResult::ClosestPoints(on_hull, there, _) => on_hull.distance(there),
        GJKResult::Intersection => 0.0,
        _ => f64::INFINITY,
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
