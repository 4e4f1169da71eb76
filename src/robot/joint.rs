//! One joint: how it moves its link, and what drives it.

use crate::math::{Pose, Vec3};

/// How a joint moves its child link in the joint's frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum JointKind {
    /// Does not move.
    Fixed,
    /// Rotation about the axis, bounded (rad).
    Revolute,
    /// Rotation about the axis, on the circle (rad).
    Continuous,
    /// Translation along the axis (m).
    Prismatic,
    /// Translation in the x-y plane (m), then rotation about z (rad).
    Planar,
    /// Translation (m), then rotation as a unit quaternion (x, y, z, w).
    Floating,
}

impl JointKind {
    /// Its name in URDF.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::Revolute => "revolute",
            Self::Continuous => "continuous",
            Self::Prismatic => "prismatic",
            Self::Planar => "planar",
            Self::Floating => "floating",
        }
    }

    /// Numbers of one configuration of the joint (columns of a path).
    pub fn nq(self) -> usize {
        match self {
            Self::Fixed => 0,
            Self::Revolute | Self::Continuous | Self::Prismatic => 1,
            Self::Planar => 3,
            Self::Floating => 7,
        }
    }

    /// Numbers of one velocity of the joint.
    pub fn nv(self) -> usize {
        match self {
            Self::Floating => 6,
            Self::Fixed | Self::Revolute | Self::Continuous | Self::Prismatic | Self::Planar => {
                self.nq()
            }
        }
    }

    /// MoveIt's names for the joint's variables: the joint itself, or `joint/x`, `joint/trans_x` …
    pub fn variable_names(self, joint: &str) -> Vec<String> {
        let parts: &[&str] = match self {
            Self::Fixed => &[],
            Self::Revolute | Self::Continuous | Self::Prismatic => return vec![joint.to_owned()],
            Self::Planar => &["x", "y", "theta"],
            Self::Floating => &[
                "trans_x", "trans_y", "trans_z", "rot_x", "rot_y", "rot_z", "rot_w",
            ],
        };
        parts
            .iter()
            .map(|part| format!("{joint}/{part}"))
            .collect()
    }
}

/// Where a joint's value comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// A fixed joint has no value.
    Fixed,
    /// Columns `q..q + nq` of the path, coordinates `v..v + nv` of a velocity.
    Variable {
        /// First configuration column.
        q: usize,
        /// First velocity coordinate.
        v: usize,
    },
    /// `multiplier · (value of joint `master`) + offset`; the master is itself not a mimic.
    Mimic {
        /// Index of the master joint.
        master: usize,
        /// Factor on the master's value and rate.
        multiplier: f64,
        /// Added to the value (m or rad).
        offset: f64,
    },
    /// Held still at `held[first..first + nq]`, values that the request may give.
    Held {
        /// First held value.
        first: usize,
    },
}

/// A joint of the tree. Joint `i` carries link `i`; joint 0 carries the root link in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Name, unique in the robot.
    pub name: String,
    /// How it moves.
    pub kind: JointKind,
    /// Link that the joint hangs on; `None` is the world (joint 0 only). Always less than the
    /// joint's own index.
    pub parent: Option<usize>,
    /// Pose of the joint's frame at value 0 in the parent link's frame.
    pub origin: Pose,
    /// Unit axis in the joint's frame (revolute, continuous, prismatic); z for the others.
    pub axis: Vec3,
    /// Where its value comes from.
    pub drive: Drive,
}
