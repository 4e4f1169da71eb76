//! What robot files say, by name and unchecked: the input of
//! [`RobotModel::new`](super::RobotModel::new).

use super::joint::JointKind;
use crate::math::{Pose, Vec3};
use crate::shape::PlacedShape;
use crate::warning::Warning;

/// A robot as its files describe it.
#[derive(Clone, Debug, Default)]
pub struct RobotDescription {
    /// Label of the robot.
    pub name: String,
    /// Links in file order.
    pub links: Vec<LinkDescription>,
    /// Joints in file order.
    pub joints: Vec<JointDescription>,
    /// Joint that carries the root link in the world; `None` fixes it at the identity.
    pub virtual_joint: Option<VirtualJoint>,
    /// Columns of a path, by variable name; `None` takes every movable joint that is not a mimic,
    /// in tree order.
    pub variables: Option<Vec<String>>,
    /// What an SRDF adds; `None` where there is none.
    pub semantics: Option<Semantics>,
    /// Link pairs to leave out besides the SRDF's.
    pub allowed_collisions: Vec<(String, String)>,
    /// What the motors of joints can do, in file order; joints of which nothing is said are left out.
    pub motors: Vec<Motor>,
    /// What the readers already found odd, a line each.
    pub warnings: Vec<Warning>,
}

/// A link and its collision shapes, in the link's frame.
#[derive(Clone, Debug, Default)]
pub struct LinkDescription {
    /// Name, unique in the robot.
    pub name: String,
    /// Collision shapes.
    pub collision: Vec<PlacedShape>,
}

/// A joint of the file.
#[derive(Clone, Debug)]
pub struct JointDescription {
    /// Name, unique in the robot.
    pub name: String,
    /// How it moves.
    pub kind: JointKind,
    /// Parent link's name.
    pub parent: String,
    /// Child link's name.
    pub child: String,
    /// Pose of the joint in the parent link's frame.
    pub origin: Pose,
    /// Axis in the joint's frame, of any length but 0.
    pub axis: Vec3,
    /// Lower and upper limit (m or rad); `None` where the file gives none.
    pub limits: Option<(f64, f64)>,
    /// Limits within those, which the robot's controllers keep (m or rad); `None` where the file
    /// gives none.
    pub soft_limits: Option<(f64, f64)>,
    /// The joint that this one copies.
    pub mimic: Option<Mimic>,
}

/// What a file says of the motor of a joint. A check of where the robot may be does not depend on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Motor {
    /// The joint's name.
    pub joint: String,
    /// The greatest speed in either direction (m or rad per s).
    pub velocity: Option<f64>,
    /// The greatest force or torque in either direction (N or Nm).
    pub effort: Option<f64>,
}

/// `value = multiplier · value(joint) + offset`.
#[derive(Clone, Debug)]
pub struct Mimic {
    /// Master joint's name.
    pub joint: String,
    /// Factor.
    pub multiplier: f64,
    /// Offset (m or rad).
    pub offset: f64,
}

/// The joint between the world and the root link.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct VirtualJoint {
    /// Name, the prefix of its variables.
    pub name: String,
    /// Planar, floating or fixed.
    pub kind: JointKind,
    /// Limits of its translations (m), in order; empty means none.
    pub position_bounds: Vec<(f64, f64)>,
    /// What the robot's maker calls the world; empty where nobody says.
    #[serde(default)]
    pub parent_frame: String,
}

/// What an SRDF says.
#[derive(Clone, Debug, Default)]
pub struct Semantics {
    /// Link pairs that are never checked.
    pub disabled_collisions: Vec<(String, String)>,
    /// Groups, with chains, links and subgroups already resolved to joint names.
    pub groups: Vec<Group>,
    /// Named configurations of groups.
    pub group_states: Vec<GroupState>,
    /// The SRDF's own virtual joint, the default where no problem file decides.
    pub virtual_joint: Option<VirtualJoint>,
}

/// A named set of joints.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Group {
    /// Name.
    pub name: String,
    /// Joint names.
    pub joints: Vec<String>,
}

/// A named configuration of a group.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GroupState {
    /// Name.
    pub name: String,
    /// Group it belongs to.
    pub group: String,
    /// Joint name and its values.
    pub values: Vec<(String, Vec<f64>)>,
}
