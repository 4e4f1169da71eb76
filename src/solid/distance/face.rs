//! The inside of a triangle: where its closest point to something convex lies there, and segments,
//! of which nothing else need be asked.

use super::gap::Nearest;
use super::segments;
use crate::math::Vec3;

/// Closest points of a triangle and a segment; equal where they overlap.
pub(super) fn to_segment(triangle: [Vec3; 3], p: Vec3, q: Vec3) -> (Vec3, Vec3) {
    seen_from_face(triangle, [p, q]).unwrap_or_else(|| {
        let mut best = Nearest::default();
        let [a, b, c] = triangle;
        for (from, to, behind) in [(a, b, c), (b, c, a), (c, a, b)] {
            let (x, y) = segments::closest(from, to, p, q);
            if (behind - x).dot(y - x) <= 0.0 {
                return (x, y);
            }
            best.offer((x, y));
        }
        best.points
    })
}

/// The closest points of a triangle and a convex solid if one is inside the triangle, and a common
/// point if the solid passes through the inside. `corners` are the solid's own, or those of its
/// points that lie lowest and highest above the triangle.
pub(super) fn seen_from_face<const N: usize>(
    triangle: [Vec3; 3],
    corners: [Vec3; N],
) -> Option<(Vec3, Vec3)> {
    let normal = normal(triangle);
    let heights = corners.map(|corner| normal.dot(corner - triangle[0]));
    let nearest =
        |sign: f64| (0..N).min_by(|&i, &j| (sign * heights[i]).total_cmp(&(sign * heights[j])));
    let lowest = if heights.iter().all(|h| *h > 0.0) {
        nearest(1.0)?
    } else if heights.iter().all(|h| *h < 0.0) {
        nearest(-1.0)?
    } else {
        return (0..N).find_map(|i| {
            let j = (i + 1) % N;
            let passes = (heights[i] > 0.0) != (heights[j] > 0.0);
            let at =
                corners[i] + (corners[j] - corners[i]) * (heights[i] / (heights[i] - heights[j]));
            (passes && is_over(triangle, normal, at)).then_some((at, at))
        });
    };
    let corner = corners[lowest];
    let foot = corner - normal * (heights[lowest] / normal.length_squared());
    is_over(triangle, normal, foot).then_some((foot, corner))
}

/// Normal of a triangle, not of unit length.
pub(super) fn normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).cross(c - a)
}

/// Whether a point of the triangle's plane is in the triangle.
fn is_over(triangle: [Vec3; 3], normal: Vec3, point: Vec3) -> bool {
    edges(triangle)
        .iter()
        .all(|(a, b)| (*b - *a).cross(point - *a).dot(normal) >= 0.0)
}

pub(super) fn edges([a, b, c]: [Vec3; 3]) -> [(Vec3, Vec3); 3] {
    [(a, b), (b, c), (c, a)]
}
