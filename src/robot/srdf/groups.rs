//! Groups of an SRDF, with chains, links and subgroups resolved to joint names.

use std::collections::HashMap;

use roxmltree::Node;

use super::super::xml::{children, line, required, syntax};
use super::{RobotDescription, RobotError, VirtualJoint};
use crate::robot::{Group, JointDescription};
use crate::warning::Warning;

/// The groups in file order; each joint is listed once, in the order in which it is first named.
pub(super) fn read(
    root: Node,
    robot: &RobotDescription,
    virtual_joint: Option<&VirtualJoint>,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<Group>, RobotError> {
    let mut nodes = HashMap::new();
    for node in children(root, "group") {
        if nodes.insert(required(node, "name")?, node).is_some() {
            return Err(RobotError::Duplicate { kind: "group", name: required(node, "name")?.to_owned() });
        }
    }
    let carried_by = robot.joints.iter().map(|joint| (joint.child.as_str(), joint)).collect();
    let mut resolver = Resolver { robot, virtual_joint, nodes, carried_by, warnings };
    let mut groups = Vec::new();
    for node in children(root, "group") {
        let mut joints = Vec::new();
        resolver.collect(node, &mut Vec::new(), &mut joints)?;
        groups.push(Group { name: required(node, "name")?.to_owned(), joints });
    }
    Ok(groups)
}

struct Resolver<'a, 'i> {
    robot: &'a RobotDescription,
    virtual_joint: Option<&'a VirtualJoint>,
    nodes: HashMap<&'a str, Node<'a, 'i>>,
    /// Joint that carries a link, by the link's name.
    carried_by: HashMap<&'a str, &'a JointDescription>,
    warnings: &'a mut Vec<Warning>,
}

impl<'a, 'i> Resolver<'a, 'i> {
    /// Adds the joints of a group; `open` are the groups that are being resolved.
    fn collect(
        &mut self,
        group: Node<'a, 'i>,
        open: &mut Vec<&'a str>,
        joints: &mut Vec<String>,
    ) -> Result<(), RobotError> {
        let name = required(group, "name")?;
        if open.contains(&name) {
            return Err(syntax(group, format!("group {name:?} contains itself: {} → {name}", open.join(" → "))));
        }
        open.push(name);
        for member in group.children().filter(Node::is_element) {
            match member.tag_name().name() {
                "joint" => self.joint(member, name, joints)?,
                "link" => self.link(member, name, joints)?,
                "chain" => self.chain(member, name, joints)?,
                "group" => {
                    let inner = required(member, "name")?;
                    let Some(&node) = self.nodes.get(inner) else {
                        let mut known: Vec<&str> = self.nodes.keys().copied().collect();
                        known.sort_unstable();
                        let text = format!("group {name:?} contains group {inner:?}, which does not exist");
                        return Err(syntax(member, format!("{text}; known: {}", known.join(", "))));
                    };
                    self.collect(node, open, joints)?;
                }
                _ => {}
            }
        }
        open.pop();
        Ok(())
    }

    fn joint(&mut self, member: Node, group: &str, joints: &mut Vec<String>) -> Result<(), RobotError> {
        let name = required(member, "name")?;
        let is_virtual = self.virtual_joint.is_some_and(|joint| joint.name == name);
        if is_virtual || self.robot.joints.iter().any(|joint| joint.name == name) {
            add(joints, name);
        } else {
            self.unknown(member, group, "joint", name);
        }
        Ok(())
    }

    /// A link stands for the joint that carries it; the root link's is the virtual joint.
    fn link(&mut self, member: Node, group: &str, joints: &mut Vec<String>) -> Result<(), RobotError> {
        let name = required(member, "name")?;
        if !self.robot.links.iter().any(|link| link.name == name) {
            self.unknown(member, group, "link", name);
        } else if let Some(joint) = self.carried_by.get(name) {
            add(joints, &joint.name);
        } else if let Some(joint) = self.virtual_joint {
            add(joints, &joint.name);
        }
        Ok(())
    }

    /// The joints between two links, through their nearest common ancestor where neither carries the other.
    fn chain(&mut self, member: Node, group: &str, joints: &mut Vec<String>) -> Result<(), RobotError> {
        let (base, tip) = (required(member, "base_link")?, required(member, "tip_link")?);
        for name in [base, tip] {
            if !self.robot.links.iter().any(|link| link.name == name) {
                self.unknown(member, group, "link", name);
                return Ok(());
            }
        }
        let (mut up, mut down) = (self.to_root(base), self.to_root(tip));
        while up.last().is_some() && up.last().map(|j| &j.name) == down.last().map(|j| &j.name) {
            up.pop();
            down.pop();
        }
        for joint in up.into_iter().chain(down.into_iter().rev()) {
            add(joints, &joint.name);
        }
        Ok(())
    }

    /// The joints from a link to the root; ends early on a loop, which the robot's own checks refuse.
    fn to_root(&self, link: &str) -> Vec<&'a JointDescription> {
        let mut found: Vec<&JointDescription> = Vec::new();
        let mut at = link;
        while let Some(&joint) = self.carried_by.get(at) {
            if found.len() > self.robot.joints.len() {
                break;
            }
            found.push(joint);
            at = &joint.parent;
        }
        found
    }

    fn unknown(&mut self, member: Node, group: &str, kind: &str, name: &str) {
        let text = format!("group {group:?} names {kind} {name:?}, which the robot does not have; it is ignored");
        self.warnings.push(Warning::cosmetic("SRDF group", format!("line {}: {text}", line(member))));
    }
}

fn add(joints: &mut Vec<String>, name: &str) {
    if !joints.iter().any(|joint| joint == name) {
        joints.push(name.to_owned());
    }
}
