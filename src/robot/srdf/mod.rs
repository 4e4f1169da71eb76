//! SRDF: which pairs never need a check, groups, named configurations, and the virtual joint.
//!
//! What a check does not need never refuses a robot: what is wrong with a group, a state or a pair
//! that would be left out is a warning. What would add a pair or columns is refused.

mod groups;
#[cfg(test)]
mod tests;

use std::collections::BTreeSet;

use roxmltree::Node;

use super::joint::JointKind;
use super::xml::{self, children, line, numbers, required, syntax, tag};
use super::{Group, GroupState, RobotDescription, RobotError, Semantics, VirtualJoint};
use crate::warning::Warning;

/// Reads an SRDF that belongs to `robot`, whose tree resolves chains and links to joints.
///
/// Returns what it says and a line for each odd thing. Names that the robot does not have are
/// odd, not wrong: SRDFs are shared between variants of a robot.
///
/// # Errors
/// A file that is no SRDF, a virtual joint or a pair to be checked that cannot be read.
pub fn parse(
    text: &str,
    robot: &RobotDescription,
) -> Result<(Semantics, Vec<Warning>), RobotError> {
    let (text, odd) = xml::tidy(text);
    let mut warnings: Vec<Warning> = odd
        .into_iter()
        .map(|text| Warning::cosmetic("text", text))
        .collect();
    let document = xml::document(&text, "SRDF")?;
    let root = document.root_element();
    let disabled_collisions = disabled_collisions(root, robot, &mut warnings)?;
    let virtual_joint = virtual_joint(root, robot, &mut warnings)?;
    let groups = groups::read(root, robot, virtual_joint.as_ref(), &mut warnings);
    let mut group_states = Vec::new();
    for node in children(root, "group_state") {
        match group_state(node, &groups) {
            Ok(state) => group_states.push(state),
            Err(error) => warnings.push(Warning::cosmetic(
                "SRDF state",
                format!("{error}; the state is ignored"),
            )),
        }
    }
    Ok((
        Semantics {
            disabled_collisions,
            groups,
            group_states,
            virtual_joint,
        },
        warnings,
    ))
}

/// Pairs of links that are never checked: `disable_default_collisions` (a link against every other
/// link of the robot; obstacles stay checked), less `enable_collisions`, plus `disable_collisions`.
fn disabled_collisions(
    root: Node,
    robot: &RobotDescription,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<(String, String)>, RobotError> {
    let mut disabled = BTreeSet::new();
    let has = |name: &str| robot.links.iter().any(|link| link.name == name);
    for node in children(root, "disable_default_collisions") {
        match required(node, "link") {
            Ok(link) if has(link) => {
                let others = robot
                    .links
                    .iter()
                    .filter(|other| other.name != link);
                disabled.extend(others.map(|other| ordered(link, &other.name)));
            }
            Ok(link) => {
                let text = format!(
                    "{} names link {link:?}, which the robot does not have",
                    tag(node)
                );
                warnings.push(Warning::cosmetic(
                    "disabled pair",
                    format!("line {}: {text}", line(node)),
                ));
            }
            Err(error) => warnings.push(Warning::cosmetic(
                "disabled pair",
                format!("{error}; it disables nothing"),
            )),
        }
    }
    for node in children(root, "enable_collisions") {
        // A pair that is to be checked must not be lost.
        let pair = pair(node)?;
        if let Some(unknown) = [&pair.0, &pair.1]
            .into_iter()
            .find(|name| !has(name))
        {
            let text = format!(
                "<enable_collisions> names link {unknown:?}, which the robot does not have"
            );
            warnings.push(Warning::uncovered(format!("line {}: {text}", line(node))));
        }
        disabled.remove(&pair);
    }
    for node in children(root, "disable_collisions") {
        match pair(node) {
            Ok(pair) => drop(disabled.insert(pair)),
            Err(error) => warnings.push(Warning::cosmetic(
                "disabled pair",
                format!("{error}; it disables nothing"),
            )),
        }
    }
    Ok(disabled.into_iter().collect())
}

fn pair(node: Node) -> Result<(String, String), RobotError> {
    Ok(ordered(required(node, "link1")?, required(node, "link2")?))
}

fn ordered(a: &str, b: &str) -> (String, String) {
    if a <= b {
        (a.to_owned(), b.to_owned())
    } else {
        (b.to_owned(), a.to_owned())
    }
}

/// The joint between the world and the root link. An SRDF may have others, for other variants of
/// the robot.
fn virtual_joint(
    root: Node,
    robot: &RobotDescription,
    warnings: &mut Vec<Warning>,
) -> Result<Option<VirtualJoint>, RobotError> {
    let mut found = None;
    for node in children(root, "virtual_joint") {
        let name = required(node, "name")?.to_owned();
        let child = required(node, "child_link")?;
        if robot
            .joints
            .iter()
            .any(|joint| joint.child == child)
            || !robot
                .links
                .iter()
                .any(|link| link.name == child)
        {
            let text =
                format!("carries {child:?}, which is not the robot's root link; it is ignored");
            let text = format!("line {}: virtual joint {name:?} {text}", line(node));
            warnings.push(Warning::cosmetic("virtual joint", text));
            continue;
        }
        let kind = match required(node, "type")? {
            "fixed" => JointKind::Fixed,
            "planar" => JointKind::Planar,
            "floating" => JointKind::Floating,
            other => {
                let valid = "valid types: fixed, planar, floating";
                return Err(syntax(
                    node,
                    format!("virtual joint {name:?} has the type {other:?}; {valid}"),
                ));
            }
        };
        if found.is_some() {
            return Err(syntax(
                node,
                "a second <virtual_joint> that carries the root link; keep one",
            ));
        }
        let parent_frame = node
            .attribute("parent_frame")
            .unwrap_or_default()
            .to_owned();
        found = Some(VirtualJoint {
            name,
            kind,
            position_bounds: Vec::new(),
            parent_frame,
        });
    }
    Ok(found)
}

fn group_state(node: Node, groups: &[Group]) -> Result<GroupState, RobotError> {
    let name = required(node, "name")?.to_owned();
    let group = required(node, "group")?.to_owned();
    let of = format!("group state {name:?}");
    if !groups.iter().any(|known| known.name == group) {
        let known: Vec<&str> = groups
            .iter()
            .map(|group| group.name.as_str())
            .collect();
        return Err(syntax(
            node,
            format!("{of} is of group {group:?}; known: {}", known.join(", ")),
        ));
    }
    let value = |joint: Node| {
        let values = numbers(joint, "value", &of)?.filter(|values| !values.is_empty());
        let values =
            values.ok_or_else(|| syntax(joint, format!("{of}: <joint> has no \"value\"")))?;
        Ok((required(joint, "name")?.to_owned(), values))
    };
    let values = children(node, "joint")
        .map(value)
        .collect::<Result<_, RobotError>>()?;
    Ok(GroupState {
        name,
        group,
        values,
    })
}
