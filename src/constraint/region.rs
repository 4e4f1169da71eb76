//! Convex sets that a point or a direction may be in.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::collision::chain::angle_between;
use crate::math::{Quat, Vec3};

/// A convex set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Region {
    /// Directions within an angle of an axis.
    Cone {
        /// Its axis, of length 1.
        axis: Vec3,
        /// The angle (rad), above 0 and at most π/2: a wider cone is not convex.
        angle: f64,
    },
    /// Directions of a frame's z axis, as the reference sees it, with which the first two of the XYZ
    /// Euler angles are within tolerances: R = Rx(α) Ry(β) Rz(γ) has the third column
    /// (sin β, −sin α cos β, cos α cos β), so that |β| ≤ y is |u₁| ≤ sin y, and |α| ≤ x is
    /// |u₂| ≤ u₃ tan x. At β = ±π/2, where α is not defined, u₂ = u₃ = 0 is within any.
    EulerXy {
        /// The reference, as who sees the direction has it.
        turned: Quat,
        /// Most of |α| (rad), below π/2; from π on any.
        x: f64,
        /// Most of |β| (rad); from π/2 on any.
        y: f64,
    },
    /// Directions of the reference's x axis, as the frame sees it, with which the third of the angles is
    /// within a tolerance: the first row of R is (cos β cos γ, −cos β sin γ, sin β).
    EulerZ {
        /// The frame, as who sees the direction has it.
        turned: Quat,
        /// Most of |γ| (rad), below π/2; from π on any.
        z: f64,
    },
    /// Points in a box.
    Box {
        /// Its middle.
        center: Vec3,
        /// How it is turned.
        turned: Quat,
        /// Half of its sides (m).
        half: Vec3,
    },
    /// Points in a ball.
    Ball {
        /// Its centre.
        center: Vec3,
        /// Its radius (m).
        radius: f64,
    },
    /// Points in a cylinder.
    Cylinder(Cylinder),
    /// Points on the inner side of a plane.
    HalfSpace(HalfSpace),
    /// Numbers between two, as the first component.
    Range {
        /// The lower.
        lower: f64,
        /// The upper.
        upper: f64,
    },
}

/// A cylinder, whole with its inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// Its middle.
    pub center: Vec3,
    /// Its axis, of length 1.
    pub axis: Vec3,
    /// Its radius (m).
    pub radius: f64,
    /// Half of its length (m).
    pub half_length: f64,
}

impl Cylinder {
    /// Distance to the mantle and to the nearer cap, negative beyond it, and the outward direction of
    /// each, of length 1.
    fn sides(&self, at: Vec3) -> [(f64, Vec3); 2] {
        let (along, across) = parts(at - self.center, self.axis);
        [
            (self.radius - across.length(), unit(across, self.axis)),
            (self.half_length - along.abs(), self.axis * along.signum()),
        ]
    }

    /// The side that is nearest to a point, or that it is farthest beyond.
    fn side(&self, at: Vec3) -> usize {
        let [(mantle, _), (cap, _)] = self.sides(at);
        usize::from(mantle >= cap)
    }

    /// The same with tolerances greater by this (m).
    fn widened(self, by: f64) -> Self {
        Self {
            radius: self.radius + by,
            half_length: self.half_length + by,
            ..self
        }
    }

    /// The lesser of its tolerances (m).
    fn tolerance(&self) -> f64 {
        self.radius.min(self.half_length)
    }
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

    fn turned(self, turned: Quat) -> Self {
        Self {
            normal: turned * self.normal,
            ..self
        }
    }
}

/// What is said of a side that a region does not have.
const NO_SIDE: (f64, Vec3) = (f64::INFINITY, Vec3::ZERO);

impl Region {
    /// Whether it is convex and has an inside: what a proof rests on.
    pub fn is_convex(&self) -> bool {
        let wedge = |angle: f64| angle > 0.0 && !(FRAC_PI_2..PI).contains(&angle);
        match *self {
            Self::Cone { angle, .. } => angle > 0.0 && angle <= FRAC_PI_2,
            Self::EulerXy { x, y, .. } => wedge(x) && y > 0.0,
            Self::EulerZ { z, .. } => wedge(z),
            Self::Box { half, .. } => half.min_element() > 0.0,
            Self::Ball { radius, .. } => radius > 0.0,
            Self::Cylinder(cylinder) => cylinder.tolerance() > 0.0,
            Self::HalfSpace(_) => true,
            Self::Range { lower, upper } => lower < upper,
        }
    }

