//! Convex sets that a point, a direction or a joint's value may be in.

use std::f64::consts::FRAC_PI_2;

use crate::collision::chain::angle_between;
use crate::math::{Quat, Vec3};

/// A convex set; `depth` is the distance to its outside.
#[derive(Clone, Debug, PartialEq)]
pub enum Region {
    /// Directions within an angle of an axis.
    Cone {
        /// Its axis, of length 1.
        axis: Vec3,
        /// The angle (rad), above 0 and at most π/2: a wider cone is not convex.
        angle: f64,
    },
    /// What is on the inner side of each; all there is where there are none.
    HalfSpaces(Vec<HalfSpace>),
    /// A ball.
    Ball {
        /// Its centre.
        center: Vec3,
        /// Its radius (m).
        radius: f64,
    },
    /// A cylinder.
    Cylinder {
        /// Its middle.
        center: Vec3,
        /// Its axis, of length 1.
        axis: Vec3,
        /// Its radius (m).
        radius: f64,
        /// Half of its length (m).
        half_length: f64,
    },
}

/// Points y with normal · y ≤ offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    /// Outward, of length 1.
    pub normal: Vec3,
    /// How far the plane is from the origin along it (m).
    pub offset: f64,
}

impl HalfSpace {
    fn depth(&self, at: Vec3) -> f64 {
        self.offset - self.normal.dot(at)
    }
}

impl Region {
    /// A box about `center`, turned so, with these half sides (m).
    pub fn cuboid(center: Vec3, turned: Quat, half: Vec3) -> Self {
        let sides = [
            (Vec3::X, half.x),
            (Vec3::Y, half.y),
            (Vec3::Z, half.z),
        ];
        let planes = sides.into_iter().flat_map(|(side, half)| {
            let normal = turned * side;
            [normal, -normal].map(|normal| HalfSpace {
                normal,
                offset: normal.dot(center) + half,
            })
        });
        Self::HalfSpaces(planes.collect())
    }

    /// Numbers between two, as the first component of a vector.
    pub fn range(lower: f64, upper: f64) -> Self {
        Self::HalfSpaces(vec![
            HalfSpace {
                normal: Vec3::X,
                offset: upper,
            },
            HalfSpace {
                normal: -Vec3::X,
                offset: -lower,
            },
        ])
    }

    /// Where a frame's z axis, as the reference sees it, may be for the first two of the XYZ Euler
    /// angles to be within tolerances (rad); `None` where a tolerance leaves no convex set.
    ///
    /// R = Rx(α) Ry(β) Rz(γ) has the third column (sin β, −sin α cos β, cos α cos β): so |β| ≤ y is
    /// |u₁| ≤ sin y, and |α| ≤ x, x < π/2, is |u₂| ≤ u₃ tan x. At β = ±π/2, where α is not defined,
    /// u₂ = u₃ = 0 is within any.
    pub fn euler_xy(x: f64, y: f64) -> Option<Self> {
        let mut planes = Vec::new();
        if y < FRAC_PI_2 {
            planes.extend([Vec3::X, -Vec3::X].map(|normal| HalfSpace {
                normal,
                offset: y.sin(),
            }));
        }
        planes.extend(wedge(x, Vec3::Y, Vec3::Z)?);
        Some(Self::HalfSpaces(planes))
    }

    /// Where the reference's x axis, as the frame sees it, may be for the third of the angles to be
    /// within a tolerance (rad): the first row of R is (cos β cos γ, −cos β sin γ, sin β).
    pub fn euler_z(z: f64) -> Option<Self> {
        wedge(z, Vec3::Y, Vec3::X).map(Self::HalfSpaces)
    }

    /// Distance to the outside; of what is outside, minus the distance to the region, or more (a corner
    /// is farther than any of its planes).
    pub fn depth(&self, at: Vec3) -> f64 {
        match *self {
            Self::Cone { axis, angle } => {
                let inside = angle - angle_between(at, axis);
                // Beyond a right angle the apex is nearest.
                at.length() * inside.max(-FRAC_PI_2).sin()
            }
            Self::HalfSpaces(ref planes) => {
                let depths = planes.iter().map(|plane| plane.depth(at));
                depths.fold(f64::INFINITY, f64::min)
            }
            Self::Ball { center, radius } => radius - at.distance(center),
            Self::Cylinder {
                center,
                axis,
                radius,
                half_length,
            } => {
                let (along, across) = parts(at - center, axis);
                (radius - across.length()).min(half_length - along.abs())
            }
        }
    }

