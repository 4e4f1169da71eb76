//! Segments against cores, in closed form; against a cylinder by the root of a monotone function.

use super::point::{self, closest_on, on_segment};
use super::{face, segments};
use crate::math::{Mat3, Vec3};
use crate::solid::core::Core;

/// Closest points of the segment from `p` to `q` and of a core; equal where they overlap.
pub(super) fn closest(p: Vec3, q: Vec3, other: &Core) -> (Vec3, Vec3) {
    match *other {
        Core::Point(a) => (on_segment(p, q, a), a),
        Core::Segment(a, b) => segments::closest(p, q, a, b),
        Core::Triangle(a, b, c) => {
            let (on_triangle, on_segment) = face::to_segment([a, b, c], p, q);
            (on_segment, on_triangle)
        }
        Core::Box { center, axes, half } => to_box(p, q, center, axes, half),
        Core::Cylinder {
            center,
            axes,
            half_height,
            radius,
        } => {
            let start = axes.transpose() * (p - center);
            let along = axes.transpose() * (q - p);
            let on_segment = p + (q - p) * nearest_to_cylinder(start, along, half_height, radius);
            (on_segment, closest_on(other, on_segment))
        }
    }
}

/// The squared distance to a box is convex and piecewise quadratic along the segment: its slope is
/// linear between the places where the segment crosses a plane of the box's faces.
fn to_box(p: Vec3, q: Vec3, center: Vec3, axes: Mat3, half: Vec3) -> (Vec3, Vec3) {
    let start = axes.transpose() * (p - center);
    let along = axes.transpose() * (q - p);
    let outside = |s: f64| {
        let x = start + along * s;
        x - x.clamp(-half, half)
    };
    let place = |s: f64| {
        let x = start + along * s;
        (p + (q - p) * s, center + axes * x.clamp(-half, half))
    };
    let mut low = 0.0;
    let mut high = 1.0;
    let mut falling = along.dot(outside(0.0));
    let mut rising = along.dot(outside(1.0));
    if falling >= 0.0 {
        return place(0.0);
    }
    if rising <= 0.0 {
        return place(1.0);
    }
    for i in 0..3 {
        for side in [-half[i], half[i]] {
            let s = (side - start[i]) / along[i];
            if s > low && s < high {
                let slope = along.dot(outside(s));
                if slope < 0.0 {
                    low = s;
                    falling = slope;
                } else {
                    high = s;
                    rising = slope;
                }
            }
        }
    }
    place(low + (high - low) * (falling / (falling - rising)))
}

/// Place of the segment's point closest to an upright cylinder. The squared distance is convex
/// along the segment, so its slope has one change of sign, which false position (with the Illinois
/// rule) encloses.
fn nearest_to_cylinder(start: Vec3, along: Vec3, half_height: f64, radius: f64) -> f64 {
    let slope = |s: f64| {
        let x = start + along * s;
        along.dot(x - point::in_upright_cylinder(half_height, radius, x))
    };
    let mut low = 0.0;
    let mut high = 1.0;
    let mut falling = slope(0.0);
    let mut rising = slope(1.0);
    if falling >= 0.0 {
        return 0.0;
    }
    if rising <= 0.0 {
        return 1.0;
    }
    // Between the places where the segment crosses the planes of the lids and the side, the slope
    // is smooth.
    for s in crossings(start, along, half_height, radius) {
        if s > low && s < high {
            let here = slope(s);
            if here < 0.0 {
                low = s;
                falling = here;
            } else {
                high = s;
                rising = here;
            }
        }
    }
    let enough = 1e-16 * (rising - falling);
    let mut last_was_low = None;
    for _ in 0..MOST_STEPS {
        let s = low + (high - low) * (falling / (falling - rising));
        let here = slope(s);
        if here.abs() <= enough || high - low <= f64::EPSILON {
            return s;
        }
        let is_low = here < 0.0;
        if is_low {
            low = s;
            falling = here;
            rising *= if last_was_low == Some(true) { 0.5 } else { 1.0 };
        } else {
            high = s;
            rising = here;
            falling *= if last_was_low == Some(false) {
                0.5
            } else {
                1.0
            };
        }
        last_was_low = Some(is_low);
    }
    low + (high - low) * 0.5
}

/// Places where a line crosses the planes of the lids and the side of an upright cylinder; not
/// finite where it does not.
fn crossings(start: Vec3, along: Vec3, half_height: f64, radius: f64) -> [f64; 4] {
    let square = along.x * along.x + along.y * along.y;
    let middle = -(start.x * along.x + start.y * along.y) / square;
    let beside = (start.x * along.y - start.y * along.x).powi(2) / square;
    let reach = ((radius * radius - beside) / square).sqrt();
    [
        (-half_height - start.z) / along.z,
        (half_height - start.z) / along.z,
        middle - reach,
        middle + reach,
    ]
}

/// Far more than false position needs.
const MOST_STEPS: usize = 100;
