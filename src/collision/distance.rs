//! Distance of two convex pieces, as a certified lower bound along a direction.
//!
//! Whatever finds the direction, closed form or GJK, the bound is computed from the shapes' own
//! support functions along it: a direction that is a little off costs tightness, never truth.

use parry3d_f64::query::epa::EPA;
use parry3d_f64::query::gjk::{self, CsoPoint, GJKResult, VoronoiSimplex};

use super::contact::Contact;
use super::piece::{Core, Piece};
use crate::math::{Pose, Vec3};

/// What a distance query knows of two convex pieces A and B.
#[derive(Clone, Copy, Debug)]
pub struct Separation {
    /// Unit vector from B towards A.
    pub normal: Vec3,
    /// `min_A n·a − max_B n·b` (m): never above the distance. Negative where the pieces overlap or no direction is known.
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
        return Separation { normal: Vec3::Z, gap: -(a.radius + b.radius), point_a: core_a, point_b: core_b };
    }
    let normal = offset / length;
    Separation {
        normal,
        gap: gap_along(a, b, normal),
        point_a: core_a - normal * a.radius,
        point_b: core_b + normal * b.radius,
    }
}

/// `min_A n·a − max_B n·b` for a unit `normal`: a lower bound of the distance whatever the normal.
pub fn gap_along(a: &Piece, b: &Piece, normal: Vec3) -> f64 {
    normal.dot(a.core.support(-normal) - b.core.support(normal)) - a.radius - b.radius
}

/// Closest points of two cores; equal where they overlap.
fn core_points(a: &Core, b: &Core) -> (Vec3, Vec3) {
    match (a, b) {
        (Core::Point(p), other) => (*p, closest_on(other, *p)),
        (other, Core::Point(p)) => (closest_on(other, *p), *p),
        (Core::Segment(a0, a1), Core::Segment(b0, b1)) => segment_segment(*a0, *a1, *b0, *b1),
        _ => gjk_points(a, b),
    }
}

/// Point of the (solid) core closest to `p`; `p` itself where it is inside.
pub fn closest_on(core: &Core, p: Vec3) -> Vec3 {
    match *core {
        Core::Point(a) => a,
        Core::Segment(a, b) => on_segment(a, b, p),
        Core::Triangle(a, b, c) => on_triangle(a, b, c, p),
        Core::Box { center, axes, half } => {
            let local = axes.transpose() * (p - center);
            let inside = local.clamp(-half, half);
            if inside == local { p } else { center + axes * inside }
        }
        Core::Cylinder { center, axes, half_height, radius } => {
            let local = axes.transpose() * (p - center);
            let across = local.x.hypot(local.y);
            if local.z.abs() <= half_height && across <= radius {
                return p;
            }
            let shrink = if across > radius { radius / across } else { 1.0 };
            let nearest = Vec3::new(local.x * shrink, local.y * shrink, local.z.clamp(-half_height, half_height));
            center + axes * nearest
        }
    }
}

fn on_segment(a: Vec3, b: Vec3, p: Vec3) -> Vec3 {
    let along = b - a;
    let square = along.length_squared();
    if square <= 0.0 { a } else { a + along * ((p - a).dot(along) / square).clamp(0.0, 1.0) }
}

/// Closest point of a triangle by its Voronoi regions (Ericson, Real-Time Collision Detection, 5.1.5).
fn on_triangle(a: Vec3, b: Vec3, c: Vec3, p: Vec3) -> Vec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let (vc, vb, va) = (d1 * d4 - d3 * d2, d5 * d2 - d1 * d6, d3 * d6 - d5 * d4);
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return on_segment(a, b, p);
    }
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return on_segment(a, c, p);
    }
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return on_segment(b, c, p);
    }
    let scale = 1.0 / (va + vb + vc);
    if !scale.is_finite() {
        // A sliver without area: its longest edge is the triangle.
        let nearest = [on_segment(a, b, p), on_segment(a, c, p), on_segment(b, c, p)];
        return nearest.into_iter().min_by(|x, y| x.distance(p).total_cmp(&y.distance(p))).unwrap_or(a);
    }
    a + ab * (vb * scale) + ac * (vc * scale)
}

/// Closest points of two segments (Ericson, Real-Time Collision Detection, 5.1.9).
fn segment_segment(a0: Vec3, a1: Vec3, b0: Vec3, b1: Vec3) -> (Vec3, Vec3) {
    let (da, db, r) = (a1 - a0, b1 - b0, a0 - b0);
    let (aa, bb, f) = (da.length_squared(), db.length_squared(), db.dot(r));
    if aa <= 0.0 {
        return (a0, on_segment(b0, b1, a0));
    }
    if bb <= 0.0 {
        return (on_segment(a0, a1, b0), b0);
    }
    let (c, ab) = (da.dot(r), da.dot(db));
    let determinant = aa * bb - ab * ab;
    let mut s = if determinant > 0.0 { ((ab * f - c * bb) / determinant).clamp(0.0, 1.0) } else { 0.0 };
    let mut t = (ab * s + f) / bb;
    if !(0.0..=1.0).contains(&t) {
        t = t.clamp(0.0, 1.0);
        s = ((ab * t - c) / aa).clamp(0.0, 1.0);
    }
    (a0 + da * s, b0 + db * t)
}

fn gjk_points(a: &Core, b: &Core) -> (Vec3, Vec3) {
    let mut simplex = VoronoiSimplex::new();
    let here = Pose::identity();
    let middle = |core: &Core| Piece { core: *core, radius: 0.0 }.center();
    let start = (middle(b) - middle(a)).try_normalize().unwrap_or(Vec3::X);
    simplex.reset(CsoPoint::from_shapes(&here, a, b, start));
    match gjk::closest_points(&here, a, b, f64::MAX, true, &mut simplex) {
        GJKResult::ClosestPoints(p, q, _) => (p, q),
        _ => (middle(a), middle(a)),
    }
}

/// Contact of two pieces, apart or overlapping, in the frame that both are given in.
///
/// Apart: their closest points. Overlapping: both points are the middle of the overlap along the
/// direction of least depth, the distance is minus that depth.
pub fn contact(a: &Piece, b: &Piece) -> Contact {
    let apart = separation(a, b);
    let (core_a, core_b) = (apart.point_a + apart.normal * a.radius, apart.point_b - apart.normal * b.radius);
    if core_a.distance(core_b) > 1e-9 {
        let distance = core_a.distance(core_b) - a.radius - b.radius;
        return place(apart.point_a, apart.point_b, apart.normal, distance);
    }
    let mut simplex = VoronoiSimplex::new();
    let here = Pose::identity();
    simplex.reset(CsoPoint::from_shapes(&here, &a.core, &b.core, Vec3::X));
    // GJK leaves the simplex around the origin, from which EPA grows.
    let _ = gjk::closest_points(&here, &a.core, &b.core, f64::MAX, true, &mut simplex);
    match EPA::new().closest_points(&here, &a.core, &b.core, &simplex) {
        // Parry's normal points from the first shape out, along which the first must not move.
        Some((p, q, normal)) => {
            let depth = p.distance(q) + a.radius + b.radius;
            place(p + normal * a.radius, q - normal * b.radius, -normal, -depth)
        }
        None => place(core_a, core_a, Vec3::Z, -(a.radius + b.radius)),
    }
}

fn place(point_a: Vec3, point_b: Vec3, normal: Vec3, distance: f64) -> Contact {
    if distance > 0.0 {
        return Contact { point_a, point_b, normal, distance };
    }
    let middle = (point_a + point_b) / 2.0;
    Contact { point_a: middle, point_b: middle, normal, distance }
}
