//! Forward kinematics of eight configurations at once, in f32, for the filter.
//!
//! Frames stand only at joints that can move; what is fixed to them is folded into constants. Each
//! frame is turned so that its joint's axis is z. Velocities are *half displacements*: velocity
//! times the half width of an interval, so that every lane may belong to an interval of another
//! segment.

mod segments;

use super::joint::{Drive, JointKind};
use super::model::RobotModel;
#[cfg(test)]
use crate::lanes::LANES;
use crate::lanes::{Axes, Eight, Lanes, Packed, Vectors, sin_cos};
use crate::math::{Mat3, Pose, Quat, Vec3};
pub use segments::{LaneCurve, LaneInput, LaneInterval, LaneSegments};

/// A joint that can move, as the lanes see it.
#[derive(Clone, Debug)]
struct LaneJoint {
    /// Frame that it hangs on; 0 is the world.
    parent: usize,
    /// Its fixed part: rotation by columns (`None`: none) and translation (m).
    rotation: Option<[[f32; 3]; 3]>,
    translation: [f32; 3],
    kind: JointKind,
    /// First input value and first rate; `None` for a joint that holds still.
    value: usize,
    rate: Option<usize>,
    factor: f32,
    offset: f32,
    /// Value from which a prismatic joint's shift is counted (m).
    rest: f32,
}

/// The moving skeleton of a robot. Frame 0 is the world, frame k + 1 is carried by the k-th moving
/// joint.
#[derive(Clone, Debug)]
pub struct Skeleton {
    joints: Vec<LaneJoint>,
    /// Frame that carries each link, and the link's pose in it.
    links: Vec<(usize, Pose)>,
    /// Joint of the robot that carries each frame but the first.
    movers: Vec<usize>,
    columns: usize,
    /// Sum of the lengths of all fixed parts (m): no point of the skeleton with translations at 0
    /// is farther out.
    extent: f64,
}

/// Where a frame is in each lane, and how it moves.
#[derive(Clone, Copy, Debug)]
pub struct LaneFrame {
    /// Axes.
    pub axes: [[Packed; 3]; 3],
    /// Origin (m).
    pub origin: [Packed; 3],
    /// Half turn (rad).
    pub angular: [Packed; 3],
    /// Half displacement of the origin (m).
    pub linear: [Packed; 3],
}

/// How much a joint alone moves in half an interval.
#[derive(Clone, Copy, Debug)]
pub struct LaneMotion {
    /// Size of its turn (rad).
    pub turn: Packed,
    /// Size of its translation (m).
    pub slide: Packed,
    /// How far its translation is from rest (m), anywhere on the interval.
    pub shift: Packed,
}

/// How far a joint alone gets on an interval of a curve from where its rate in the middle would take it.
#[derive(Clone, Copy, Debug)]
pub struct LaneBulge {
    /// Size of the turn (rad).
    pub turn: Packed,
    /// Size of the translation (m).
    pub slide: Packed,
}

/// What [`Skeleton::update`] makes.
#[derive(Clone, Debug, Default)]
pub struct Placed {
    /// Where each frame is.
    pub frames: Vec<LaneFrame>,
    /// Of each moving joint.
    pub motions: Vec<LaneMotion>,
    /// Of each moving joint, on curves alone.
    pub bulges: Vec<LaneBulge>,
}

const ZERO: Packed = Packed(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);

impl LaneFrame {
    const WORLD: Self = {
        const ONE: Packed = Packed(1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0);
        Self {
            axes: [[ONE, ZERO, ZERO], [ZERO, ONE, ZERO], [ZERO, ZERO, ONE]],
            origin: [ZERO; 3],
            angular: [ZERO; 3],
            linear: [ZERO; 3],
        }
    };

    /// World place and half displacement of a point of the frame.
    #[inline(always)]
    pub fn point<S: Eight>(&self, simd: S, p: [f32; 3]) -> (Vectors<S>, Vectors<S>) {
        let arm = Axes::new(simd, &self.axes).combine_constant(p);
        let angular = Vectors::new(simd, self.angular);
        (
            Vectors::new(simd, self.origin) + arm,
            Vectors::new(simd, self.linear) + angular.cross(arm),
        )
    }
}

