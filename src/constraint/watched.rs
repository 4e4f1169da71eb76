//! A vector that moves with a robot, as a frame sees it.

use crate::collision::chain::{self, ChainMotion, SweptBall, SweptCone, way_up};
use crate::math::{Quat, Vec3};
use crate::robot::configuration::shortest_arc;
use crate::robot::kinematics::in_parent;
use crate::robot::{Joint, JointKind, Kinematics, RobotModel};

/// A point or direction of a link, or of the world; or a joint's value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Vector {
    /// A point (m).
    Point(Vec3),
    /// A direction, of length 1.
    Direction(Vec3),
    /// How far a joint is from a value (rad or m), as the first component.
    Joint(JointValue),
}

/// A joint's value, which goes straight on a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointValue {
    /// Its column of a configuration, or that of the joint that it mimics.
    pub column: usize,
    /// That one's velocity coordinate.
    pub coordinate: usize,
    /// Factor on the column's value (a mimic's multiplier).
    pub factor: f64,
    /// Added to that (rad or m).
    pub offset: f64,
    /// On the circle: the shorter way counts.
    pub is_angle: bool,
}

impl JointValue {
    fn of(&self, configuration: &[f64]) -> f64 {
        let value = configuration[self.column] * self.factor + self.offset;
        match self.is_angle {
            true => shortest_arc(0.0, value),
            false => value,
        }
    }
}

/// Where a robot stands, and how fast it moves.
#[derive(Clone, Copy, Debug)]
pub struct Stand<'a> {
    /// Where its links are, and how fast after [`Kinematics::update_velocities`].
    pub kinematics: &'a Kinematics,
    /// Its configuration.
    pub configuration: &'a [f64],
    /// Its velocity.
    pub velocity: &'a [f64],
}

/// A vector of a link as another link, or the world, sees it.
#[derive(Clone, Debug)]
pub struct Watched {
    /// In the frame of `link`.
    vector: Vector,
    /// The link that carries it; `None` = it stands in the world.
    link: Option<usize>,
    /// The link that sees it; `None` = the world does.
    seen_from: Option<usize>,
    /// The motions from who sees it to it.
    chain: Vec<ChainMotion>,
    /// Links from the one that carries it up to below the last that carries both, ...
    up: Vec<usize>,
    /// ... and from there down to the one that sees it.
    down: Vec<usize>,
}

impl Watched {
    /// How far a joint is from a value.
    pub fn joint(value: JointValue) -> Self {
        Self {
            vector: Vector::Joint(value),
            link: None,
            seen_from: None,
            chain: Vec::new(),
            up: Vec::new(),
            down: Vec::new(),
        }
    }

    /// A vector of a link (or the world) that another one sees.
    pub fn new(
        robot: &RobotModel,
        vector: Vector,
        link: Option<usize>,
        seen_from: Option<usize>,
    ) -> Self {
        let ancestor = common_ancestor(robot, link, seen_from);
        let up_from = |link: Option<usize>| -> Vec<usize> {
            link.into_iter()
                .flat_map(|link| way_up(robot, link, ancestor))
                .collect()
        };
        let mut down = up_from(seen_from);
        down.reverse();
        Self {
            vector,
            link,
            seen_from,
            chain: motions(robot, vector, link, seen_from),
            up: up_from(link),
            down,
        }
    }

    /// The vector, in the frame of its link.
    pub fn vector(&self) -> Vector {
        self.vector
    }

    /// The link that carries it; `None` = it stands in the world.
    pub fn link(&self) -> Option<usize> {
        self.link
    }

    /// The link that sees it; `None` = the world does.
    pub fn seen_from(&self) -> Option<usize> {
        self.seen_from
    }

    /// The motions from who sees it to it, each with how far it can swing it.
    pub fn chain(&self) -> &[ChainMotion] {
        &self.chain
    }

    /// Where it is.
    pub fn at(&self, stand: &Stand) -> Vec3 {
        let kinematics = stand.kinematics;
        match self.vector {
            Vector::Joint(joint) => Vec3::X * joint.of(stand.configuration),
            Vector::Point(point) => {
                self.point_seen(kinematics, placed(kinematics, self.link, point))
            }
            Vector::Direction(direction) => {
                let back = rotation(kinematics, self.seen_from).inverse();
                back * (rotation(kinematics, self.link) * direction)
            }
        }
    }

