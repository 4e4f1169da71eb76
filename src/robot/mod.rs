//! Robots: a checked tree of joints and links, its configuration space and its kinematics.
//!
//! [`description`] is what a file says, [`model`] what it becomes once everything in it is checked.

// A new kind of shape, core or joint is an error here, not another one's arm.
#![deny(clippy::wildcard_enum_match_arm)]

pub mod configuration;
pub mod description;
pub mod joint;
pub mod kinematics;
pub mod lane_kinematics;
pub mod model;
pub mod srdf;
mod stand;
pub mod urdf;
pub mod variable;
mod worlds;
mod xml;

pub use configuration::{Component, ConfigurationSpace};
pub use description::{
    Group, GroupState, JointDescription, LinkDescription, Mimic, Motor, RobotDescription,
    Semantics, VirtualJoint,
};
pub use joint::{Drive, Joint, JointKind};
pub use kinematics::Kinematics;
pub use model::{Link, RobotError, RobotModel};
pub use stand::{StandError, stand};
pub use variable::{HeldVariable, Variable};
pub(crate) use xml::name as xml_name;