#[cfg(test)]
impl LaneFrame {
    /// World place of a point of the frame in one lane.
    pub(crate) fn lane(&self, lane: usize, p: [f32; 3]) -> [f32; 3] {
        struct Place<'a>(&'a LaneFrame, [f32; 3]);
        impl crate::lanes::EightWide for Place<'_> {
            type Output = [Packed; 3];
            #[inline(always)]
            fn run<S: Eight>(self, simd: S) -> [Packed; 3] {
                self.0.point(simd, self.1).0.packed()
            }
        }
        let place = crate::lanes::InstructionSet::default().run(Place(self, p));
        place.map(|lanes| pulp::cast::<Packed, [f32; LANES]>(lanes)[lane])
    }
}

impl Skeleton {
    /// The skeleton of a robot; `rest` is the value (m) of a prismatic joint that its shift is
    /// counted from.
    pub fn new(robot: &RobotModel, rest: impl Fn(usize) -> f64) -> Self {
        let mut skeleton = Self {
            joints: Vec::new(),
            links: Vec::new(),
            movers: Vec::new(),
            columns: robot.space().nq(),
            extent: 0.0,
        };
        for (index, joint) in robot.joints().iter().enumerate() {
            let (parent, place) = joint
                .parent
                .map_or((0, Pose::identity()), |parent| skeleton.links[parent]);
            let place = place * joint.origin;
            if joint.kind == JointKind::Fixed {
                skeleton.links.push((parent, place));
                continue;
            }
            let (driver, factor, offset) = match joint.drive {
                Drive::Mimic {
                    master,
                    multiplier,
                    offset,
                } => (robot.joints()[master].drive, multiplier, offset),
                own @ (Drive::Fixed | Drive::Variable { .. } | Drive::Held { .. }) => {
                    (own, 1.0, 0.0)
                }
            };
            let (value, rate) = match driver {
                Drive::Variable { q, v } => (q, Some(v)),
                Drive::Held { first } => (skeleton.columns + first, None),
                Drive::Fixed | Drive::Mimic { .. } => {
                    unreachable!("a movable joint is driven by a variable or held")
                }
            };
            // The frame stands turned against its link: its joint's axis becomes z.
            let turn = match joint.kind {
                JointKind::Planar | JointKind::Floating => Quat::IDENTITY,
                JointKind::Fixed
                | JointKind::Revolute
                | JointKind::Continuous
                | JointKind::Prismatic => Quat::from_rotation_arc(Vec3::Z, joint.axis.normalize()),
            };
            skeleton.extent += place.translation.length();
            let columns = Mat3::from_quat(place.rotation * turn);
            skeleton.joints.push(LaneJoint {
                parent,
                rotation: (columns != Mat3::IDENTITY)
                    .then(|| [columns.x_axis, columns.y_axis, columns.z_axis].map(single)),
                translation: single(place.translation),
                kind: joint.kind,
                value,
                rate,
                factor: factor as f32,
                offset: offset as f32,
                rest: if joint.kind == JointKind::Prismatic {
                    rest(index) as f32
                } else {
                    0.0
                },
            });
            skeleton.movers.push(index);
            skeleton.links.push((
                skeleton.joints.len(),
                Pose::from_parts(Vec3::ZERO, turn.conjugate()),
            ));
        }
        skeleton
    }

