//! Distance of two convex pieces, as a certified lower bound along a direction.
//!
//! Closed forms find the closest points (`segment`, `triangle`, `boxes`), for two cylinders an
//! iteration does (`cylinders`). Whatever finds them, the bound is computed from the shapes' own
//! support functions along their direction: a direction that is a little off costs tightness, never
//! truth.
//!
//! # Rounding
//!
//! A support gap takes the difference of two support points, an inner product with a unit vector
//! and two radii. With u = 2⁻⁵³ and all coordinates, sizes and radii at most s metres, a support
//! point is off by at most 12 u s, the inner product adds 4 u s, the length of the normal (off by 3
//! u) 6 u s, and the radii 2 u s: below 40 u s altogether, 5e-15 m in a world of a metre and 5e-12
//! m in one of a kilometre. Poses composed along a chain of joints add u s for each of some dozen
//! operations per joint. The checker allows 1e-9 m for all of it. Points and normals may be off by
//! more where a distance is tiny (u s over the distance, in radians); this only lowers the gap.

mod boxes;
mod convex;
mod cylinders;
mod face;
mod gap;
mod point;
mod segment;
mod segments;
#[cfg(test)]
mod tests;
mod triangle;

pub use convex::{Hull, deepest_of_hulls, direction_between, from_hull};
pub use gap::gap_along;
pub use point::closest_on;

use super::contact::Contact;
use super::core::Core;
use super::piece::Piece;
use crate::math::Vec3;

/// What a distance query knows of two convex pieces A and B.
#[derive(Clone, Copy, Debug)]
pub struct Separation {
    /// Unit vector from B towards A.
    pub normal: Vec3,
    /// `min_A n·a − max_B n·b` (m): never above the distance. Negative where the pieces overlap or
    /// no direction is known.
    pub gap: f64,
    /// Closest point of A.
    pub point_a: Vec3,
    /// Closest point of B.
    pub point_b: Vec3,
}

/// Distance of two pieces given in one frame.
pub fn separation(a: &Piece, b: &Piece) -> Separation {
    let (core_a, core_b) = core_points(&a.core, &b.core);
    let offset = core_a - core_b;
    let length = offset.length();
    if length < 1e-12 {
        return Separation {
            normal: Vec3::Z,
            gap: -(a.radius + b.radius),
            point_a: core_a,
            point_b: core_b,
        };
    }
    let normal = offset / length;
    Separation {
        normal,
        gap: gap_along(a, b, normal),
        point_a: core_a - normal * a.radius,
        point_b: core_b + normal * b.radius,
    }
}

/// The widest gap along a few directions that cost no search, and its direction: between the
/// middles, and across faces and lids.
fn cheap_gap(a: &Piece, b: &Piece) -> (Vec3, f64) {
    let mut best = (Vec3::Z, f64::NEG_INFINITY);
    let mut offer = |normal: Vec3| {
        let gap = gap_along(a, b, normal);
        if gap > best.1 {
            best = (normal, gap);
        }
    };
    (a.center() - b.center())
        .try_normalize()
        .into_iter()
        .for_each(&mut offer);
    for normal in [a, b]
        .into_iter()
        .flat_map(|piece| piece.core.normals())
        .flatten()
    {
        offer(normal);
        offer(-normal);
    }
    best
}

/// [`contact`] of two pieces that are closer than `within` (m); negative for "overlap deeper than
/// that". `None` where a cheap direction shows that they are not; nothing is said of the others.
pub fn contact_within(a: &Piece, b: &Piece, within: f64) -> Option<Contact> {
    // No direction has a wider gap than the distance, or than minus the depth.
    (within.is_infinite() || cheap_gap(a, b).1 < within).then(|| contact(a, b))
}

/// The same where it is enough to know of an overlap that it is one: distance 0, without its depth,
/// which is dear.
pub fn approach_within(a: &Piece, b: &Piece, within: f64) -> Option<Contact> {
    if within.is_finite() && cheap_gap(a, b).1 >= within {
        return None;
    }
    let Separation {
        normal,
        gap,
        point_a,
        point_b,
    } = separation(a, b);
    // Where cores meet there is no direction, and the gap along none says nothing.
    let distance = (point_a - point_b)
        .dot(normal)
        .max(gap)
        .max(0.0);
    Some(place(point_a, point_b, normal, distance))
}

/// Closest points of two cores; equal where they overlap.
fn core_points(a: &Core, b: &Core) -> (Vec3, Vec3) {
    use Core::{Box, Cylinder, Point, Segment, Triangle};
    match (a, b) {
        (Point(p), _) => (*p, closest_on(b, *p)),
        (Segment(p, q), Segment(..) | Triangle(..) | Box { .. } | Cylinder { .. }) => {
            segment::closest(*p, *q, b)
        }
        (Triangle(p, q, r), Triangle(s, t, u)) => triangle::to_triangle([*p, *q, *r], [*s, *t, *u]),
        (Triangle(p, q, r), Box { .. } | Cylinder { .. }) => triangle::to_solid([*p, *q, *r], b),
        (&Box { center, axes, half }, Box { .. } | Cylinder { .. }) => {
            boxes::to_solid(center, axes, half, b)
        }
        (Cylinder { .. }, Cylinder { .. }) => cylinders::closest(a, b),
        // Every pair by name: one that is left out would ask for itself without end.
        (Segment(..), Point(_))
        | (Triangle(..), Point(_) | Segment(..))
        | (Box { .. }, Point(_) | Segment(..) | Triangle(..))
        | (Cylinder { .. }, Point(_) | Segment(..) | Triangle(..) | Box { .. }) => {
            let (on_b, on_a) = core_points(b, a);
            (on_a, on_b)
        }
    }
}

/// Contact of two pieces, apart or overlapping, in the frame that both are given in.
///
/// Apart: their closest points. Overlapping: both points are the middle of the overlap along the
/// direction of least depth, the distance is minus that depth.
pub fn contact(a: &Piece, b: &Piece) -> Contact {
    let apart = separation(a, b);
    let core_a = apart.point_a + apart.normal * a.radius;
    let core_b = apart.point_b - apart.normal * b.radius;
    if core_a.distance(core_b) > 1e-9 {
        let distance = core_a.distance(core_b) - a.radius - b.radius;
        return place(apart.point_a, apart.point_b, apart.normal, distance);
    }
    // The iteration finds corners and edges, and may miss by centimetres where solids are round.
    let (normal, gap) = cheap_gap(a, b);
    match convex::deepest(&a.core, &b.core) {
        Some((p, q, normal)) if p.distance(q) + a.radius + b.radius <= -gap => {
            let depth = p.distance(q) + a.radius + b.radius;
            place(p - normal * a.radius, q + normal * b.radius, normal, -depth)
        }
        _ => place(core_a, core_a, normal, gap),
    }
}

fn place(point_a: Vec3, point_b: Vec3, normal: Vec3, distance: f64) -> Contact {
    if distance > 0.0 {
        return Contact {
            point_a,
            point_b,
            normal,
            distance,
        };
    }
    let middle = (point_a + point_b) / 2.0;
    Contact {
        point_a: middle,
        point_b: middle,
        normal,
        distance,
    }
}
