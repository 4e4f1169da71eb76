//! The immutable robot: a tree of joints in topological order, checked once when it is built.

mod columns;
mod error;
mod hash;
mod joints;
mod link;
mod mimic;
mod semantics;
mod source;
mod tree;

use super::configuration::ConfigurationSpace;
use super::description::{GroupState, LinkDescription, RobotDescription};
use super::joint::{Drive, Joint};
use super::variable::{HeldVariable, Variable};
use crate::warning::Warning;
use columns::Columns;
pub use error::RobotError;
pub use link::Link;
use mimic::free_of_fixed_leaders;
use semantics::{Pairs, allowed_pairs, groups};
use tree::Order;

/// A robot. Joint `i` carries link `i`; a joint's parent link comes before it.
#[derive(Clone, Debug)]
pub struct RobotModel {
    // Kept: whoever keeps the robot keeps what it was made of, and has it checked again.
    description: RobotDescription,
    name: String,
    links: Vec<Link>,
    joints: Vec<Joint>,
    space: ConfigurationSpace,
    variables: Vec<Variable>,
    held: Vec<HeldVariable>,
    groups: Vec<(String, Vec<bool>)>,
    group_states: Vec<GroupState>,
    allowed: Pairs,
    warnings: Vec<Warning>,
    hash: u64,
    layout_hash: u64,
}

impl RobotModel {
    /// Checks a description and orders it.
    ///
    /// # Errors
    /// A duplicate or unknown name, joints that form no tree, a number that is not finite or out of
    /// its range: the message names the place, the value and the valid ones.
    pub fn new(mut description: RobotDescription) -> Result<Self, RobotError> {
        let kept = description.clone();
        let mut warnings = description.warnings.clone();
        warnings.extend(free_of_fixed_leaders(&mut description));
        let order = Order::of(&description)?;
        let joint_index = order.joint_index(&description);
        let columns = Columns::assign(&description, &order, &joint_index, &mut warnings)?;
        let links = links(&description, &order);
        let joints = joints(&description, &order, &columns.drives)?;
        let numbered = links.iter().enumerate();
        let link_index = numbered
            .map(|(i, link)| (link.name.as_str(), i))
            .collect();
        let allowed = allowed_pairs(&description, &joints, &link_index, &mut warnings)?;
        let (groups, group_states) =
            groups(&description, &joints, columns.space.nv(), &joint_index);
        let hash = hash::of_content(&hash::Parts {
            links: &links,
            joints: &joints,
            variables: &columns.variables,
            allowed: &allowed,
            groups: &groups,
            group_states: &group_states,
        });
        Ok(Self {
            description: kept,
            name: description.name,
            links,
            joints,
            space: columns.space,
            layout_hash: hash::of_layout(&columns.variables),
            variables: columns.variables,
            held: columns.held,
            groups,
            group_states,
            allowed,
            warnings,
            hash,
        })
    }

    /// What it was made of: a model made of it again is the same, but for warnings found where it
    /// was put to use.
    pub fn description(&self) -> &RobotDescription {
        &self.description
    }
    /// Label of the robot.
    pub fn name(&self) -> &str {
        &self.name
    }
    /// Links, root first, parents before children.
    pub fn links(&self) -> &[Link] {
        &self.links
    }
    /// Joints; joint `i` carries link `i`.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }
    /// The space that a row of a path lives in.
    pub fn space(&self) -> &ConfigurationSpace {
        &self.space
    }
    /// Columns of a path.
    pub fn variables(&self) -> &[Variable] {
        &self.variables
    }
    /// Variables of the joints that hold still.
    pub fn held(&self) -> &[HeldVariable] {
        &self.held
    }
    /// Groups: name, and which velocity coordinates belong to it.
    pub fn groups(&self) -> &[(String, Vec<bool>)] {
        &self.groups
    }
    /// Named configurations of groups.
    pub fn group_states(&self) -> &[GroupState] {
        &self.group_states
    }
    /// Whether the pair of links is left out of every check (SRDF, `allowed_collisions`, or joined
    /// by one joint where there is no SRDF).
    pub fn is_allowed(&self, a: usize, b: usize) -> bool {
        self.allowed.contains(&(a.min(b), a.max(b)))
    }
    /// What is odd about the files, a line each.
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }
    /// The same robot with more that is odd about it, found where it was put to use.
    pub fn with_warnings(mut self, more: Vec<Warning>) -> Self {
        self.warnings.extend(more);
        self
    }
    /// Content hash: equal models have equal hashes whatever their label.
    pub fn hash(&self) -> u64 {
        self.hash
    }
    /// Whether another model is the same in all that it can do: of equal content, which is all that a path
    /// depends on, and with equal motors, which its times depend on.
    pub fn is_same(&self, other: &Self) -> bool {
        self.hash == other.hash && self.description.motors == other.description.motors
    }
    /// Hash of the variable names in order.
    pub fn layout_hash(&self) -> u64 {
        self.layout_hash
    }
    /// Hash of the shapes of each link: equal for robots that differ in joints and variables only.
    pub fn shapes_hash(&self) -> u64 {
        hash::of_shapes(&self.links)
    }
    /// Index of a link by name.
    pub fn link_index(&self, name: &str) -> Option<usize> {
        self.links
            .iter()
            .position(|link| link.name == name)
    }
}

/// The links, in tree order.
fn links(description: &RobotDescription, order: &Order) -> Vec<Link> {
    let sources = order
        .0
        .iter()
        .map(|&(link, _)| &description.links[link]);
    let link = |source: &LinkDescription| Link {
        name: source.name.clone(),
        shapes: source.collision.clone(),
    };
    sources.map(link).collect()
}

/// The joints, in tree order.
fn joints(
    description: &RobotDescription,
    order: &Order,
    drives: &[Drive],
) -> Result<Vec<Joint>, RobotError> {
    let joint = |position: usize| match order.joint(description, position) {
        None => joints::root(description, drives[position]),
        Some(joint) => {
            let parent = order.link_position(description, &joint.parent);
            joints::checked(joint, parent, drives[position])
        }
    };
    (0..order.len()).map(joint).collect()
}
