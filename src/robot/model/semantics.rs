//! What an SRDF says of a robot: pairs that are never checked, and groups.

use std::collections::{BTreeSet, HashMap};

use super::error::{RobotError, list};
use crate::robot::description::{GroupState, RobotDescription};
use crate::robot::joint::{Drive, Joint};
use crate::warning::Warning;

/// Pairs of links by index, the lower first.
pub(super) type Pairs = BTreeSet<(usize, usize)>;

/// Pairs of links that are never checked.
///
/// # Errors
/// An allowed pair that names a link that is not there.
pub(super) fn allowed_pairs(
    description: &RobotDescription,
    joints: &[Joint],
    link_index: &HashMap<&str, usize>,
    warnings: &mut Vec<Warning>,
) -> Result<Pairs, RobotError> {
    let mut allowed = match &description.semantics {
        Some(semantics) => disabled(&semantics.disabled_collisions, link_index, warnings),
        None => joined(joints, warnings),
    };
    for (a, b) in &description.allowed_collisions {
        let index = |name: &String| {
            let found = link_index.get(name.as_str()).copied();
            found.ok_or_else(|| RobotError::Unknown {
                what: format!("the allowed pair {a} × {b}"),
                kind: "link",
                name: name.clone(),
                known: list(
                    description
                        .links
                        .iter()
                        .map(|link| link.name.as_str()),
                ),
            })
        };
        allowed.insert(ordered(index(a)?, index(b)?));
    }
    Ok(allowed)
}

/// Pairs that an SRDF disables.
fn disabled(
    pairs: &[(String, String)],
    link_index: &HashMap<&str, usize>,
    warnings: &mut Vec<Warning>,
) -> Pairs {
    let mut disabled = Pairs::new();
    for (a, b) in pairs {
        // SRDFs are shared between variants of a robot, so unknown links are common there.
        if let (Some(&a), Some(&b)) = (link_index.get(a.as_str()), link_index.get(b.as_str())) {
            disabled.insert(ordered(a, b));
        } else {
            let text = format!("the SRDF disables {a} × {b}, not both links of this robot");
            warnings.push(Warning::cosmetic("SRDF pair", text));
        }
    }
    disabled
}

/// Pairs that one joint joins.
fn joined(joints: &[Joint], warnings: &mut Vec<Warning>) -> Pairs {
    if joints.len() > 1 {
        let text = "no SRDF: links joined by one joint are not checked against each other";
        warnings.push(Warning::uncovered(text));
    }
    let carried = joints.iter().enumerate();
    carried
        .filter_map(|(child, joint)| Some(ordered(joint.parent?, child)))
        .collect()
}

fn ordered(a: usize, b: usize) -> (usize, usize) {
    (a.min(b), a.max(b))
}

/// Groups, by name and the velocity coordinates that belong to each, and their states.
pub(super) type Groups = (Vec<(String, Vec<bool>)>, Vec<GroupState>);

/// The groups of an SRDF.
pub(super) fn groups(
    description: &RobotDescription,
    joints: &[Joint],
    nv: usize,
    joint_index: &HashMap<String, usize>,
) -> Groups {
    let Some(semantics) = &description.semantics else {
        return Groups::default();
    };
    let masked = |names: &[String]| {
        let known = names
            .iter()
            .filter_map(|name| joint_index.get(name));
        mask(known.map(|&joint| &joints[joint]), nv)
    };
    let groups = semantics.groups.iter();
    let groups = groups.map(|group| (group.name.clone(), masked(&group.joints)));
    (groups.collect(), semantics.group_states.clone())
}

fn mask<'a>(joints: impl Iterator<Item = &'a Joint>, nv: usize) -> Vec<bool> {
    let mut mask = vec![false; nv];
    for joint in joints {
        if let Drive::Variable { v, .. } = joint.drive {
            mask[v..v + joint.kind.nv()].fill(true);
        }
    }
    mask
}