    /// Where it is at a configuration, by the links on its way alone.
    pub fn at_configuration(&self, robot: &RobotModel, q: &[f64], held: &[f64]) -> Vec3 {
        let place = |link: &usize| in_parent(robot, *link, q, held);
        let up = self.up.iter().map(place);
        let down = self.down.iter().map(place);
        match self.vector {
            Vector::Joint(joint) => Vec3::X * joint.of(q),
            Vector::Point(point) => {
                let carried = up.fold(point, |point, pose| pose.transform_point(point));
                down.fold(carried, |point, pose| pose.inverse_transform_point(point))
            }
            Vector::Direction(direction) => {
                let carried = up.fold(direction, |direction, pose| pose.rotation * direction);
                down.fold(carried, |direction, pose| {
                    pose.rotation.inverse() * direction
                })
            }
        }
    }

    fn point_seen(&self, kinematics: &Kinematics, point: Vec3) -> Vec3 {
        self.seen_from.map_or(point, |link| {
            kinematics.poses()[link].inverse_transform_point(point)
        })
    }

    /// Where in the world it is seen (m): a point itself, of a direction the origin of its link; the
    /// world's origin of what is nowhere.
    pub fn seen(&self, kinematics: &Kinematics) -> Vec3 {
        match self.vector {
            Vector::Joint(_) => Vec3::ZERO,
            Vector::Point(point) => placed(kinematics, self.link, point),
            Vector::Direction(_) => placed(kinematics, self.link, Vec3::ZERO),
        }
    }

    /// A direction as who sees it has it, in the world.
    pub fn in_world(&self, kinematics: &Kinematics, direction: Vec3) -> Vec3 {
        rotation(kinematics, self.seen_from) * direction
    }

    /// How fast it moves (per unit time).
    pub fn rate(&self, stand: &Stand) -> Vec3 {
        let kinematics = stand.kinematics;
        let moved = match self.vector {
            Vector::Joint(joint) => {
                return Vec3::X * (joint.factor * stand.velocity[joint.coordinate]);
            }
            Vector::Point(point) => {
                let point = placed(kinematics, self.link, point);
                velocity(kinematics, self.link, point) - velocity(kinematics, self.seen_from, point)
            }
            Vector::Direction(direction) => {
                let turning = angular(kinematics, self.link) - angular(kinematics, self.seen_from);
                turning.cross(rotation(kinematics, self.link) * direction)
            }
        };
        rotation(kinematics, self.seen_from).inverse() * moved
    }

    /// Adds `normalᵀ J` to `row` (nv numbers), J the Jacobian of the vector and `normal` as who sees it
    /// has it.
    pub fn add_row(
        &self,
        robot: &RobotModel,
        kinematics: &Kinematics,
        normal: Vec3,
        row: &mut [f64],
    ) {
        if let Vector::Joint(joint) = self.vector {
            row[joint.coordinate] += joint.factor * normal.x;
            return;
        }
        let normal = rotation(kinematics, self.seen_from) * normal;
        let mut add = |link: Option<usize>, point: Vec3, sign: f64| {
            if let Some(link) = link {
                kinematics.add_point_row(robot, link, point, normal, sign, row);
            }
        };
        match self.vector {
            Vector::Joint(_) => {}
            Vector::Point(point) => {
                let point = placed(kinematics, self.link, point);
                add(self.link, point, 1.0);
                add(self.seen_from, point, -1.0);
            }
            Vector::Direction(direction) => {
                // A direction turns like the way between two points of its link.
                let direction = rotation(kinematics, self.link) * direction;
                add(self.link, direction, 1.0);
                add(self.link, Vec3::ZERO, -1.0);
                add(self.seen_from, direction, -1.0);
                add(self.seen_from, Vec3::ZERO, 1.0);
            }
        }
    }
}

fn rotation(kinematics: &Kinematics, link: Option<usize>) -> Quat {
    link.map_or(Quat::IDENTITY, |link| kinematics.poses()[link].rotation)
}

fn angular(kinematics: &Kinematics, link: Option<usize>) -> Vec3 {
    link.map_or(Vec3::ZERO, |link| kinematics.angular()[link])
}

