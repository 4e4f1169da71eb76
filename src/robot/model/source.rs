//! What the columns need to know of a joint.

use crate::robot::configuration::Component;
use crate::robot::description::{JointDescription, Mimic, RobotDescription, VirtualJoint};
use crate::robot::joint::JointKind;
use crate::robot::variable::Bounds;

/// What the columns need to know of a joint, virtual or not.
pub(super) struct JointSource<'a> {
    /// Name, the prefix of its variables.
    pub name: &'a str,
    /// How it moves.
    pub kind: JointKind,
    /// Limits of its variables, in order; those that it does not name have none.
    pub limits: Vec<Bounds>,
    /// What it copies.
    pub mimic: Option<&'a Mimic>,
}

impl<'a> JointSource<'a> {
    /// Of a joint of the file.
    pub fn of(joint: &'a JointDescription) -> Self {
        let limits = match joint.kind {
            JointKind::Revolute | JointKind::Prismatic => Bounds::of(joint).into_iter().collect(),
            JointKind::Fixed | JointKind::Continuous | JointKind::Planar | JointKind::Floating => {
                Vec::new()
            }
        };
        Self {
            name: &joint.name,
            kind: joint.kind,
            limits,
            mimic: joint.mimic.as_ref(),
        }
    }

    /// Limits of its variable `index`.
    pub fn bounds(&self, index: usize) -> Bounds {
        self.limits
            .get(index)
            .copied()
            .unwrap_or(Bounds::NONE)
    }

    fn of_virtual(joint: &'a VirtualJoint) -> Self {
        let bounds = joint.position_bounds.iter().copied();
        Self {
            name: &joint.name,
            kind: joint.kind,
            limits: bounds.map(Bounds::hard).collect(),
            mimic: None,
        }
    }

    /// Of the joint that carries the root.
    pub fn root(description: &'a RobotDescription) -> Self {
        match &description.virtual_joint {
            Some(joint) => Self::of_virtual(joint),
            None => Self {
                name: "world",
                kind: JointKind::Fixed,
                limits: Vec::new(),
                mimic: None,
            },
        }
    }
}

/// The components of a joint at columns from `q` on and coordinates from `v` on.
pub(super) fn push_components(
    kind: JointKind,
    q: usize,
    v: usize,
    components: &mut Vec<Component>,
) {
    match kind {
        JointKind::Fixed => {}
        JointKind::Revolute | JointKind::Prismatic => components.push(Component::Line { q, v }),
        JointKind::Continuous => components.push(Component::Circle { q, v }),
        JointKind::Planar => {
            components.extend([
                Component::Line { q, v },
                Component::Line { q: q + 1, v: v + 1 },
            ]);
            components.push(Component::Circle { q: q + 2, v: v + 2 });
        }
        JointKind::Floating => {
            components.extend((0..3).map(|i| Component::Line { q: q + i, v: v + i }));
            components.push(Component::Rotation { q: q + 3, v: v + 3 });
        }
    }
}
