//! Where a robot comes from, so that another process can read the same one.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::{FileError, Reader};
use crate::robot::{RobotDescription, VirtualJoint};

/// The files of a robot, and what is said about it elsewhere.
#[derive(Clone, Debug, Default)]
pub struct RobotFiles {
    /// Its URDF.
    pub urdf: PathBuf,
    /// Its SRDF.
    pub srdf: Option<PathBuf>,
    /// Folders of packages by name.
    pub packages: BTreeMap<String, PathBuf>,
    /// Joint between the world and the root link.
    pub root: RootJoint,
    /// Columns of a path; `None` takes every movable joint that is not a mimic.
    pub variables: Option<Vec<String>>,
    /// Link pairs that may touch, besides the SRDF's.
    pub allowed_collisions: Vec<(String, String)>,
}

/// Who decides about the joint between the world and the root link.
#[derive(Clone, Debug, Default)]
pub enum RootJoint {
    /// The SRDF; without one the root is fixed.
    #[default]
    OfSrdf,
    /// This joint; `None` fixes the root.
    Given(Option<VirtualJoint>),
}

impl Reader {
    /// Reads a robot as `files` says.
    ///
    /// # Errors
    /// A file that cannot be read, or is no URDF or SRDF.
    pub fn robot_of(&mut self, files: &RobotFiles) -> Result<RobotDescription, FileError> {
        let mut robot = self.robot_with(&files.urdf, files.srdf.as_deref(), &files.packages)?;
        if let RootJoint::Given(joint) = &files.root {
            robot.virtual_joint.clone_from(joint);
        }
        robot.allowed_collisions.clone_from(&files.allowed_collisions);
        robot.variables.clone_from(&files.variables);
        Ok(robot)
    }
}