    /// Frames, the world among them.
    pub fn frames(&self) -> usize {
        self.joints.len() + 1
    }
    /// Frame that carries a link, and the link's pose in it.
    pub fn carrier(&self, link: Option<usize>) -> (usize, Pose) {
        link.map_or((0, Pose::identity()), |link| self.links[link])
    }
    /// Motion (entry of [`Self::update`]'s motions) of one of the robot's joints that can move.
    pub fn motion_of(&self, joint: usize) -> Option<usize> {
        self.movers
            .iter()
            .position(|&mover| mover == joint)
    }
    /// Size of a joint-space motion (rad): of all turns and, divided by `reach`, of all
    /// translations.
    pub fn motion(&self, velocity: &[f64], reach: f64) -> f64 {
        let square = |joint: &LaneJoint, first: usize| {
            let sum = |range: std::ops::Range<usize>| {
                velocity[range]
                    .iter()
                    .map(|x| x * x)
                    .sum::<f64>()
            };
            let (slides, turns) = coordinates(joint.kind);
            sum(first..first + slides) / (reach * reach)
                + sum(first + slides..first + slides + turns)
        };
        let squares = self
            .joints
            .iter()
            .filter_map(|joint| Some(square(joint, joint.rate?)));
        squares.sum::<f64>().sqrt()
    }
    /// Sum of the lengths of all fixed parts (m).
    pub fn extent(&self) -> f64 {
        self.extent
    }

    /// Places all frames. Without `MOVING` nothing has a velocity; where `CURVED`, speeds change and
    /// there are bulges.
    #[inline(always)]
    pub fn update<S: Eight, const MOVING: bool, const CURVED: bool>(
        &self,
        simd: S,
        input: &LaneInput,
        placed: &mut Placed,
    ) {
        let Placed {
            frames,
            motions,
            bulges,
        } = placed;
        frames.clear();
        motions.clear();
        bulges.clear();
        frames.push(LaneFrame::WORLD);
        for joint in &self.joints {
            let parent = frames[joint.parent];
            let mut moved = Moved::on(simd, &parent, joint);
            let value = Input {
                simd,
                packed: &input.values[joint.value..],
                known: true,
            };
            let rate = match joint.rate {
                Some(first) => Input {
                    simd,
                    packed: &input.rates[first..],
                    known: true,
                },
                None => Input {
                    simd,
                    packed: &[],
                    known: false,
                },
            };
            match joint.kind {
                JointKind::Fixed => {}
                JointKind::Revolute | JointKind::Continuous => {
                    moved.turn_about_z::<MOVING>(
                        value.at(0) * joint.factor + joint.offset,
                        rate.at(0) * joint.factor,
                    );
                }
                JointKind::Prismatic => {
                    let at = value.at(0) * joint.factor + joint.offset;
                    let by = rate.at(0) * joint.factor;
                    let zero = Lanes::splat(simd, 0.0);
                    let along_z = |z| Vectors {
                        x: zero,
                        y: zero,
                        z,
                    };
                    moved.slide::<MOVING>(along_z(at), along_z(by), along_z(at - joint.rest));
                }
                JointKind::Planar => {
                    let zero = Lanes::splat(simd, 0.0);
                    let at = Vectors {
                        x: value.at(0),
                        y: value.at(1),
                        z: zero,
                    };
                    moved.slide::<MOVING>(
                        at,
                        Vectors {
                            x: rate.at(0),
                            y: rate.at(1),
                            z: zero,
                        },
                        at,
                    );
                    moved.turn_about_z::<MOVING>(value.at(2), rate.at(2));
                }
                JointKind::Floating => {
                    let at = Vectors {
                        x: value.at(0),
                        y: value.at(1),
                        z: value.at(2),
                    };
                    moved.slide::<MOVING>(
                        at,
                        Vectors {
                            x: rate.at(0),
                            y: rate.at(1),
                            z: rate.at(2),
                        },
                        at,
                    );
                    let by = Vectors {
                        x: rate.at(3),
                        y: rate.at(4),
                        z: rate.at(5),
                    };
                    moved.turn::<MOVING>([value.at(3), value.at(4), value.at(5), value.at(6)], by);
                }
            }
            if CURVED {
                bulges.push(moved.bend(simd, joint, input));
            }
            motions.push(LaneMotion {
                turn: moved.turned.packed,
                slide: moved.slid.packed,
                shift: moved.shifted.packed,
            });
            frames.push(LaneFrame {
                axes: moved.axes.packed(),
                origin: moved.origin.packed(),
                angular: moved.angular.packed(),
                linear: moved.linear.packed(),
            });
        }
    }
}