    /// The same with tolerances greater by this (rad or m, as its own are).
    #[must_use]
    pub fn widened(self, by: f64) -> Self {
        match self {
            Self::Cone { axis, angle } => Self::Cone {
                axis,
                angle: angle + by,
            },
            Self::EulerXy { turned, x, y } => Self::EulerXy {
                turned,
                x: if x < PI { x + by } else { x },
                y: if y < FRAC_PI_2 { y + by } else { y },
            },
            Self::EulerZ { turned, z } => Self::EulerZ { turned, z: z + by },
            Self::Box {
                center,
                turned,
                half,
            } => Self::Box {
                center,
                turned,
                half: half + Vec3::splat(by),
            },
            Self::Ball { center, radius } => Self::Ball {
                center,
                radius: radius + by,
            },
            Self::Cylinder(cylinder) => Self::Cylinder(cylinder.widened(by)),
            Self::HalfSpace(HalfSpace { normal, offset }) => Self::HalfSpace(HalfSpace {
                normal,
                offset: offset + by,
            }),
            Self::Range { lower, upper } => Self::Range {
                lower: lower - by,
                upper: upper + by,
            },
        }
    }

    /// How much of its tolerance is left, in its unit (rad for directions, m for points): negative
    /// outside.
    pub fn left(&self, at: Vec3) -> f64 {
        match *self {
            Self::Cone { axis, angle } => angle - angle_between(at, axis),
            Self::EulerXy { turned, x, y } => {
                let at = turned.inverse() * at;
                let alpha = (-at.y).atan2(at.z);
                let beta = at.x.atan2(at.y.hypot(at.z));
                (bounded(x, PI) - alpha.abs()).min(bounded(y, FRAC_PI_2) - beta.abs())
            }
            Self::EulerZ { turned, z } => {
                let at = turned.inverse() * at;
                z - (-at.y).atan2(at.x).abs()
            }
            Self::Box { .. }
            | Self::Ball { .. }
            | Self::Cylinder(_)
            | Self::HalfSpace(_)
            | Self::Range { .. } => self.depth(at),
        }
    }

    /// Distance to the outside (m; of a direction, as a point of the unit sphere); of what is outside,
    /// minus the distance to the region or less (a corner is farther than any of its planes).
    pub fn depth(&self, at: Vec3) -> f64 {
        match *self {
            Self::Cone { axis, angle } => {
                let inside = angle - angle_between(at, axis);
                // Beyond a right angle the apex is nearest.
                at.length() * inside.max(-FRAC_PI_2).sin()
            }
            Self::Ball { center, radius } => radius - at.distance(center),
            Self::Cylinder(cylinder) => cylinder.sides(at)[cylinder.side(at)].0,
            Self::EulerXy { .. }
            | Self::EulerZ { .. }
            | Self::Box { .. }
            | Self::HalfSpace(_)
            | Self::Range { .. } => self
                .planes()
                .map(|plane| plane.depth(at))
                .fold(f64::INFINITY, least),
        }
    }

    /// The least of its tolerances (rad or m, as its own are); ∞ where it has none.
    pub fn tolerance(&self) -> f64 {
        match *self {
            Self::Cone { angle, .. } => angle,
            Self::EulerXy { x, y, .. } => bounded(x, PI).min(bounded(y, FRAC_PI_2)),
            Self::EulerZ { z, .. } => z,
            Self::Box { half, .. } => half.min_element(),
            Self::Ball { radius, .. } => radius,
            Self::Cylinder(cylinder) => cylinder.tolerance(),
            Self::HalfSpace(_) => f64::INFINITY,
            Self::Range { lower, upper } => 0.5 * (upper - lower),
        }
    }

