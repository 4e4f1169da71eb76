//! Groups of an SRDF, with chains, links and subgroups resolved to joint names.

use std::collections::HashMap;

use roxmltree::Node;

use super::super::xml::{children, line, required, syntax};
use super::{RobotDescription, RobotError, VirtualJoint};
use crate::robot::{Group, JointDescription};
use crate::warning::Warning;

/// The groups in file order; each joint is listed once, in the order in which it is first named.
/// What is wrong with a group is left out of it, and said.
pub(super) fn read(
    root: Node,
    robot: &RobotDescription,
    virtual_joint: Option<&VirtualJoint>,
    warnings: &mut Vec<Warning>,
) -> Vec<Group> {
    let mut nodes = HashMap::new();
    let mut order = Vec::new();
    for node in children(root, "group") {
        match required(node, "name") {
            Ok(name) if nodes.contains_key(name) => {
                let text = format!(
                    "line {}: a second group {name:?}; the first counts",
                    line(node)
                );
                warnings.push(Warning::cosmetic("SRDF group", text));
            }
            Ok(name) => {
                nodes.insert(name, node);
                order.push(name);
            }
            Err(error) => warnings.push(Warning::cosmetic(
                "SRDF group",
                format!("{error}; the group is ignored"),
            )),
        }
    }
    let carried_by = robot
        .joints
        .iter()
        .map(|joint| (joint.child.as_str(), joint))
        .collect();
    let mut resolver = Resolver {
        robot,
        virtual_joint,
        nodes,
        carried_by,
        warnings,
        open: Vec::new(),
    };
    let mut groups = Vec::new();
    for name in order {
        let mut joints = Vec::new();
        resolver.collect(name, &mut joints);
        groups.push(Group {
            name: name.to_owned(),
            joints,
        });
    }
    groups
}

struct Resolver<'a, 'i> {
    robot: &'a RobotDescription,
    virtual_joint: Option<&'a VirtualJoint>,
    nodes: HashMap<&'a str, Node<'a, 'i>>,
    /// Joint that carries a link, by the link's name.
    carried_by: HashMap<&'a str, &'a JointDescription>,
    warnings: &'a mut Vec<Warning>,
    /// The groups that are being resolved.
    open: Vec<&'a str>,
}

impl<'a, 'i> Resolver<'a, 'i> {
    /// Adds the joints of a group.
    fn collect(&mut self, name: &'a str, joints: &mut Vec<String>) {
        let Some(&group) = self.nodes.get(name) else {
            return;
        };
        self.open.push(name);
        for member in group.children().filter(Node::is_element) {
            if let Err(error) = self.member(member, name, joints) {
                self.warn(format!("{error}; it is ignored"));
            }
        }
        self.open.pop();
    }

    fn member(
        &mut self,
        member: Node<'a, 'i>,
        group: &str,
        joints: &mut Vec<String>,
    ) -> Result<(), RobotError> {
        match member.tag_name().name() {
            "joint" => self.joint(member, group, joints),
            "link" => self.link(member, group, joints),
            "chain" => self.chain(member, group, joints),
            "group" => {
                let inner = required(member, "name")?;
                if self.open.contains(&inner) {
                    let open = self.open.join(" → ");
                    return Err(syntax(
                        member,
                        format!("group {inner:?} contains itself: {open} → {inner}"),
                    ));
                }
                if !self.nodes.contains_key(inner) {
                    let mut known: Vec<&str> = self.nodes.keys().copied().collect();
                    known.sort_unstable();
                    let text =
                        format!("group {group:?} contains group {inner:?}, which does not exist");
                    return Err(syntax(
                        member,
                        format!("{text}; known: {}", known.join(", ")),
                    ));
                }
                self.collect(inner, joints);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn joint(
        &mut self,
        member: Node,
        group: &str,
        joints: &mut Vec<String>,
    ) -> Result<(), RobotError> {
        let name = required(member, "name")?;
        let is_virtual = self
            .virtual_joint
            .is_some_and(|joint| joint.name == name);
        if !is_virtual
            && !self
                .robot
                .joints
                .iter()
                .any(|joint| joint.name == name)
        {
            return Err(unknown(member, group, "joint", name));
        }
        add(joints, name);
        Ok(())
    }

    /// A link stands for the joint that carries it; the root link's is the virtual joint.
    fn link(
        &mut self,
        member: Node,
        group: &str,
        joints: &mut Vec<String>,
    ) -> Result<(), RobotError> {
        let name = required(member, "name")?;
        if !self
            .robot
            .links
            .iter()
            .any(|link| link.name == name)
        {
            return Err(unknown(member, group, "link", name));
        }
        if let Some(joint) = self.carried_by.get(name) {
            add(joints, &joint.name);
        } else if let Some(joint) = self.virtual_joint {
            add(joints, &joint.name);
        }
        Ok(())
    }

    /// The joints between two links, through their nearest common ancestor where neither carries
    /// the other.
    fn chain(
        &mut self,
        member: Node,
        group: &str,
        joints: &mut Vec<String>,
    ) -> Result<(), RobotError> {
        let base = required(member, "base_link")?;
        let tip = required(member, "tip_link")?;
        for name in [base, tip] {
            if !self
                .robot
                .links
                .iter()
                .any(|link| link.name == name)
            {
                return Err(unknown(member, group, "link", name));
            }
        }
        let mut up = self.to_root(base);
        let mut down = self.to_root(tip);
        while up.last().is_some() && up.last().map(|j| &j.name) == down.last().map(|j| &j.name) {
            up.pop();
            down.pop();
        }
        for joint in up.into_iter().chain(down.into_iter().rev()) {
            add(joints, &joint.name);
        }
        Ok(())
    }

    /// The joints from a link to the root; ends early on a loop, which the robot's own checks
    /// refuse.
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

    /// A group that others contain is resolved for each of them: what is wrong with it is said
    /// once.
    fn warn(&mut self, text: String) {
        let warning = Warning::cosmetic("SRDF group", text);
        if !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
    }
}

fn unknown(member: Node, group: &str, kind: &str, name: &str) -> RobotError {
    syntax(
        member,
        format!("group {group:?} names {kind} {name:?}, which the robot does not have"),
    )
}

fn add(joints: &mut Vec<String>, name: &str) {
    if !joints.iter().any(|joint| joint == name) {
        joints.push(name.to_owned());
    }
}
