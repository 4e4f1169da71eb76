//! What parry is asked: how deep two pieces overlap, for messages and rows, and in which direction
//! two clouds of points lie apart. Nothing that it says is taken for a bound: directions and
//! choices are, whatever they are.

use parry3d_f64::query::epa::EPA;
use parry3d_f64::query::gjk::{self, CsoPoint, GJKResult, VoronoiSimplex};
use parry3d_f64::shape::SupportMap;

use super::point::closest_on;
use crate::math::{Pose, Vec3};
use crate::solid::contact::Contact;
use crate::solid::core::Core;
use crate::solid::piece::Piece;
use crate::solid::transform::Transform;

impl SupportMap for Core {
    fn local_support_point(&self, direction: Vec3) -> Vec3 {
        self.support(direction)
    }
}

/// A convex body.
pub enum Hull {
    /// A single piece.
    Piece(Piece),
    /// The convex hull of points, swept by a ball.
    Points {
        /// The points.
        points: Vec<Vec3>,
        /// Unit normals of its faces, out or in.
        normals: Vec<Vec3>,
        /// Radius of the ball (m).
        radius: f64,
    },
}

impl Hull {
    fn radius(&self) -> f64 {
        match self {
            Self::Piece(piece) => piece.radius,
            Self::Points { radius, .. } => *radius,
        }
    }

    fn normals(&self) -> Vec<Vec3> {
        match self {
            Self::Piece(piece) => piece
                .core
                .normals()
                .into_iter()
                .flatten()
                .collect(),
            Self::Points { normals, .. } => normals.clone(),
        }
    }
}

/// Of the core that the ball sweeps.
impl SupportMap for Hull {
    fn local_support_point(&self, direction: Vec3) -> Vec3 {
        match self {
            Self::Piece(piece) => piece.core.support(direction),
            Self::Points { points, .. } => Cloud {
                points,
                at: Transform::IDENTITY,
            }
            .local_support_point(direction),
        }
    }
}

/// Contact of two convex bodies that overlap, given in one frame: along the direction of least
/// depth, both points the middle of the overlap. `None` where their cores are apart.
pub fn deepest_of_hulls(a: &Hull, b: &Hull) -> Option<Contact> {
    let round = a.radius() + b.radius();
    let along = |normal: Vec3| {
        let low = a.local_support_point(-normal);
        let high = b.local_support_point(normal);
        Contact {
            point_a: low,
            point_b: high,
            normal,
            distance: normal.dot(low - high) - round,
        }
    };
    // Where a core is a point, or faces are parallel, the search may end beside the best; a face it
    // does not miss.
    let faces = a
        .normals()
        .into_iter()
        .chain(b.normals())
        .flat_map(|normal| [along(normal), along(-normal)]);
    let of_faces = faces.max_by(|a, b| a.distance.total_cmp(&b.distance));
    let of_search = deepest(a, b).map(|(on_a, on_b, normal)| {
        let middle = (on_a + on_b) / 2.0;
        // What a search says of depth is not counted on: the way that parts the bodies along its
        // direction is.
        Contact {
            point_a: middle,
            point_b: middle,
            ..along(normal)
        }
    });
    let best = match (of_search, of_faces) {
        (Some(search), Some(face)) if face.distance > search.distance + 1e-12 => face,
        (search, face) => search.or(face)?,
    };
    let middle = (best.point_a + best.point_b) / 2.0;
    (best.distance < -round).then_some(Contact {
        point_a: middle,
        point_b: middle,
        ..best
    })
}

/// Points, seen from the frame in which `at` places theirs.
struct Cloud<'a> {
    points: &'a [Vec3],
    at: Transform,
}

impl SupportMap for Cloud<'_> {
    fn local_support_point(&self, direction: Vec3) -> Vec3 {
        let direction = self.at.rotation.transpose() * direction;
        let mut farthest = Vec3::ZERO;
        let mut most = f64::NEG_INFINITY;
        for point in self.points {
            let along = point.dot(direction);
            if along > most {
                farthest = *point;
                most = along;
            }
        }
        self.at.point(farthest)
    }
}

/// Unit vector from B's points towards A's, which `relative` places in B's frame, where the two
/// convex hulls are about closest; `None` where they overlap.
pub fn direction_between(a: &[Vec3], relative: &Transform, b: &[Vec3]) -> Option<Vec3> {
    let a = Cloud {
        points: a,
        at: *relative,
    };
    let b = Cloud {
        points: b,
        at: Transform::IDENTITY,
    };
    let mut simplex = VoronoiSimplex::new();
    let here = Pose::identity();
    let start = (relative.point(middle(a.points)) - middle(b.points))
        .try_normalize()
        .unwrap_or(Vec3::X);
    simplex.reset(CsoPoint::from_shapes(&here, &a, &b, -start));
    match gjk::closest_points(&here, &a, &b, f64::MAX, true, &mut simplex) {
        GJKResult::ClosestPoints(on_a, on_b, _) => (on_a - on_b).try_normalize(),
        GJKResult::Intersection | GJKResult::Proximity(_) | GJKResult::NoIntersection(_) => None,
    }
}

fn middle(points: &[Vec3]) -> Vec3 {
    points.iter().sum::<Vec3>() / points.len().max(1) as f64
}