/// Values of a joint, or zeros.
#[derive(Clone, Copy)]
struct Input<'a, S: Eight> {
    simd: S,
    packed: &'a [Packed],
    known: bool,
}

impl<S: Eight> Input<'_, S> {
    #[inline(always)]
    fn at(self, k: usize) -> Lanes<S> {
        Lanes::new(self.simd, if self.known { self.packed[k] } else { ZERO })
    }
}

/// A frame on its way from its parent to its place.
struct Moved<S: Eight> {
    axes: Axes<S>,
    origin: Vectors<S>,
    angular: Vectors<S>,
    linear: Vectors<S>,
    turned: Lanes<S>,
    slid: Lanes<S>,
    shifted: Lanes<S>,
}

impl<S: Eight> Moved<S> {
    /// Where the joint's fixed part brings it.
    #[inline(always)]
    fn on(simd: S, parent: &LaneFrame, joint: &LaneJoint) -> Self {
        let mut axes = Axes::new(simd, &parent.axes);
        let arm = axes.combine_constant(joint.translation);
        if let Some(columns) = &joint.rotation {
            axes = Axes([
                axes.combine_constant(columns[0]),
                axes.combine_constant(columns[1]),
                axes.combine_constant(columns[2]),
            ]);
        }
        let angular = Vectors::new(simd, parent.angular);
        let zero = Lanes::splat(simd, 0.0);
        Self {
            axes,
            origin: Vectors::new(simd, parent.origin) + arm,
            angular,
            linear: Vectors::new(simd, parent.linear) + angular.cross(arm),
            turned: zero,
            slid: zero,
            shifted: zero,
        }
    }

    /// Translates it to `at`, half displacement `by`, which is `from_rest` of where its reach
    /// counts from.
    #[inline(always)]
    fn slide<const MOVING: bool>(&mut self, at: Vectors<S>, by: Vectors<S>, from_rest: Vectors<S>) {
        let arm = self.axes.combine(at);
        self.origin = self.origin + arm;
        if MOVING {
            self.linear = self.linear + self.angular.cross(arm) + self.axes.combine(by);
            self.slid = by.length();
            self.shifted = from_rest.length() + self.slid;
        }
    }

    /// On a curve speeds are the greatest of the interval, and the joint's coordinates bulge.
    #[inline(always)]
    fn bend(&mut self, simd: S, joint: &LaneJoint, input: &LaneInput) -> LaneBulge {
        let Some(first) = joint.rate else {
            return LaneBulge {
                turn: ZERO,
                slide: ZERO,
            };
        };
        let (slides, turns) = coordinates(joint.kind);
        let factor = joint.factor.abs();
        let size = Size { simd, factor };
        let slid = size.of(&input.speeds[first..first + slides]);
        self.shifted = self.shifted - self.slid + slid;
        self.slid = slid;
        let turning = first + slides..first + slides + turns;
        self.turned = size.of(&input.speeds[turning.clone()]);
        LaneBulge {
            turn: size.of(&input.bulges[turning]).packed,
            slide: size
                .of(&input.bulges[first..first + slides])
                .packed,
        }
    }

    #[inline(always)]
    fn turn_about_z<const MOVING: bool>(&mut self, angle: Lanes<S>, by: Lanes<S>) {
        let (sine, cosine) = sin_cos(angle);
        let [x, y, z] = self.axes.0;
        self.axes = Axes([x * cosine + y * sine, y * cosine - x * sine, z]);
        if MOVING {
            self.angular = self.angular + z * by;
            self.turned = by.abs();
        }
    }

