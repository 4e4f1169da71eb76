//! Elementary motions that carry something, and how far each can swing it.
//!
//! Going up from what is carried, a set that encloses it is swept by each joint: a turn about an axis
//! makes a ball one about the nearest point of the axis, and a cone of directions one about the axis.

use crate::math::{Pose, Vec3};
use crate::robot::{Drive, Joint, JointKind, RobotModel};

/// One elementary motion of a joint and how far it swings what it carries.
#[derive(Clone, Copy, Debug)]
pub struct ChainMotion {
    /// Joint (= link) whose motion it is.
    pub joint: usize,
    /// What moves.
    pub kind: MotionKind,
    /// First velocity coordinate, `None` for a joint that holds still.
    pub coordinate: Option<usize>,
    /// Where its value comes from.
    pub source: Source,
    /// Factor on value and velocity (a mimic's multiplier).
    pub factor: f64,
    /// Added to the value (a mimic's offset).
    pub offset: f64,
    /// For a rotation: distance from its axis (ball: centre) to the farthest point carried (m; of a
    /// direction, as a point of the unit sphere),
    /// whatever the joints in between do, as long as translations in between stay at `rest`.
    pub reach: f64,
    /// For a translation: the value that `reach` of the motions above counts on (m).
    pub rest: Vec3,
}

/// Where the value of a motion is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// First of its columns in the configuration.
    Column(usize),
    /// First of its held values.
    Held(usize),
}

/// An elementary motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionKind {
    /// Translation of `n` coordinates, which are mutually perpendicular.
    Translation(usize),
    /// Rotation by one coordinate about a fixed axis.
    Axis,
    /// Rotation by a rotation vector about a fixed centre.
    Ball,
}

impl ChainMotion {
    /// Whether it turns what it carries.
    pub fn turns(&self) -> bool {
        !matches!(self.kind, MotionKind::Translation(_))
    }
}

/// What a chain carries, as it is seen from somewhere up the chain.
pub trait Carried {
    /// Turned about an axis through the origin; how far from the axis it gets then.
    fn turn_about(&mut self, axis: Vec3) -> f64;
    /// Turned about the origin, anyhow; how far from it it gets then.
    fn turn_freely(&mut self) -> f64;
    /// Moved without a turn (m).
    fn shift(&mut self, by: Vec3);
    /// Seen from the frame in which `origin` is given.
    fn seen_from_above(&mut self, origin: &Pose);
}

/// A ball that encloses what is carried.
#[derive(Clone, Copy, Debug)]
pub struct SweptBall {
    /// Its centre.
    pub center: Vec3,
    /// Its radius (m).
    pub radius: f64,
}

impl Carried for SweptBall {
    fn turn_about(&mut self, axis: Vec3) -> f64 {
        let on_axis = axis * self.center.dot(axis);
        self.radius += self.center.distance(on_axis);
        self.center = on_axis;
        self.radius
    }

    fn turn_freely(&mut self) -> f64 {
        self.radius += self.center.length();
        self.center = Vec3::ZERO;
        self.radius
    }

    fn shift(&mut self, by: Vec3) {
        self.center += by;
    }

    fn seen_from_above(&mut self, origin: &Pose) {
        self.center = origin.transform_point(self.center);
    }
}

/// A cone of directions that encloses the one carried.
#[derive(Clone, Copy, Debug)]
pub struct SweptCone {
    /// Its axis, of length 1.
    pub axis: Vec3,
    /// Angle between the axis and what is farthest from it (rad).
    pub angle: f64,
}

impl Carried for SweptCone {
    fn turn_about(&mut self, axis: Vec3) -> f64 {
        // The axis has two ends, of which one is nearer.
        let along = self.axis.dot(axis);
        let nearer = if along < 0.0 { -axis } else { axis };
        self.angle += angle_between(self.axis, nearer);
        self.axis = nearer;
        self.angle
            .min(std::f64::consts::FRAC_PI_2)
            .sin()
    }

    fn turn_freely(&mut self) -> f64 {
        self.angle = std::f64::consts::PI;
        1.0
    }

    fn shift(&mut self, _by: Vec3) {}

    fn seen_from_above(&mut self, origin: &Pose) {
        self.axis = origin.rotation * self.axis;
    }
}

/// Angle between two directions (rad), to full precision where they are nearly the same.
pub fn angle_between(a: Vec3, b: Vec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

/// The motions between a link's ancestor, or the root, and the link, in this order; `carried` is seen
/// from the link, and then from above.
pub fn down_to(
    robot: &RobotModel,
    link: usize,
    ancestor: Option<usize>,
    carried: &mut impl Carried,
) -> Vec<ChainMotion> {
    let mut motions = Vec::new();
    for joint in way_up(robot, link, ancestor) {
        Mover::of(robot, joint).carry(carried, &mut motions);
        carried.seen_from_above(&robot.joints()[joint].origin);
    }
    motions.reverse();
    motions
}

/// The same motions undone, as the link sees what stands in its ancestor: in the order from the link
/// on. `carried` is seen from the ancestor, and then from the link.
pub fn up_from(
    robot: &RobotModel,
    link: usize,
    ancestor: Option<usize>,
    carried: &mut impl Carried,
) -> Vec<ChainMotion> {
    let mut way: Vec<usize> = way_up(robot, link, ancestor).collect();
    way.reverse();
    let mut motions = Vec::new();
    for joint in way {
        carried.seen_from_above(&robot.joints()[joint].origin.inverse());
        Mover::of(robot, joint).carry_back(carried, &mut motions);
    }
    motions.reverse();
    motions
}

/// The joints from a link up to an ancestor, whose own is not among them, or to the root.
pub fn way_up(
    robot: &RobotModel,
    link: usize,
    ancestor: Option<usize>,
) -> impl Iterator<Item = usize> {
    let parent = |joint: &usize| robot.joints()[*joint].parent;
    std::iter::successors(Some(link), parent).take_while(move |joint| Some(*joint) != ancestor)
}

/// A joint with what drives it.
struct Mover<'r> {
    robot: &'r RobotModel,
    index: usize,
    joint: &'r Joint,
    driver: Drive,
    factor: f64,
    offset: f64,
}

