//! Triangles against cores, in closed form.
//!
//! Where a closest point is inside the triangle, the direction is the triangle's normal, and the
//! other core's point lowest along it is a closest one, or else the closest points that do not lie
//! inside reach an edge. So the lowest point and the three edges are all that need be tried.

use super::face::{edges, normal, seen_from_face};
use super::gap::{Nearest, is_certain};
use super::segment;
use super::segments;
use crate::math::Vec3;
use crate::solid::core::Core;

/// Closest points of a triangle and of a box or cylinder; equal where they overlap.
pub(super) fn to_solid(triangle: [Vec3; 3], other: &Core) -> (Vec3, Vec3) {
    let normal = normal(triangle);
    seen_from_face(triangle, [other.support(-normal), other.support(normal)]).unwrap_or_else(|| {
        let mut best = Nearest::default();
        for (a, b) in edges(triangle) {
            let points = segment::closest(a, b, other);
            if is_certain(
                &Core::Triangle(triangle[0], triangle[1], triangle[2]),
                other,
                points,
            ) {
                return points;
            }
            best.offer(points);
        }
        best.points
    })
}

/// Closest points of two triangles; equal where they overlap.
pub(super) fn to_triangle(first: [Vec3; 3], second: [Vec3; 3]) -> (Vec3, Vec3) {
    if let Some(points) = seen_from_face(first, second) {
        return points;
    }
    if let Some((on_second, on_first)) = seen_from_face(second, first) {
        return (on_first, on_second);
    }
    // The edges that meet at the corners which look at each other are most often the closest.
    let between = second[0] + second[1] + second[2] - first[0] - first[1] - first[2];
    let first = corner_second(first, between);
    let second = corner_second(second, -between);
    let mut best = Nearest::default();
    for i in 0..3 {
        let a = first[i];
        let b = first[(i + 1) % 3];
        let behind_a = first[(i + 2) % 3];
        for j in 0..3 {
            let c = second[j];
            let d = second[(j + 1) % 3];
            let behind_c = second[(j + 2) % 3];
            let (x, y) = segments::closest(a, b, c, d);
            // Where both third corners lie behind the two points, a slab parts the triangles:
            // nothing is closer.
            let offset = y - x;
            if (behind_a - x).dot(offset) <= 0.0 && (behind_c - y).dot(offset) >= 0.0 {
                return (x, y);
            }
            best.offer((x, y));
        }
    }
    best.points
}

/// The triangle from another of its corners on, so that the second is the one farthest along a
/// direction: the first two edges meet there.
fn corner_second([a, b, c]: [Vec3; 3], direction: Vec3) -> [Vec3; 3] {
    let u = direction.dot(a);
    let v = direction.dot(b);
    let w = direction.dot(c);
    if v >= u && v >= w {
        [a, b, c]
    } else if w >= u {
        [b, c, a]
    } else {
        [c, a, b]
    }
}