    /// Outward direction at the point of the boundary that is nearest, of length 1.
    pub fn outward(&self, at: Vec3) -> Vec3 {
        match *self {
            Self::Cone { axis, angle } => {
                let across = unit(parts(at, axis).1, axis);
                // Perpendicular to the line of the cone that is nearest.
                across * angle.cos() - axis * angle.sin()
            }
            Self::HalfSpaces(ref planes) => {
                let least = planes
                    .iter()
                    .min_by(|a, b| a.depth(at).total_cmp(&b.depth(at)));
                least.map_or(Vec3::ZERO, |plane| plane.normal)
            }
            Self::Ball { center, .. } => unit(at - center, Vec3::Z),
            Self::Cylinder {
                center,
                axis,
                radius,
                half_length,
            } => {
                let (along, across) = parts(at - center, axis);
                if radius - across.length() < half_length - along.abs() {
                    unit(across, axis)
                } else {
                    axis * along.signum()
                }
            }
        }
    }
}

/// |side| ≤ middle · tan(angle): the wedge of this half angle about `middle`, across `side`; all there is
/// from π on, `None` where it is not convex.
fn wedge(angle: f64, side: Vec3, middle: Vec3) -> Option<Vec<HalfSpace>> {
    if angle >= std::f64::consts::PI {
        return Some(Vec::new());
    }
    let plane = |side: Vec3| HalfSpace {
        normal: side * angle.cos() - middle * angle.sin(),
        offset: 0.0,
    };
    (angle < FRAC_PI_2).then(|| vec![plane(side), plane(-side)])
}

/// What of a vector is along an axis, and what is across it.
fn parts(v: Vec3, axis: Vec3) -> (f64, Vec3) {
    let along = v.dot(axis);
    (along, v - axis * along)
}

/// A vector at length 1; of none, some direction across `fallback`.
fn unit(v: Vec3, fallback: Vec3) -> Vec3 {
    v.try_normalize()
        .unwrap_or_else(|| fallback.any_orthonormal_vector())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn regions() -> Vec<Region> {
        let axis = Vec3::new(0.36, 0.48, 0.8);
        vec![
            Region::Cone { axis, angle: 0.4 },
            Region::Cone {
                axis,
                angle: FRAC_PI_2,
            },
            Region::cuboid(axis, Quat::from_rotation_y(0.3), Vec3::new(0.3, 0.5, 1.0)),
            Region::euler_xy(0.3, 0.2).unwrap(),
            Region::euler_xy(0.3, FRAC_PI_2).unwrap(),
            Region::euler_z(0.7).unwrap(),
            Region::Ball {
                center: axis,
                radius: 0.7,
            },
            Region::Cylinder {
                center: axis,
                axis,
                radius: 0.4,
                half_length: 0.6,
            },
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(10_000))]

        /// Whatever is nearer than the depth is inside, and one step outward by the depth is not.
        #[test]
        fn depth_is_the_distance_to_the_outside(
            at in prop::array::uniform3(-1.5..1.5_f64),
            to in prop::array::uniform3(-1.0..1.0_f64),
            part in 0.0..1.0_f64,
        ) {
            let at = Vec3::from_array(at);
            let to = unit(Vec3::from_array(to), Vec3::X);
            for region in regions() {
                let depth = region.depth(at);
                if depth > 0.0 {
                    prop_assert!(region.depth(at + to * (depth * part)) > -1e-12, "{region:?}");
                    let out = at + region.outward(at) * (depth + 1e-9);
                    prop_assert!(region.depth(out) < 1e-8, "{region:?} {at}");
                } else {
                    // A plane parts it from the region, as far as that says.
                    let outward = region.outward(at);
                    let back = at + outward * (depth * 0.999);
                    prop_assert!(region.depth(back) < 1e-9, "{region:?} {at}");
                }
            }
        }

        /// Orientations within the tolerances of MoveIt's formula, and no others.
        #[test]
        fn half_spaces_are_the_euler_angles(
            alpha in -3.1..3.1_f64,
            beta in -1.57..1.57_f64,
            gamma in -3.1..3.1_f64,
            x in 0.01..1.5_f64,
            y in 0.01..1.57_f64,
            z in 0.01..1.5_f64,
        ) {
            let turned = Quat::from_rotation_x(alpha)
                * Quat::from_rotation_y(beta)
                * Quat::from_rotation_z(gamma);
            let within = [(alpha, x), (beta, y), (gamma, z)].map(|(angle, most)| most - angle.abs());
            prop_assume!(within.iter().all(|room| room.abs() > 1e-9));
            let by_angles = within.iter().all(|room| *room > 0.0);
            let by_planes = Region::euler_xy(x, y).unwrap().depth(turned * Vec3::Z) > 0.0
                && Region::euler_z(z).unwrap().depth(turned.inverse() * Vec3::X) > 0.0;
            prop_assert_eq!(by_angles, by_planes);
        }
    }

    #[test]
    fn tolerances_beyond_the_convex_range_are_none_and_from_half_a_turn_on_all() {
        assert_eq!(Region::euler_xy(1.6, 0.1), None);
        assert_eq!(Region::euler_z(FRAC_PI_2), None);
        assert_eq!(Region::euler_z(4.0), Some(Region::HalfSpaces(Vec::new())));
        let all = Region::euler_xy(4.0, 4.0).unwrap();
        assert_eq!(all.depth(-Vec3::Z), f64::INFINITY);
    }
}