impl<'r> Mover<'r> {
    fn of(robot: &'r RobotModel, index: usize) -> Self {
        let joint = &robot.joints()[index];
        let (driver, factor, offset) = match joint.drive {
            Drive::Mimic {
                master,
                multiplier,
                offset,
            } => (robot.joints()[master].drive, multiplier, offset),
            own @ (Drive::Fixed | Drive::Variable { .. } | Drive::Held { .. }) => (own, 1.0, 0.0),
        };
        Self {
            robot,
            index,
            joint,
            driver,
            factor,
            offset,
        }
    }

    /// Its motions, the last first.
    fn carry(&self, carried: &mut impl Carried, motions: &mut Vec<ChainMotion>) {
        match self.joint.kind {
            JointKind::Fixed => {}
            JointKind::Revolute | JointKind::Continuous => {
                motions.push(self.turn(0, carried.turn_about(self.joint.axis)));
            }
            JointKind::Prismatic => {
                motions.push(self.slide(carried, 1.0));
            }
            JointKind::Planar => {
                motions.push(self.turn(2, carried.turn_about(Vec3::Z)));
                motions.push(self.translation(2, Vec3::ZERO));
            }
            JointKind::Floating => {
                motions.push(self.turn_freely(carried));
                motions.push(self.translation(3, Vec3::ZERO));
            }
        }
    }

    /// Its motions undone, the first first: what the joint does last is undone last.
    fn carry_back(&self, carried: &mut impl Carried, motions: &mut Vec<ChainMotion>) {
        match self.joint.kind {
            JointKind::Fixed => {}
            JointKind::Revolute | JointKind::Continuous => {
                motions.push(self.turn(0, carried.turn_about(self.joint.axis)));
            }
            JointKind::Prismatic => {
                motions.push(self.slide(carried, -1.0));
            }
            JointKind::Planar => {
                motions.push(self.translation(2, Vec3::ZERO));
                motions.push(self.turn(2, carried.turn_about(Vec3::Z)));
            }
            JointKind::Floating => {
                motions.push(self.translation(3, Vec3::ZERO));
                motions.push(self.turn_freely(carried));
            }
        }
    }

    fn turn(&self, first: usize, reach: f64) -> ChainMotion {
        self.motion(MotionKind::Axis, first, reach, Vec3::ZERO)
    }

    fn turn_freely(&self, carried: &mut impl Carried) -> ChainMotion {
        self.motion(MotionKind::Ball, 3, carried.turn_freely(), Vec3::ZERO)
    }

    /// Along the joint's axis, in this sense.
    fn slide(&self, carried: &mut impl Carried, sense: f64) -> ChainMotion {
        let rest = Vec3::new(rest_value(self.robot, self.index), 0.0, 0.0);
        carried.shift(self.joint.axis * (sense * rest.x));
        self.translation(1, rest)
    }

    fn translation(&self, coordinates: usize, rest: Vec3) -> ChainMotion {
        self.motion(MotionKind::Translation(coordinates), 0, 0.0, rest)
    }

    fn motion(&self, kind: MotionKind, first: usize, reach: f64, rest: Vec3) -> ChainMotion {
        let (source, coordinate) = match self.driver {
            Drive::Variable { q, v } => (Source::Column(q + first), Some(v + first)),
            Drive::Held { first: value } => (Source::Held(value + first), None),
            Drive::Fixed | Drive::Mimic { .. } => {
                unreachable!("a movable joint is driven by a variable or held")
            }
        };
        ChainMotion {
            joint: self.index,
            kind,
            coordinate,
            source,
            factor: self.factor,
            offset: self.offset,
            reach,
            rest,
        }
    }
}

/// Middle of a prismatic joint's range, where it has one; 0 otherwise.
pub(super) fn rest_value(robot: &RobotModel, joint: usize) -> f64 {
    let middle = |drive: Drive| match drive {
        Drive::Variable { q, .. } => {
            let middle = (robot.variables()[q].hard_lower + robot.variables()[q].hard_upper) / 2.0;
            if middle.is_finite() { middle } else { 0.0 }
        }
        Drive::Fixed | Drive::Mimic { .. } | Drive::Held { .. } => 0.0,
    };
    match robot.joints()[joint].drive {
        Drive::Mimic {
            master,
            multiplier,
            offset,
        } => multiplier * middle(robot.joints()[master].drive) + offset,
        own @ (Drive::Fixed | Drive::Variable { .. } | Drive::Held { .. }) => middle(own),
    }
}
