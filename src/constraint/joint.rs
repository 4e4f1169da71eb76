//! Numbers of a path by name: the value of a joint, or one of those of a planar or floating joint.

use super::{ConstraintKind, JointValue};
use crate::robot::{Component, Drive, Joint, JointKind, RobotModel};

/// The number of this name; `None` where the path has none.
pub(super) fn named(robot: &RobotModel, name: &str) -> Option<(JointValue, ConstraintKind)> {
    let joints = robot.joints();
    let joint = joints.iter().find(|joint| joint.name == name);
    joint
        .and_then(|joint| of_joint(joints, joint))
        .or_else(|| of_variable(robot, name))
}

/// The names that there are.
pub(super) fn names(robot: &RobotModel) -> String {
    let joints = robot.joints().iter();
    let joints = joints.map(|joint| joint.name.as_str());
    let variables = robot.variables().iter();
    let variables = variables.map(|variable| variable.name.as_str());
    let mut valid: Vec<&str> = Vec::new();
    for name in joints.chain(variables) {
        if !valid.contains(&name) && named(robot, name).is_some() {
            valid.push(name);
        }
    }
    valid.join(", ")
}

/// The value of a joint that has one.
fn of_joint(joints: &[Joint], joint: &Joint) -> Option<(JointValue, ConstraintKind)> {
    let kind = match joint.kind {
        JointKind::Prismatic => ConstraintKind::Slide,
        JointKind::Revolute | JointKind::Continuous => ConstraintKind::Angle,
        JointKind::Fixed | JointKind::Planar | JointKind::Floating => return None,
    };
    let (drive, factor, offset) = match joint.drive {
        Drive::Mimic {
            master,
            multiplier,
            offset,
        } => (joints[master].drive, multiplier, offset),
        own @ (Drive::Fixed | Drive::Variable { .. } | Drive::Held { .. }) => (own, 1.0, 0.0),
    };
    let Drive::Variable { q, v } = drive else {
        return None;
    };
    let value = JointValue {
        column: q,
        coordinate: v,
        factor,
        offset,
        is_angle: joint.kind == JointKind::Continuous,
    };
    Some((value, kind))
}

/// A number of a joint that has several, but not of a rotation.
fn of_variable(robot: &RobotModel, name: &str) -> Option<(JointValue, ConstraintKind)> {
    let mut variables = robot.variables().iter();
    let column = variables.position(|variable| variable.name == name)?;
    let mut components = robot.space().components().iter();
    components.find_map(|component| match *component {
        Component::Line { q, v } if q == column => Some((own(q, v, false), ConstraintKind::Slide)),
        Component::Circle { q, v } if q == column => Some((own(q, v, true), ConstraintKind::Angle)),
        Component::Line { .. } | Component::Circle { .. } | Component::Rotation { .. } => None,
    })
}

/// A column as it stands.
fn own(column: usize, coordinate: usize, is_angle: bool) -> JointValue {
    JointValue {
        column,
        coordinate,
        factor: 1.0,
        offset: 0.0,
        is_angle,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Pose, Vec3};
    use crate::robot::{JointDescription, LinkDescription, Mimic, RobotDescription, VirtualJoint};

    fn joint(name: &str, kind: JointKind, parent: &str, mimic: Option<Mimic>) -> JointDescription {
        JointDescription {
            name: name.into(),
            kind,
            parent: parent.into(),
            child: format!("of_{name}"),
            origin: Pose::identity(),
            axis: Vec3::Z,
            limits: Some((-1.0, 1.0)),
            soft_limits: None,
            mimic,
        }
    }

    /// A base on wheels with an arm, a finger that follows it, and one that stands still with the finger
    /// that follows that.
    fn robot(base: JointKind) -> RobotModel {
        let follows = |joint: &str| {
            Some(Mimic {
                joint: joint.into(),
                multiplier: -2.0,
                offset: 0.5,
            })
        };
        let joints = vec![
            joint("arm", JointKind::Prismatic, "base", None),
            joint("finger", JointKind::Revolute, "base", follows("arm")),
            joint("still", JointKind::Revolute, "base", None),
            joint("after", JointKind::Revolute, "base", follows("still")),
        ];
        let links = ["base", "of_arm", "of_finger", "of_still", "of_after"];
        let probe = RobotModel::new(RobotDescription {
            name: "cart".into(),
            links: links
                .map(|name| LinkDescription {
                    name: name.into(),
                    collision: Vec::new(),
                })
                .into(),
            joints,
            virtual_joint: Some(VirtualJoint {
                name: "root".into(),
                kind: base,
                position_bounds: Vec::new(),
                parent_frame: String::new(),
            }),
            ..RobotDescription::default()
        })
        .unwrap();
        let mut description = probe.description().clone();
        let columns = probe.variables().iter();
        let columns = columns.map(|variable| variable.name.clone());
        description.variables = Some(columns.filter(|name| name != "still").collect());
        RobotModel::new(description).unwrap()
    }

    #[test]
    fn joints_of_several_numbers_have_them_by_the_names_of_variables() {
        let planar = robot(JointKind::Planar);
        assert_eq!(names(&planar), "arm, finger, root/x, root/y, root/theta");
        let (theta, kind) = named(&planar, "root/theta").unwrap();
        assert!(theta.is_angle && kind == ConstraintKind::Angle);
        let floating = robot(JointKind::Floating);
        assert_eq!(
            names(&floating),
            "arm, finger, root/trans_x, root/trans_y, root/trans_z"
        );
        assert_eq!(
            named(&floating, "root/trans_y").unwrap().1,
            ConstraintKind::Slide
        );
    }

    #[test]
    fn what_follows_a_joint_has_its_column_and_what_stands_still_has_none() {
        let robot = robot(JointKind::Planar);
        let (arm, _) = named(&robot, "arm").unwrap();
        let (finger, kind) = named(&robot, "finger").unwrap();
        assert_eq!(
            (finger.column, finger.factor, finger.offset),
            (arm.column, -2.0, 0.5)
        );
        assert_eq!(kind, ConstraintKind::Angle);
        for name in ["still", "after", "root", "root/x/y", ""] {
            assert_eq!(named(&robot, name).map(|found| found.1), None, "{name}");
        }
    }
}
