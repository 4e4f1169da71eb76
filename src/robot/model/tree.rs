//! The joints as one tree: which link each carries, parents before children.

use std::collections::{BTreeSet, HashMap};

use super::error::{RobotError, list, unique};
use crate::robot::description::{JointDescription, RobotDescription};

/// (link, joint that carries it) by index in the description, root first.
pub(super) struct Order(pub Vec<(usize, Option<usize>)>);

impl Order {
    /// Orders the joints of a description.
    ///
    /// # Errors
    /// A name that stands twice or names no link; joints that form no tree.
    pub fn of(description: &RobotDescription) -> Result<Self, RobotError> {
        check_names(description)?;
        let tree = Tree::of(description)?;
        let root = tree.root(description)?;
        let order = tree.depth_first(root);
        check_reached(description, &order)?;
        Ok(Self(order))
    }

    /// Links in the tree.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// The joint that carries the link at a position; `None` for the root.
    pub fn joint<'a>(
        &self,
        description: &'a RobotDescription,
        position: usize,
    ) -> Option<&'a JointDescription> {
        self.0[position]
            .1
            .map(|joint| &description.joints[joint])
    }

    /// Position of the link called `name` in tree order.
    pub fn link_position(&self, description: &RobotDescription, name: &str) -> usize {
        let position = self
            .0
            .iter()
            .position(|&(link, _)| description.links[link].name == name);
        position.expect("every link name was checked when the order was made")
    }

    /// Joint name to position in tree order; the virtual joint is at 0.
    pub fn joint_index(&self, description: &RobotDescription) -> HashMap<String, usize> {
        let named = |position| Some((self.joint_name(description, position)?, position));
        (0..self.len()).filter_map(named).collect()
    }

    /// Of the virtual joint too.
    fn joint_name(&self, description: &RobotDescription, position: usize) -> Option<String> {
        let joint = self.joint(description, position);
        let name = joint.map(|joint| &joint.name);
        let root = description.virtual_joint.as_ref();
        name.or(root.map(|joint| &joint.name)).cloned()
    }
}

fn check_names(description: &RobotDescription) -> Result<(), RobotError> {
    let virtual_name = description
        .virtual_joint
        .iter()
        .map(|v| v.name.as_str());
    let joints = description
        .joints
        .iter()
        .map(|joint| joint.name.as_str());
    unique("link", link_names(description))?;
    unique("joint", joints.chain(virtual_name))
}

fn link_names(description: &RobotDescription) -> impl Iterator<Item = &str> {
    description
        .links
        .iter()
        .map(|link| link.name.as_str())
}

/// Who carries whom, by index in the description.
struct Tree {
    /// For each joint, its child link.
    child_of: Vec<usize>,
    /// For each link, the joint that carries it.
    carried_by: Vec<Option<usize>>,
    /// For each link, the joints that it carries.
    children: Vec<Vec<usize>>,
}

impl Tree {
    fn of(description: &RobotDescription) -> Result<Self, RobotError> {
        let links = description.links.len();
        let numbered = link_names(description).enumerate();
        let index: HashMap<&str, usize> = numbered.map(|(i, name)| (name, i)).collect();
        let mut tree = Self {
            child_of: Vec::with_capacity(description.joints.len()),
            carried_by: vec![None; links],
            children: vec![Vec::new(); links],
        };
        for (number, joint) in description.joints.iter().enumerate() {
            let known = |end: &str, name: &str| {
                let found = index.get(name).copied();
                found.ok_or_else(|| unknown_link(description, joint, end, name))
            };
            let parent = known("parent", &joint.parent)?;
            let child = known("child", &joint.child)?;
            if let Some(other) = tree.carried_by[child] {
                return Err(two_parents(&description.joints[other], joint));
            }
            tree.child_of.push(child);
            tree.carried_by[child] = Some(number);
            tree.children[parent].push(number);
        }
        Ok(tree)
    }

    /// The link that no joint carries.
    fn root(&self, description: &RobotDescription) -> Result<usize, RobotError> {
        let uncarried = (0..self.carried_by.len()).filter(|&link| self.carried_by[link].is_none());
        let roots: Vec<usize> = uncarried.collect();
        let text = match roots.as_slice() {
            &[root] => return Ok(root),
            [] if description.links.is_empty() => "there is no link".to_owned(),
            [] => "every link is some joint's child, so the joints form a loop".to_owned(),
            several => {
                let names = several
                    .iter()
                    .map(|&l| description.links[l].name.as_str());
                let count = several.len();
                format!("{count} links are no joint's child: {}", list(names))
            }
        };
        Err(RobotError::NotATree(text))
    }

    /// A chain's links lie side by side.
    fn depth_first(&self, root: usize) -> Vec<(usize, Option<usize>)> {
        let mut order = Vec::with_capacity(self.carried_by.len());
        let mut stack = vec![(root, None)];
        while let Some((link, joint)) = stack.pop() {
            order.push((link, joint));
            let children = self.children[link].iter().rev();
            stack.extend(children.map(|&joint| (self.child_of[joint], Some(joint))));
        }
        order
    }
}

fn check_reached(
    description: &RobotDescription,
    order: &[(usize, Option<usize>)],
) -> Result<(), RobotError> {
    let reached: BTreeSet<usize> = order.iter().map(|&(link, _)| link).collect();
    if reached.len() == description.links.len() {
        return Ok(());
    }
    let lost = (0..description.links.len()).filter(|link| !reached.contains(link));
    let names = lost.map(|link| description.links[link].name.as_str());
    Err(RobotError::NotATree(format!(
        "a loop that the root does not reach: {}",
        list(names)
    )))
}

fn unknown_link(
    description: &RobotDescription,
    joint: &JointDescription,
    end: &str,
    name: &str,
) -> RobotError {
    RobotError::Unknown {
        what: format!("joint {:?} ({end})", joint.name),
        kind: "link",
        name: name.to_owned(),
        known: list(link_names(description)),
    }
}

fn two_parents(first: &JointDescription, second: &JointDescription) -> RobotError {
    let text = format!(
        "link {:?} is the child of two joints, {:?} and {:?}",
        second.child, first.name, second.name
    );
    RobotError::NotATree(text)
}
