//! Regions as the page draws them: solids of points, edges of directions.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use taut::constraint::Region;
use taut::math::{Pose, Quat, Vec3};
use taut::shape::{PlacedShape, Shape};

use super::shapes::{Meshes, Solid};

/// Points of each edge.
const POINTS: usize = 64;

/// A region of points as a solid; `None` of others, and of those without an end.
pub(super) fn solid(region: &Region, meshes: &mut Meshes) -> Option<Solid> {
    let placed = |center: Vec3, turned: Quat, shape: Shape| PlacedShape {
        pose: Pose::from_parts(center, turned),
        shape,
    };
    let shape = match *region {
        Region::Box {
            center,
            turned,
            half,
        } => placed(center, turned, Shape::Box { half_extents: half }),
        Region::Ball { center, radius } => placed(center, Quat::IDENTITY, Shape::Sphere { radius }),
        Region::Cylinder(cylinder) => placed(
            cylinder.center,
            Quat::from_rotation_arc(Vec3::Z, cylinder.axis),
            Shape::Cylinder {
                radius: cylinder.radius,
                half_height: cylinder.half_length,
            },
        ),
        Region::Cone { .. }
        | Region::EulerXy { .. }
        | Region::EulerZ { .. }
        | Region::HalfSpace(_)
        | Region::Range { .. } => return None,
    };
    Some(Solid::of(&shape, meshes))
}

/// Closed edges of a region of directions, on the unit sphere; none of others.
pub(super) fn edges(region: &Region) -> Vec<Vec<[f64; 3]>> {
    match *region {
        Region::Cone { axis, angle } => {
            let turned = Quat::from_rotation_arc(Vec3::Z, axis);
            vec![closed(|around| turned * polar(angle, around))]
        }
        Region::EulerXy { turned, x, y } => {
            let y = y.min(FRAC_PI_2);
            match x < PI {
                true => vec![frame(x, y, |alpha, beta| {
                    turned * third_column(alpha, beta)
                })],
                false => [y, -y]
                    .map(|beta| closed(|alpha| turned * third_column(alpha, beta)))
                    .into(),
            }
        }
        Region::EulerZ { turned, z } => {
            vec![frame(z.min(PI), FRAC_PI_2, |gamma, beta| {
                turned * first_row(beta, gamma)
            })]
        }
        Region::Box { .. }
        | Region::Ball { .. }
        | Region::Cylinder(_)
        | Region::HalfSpace(_)
        | Region::Range { .. } => Vec::new(),
    }
}

/// The direction at an angle from z, so far around it.
fn polar(angle: f64, around: f64) -> Vec3 {
    let (sin, cos) = angle.sin_cos();
    Vec3::new(sin * around.cos(), sin * around.sin(), cos)
}

/// Of Rx(α) Ry(β) Rz(γ).
fn third_column(alpha: f64, beta: f64) -> Vec3 {
    let (sin, cos) = beta.sin_cos();
    Vec3::new(sin, -alpha.sin() * cos, alpha.cos() * cos)
}

/// Of Rx(α) Ry(β) Rz(γ).
fn first_row(beta: f64, gamma: f64) -> Vec3 {
    let (sin, cos) = beta.sin_cos();
    Vec3::new(cos * gamma.cos(), -cos * gamma.sin(), sin)
}

/// A closed line of a number that goes once round.
fn closed(at: impl Fn(f64) -> Vec3) -> Vec<[f64; 3]> {
    let step = TAU / POINTS as f64;
    (0..=POINTS)
        .map(|point| at(point as f64 * step).to_array())
        .collect()
}

/// The edge of |a| ≤ `a`, |b| ≤ `b`.
fn frame(a: f64, b: f64, at: impl Fn(f64, f64) -> Vec3) -> Vec<[f64; 3]> {
    let corners = [(-a, -b), (a, -b), (a, b), (-a, b), (-a, -b)];
    let side = POINTS / 4;
    let mut edge = Vec::with_capacity(POINTS + 1);
    for pair in corners.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        edge.extend((0..side).map(|point| {
            let t = point as f64 / side as f64;
            at(from.0 + t * (to.0 - from.0), from.1 + t * (to.1 - from.1)).to_array()
        }));
    }
    edge.push(at(-a, -b).to_array());
    edge
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every point of an edge is a direction of which nothing is left, and edges are closed.
    #[test]
    fn edges_are_where_nothing_is_left() {
        let turned = Quat::from_rotation_x(0.4) * Quat::from_rotation_z(1.0);
        for region in [
            Region::Cone {
                axis: turned * Vec3::X,
                angle: 0.3,
            },
            Region::EulerXy {
                turned,
                x: 0.3,
                y: 0.2,
            },
            Region::EulerXy {
                turned,
                x: 4.0,
                y: 0.2,
            },
            Region::EulerXy {
                turned,
                x: 0.3,
                y: 2.0,
            },
            Region::EulerZ { turned, z: 0.5 },
        ] {
            let edges = edges(&region);
            assert!(!edges.is_empty());
            for edge in edges {
                assert_eq!(edge.len(), POINTS + 1);
                let ends = [edge[0], edge[POINTS]].map(Vec3::from_array);
                assert!(ends[0].distance(ends[1]) < 1e-12, "{region:?}");
                for point in edge {
                    let at = Vec3::from_array(point);
                    assert!((at.length() - 1.0).abs() < 1e-12);
                    assert!(region.depth(at).abs() < 1e-12, "{region:?} at {at}");
                }
            }
        }
    }
}
