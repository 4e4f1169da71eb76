//! Joints, checked one by one.

use super::error::RobotError;
use crate::math::{Pose, Vec3};
use crate::robot::description::{JointDescription, RobotDescription};
use crate::robot::joint::{Drive, Joint, JointKind};

/// The joint that carries the root link.
///
/// # Errors
/// A virtual joint of a kind that carries no root.
pub(super) fn root(description: &RobotDescription, drive: Drive) -> Result<Joint, RobotError> {
    let (name, kind) = match &description.virtual_joint {
        None => ("world".to_owned(), JointKind::Fixed),
        Some(joint) => (joint.name.clone(), joint.kind),
    };
    match kind {
        JointKind::Fixed | JointKind::Planar | JointKind::Floating => Ok(Joint {
            name,
            kind,
            parent: None,
            origin: Pose::identity(),
            axis: Vec3::Z,
            drive,
        }),
        JointKind::Revolute | JointKind::Continuous | JointKind::Prismatic => {
            Err(RobotError::BadValue {
                what: format!("the type of virtual joint {name:?}"),
                value: kind.name().to_owned(),
                rule: "it must be fixed, planar or floating",
            })
        }
    }
}

/// A joint of the file, its axis of unit length.
///
/// # Errors
/// An origin, axis or limit that is none.
pub(super) fn checked(
    joint: &JointDescription,
    parent: usize,
    drive: Drive,
) -> Result<Joint, RobotError> {
    if !joint.origin.is_finite() {
        let value = format!("{:?}", joint.origin);
        return Err(bad(joint, "origin", value, "it must be finite"));
    }
    let axis = axis(joint)?;
    check_limits(joint)?;
    Ok(Joint {
        name: joint.name.clone(),
        kind: joint.kind,
        parent: Some(parent),
        origin: joint.origin,
        axis,
        drive,
    })
}

fn axis(joint: &JointDescription) -> Result<Vec3, RobotError> {
    match joint.kind {
        JointKind::Revolute | JointKind::Continuous | JointKind::Prismatic => {
            let length = joint.axis.length();
            if length.is_finite() && length >= 1e-9 {
                return Ok(joint.axis / length);
            }
            let value = joint.axis.to_string();
            Err(bad(joint, "axis", value, "it must be finite and not zero"))
        }
        JointKind::Fixed | JointKind::Planar | JointKind::Floating => Ok(Vec3::Z),
    }
}

/// Limits count for joints that must have them.
fn check_limits(joint: &JointDescription) -> Result<(), RobotError> {
    match (joint.kind, joint.limits) {
        (JointKind::Revolute | JointKind::Prismatic, None) => {
            let rule = "a revolute or prismatic joint needs <limit lower= upper=>; use continuous for a joint without";
            Err(bad(joint, "limits", "missing".to_owned(), rule))
        }
        (JointKind::Revolute | JointKind::Prismatic, Some((lower, upper)))
            if lower.is_nan() || upper.is_nan() || lower > upper =>
        {
            let value = format!("[{lower}, {upper}]");
            let rule = "they must be numbers, lower ≤ upper";
            Err(bad(joint, "limits", value, rule))
        }
        (JointKind::Revolute | JointKind::Prismatic, Some(_))
        | (JointKind::Fixed | JointKind::Continuous | JointKind::Planar | JointKind::Floating, _) => {
            Ok(())
        }
    }
}

fn bad(joint: &JointDescription, what: &str, value: String, rule: &'static str) -> RobotError {
    RobotError::BadValue {
        what: format!("the {what} of joint {:?}", joint.name),
        value,
        rule,
    }
}
