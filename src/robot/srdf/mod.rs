//! SRDF: which pairs never need a check, groups, named configurations, and the virtual joint.

mod groups;
#[cfg(test)]
mod tests;

use std::collections::BTreeSet;

use roxmltree::Node;

use super::joint::JointKind;
use super::xml::{self, children, line, numbers, required, syntax};
use super::{GroupState, RobotDescription, RobotError, Semantics, VirtualJoint};
use crate::warning::Warning;

/// Reads an SRDF that belongs to `robot`, whose tree resolves chains and links to joints.
///
/// Returns what it says and a line for each odd thing. Names that the robot does not have are
/// odd, not wrong: SRDFs are shared between variants of a robot.
///
/// # Errors
/// A file that is no SRDF, an element without a name it needs, groups that contain themselves.
pub fn parse(text: &str, robot: &RobotDescription) -> Result<(Semantics, Vec<Warning>), RobotError> {
    let document = xml::document(text, "SRDF")?;
    let root = document.root_element();
    let mut warnings = Vec::new();
    let disabled_collisions = disabled_collisions(root, robot)?;
    let virtual_joint = virtual_joint(root, robot, &mut warnings)?;
    let groups = groups::read(root, robot, virtual_joint.as_ref(), &mut warnings)?;
    let group_states = children(root, "group_state").map(group_state).collect::<Result<_, _>>()?;
    Ok((Semantics { disabled_collisions, groups, group_states, virtual_joint }, warnings))
}

/// Pairs of links that are never checked: `disable_default_collisions` (a link against every other link
/// of the robot; obstacles stay checked), less `enable_collisions`, plus `disable_collisions`.
fn disabled_collisions(root: Node, robot: &RobotDescription) -> Result<Vec<(String, String)>, RobotError> {
    let mut disabled = BTreeSet::new();
    for node in children(root, "disable_default_collisions") {
        let link = required(node, "link")?;
        for other in robot.links.iter().filter(|other| other.name != link) {
            disabled.insert(ordered(link, &other.name));
        }
    }
    for node in children(root, "enable_collisions") {
        disabled.remove(&pair(node)?);
    }
    for node in children(root, "disable_collisions") {
        disabled.insert(pair(node)?);
    }
    Ok(disabled.into_iter().collect())
}

fn pair(node: Node) -> Result<(String, String), RobotError> {
    Ok(ordered(required(node, "link1")?, required(node, "link2")?))
}

fn ordered(a: &str, b: &str) -> (String, String) {
    if a <= b { (a.to_owned(), b.to_owned()) } else { (b.to_owned(), a.to_owned()) }
}

fn virtual_joint(
    root: Node,
    robot: &RobotDescription,
    warnings: &mut Vec<Warning>,
) -> Result<Option<VirtualJoint>, RobotError> {
    let mut nodes = children(root, "virtual_joint");
    let Some(node) = nodes.next() else { return Ok(None) };
    if let Some(second) = nodes.next() {
        return Err(syntax(second, "a second <virtual_joint>; a robot has one root"));
    }
    let name = required(node, "name")?.to_owned();
    let kind = match required(node, "type")? {
        "fixed" => JointKind::Fixed,
        "planar" => JointKind::Planar,
        "floating" => JointKind::Floating,
        other => {
            let text = format!("virtual joint {name:?} has the type {other:?}; valid types: fixed, planar, floating");
            return Err(syntax(node, text));
        }
    };
    let child = required(node, "child_link")?;
    if robot.joints.iter().any(|joint| joint.child == child) || !robot.links.iter().any(|link| link.name == child) {
        let text =
            format!("virtual joint {name:?} carries {child:?}, which is not the robot's root link; it is ignored");
        warnings.push(Warning::cosmetic("virtual joint", format!("line {}: {text}", line(node))));
        return Ok(None);
    }
    Ok(Some(VirtualJoint { name, kind, position_bounds: Vec::new() }))
}

fn group_state(node: Node) -> Result<GroupState, RobotError> {
    let (name, group) = (required(node, "name")?.to_owned(), required(node, "group")?.to_owned());
    let of = format!("group state {name:?}");
    let value = |joint: Node| {
        let values = numbers(joint, "value", &of)?.filter(|values| !values.is_empty());
        let values = values.ok_or_else(|| syntax(joint, format!("{of}: <joint> has no \"value\"")))?;
        Ok((required(joint, "name")?.to_owned(), values))
    };
    let values = children(node, "joint").map(value).collect::<Result<_, RobotError>>()?;
    Ok(GroupState { name, group, values })
}