/// At most how far a point is from the convex hull of `points` (m). Parry only chooses the few of
/// them that it is measured from: a poor choice gives too much, never too little.
pub fn from_hull(points: &[Vec3], point: Vec3) -> f64 {
    let hull = Cloud {
        points,
        at: Transform::IDENTITY,
    };
    let mut simplex = VoronoiSimplex::new();
    let here = Pose::identity();
    let core = Core::Point(point);
    simplex.reset(CsoPoint::from_shapes(&here, &hull, &core, Vec3::X));
    let _ = gjk::closest_points(&here, &hull, &core, f64::MAX, true, &mut simplex);
    let last: Vec<_> = (0..=simplex.dimension())
        .map(|index| simplex.point(index).orig1)
        .collect();
    let before: Vec<_> = (0..=simplex.prev_dimension())
        .map(|index| simplex.prev_point(index).orig1)
        .collect();
    from_simplex(&last, point).min(from_simplex(&before, point))
}

/// How far a point is from the convex hull of one to four points (m); of four that are nearly in a
/// plane, from their triangles.
fn from_simplex(corners: &[Vec3], point: Vec3) -> f64 {
    let from = |core: Core| closest_on(&core, point).distance(point);
    match *corners {
        [a] => from(Core::Point(a)),
        [a, b] => from(Core::Segment(a, b)),
        [a, b, c] => from(Core::Triangle(a, b, c)),
        [a, b, c, d] if is_inside([a, b, c, d], point) => INSIDE_ROUNDING * size_of([a, b, c, d]),
        [a, b, c, d] => {
            let sides = [[a, b, c], [a, b, d], [a, c, d], [b, c, d]];
            sides
                .into_iter()
                .map(|[a, b, c]| from(Core::Triangle(a, b, c)))
                .fold(f64::INFINITY, f64::min)
        }
        _ => f64::INFINITY,
    }
}

/// How far outside of a tetrahedron, relative to its size, a point may be that counts as inside:
/// volumes are off by some 1e-15 of the size cubed, and the tetrahedron's own is at least [`FLAT`]
/// of it.
const INSIDE_ROUNDING: f64 = 1e-5;
const FLAT: f64 = 1e-9;

fn size_of([a, b, c, d]: [Vec3; 4]) -> f64 {
    a.distance(b)
        .max(a.distance(c))
        .max(a.distance(d))
}

/// Whether a point is inside a tetrahedron that is not flat: it then makes four of the same
/// orientation with its sides.
fn is_inside([a, b, c, d]: [Vec3; 4], point: Vec3) -> bool {
    let volume = |a: Vec3, b: Vec3, c: Vec3, d: Vec3| (b - a).dot((c - a).cross(d - a));
    let whole = volume(a, b, c, d);
    let parts = [
        volume(point, b, c, d),
        volume(a, point, c, d),
        volume(a, b, point, d),
        volume(a, b, c, point),
    ];
    whole.abs() > FLAT * size_of([a, b, c, d]).powi(3)
        && parts
            .into_iter()
            .all(|part| part * whole >= 0.0)
}

/// Points of two overlapping cores that are deepest in the other, and the unit direction along
/// which A leaves B soonest; `None` where none was found.
pub(super) fn deepest<A: SupportMap, B: SupportMap>(a: &A, b: &B) -> Option<(Vec3, Vec3, Vec3)> {
    let mut simplex = VoronoiSimplex::new();
    let here = Pose::identity();
    simplex.reset(CsoPoint::from_shapes(&here, a, b, Vec3::X));
    // GJK leaves the simplex around the origin, from which EPA grows.
    let _ = gjk::closest_points(&here, a, b, f64::MAX, true, &mut simplex);
    let (on_a, on_b, normal) = EPA::new().closest_points(&here, a, b, &simplex)?;
    // Parry's normal points from the first shape out, along which the first must not move.
    Some((on_a, on_b, -normal))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever parry chooses: on a cube and on a flat square of points, what lies outside is
    /// measured exactly.
    #[test]
    fn distances_from_a_hull_are_never_too_short() {
        let cube: Vec<_> = (0..8)
            .map(|i| Vec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
            .collect();
        let square: Vec<_> = cube
            .iter()
            .copied()
            .filter(|corner| corner.z == 0.0)
            .collect();
        let mut random = fastrand::Rng::with_seed(3);
        for round in 0..5000 {
            let mut coordinate = || {
                if round % 3 == 0 {
                    0.5 * f64::from(random.u8(0..5)) - 0.5
                } else {
                    2.0 * random.f64() - 0.5
                }
            };
            let point = Vec3::new(coordinate(), coordinate(), coordinate());
            for (points, top) in [(&cube, Vec3::ONE), (&square, Vec3::new(1.0, 1.0, 0.0))] {
                let exact = point.distance(point.clamp(Vec3::ZERO, top));
                let found = from_hull(points, point);
                assert!(found >= exact - 1e-12, "{found} of {exact} at {point}");
                assert!(
                    found <= exact + 1e-9 || exact == 0.0 && found < 1e-4,
                    "{found} of {exact} at {point}"
                );
            }
        }
    }
}
