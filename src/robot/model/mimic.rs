//! Joints that copy others.

use std::collections::{BTreeSet, HashMap};

use super::error::{RobotError, list};
use super::tree::Order;
use crate::robot::configuration::Component;
use crate::robot::description::{JointDescription, Mimic, RobotDescription};
use crate::robot::joint::{Drive, JointKind};
use crate::warning::Warning;

/// Drops the mimics of fixed joints, which have no value to follow: MoveIt takes such joints for
/// independent.
pub(super) fn free_of_fixed_leaders(description: &mut RobotDescription) -> Vec<Warning> {
    let fixed = |joint: &&JointDescription| joint.kind == JointKind::Fixed;
    let fixed: BTreeSet<String> = description
        .joints
        .iter()
        .filter(fixed)
        .map(|joint| joint.name.clone())
        .collect();
    let mut warnings = Vec::new();
    for joint in description
        .joints
        .iter_mut()
        .filter(|joint| joint.kind != JointKind::Fixed)
    {
        if let Some(mimic) = joint
            .mimic
            .take_if(|mimic| fixed.contains(&mimic.joint))
        {
            let text = format!(
                "mimics {:?}, which is fixed; it moves independently",
                mimic.joint
            );
            warnings.push(Warning::uncovered(format!("joint {:?} {text}", joint.name)));
        }
    }
    warnings
}

/// `multiplier · (value of the joint at `master`) + offset`.
pub(super) struct Followed {
    /// Position in tree order of the joint that is a variable or held.
    pub master: usize,
    /// Factor.
    pub multiplier: f64,
    /// Offset (m or rad).
    pub offset: f64,
}

/// Follows a mimic to the joint that is a variable or held, composing multipliers and offsets;
/// `None` for a joint that copies none.
///
/// # Errors
/// A mimic of a joint that is not there or has not one variable; joints that copy each other.
pub(super) fn follow(
    description: &RobotDescription,
    joint_index: &HashMap<String, usize>,
    position: usize,
    order: &Order,
    is_listed: &[bool],
) -> Result<Option<Followed>, RobotError> {
    let mut followed = Followed {
        master: position,
        multiplier: 1.0,
        offset: 0.0,
    };
    // Joints that copy each other in a loop beside this one are found from one of them.
    for _ in 0..=order.len() {
        let Some(joint) = order.joint(description, followed.master) else {
            break;
        };
        let Some(mimic) = joint
            .mimic
            .as_ref()
            .filter(|_| !is_listed[followed.master])
        else {
            break;
        };
        let found = joint_index.get(&mimic.joint).copied();
        let master = found.ok_or_else(|| unknown_master(description, joint, mimic))?;
        check_mimic(joint, mimic, order.joint(description, master))?;
        followed.offset += followed.multiplier * mimic.offset;
        followed.multiplier *= mimic.multiplier;
        followed.master = master;
        if master == position {
            return Err(RobotError::NotATree(format!(
                "joint {:?} mimics itself",
                joint.name
            )));
        }
    }
    Ok((followed.master != position).then_some(followed))
}

fn check_mimic(
    joint: &JointDescription,
    mimic: &Mimic,
    master: Option<&JointDescription>,
) -> Result<(), RobotError> {
    let is_single = |kind: JointKind| kind.nq() == 1;
    let is_finite = mimic.multiplier.is_finite() && mimic.offset.is_finite();
    if is_finite && is_single(joint.kind) && master.is_some_and(|joint| is_single(joint.kind)) {
        return Ok(());
    }
    Err(RobotError::BadValue {
        what: format!("the mimic of joint {:?}", joint.name),
        value: format!(
            "{} · {:?} + {}",
            mimic.multiplier, mimic.joint, mimic.offset
        ),
        rule: "both joints have one variable, multiplier and offset are finite",
    })
}

fn unknown_master(
    description: &RobotDescription,
    joint: &JointDescription,
    mimic: &Mimic,
) -> RobotError {
    RobotError::Unknown {
        what: format!("the mimic of joint {:?}", joint.name),
        kind: "joint",
        name: mimic.joint.clone(),
        known: list(
            description
                .joints
                .iter()
                .map(|j| j.name.as_str()),
        ),
    }
}

/// Takes a continuous joint's numbers as they stand where a joint that follows it is not the same
/// after a whole turn: the leader then is no angle on the circle but a real line. Says so once.
pub(super) fn as_real_line(
    components: &mut [Component],
    leader: Drive,
    name: &str,
    follower: JointKind,
    multiplier: f64,
) -> Option<String> {
    let Drive::Variable { q, v } = leader else {
        return None;
    };
    let is_periodic = match follower {
        JointKind::Revolute | JointKind::Continuous => multiplier.fract() == 0.0,
        JointKind::Prismatic => multiplier == 0.0,
        JointKind::Fixed | JointKind::Planar | JointKind::Floating => true,
    };
    let circle = components
        .iter_mut()
        .find(|component| **component == Component::Circle { q, v })?;
    if is_periodic {
        return None;
    }
    *circle = Component::Line { q, v };
    Some(format!("whole turns of continuous joint {name:?} count"))
}
