//! Flat polygons as triangles, by cutting off ears.

use crate::math::Vec3;

/// Triangles that fill a polygon, as positions among its corners, with its winding; none for fewer than three
/// corners.
///
/// A polygon that is not convex is never filled beyond its outline. One that crosses itself has no inside; its
/// rest is then filled as a fan.
pub(super) fn triangulate(corners: &[Vec3]) -> Vec<[usize; 3]> {
    if corners.len() < 3 {
        return Vec::new();
    }
    let flat = flatten(corners);
    let mut left: Vec<usize> = (0..corners.len()).collect();
    let mut triangles = Vec::with_capacity(corners.len() - 2);
    while left.len() > 3 {
        let Some(ear) = (0..left.len()).find(|&at| is_ear(&flat, &left, at)) else { break };
        triangles.push(around(&left, ear));
        left.remove(ear);
    }
    triangles.extend((1..left.len() - 1).map(|at| [left[0], left[at], left[at + 1]]));
    triangles
}

/// The corners along the polygon's normal, turning counter-clockwise.
fn flatten(corners: &[Vec3]) -> Vec<[f64; 2]> {
    // Newell's normal is right for polygons that are not convex, or not quite flat.
    let next = corners.iter().cycle().skip(1);
    let origin = corners[0];
    let normal: Vec3 = corners.iter().zip(next).map(|(a, b)| (*a - origin).cross(*b - origin)).sum();
    let (x, y) = normal.try_normalize().unwrap_or(Vec3::Z).any_orthonormal_pair();
    // The pair may turn either way about the normal.
    let y = if x.cross(y).dot(normal) < 0.0 { -y } else { y };
    corners.iter().map(|corner| [(*corner - origin).dot(x), (*corner - origin).dot(y)]).collect()
}

fn around(left: &[usize], at: usize) -> [usize; 3] {
    [left[(at + left.len() - 1) % left.len()], left[at], left[(at + 1) % left.len()]]
}

/// Whether the triangle at a corner lies inside the polygon, with no other corner in it.
fn is_ear(flat: &[[f64; 2]], left: &[usize], at: usize) -> bool {
    let triangle = around(left, at);
    let [a, b, c] = triangle.map(|i| flat[i]);
    if turn(a, b, c) <= 0.0 {
        return false;
    }
    let inside = |p: [f64; 2]| turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
    // A polygon with a slit to a hole comes back to the same place: that is no corner in between.
    let other = |i: &&usize| !triangle.contains(i) && ![a, b, c].contains(&flat[**i]);
    !left.iter().filter(other).any(|&i| inside(flat[i]))
}

/// Twice the area of a triangle, positive where it turns counter-clockwise.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::quat_exp;

    fn areas(corners: &[Vec3]) -> Vec<Vec3> {
        let area = |t: [usize; 3]| {
            let [a, b, c] = t.map(|i| corners[i]);
            (b - a).cross(c - a) / 2.0
        };
        triangulate(corners).into_iter().map(area).collect()
    }

    /// The areas of the triangles add up to the outline's only if none lies outside it.
    #[test]
    fn a_polygon_is_filled_to_its_outline_whatever_its_form_and_place() {
        let arrow = [[0.0, 0.0], [2.0, 1.0], [0.0, 2.0], [0.5, 1.0]];
        let comb = [[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [3.0, 2.0], [3.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let edge = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]];
        for (outline, area) in [(&arrow[..], 1.5), (&comb[..], 6.0), (&edge[..], 2.0)] {
            for turn in [Vec3::ZERO, Vec3::new(1.0, -2.0, 0.5), Vec3::X * std::f64::consts::PI] {
                let rotation = quat_exp(turn);
                for start in 0..outline.len() {
                    let cycled = outline.iter().cycle().skip(start).take(outline.len());
                    let corners: Vec<Vec3> =
                        cycled.map(|p| rotation * Vec3::new(p[0], p[1], 0.3) + Vec3::new(5.0, 1.0, -2.0)).collect();
                    let (parts, normal) = (areas(&corners), rotation * Vec3::Z);
                    assert_eq!(parts.len(), corners.len() - 2);
                    let filled: f64 = parts.iter().map(|part| part.length()).sum();
                    assert!((filled - area).abs() < 1e-12, "{outline:?} from {start}: {filled}");
                    assert!(parts.iter().all(|part| part.dot(normal) >= 0.0), "turned over: {outline:?}");
                }
            }
        }
    }

    #[test]
    fn what_has_no_inside_still_gives_triangles() {
        assert!(triangulate(&[Vec3::ZERO, Vec3::X]).is_empty());
        assert_eq!(triangulate(&[Vec3::ZERO, Vec3::X, Vec3::X * 2.0, Vec3::X * 3.0]).len(), 2);
        assert_eq!(triangulate(&[Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ONE]).len(), 2, "crosses itself");
    }
}