    /// Turns it by a unit quaternion (x, y, z, w), half displacement `by` about its own axes.
    #[inline(always)]
    fn turn<const MOVING: bool>(&mut self, [x, y, z, w]: [Lanes<S>; 4], by: Vectors<S>) {
        let x2 = x * 2.0;
        let y2 = y * 2.0;
        let z2 = z * 2.0;
        let xx = x * x2;
        let yy = y * y2;
        let zz = z * z2;
        let xy = x * y2;
        let xz = x * z2;
        let yz = y * z2;
        let wx = w * x2;
        let wy = w * y2;
        let wz = w * z2;
        let old = self.axes;
        self.axes = Axes([
            old.combine(Vectors {
                x: -(yy + zz) + 1.0,
                y: xy + wz,
                z: xz - wy,
            }),
            old.combine(Vectors {
                x: xy - wz,
                y: -(xx + zz) + 1.0,
                z: yz + wx,
            }),
            old.combine(Vectors {
                x: xz + wy,
                y: yz - wx,
                z: -(xx + yy) + 1.0,
            }),
        ]);
        if MOVING {
            self.angular = self.angular + self.axes.combine(by);
            self.turned = by.length();
        }
    }
}

/// The length of what several coordinates make together.
struct Size<S: Eight> {
    simd: S,
    factor: f32,
}

impl<S: Eight> Size<S> {
    #[inline(always)]
    fn of(&self, coordinates: &[Packed]) -> Lanes<S> {
        let mut squares = Lanes::splat(self.simd, 0.0);
        for coordinate in coordinates {
            let coordinate = Lanes::new(self.simd, *coordinate);
            squares = squares + coordinate * coordinate;
        }
        squares.sqrt() * self.factor
    }
}

/// How many coordinates of a joint slide, and how many turn.
#[inline(always)]
fn coordinates(kind: JointKind) -> (usize, usize) {
    match kind {
        JointKind::Fixed => (0, 0),
        JointKind::Revolute | JointKind::Continuous => (0, 1),
        JointKind::Prismatic => (1, 0),
        JointKind::Planar => (2, 1),
        JointKind::Floating => (3, 3),
    }
}

/// Unit roundoff of f32.
const ROUNDOFF: f64 = 5.960_464_5e-8;

impl Skeleton {
    /// Bound on the error (m) of the place of a point this far (m) from its frame's origin, as long
    /// as all translations are 0 and no angle is beyond a turn.
    ///
    /// A product of two rotations rounds each entry by at most 3 roundoffs, sine and cosine add 5,
    /// so the rotation of frame k is off by at most 16 k roundoffs in norm; places add that times
    /// each arm. Half displacements have the same error relative to the plain bound V h.
    pub fn rounding(&self, point: f64) -> f64 {
        self.relative_rounding() * (self.extent + point)
    }

    /// Bound on the relative error of rotations and velocities.
    pub fn relative_rounding(&self) -> f64 {
        16.0 * ROUNDOFF * (self.joints.len() + 4) as f64
    }

    /// What large angles and translations add to [`Self::rounding`] (m).
    fn rounding_of_values(&self, from: &[f64], velocity: &[f64], held: &[f64]) -> f64 {
        let mut lengths = 0.0;
        let mut angles = 0.0;
        for joint in &self.joints {
            let size = |k: usize| {
                let at = joint.value + k;
                let value = if at < self.columns {
                    from[at]
                } else {
                    held[at - self.columns]
                };
                let rate = joint
                    .rate
                    .map_or(0.0, |first| velocity[first + k]);
                f64::from(joint.factor).abs() * (value.abs() + rate.abs())
                    + f64::from(joint.offset).abs()
            };
            match joint.kind {
                JointKind::Fixed => {}
                JointKind::Revolute | JointKind::Continuous => angles += size(0),
                JointKind::Prismatic => lengths += size(0),
                JointKind::Planar => {
                    (lengths, angles) = (lengths + size(0) + size(1), angles + size(2))
                }
                JointKind::Floating => lengths += size(0) + size(1) + size(2),
            }
        }
        self.relative_rounding() * lengths + 4.0 * ROUNDOFF * angles * (self.extent + lengths)
    }
}

fn single(v: Vec3) -> [f32; 3] {
    v.to_array().map(|value| value as f32)
}