    /// Of the sides that make its boundary the one that is nearest, by its number: what has planes has
    /// one for each, a cylinder its mantle and its caps, others only one.
    pub fn side(&self, at: Vec3) -> usize {
        match *self {
            Self::Cone { .. } | Self::Ball { .. } => 0,
            Self::Cylinder(cylinder) => cylinder.side(at),
            Self::EulerXy { .. }
            | Self::EulerZ { .. }
            | Self::Box { .. }
            | Self::HalfSpace(_)
            | Self::Range { .. } => {
                let planes = self.planes().enumerate();
                let nearest = planes.min_by(|(_, a), (_, b)| a.depth(at).total_cmp(&b.depth(at)));
                nearest.map_or(0, |(side, _)| side)
            }
        }
    }

    /// Distance to one of its sides, negative beyond it, and the outward direction there, of length 1;
    /// as far as can be where it has no such side.
    pub fn beside(&self, side: usize, at: Vec3) -> (f64, Vec3) {
        match *self {
            Self::Cylinder(cylinder) => cylinder
                .sides(at)
                .get(side)
                .copied()
                .unwrap_or(NO_SIDE),
            Self::Cone { .. } | Self::Ball { .. } => (self.depth(at), self.outward(at)),
            Self::EulerXy { .. }
            | Self::EulerZ { .. }
            | Self::Box { .. }
            | Self::HalfSpace(_)
            | Self::Range { .. } => self
                .planes()
                .nth(side)
                .map_or(NO_SIDE, |plane| (plane.depth(at), plane.normal)),
        }
    }

    /// Outward direction at the point of the boundary that is nearest, of length 1; zero where there is
    /// no boundary.
    pub fn outward(&self, at: Vec3) -> Vec3 {
        match *self {
            Self::Cone { axis, angle } => {
                let across = unit(parts(at, axis).1, axis);
                // Perpendicular to the line of the cone that is nearest.
                across * angle.cos() - axis * angle.sin()
            }
            Self::Ball { center, .. } => unit(at - center, Vec3::Z),
            Self::Cylinder(_)
            | Self::EulerXy { .. }
            | Self::EulerZ { .. }
            | Self::Box { .. }
            | Self::HalfSpace(_)
            | Self::Range { .. } => self.beside(self.side(at), at).1,
        }
    }

    /// The planes of a region that has no other boundary.
    fn planes(&self) -> impl Iterator<Item = HalfSpace> {
        let planes: [Option<HalfSpace>; 6] = match *self {
            Self::EulerXy { turned, x, y } => {
                let [a, b] = wedge(x);
                let [c, d] = (y < FRAC_PI_2)
                    .then(|| slab(Vec3::X, y.sin()))
                    .map_or([None; 2], |planes| planes.map(Some));
                [a, b, c, d, None, None].map(|plane| plane.map(|plane| plane.turned(turned)))
            }
            Self::EulerZ { turned, z } => {
                let to_x = Quat::from_rotation_y(FRAC_PI_2);
                let [a, b] = wedge(z).map(|plane| plane.map(|plane| plane.turned(turned * to_x)));
                [a, b, None, None, None, None]
            }
            Self::Box {
                center,
                turned,
                half,
            } => {
                let [[a, b], [c, d], [e, f]] = [
                    slab(Vec3::X, half.x),
                    slab(Vec3::Y, half.y),
                    slab(Vec3::Z, half.z),
                ];
                [a, b, c, d, e, f].map(|plane| Some(about(plane.turned(turned), center)))
            }
            Self::HalfSpace(plane) => [Some(plane), None, None, None, None, None],
            Self::Range { lower, upper } => {
                let [a, b] = [(Vec3::X, upper), (-Vec3::X, -lower)]
                    .map(|(normal, offset)| Some(HalfSpace { normal, offset }));
                [a, b, None, None, None, None]
            }
            Self::Cone { .. } | Self::Ball { .. } | Self::Cylinder(_) => [None; 6],
        };
        planes.into_iter().flatten()
    }
}

/// Points no farther than this from the origin, along a side or against it.
fn slab(side: Vec3, half: f64) -> [HalfSpace; 2] {
    [side, -side].map(|normal| HalfSpace {
        normal,
        offset: half,
    })
}

/// The same plane, seen from where the origin is not `center`.
fn about(plane: HalfSpace, center: Vec3) -> HalfSpace {
    HalfSpace {
        offset: plane.offset + plane.normal.dot(center),
        ..plane
    }
}