fn placed(kinematics: &Kinematics, link: Option<usize>, point: Vec3) -> Vec3 {
    link.map_or(point, |link| {
        kinematics.poses()[link].transform_point(point)
    })
}

/// Of a point of the world that moves with a link.
fn velocity(kinematics: &Kinematics, link: Option<usize>, point: Vec3) -> Vec3 {
    link.map_or(Vec3::ZERO, |link| {
        let arm = point - kinematics.poses()[link].translation;
        kinematics.linear()[link] + kinematics.angular()[link].cross(arm)
    })
}

/// The motions from who sees a vector to it: up to the ancestor of both, and down again.
fn motions(
    robot: &RobotModel,
    vector: Vector,
    link: Option<usize>,
    seen_from: Option<usize>,
) -> Vec<ChainMotion> {
    match vector {
        Vector::Joint(_) => Vec::new(),
        Vector::Point(center) => {
            let mut ball = SweptBall {
                center,
                radius: 0.0,
            };
            both_ways(robot, &mut ball, link, seen_from)
        }
        Vector::Direction(axis) => {
            let mut cone = SweptCone { axis, angle: 0.0 };
            let mut motions = both_ways(robot, &mut cone, link, seen_from);
            // What does not turn leaves a direction as it is.
            motions.retain(ChainMotion::turns);
            motions
        }
    }
}

fn both_ways(
    robot: &RobotModel,
    carried: &mut impl chain::Carried,
    link: Option<usize>,
    seen_from: Option<usize>,
) -> Vec<ChainMotion> {
    let ancestor = common_ancestor(robot, link, seen_from);
    let down = moving(link, ancestor)
        .map(|link| chain::down_to(robot, link, ancestor, carried))
        .unwrap_or_default();
    let mut motions = moving(seen_from, ancestor)
        .map(|link| chain::up_from(robot, link, ancestor, carried))
        .unwrap_or_default();
    motions.extend(down);
    motions
}

/// A link that is not the ancestor itself.
fn moving(link: Option<usize>, ancestor: Option<usize>) -> Option<usize> {
    link.filter(|_| link != ancestor)
}

/// The last link that carries both; `None` where only the world does.
fn common_ancestor(robot: &RobotModel, a: Option<usize>, b: Option<usize>) -> Option<usize> {
    let above_a: Vec<usize> = way_up(robot, a?, None).collect();
    way_up(robot, b?, None).find(|link| above_a.contains(link))
}

/// Who sees the angle between a direction that `link` carries and an `axis` of another as that one does:
/// the last link on the way that does no more than turn about the axis; and the axis in its frame. The
/// fewer motions are left, the less a proof has to pay for.
pub fn angle_seen_from(
    robot: &RobotModel,
    link: Option<usize>,
    seen_from: Option<usize>,
    axis: Vec3,
) -> (Option<usize>, Vec3) {
    let mut seen = (seen_from, axis);
    for joint in way_down(robot, link, seen_from) {
        let joint_frame = &robot.joints()[joint];
        let axis = joint_frame.origin.rotation.inverse() * seen.1;
        if !leaves_angles_to(joint_frame, axis) {
            break;
        }
        seen = (Some(joint), axis);
    }
    seen
}

/// The joints from who sees to a link that it carries; none where it does not carry it.
fn way_down(robot: &RobotModel, link: Option<usize>, seen_from: Option<usize>) -> Vec<usize> {
    let Some(link) = link else {
        return Vec::new();
    };
    let mut way: Vec<usize> = way_up(robot, link, seen_from).collect();
    way.reverse();
    let is_carried = way
        .first()
        .is_some_and(|first| robot.joints()[*first].parent == seen_from);
    if is_carried { way } else { Vec::new() }
}

/// Whether a joint keeps every direction's angle to an axis that its frame has.
fn leaves_angles_to(joint: &Joint, axis: Vec3) -> bool {
    match joint.kind {
        JointKind::Fixed | JointKind::Prismatic => true,
        JointKind::Revolute | JointKind::Continuous => is_parallel(joint.axis, axis),
        JointKind::Planar => is_parallel(Vec3::Z, axis),
        JointKind::Floating => false,
    }
}

/// Up to the last bits of two directions; the margin of a proof pays for these.
fn is_parallel(a: Vec3, b: Vec3) -> bool {
    a.cross(b).length() < 1e-15
}
