//! What triangles enclose.

use super::edges::Triangle;
use crate::math::Vec3;

/// A surface encloses less than this part of its size cubed: none.
const NO_VOLUME: f64 = 1e-12;

/// The least and the greatest coordinates of points.
pub(super) fn bounds(points: impl Iterator<Item = Vec3>) -> (Vec3, Vec3) {
    points.fold(
        (Vec3::INFINITY, Vec3::NEG_INFINITY),
        |(low, high), point| (low.min(point), high.max(point)),
    )
}

/// The corners of triangles, one triangle after the other.
pub(super) fn corners_of(vertices: &[Vec3], triangles: &[Triangle]) -> impl Iterator<Item = Vec3> {
    triangles
        .iter()
        .flatten()
        .map(|&i| vertices[i as usize])
}

/// Whether triangles enclose no volume.
pub(super) fn is_flat(vertices: &[Vec3], triangles: &[Triangle]) -> bool {
    let (low, high) = bounds(corners_of(vertices, triangles));
    volume(vertices, triangles).abs() <= NO_VOLUME * (high - low).length().powi(3)
}

/// Volume that triangles enclose (m³); negative where they face inwards.
pub(super) fn volume(vertices: &[Vec3], triangles: &[Triangle]) -> f64 {
    // The first one has a corner at the origin.
    let Some((first, others)) = triangles.split_first() else {
        return 0.0;
    };
    let origin = vertices[first[0] as usize];
    let six_fold = others
        .iter()
        .map(|t| six_fold(vertices, t, origin));
    six_fold.sum::<f64>() / 6.0
}

/// Six times the signed volume between a triangle and a point.
pub(super) fn six_fold(vertices: &[Vec3], triangle: &Triangle, origin: Vec3) -> f64 {
    let [a, b, c] = triangle.map(|i| vertices[i as usize] - origin);
    a.dot(b.cross(c))
}

/// Signed solid angle of a triangle seen from the origin (van Oosterom and Strackee, 1983).
pub fn solid_angle([a, b, c]: [Vec3; 3]) -> f64 {
    let la = a.length();
    let lb = b.length();
    let lc = c.length();
    let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * a.dot(b.cross(c)).atan2(denominator)
}
