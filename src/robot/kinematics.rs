//! Forward kinematics: poses of all links, their velocities, and rows of the point Jacobian.

use super::configuration::quat;
use super::joint::{Drive, Joint, JointKind};
use super::model::RobotModel;
use crate::math::{Pose, Quat, Vec3};

/// Scratch that holds where the links are (and how fast) at one configuration.
#[derive(Clone, Debug, Default)]
pub struct Kinematics {
    poses: Vec<Pose>,
    /// World rotation of each joint's frame before its own motion: its axes live there.
    frames: Vec<Quat>,
    angular: Vec<Vec3>,
    linear: Vec<Vec3>,
}

impl Kinematics {
    /// World pose of each link.
    pub fn poses(&self) -> &[Pose] {
        &self.poses
    }
    /// World angular velocity of each link (rad per unit time), after [`Self::update_velocities`].
    pub fn angular(&self) -> &[Vec3] {
        &self.angular
    }
    /// World velocity of each link's origin (m per unit time), after [`Self::update_velocities`].
    pub fn linear(&self) -> &[Vec3] {
        &self.linear
    }

    /// Places all links at configuration `q`, with the joints that are no variables at `held`.
    pub fn update(&mut self, robot: &RobotModel, q: &[f64], held: &[f64]) {
        let joints = robot.joints();
        self.poses
            .resize(joints.len(), Pose::identity());
        self.frames.resize(joints.len(), Quat::IDENTITY);
        for (i, joint) in joints.iter().enumerate() {
            let frame = match joint.parent {
                Some(parent) => self.poses[parent] * joint.origin,
                None => joint.origin,
            };
            self.frames[i] = frame.rotation;
            self.poses[i] = match joint.kind {
                JointKind::Fixed => frame,
                JointKind::Revolute | JointKind::Continuous => {
                    let turn = Quat::from_axis_angle(joint.axis, value(joints, joint, q, held));
                    Pose::from_parts(frame.translation, frame.rotation * turn)
                }
                JointKind::Prismatic => {
                    let shift = joint.axis * value(joints, joint, q, held);
                    Pose::from_parts(frame.translation + frame.rotation * shift, frame.rotation)
                }
                JointKind::Planar => {
                    let x = values(joint, q, held);
                    let shift = frame.rotation * Vec3::new(x[0], x[1], 0.0);
                    Pose::from_parts(
                        frame.translation + shift,
                        frame.rotation * Quat::from_rotation_z(x[2]),
                    )
                }
                JointKind::Floating => {
                    let x = values(joint, q, held);
                    let shift = frame.rotation * Vec3::new(x[0], x[1], x[2]);
                    Pose::from_parts(frame.translation + shift, frame.rotation * quat(x, 3))
                }
            };
        }
    }

    /// Velocities of all links for the configuration velocity `v`; call after [`Self::update`].
    pub fn update_velocities(&mut self, robot: &RobotModel, v: &[f64]) {
        let joints = robot.joints();
        self.angular.resize(joints.len(), Vec3::ZERO);
        self.linear.resize(joints.len(), Vec3::ZERO);
        for (i, joint) in joints.iter().enumerate() {
            let (mut angular, mut linear) = match joint.parent {
                Some(p) => {
                    let arm = self.poses[i].translation - self.poses[p].translation;
                    (self.angular[p], self.linear[p] + self.angular[p].cross(arm))
                }
                None => (Vec3::ZERO, Vec3::ZERO),
            };
            if let Some((first, factor)) = rate(joints, joint) {
                let frame = self.frames[i];
                match joint.kind {
                    JointKind::Fixed => {}
                    JointKind::Revolute | JointKind::Continuous => {
                        angular += frame * joint.axis * (factor * v[first])
                    }
                    JointKind::Prismatic => linear += frame * joint.axis * (factor * v[first]),
                    JointKind::Planar => {
                        linear += frame * Vec3::new(v[first], v[first + 1], 0.0);
                        angular += frame * Vec3::Z * v[first + 2];
                    }
                    JointKind::Floating => {
                        linear += frame * Vec3::new(v[first], v[first + 1], v[first + 2]);
                        // The rotation vector is in the link's frame, and its own motion leaves it
                        // there.
                        angular += self.poses[i].rotation
                            * Vec3::new(v[first + 3], v[first + 4], v[first + 5]);
                    }
                }
            }
            self.angular[i] = angular;
            self.linear[i] = linear;
        }
    }

