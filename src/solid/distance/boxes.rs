//! Boxes against boxes and cylinders.
//!
//! A box's closest point lies on an edge, or inside of a face. Inside of a face the direction is
//! the face's, so the other solid's point lowest above it is a closest one. Only faces beyond which
//! the other's middle lies can have a part in the direction of the least distance, and of the edges
//! only theirs.

use super::gap::{Nearest, is_certain};
use super::segment;
use crate::math::{Mat3, Vec3};
use crate::solid::core::Core;
use crate::solid::transform::Transform;

/// Closest points of a box and a box or cylinder; equal where they overlap.
pub(super) fn to_solid(center: Vec3, axes: Mat3, half: Vec3, other: &Core) -> (Vec3, Vec3) {
    let into = axes.transpose();
    let other = other.transformed(&Transform {
        rotation: into,
        translation: -(into * center),
    });
    let (on_box, on_other) = upright_to_solid(half, &other);
    (center + axes * on_box, center + axes * on_other)
}

/// The same for a box about the origin, along the axes.
fn upright_to_solid(half: Vec3, other: &Core) -> (Vec3, Vec3) {
    let middle = other.center();
    let seen = [0, 1, 2].map(|i| middle[i].abs() > half[i]);
    if seen == [false; 3] {
        return (middle, middle);
    }
    if let Some(points) = (0..3)
        .filter(|&i| seen[i])
        .find_map(|i| seen_from_face(half, i, middle, other))
    {
        return points;
    }
    let this = Core::Box {
        center: Vec3::ZERO,
        axes: Mat3::IDENTITY,
        half,
    };
    let mut best = Nearest::default();
    // Edges between two such faces first: the closest points are most often there.
    for wanted in [2, 1] {
        for along in 0..3 {
            let j = (along + 1) % 3;
            let k = (along + 2) % 3;
            for (side_j, side_k) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                let faces = usize::from(side_j * middle[j] > half[j])
                    + usize::from(side_k * middle[k] > half[k]);
                if faces != wanted {
                    continue;
                }
                let mut from = Vec3::ZERO;
                from[along] = -half[along];
                from[j] = side_j * half[j];
                from[k] = side_k * half[k];
                let mut to = from;
                to[along] = half[along];
                let points = segment::closest(from, to, other);
                if is_certain(&this, other, points) {
                    return points;
                }
                best.offer(points);
            }
        }
    }
    best.points
}

/// The closest points if one is inside of the face across axis `i` that looks at `middle`, and a
/// common point if the other solid passes through the inside of the face.
fn seen_from_face(half: Vec3, i: usize, middle: Vec3, other: &Core) -> Option<(Vec3, Vec3)> {
    let mut outwards = Vec3::ZERO;
    outwards[i] = middle[i].signum();
    let lowest = other.support(-outwards);
    let height = outwards.dot(lowest) - half[i];
    let top = outwards.dot(middle) - half[i];
    // Where the other dips below the face's plane: the place where it passes.
    let corner = if height > 0.0 {
        lowest
    } else {
        lowest + (middle - lowest) * (height / (height - top))
    };
    let mut foot = corner;
    foot[i] = outwards[i] * half[i];
    let is_over = (0..3).all(|j| j == i || foot[j].abs() <= half[j]);
    is_over.then_some((foot, if height > 0.0 { corner } else { foot }))
}