/// |y| ≤ z tan(angle); all there is from π on.
fn wedge(angle: f64) -> [Option<HalfSpace>; 2] {
    [Vec3::Y, -Vec3::Y].map(|side| {
        (angle < PI).then(|| HalfSpace {
            normal: side * angle.cos() - Vec3::Z * angle.sin(),
            offset: 0.0,
        })
    })
}

/// The smaller of two; what is no number is not passed over.
pub(super) fn least(a: f64, b: f64) -> f64 {
    match a < b || a.is_nan() {
        true => a,
        false => b,
    }
}

/// A tolerance; from `free` on there is none.
fn bounded(tolerance: f64, free: f64) -> f64 {
    match tolerance < free {
        true => tolerance,
        false => f64::INFINITY,
    }
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

    fn euler_xy(x: f64, y: f64) -> Region {
        Region::EulerXy {
            turned: Quat::from_rotation_z(0.5),
            x,
            y,
        }
    }

    fn euler_z(z: f64) -> Region {
        Region::EulerZ {
            turned: Quat::from_rotation_y(0.2),
            z,
        }
    }

    fn regions() -> Vec<Region> {
        let axis = Vec3::new(0.36, 0.48, 0.8);
        vec![
            Region::Cone { axis, angle: 0.4 },
            Region::Cone {
                axis,
                angle: FRAC_PI_2,
            },
            Region::Box {
                center: axis,
                turned: Quat::from_rotation_y(0.3),
                half: Vec3::new(0.3, 0.5, 1.0),
            },
            euler_xy(0.3, 0.2),
            euler_xy(0.3, FRAC_PI_2),
            euler_z(0.7),
            Region::HalfSpace(HalfSpace {
                normal: axis,
                offset: 0.3,
            }),
            Region::Range {
                lower: -0.2,
                upper: 0.7,
            },
            Region::Ball {
                center: axis,
                radius: 0.7,
            },
            Region::Cylinder(Cylinder {
                center: axis,
                axis,
                radius: 0.4,
                half_length: 0.6,
            }),
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
            let reference = Quat::from_rotation_z(0.5);
            let column = reference * turned * Vec3::Z;
            let row = Quat::from_rotation_y(0.2) * turned.inverse() * Vec3::X;
            let parts = [(euler_xy(x, y), column), (euler_z(z), row)];
            prop_assert_eq!(by_angles, parts.iter().all(|(region, at)| region.depth(*at) > 0.0));
            let left = parts.map(|(region, at)| region.left(at));
            let least = within.into_iter().fold(f64::INFINITY, f64::min);
            prop_assert!((left[0].min(left[1]) - least).abs() < 1e-6, "{left:?} {within:?}");
        }
    }

    #[test]
    fn tolerances_beyond_the_convex_range_are_none_and_from_half_a_turn_on_all() {
        assert!(!euler_xy(1.6, 0.1).is_convex() && euler_xy(1.5, 3.0).is_convex());
        assert!(!euler_z(FRAC_PI_2).is_convex());
        assert!(!euler_z(0.0).is_convex());
        assert!(euler_xy(4.0, 4.0).is_convex());
        assert_eq!(euler_xy(4.0, 4.0).depth(-Vec3::Z), f64::INFINITY);
    }

    #[test]
    fn a_wider_region_has_as_much_more_left() {
        let at = Vec3::new(0.2, 0.1, 0.9);
        for region in regions() {
            let wider = region.widened(0.01);
            assert!(
                (wider.left(at) - region.left(at) - 0.01).abs() < 1e-12,
                "{region:?}"
            );
        }
    }

    #[test]
    fn the_nearest_side_is_the_boundary() {
        let mut rng = fastrand::Rng::with_seed(7);
        for region in regions() {
            for _ in 0..200 {
                let at = crate::testing::vector(&mut rng, 1.0);
                let (depth, outward) = region.beside(region.side(at), at);
                assert_eq!(depth, region.depth(at), "{region:?} at {at:?}");
                assert_eq!(outward, region.outward(at));
                assert!(region.tolerance() > 0.0);
            }
        }
    }
}