    /// Adds `sign · directionᵀ J` to `row` (nv numbers), J the Jacobian of the world point `point`
    /// fixed to `link`.
    pub fn add_point_row(
        &self,
        robot: &RobotModel,
        link: usize,
        point: Vec3,
        direction: Vec3,
        sign: f64,
        row: &mut [f64],
    ) {
        let joints = robot.joints();
        let mut at = Some(link);
        while let Some(i) = at {
            let joint = &joints[i];
            at = joint.parent;
            let Some((first, factor)) = rate(joints, joint) else {
                continue;
            };
            let frame = self.frames[i];
            let scale = sign * factor;
            // Moment of the direction about the joint's origin: u·(ω × arm) = ω·(arm × u).
            let moment = (point - self.poses[i].translation).cross(direction);
            let mut add = |k: usize, value: f64| row[first + k] += scale * value;
            match joint.kind {
                JointKind::Fixed => {}
                JointKind::Revolute | JointKind::Continuous => {
                    add(0, (frame * joint.axis).dot(moment))
                }
                JointKind::Prismatic => add(0, (frame * joint.axis).dot(direction)),
                JointKind::Planar => {
                    add(0, (frame * Vec3::X).dot(direction));
                    add(1, (frame * Vec3::Y).dot(direction));
                    add(2, (frame * Vec3::Z).dot(moment));
                }
                JointKind::Floating => {
                    let body = self.poses[i].rotation;
                    for (k, axis) in [Vec3::X, Vec3::Y, Vec3::Z]
                        .into_iter()
                        .enumerate()
                    {
                        add(k, (frame * axis).dot(direction));
                        add(k + 3, (body * axis).dot(moment));
                    }
                }
            }
        }
    }
}

/// Where a link is in the frame of the one that carries it (of the world, if none does) at
/// configuration `q`: for who wants few links, and not the others.
pub fn in_parent(robot: &RobotModel, link: usize, q: &[f64], held: &[f64]) -> Pose {
    let joints = robot.joints();
    let joint = &joints[link];
    let motion = match joint.kind {
        JointKind::Fixed => return joint.origin,
        JointKind::Revolute | JointKind::Continuous => {
            let turn = Quat::from_axis_angle(joint.axis, value(joints, joint, q, held));
            Pose::from_parts(Vec3::ZERO, turn)
        }
        JointKind::Prismatic => {
            let shift = joint.axis * value(joints, joint, q, held);
            Pose::from_parts(shift, Quat::IDENTITY)
        }
        JointKind::Planar => {
            let x = values(joint, q, held);
            Pose::from_parts(Vec3::new(x[0], x[1], 0.0), Quat::from_rotation_z(x[2]))
        }
        JointKind::Floating => {
            let x = values(joint, q, held);
            Pose::from_parts(Vec3::new(x[0], x[1], x[2]), quat(x, 3))
        }
    };
    joint.origin * motion
}

/// First velocity coordinate that moves the joint, and the factor on it; `None` for one that never
/// moves.
pub fn rate(joints: &[Joint], joint: &Joint) -> Option<(usize, f64)> {
    match joint.drive {
        Drive::Variable { v, .. } => Some((v, 1.0)),
        Drive::Mimic {
            master, multiplier, ..
        } => match joints[master].drive {
            Drive::Variable { v, .. } => Some((v, multiplier)),
            Drive::Fixed | Drive::Mimic { .. } | Drive::Held { .. } => None,
        },
        Drive::Fixed | Drive::Held { .. } => None,
    }
}

// Once for each joint of each look: a call would cost as much as what it does.
#[inline(always)]
fn value(joints: &[Joint], joint: &Joint, q: &[f64], held: &[f64]) -> f64 {
    match joint.drive {
        Drive::Mimic {
            master,
            multiplier,
            offset,
        } => multiplier * values(&joints[master], q, held)[0] + offset,
        Drive::Fixed | Drive::Variable { .. } | Drive::Held { .. } => values(joint, q, held)[0],
    }
}

/// The joint's own columns, or its held values.
#[inline(always)]
fn values<'a>(joint: &Joint, q: &'a [f64], held: &'a [f64]) -> &'a [f64] {
    match joint.drive {
        Drive::Variable { q: first, .. } => &q[first..first + joint.kind.nq()],
        Drive::Held { first } => &held[first..first + joint.kind.nq()],
        Drive::Fixed | Drive::Mimic { .. } => &[],
    }
}
