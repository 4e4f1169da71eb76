//! Content hashes of a robot. The words are those of the first hashes, by which certificates and
//! journals name robots; they are written field by field, so that no renaming moves them.

use super::link::Link;
use super::semantics::Pairs;
use crate::hash::{ContentHasher, number, quoted};
use crate::robot::{Drive, GroupState, Joint, JointKind, Variable};

/// Hash of the variable names in order.
pub(super) fn of_layout(variables: &[Variable]) -> u64 {
    let mut hasher = ContentHasher::default();
    for variable in variables {
        hasher.text(&variable.name);
    }
    hasher.finish()
}

/// Hash of the shapes of each link.
pub(super) fn of_shapes(links: &[Link]) -> u64 {
    let mut hasher = ContentHasher::default();
    for link in links {
        hasher.text(&link.name);
        link.shapes
            .iter()
            .for_each(|shape| shape.tell(&mut hasher));
    }
    hasher.finish()
}

/// What a robot is by content, whatever it is called.
pub(super) struct Parts<'a> {
    /// Joint `i` carries link `i`.
    pub links: &'a [Link],
    /// The joints.
    pub joints: &'a [Joint],
    /// Columns of a path.
    pub variables: &'a [Variable],
    /// Pairs that are never checked.
    pub allowed: &'a Pairs,
    /// Name and velocity coordinates of each.
    pub groups: &'a [(String, Vec<bool>)],
    /// Named configurations of groups.
    pub group_states: &'a [GroupState],
}

/// Hash of everything that the robot does.
pub(super) fn of_content(robot: &Parts) -> u64 {
    let mut hasher = ContentHasher::default();
    for (link, joint) in robot.links.iter().zip(robot.joints) {
        hasher.text(&link.name);
        link.shapes
            .iter()
            .for_each(|shape| shape.tell(&mut hasher));
        hasher
            .text(&joint.name)
            .text(&words_of_joint(joint));
        hasher
            .pose(&joint.origin)
            .floats(&joint.axis.to_array());
    }
    for variable in robot.variables {
        tell_variable(variable, &mut hasher);
    }
    hasher.text(&words_of_rules(robot));
    hasher.finish()
}

fn tell_variable(variable: &Variable, hasher: &mut ContentHasher) {
    hasher
        .text(&variable.name)
        .floats(&[variable.lower, variable.upper]);
    if variable.has_soft_limits() {
        hasher.floats(&[variable.hard_lower, variable.hard_upper]);
    }
}

fn words_of_joint(joint: &Joint) -> String {
    let kind = word_of_kind(joint.kind);
    let parent = match joint.parent {
        None => "None".to_owned(),
        Some(parent) => format!("Some({parent})"),
    };
    format!("{kind}{parent}{}", words_of_drive(joint.drive))
}

fn word_of_kind(kind: JointKind) -> &'static str {
    match kind {
        JointKind::Fixed => "Fixed",
        JointKind::Revolute => "Revolute",
        JointKind::Continuous => "Continuous",
        JointKind::Prismatic => "Prismatic",
        JointKind::Planar => "Planar",
        JointKind::Floating => "Floating",
    }
}

fn words_of_drive(drive: Drive) -> String {
    match drive {
        Drive::Fixed => "Fixed".to_owned(),
        Drive::Variable { q, v } => format!("Variable {{ q: {q}, v: {v} }}"),
        Drive::Mimic {
            master,
            multiplier,
            offset,
        } => format!(
            "Mimic {{ master: {master}, multiplier: {}, offset: {} }}",
            number(multiplier),
            number(offset)
        ),
        Drive::Held { first } => format!("Held {{ first: {first} }}"),
    }
}

/// Allowed pairs, groups and their states.
fn words_of_rules(robot: &Parts) -> String {
    let pairs = robot
        .allowed
        .iter()
        .map(|(a, b)| format!("({a}, {b})"));
    let groups = robot.groups.iter().map(|(name, moving)| {
        let moving = moving.iter().map(bool::to_string);
        format!("({}, [{}])", quoted(name), joined(moving))
    });
    let states = robot.group_states.iter().map(words_of_state);
    format!(
        "{{{}}}[{}][{}]",
        joined(pairs),
        joined(groups),
        joined(states)
    )
}

fn words_of_value(joint: &str, values: &[f64]) -> String {
    let values = values.iter().map(|value| number(*value));
    format!("({}, [{}])", quoted(joint), joined(values))
}

fn words_of_state(state: &GroupState) -> String {
    let values = state.values.iter();
    let values = values.map(|(joint, values)| words_of_value(joint, values));
    format!(
        "GroupState {{ name: {}, group: {}, values: [{}] }}",
        quoted(&state.name),
        quoted(&state.group),
        joined(values)
    )
}

fn joined(words: impl Iterator<Item = String>) -> String {
    words.collect::<Vec<_>>().join(", ")
}
