//! Where a robot comes from, so that another process can read the same one.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::{FileError, Reader, folder_of};
use crate::robot::urdf::{self, Visual};
use crate::robot::{RobotDescription, VirtualJoint};

/// The files of a robot, and what is said about it elsewhere.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
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
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RootJoint {
    /// The SRDF; without one the root is fixed.
    #[default]
    OfSrdf,
    /// This joint; `None` fixes the root.
    Given(Option<VirtualJoint>),
}

impl RobotFiles {
    /// The same by absolute paths, for a process that was started elsewhere, with more packages
    /// where it has none of their names.
    #[must_use]
    pub fn absolute(&self, packages: &BTreeMap<String, PathBuf>) -> Self {
        let absolute = |file: &PathBuf| std::path::absolute(file).unwrap_or_else(|_| file.clone());
        let named = packages.iter().chain(&self.packages);
        Self {
            urdf: absolute(&self.urdf),
            srdf: self.srdf.as_ref().map(absolute),
            packages: named
                .map(|(name, folder)| (name.clone(), absolute(folder)))
                .collect(),
            ..self.clone()
        }
    }
}

impl Reader {
    /// Reads a robot as `files` says.
    ///
    /// # Errors
    /// A file that cannot be read, or is no URDF or SRDF.
    pub fn robot_of(&mut self, files: &RobotFiles) -> Result<RobotDescription, FileError> {
        let mut robot = self.robot_with(&files.urdf, files.srdf.as_deref(), &files.packages)?;
        if let RootJoint::Given(joint) = &files.root {
            let of_srdf = robot
                .virtual_joint
                .take()
                .map(|joint| joint.parent_frame)
                .unwrap_or_default();
            robot.virtual_joint.clone_from(joint);
            // Who says how the root moves need not repeat what the world is called.
            if let Some(joint) = &mut robot.virtual_joint
                && joint.parent_frame.is_empty()
            {
                joint.parent_frame = of_srdf;
            }
        }
        robot
            .allowed_collisions
            .clone_from(&files.allowed_collisions);
        robot.variables.clone_from(&files.variables);
        Ok(robot)
    }

    /// What a robot looks like, for pictures; and what of it cannot be shown, a line each.
    ///
    /// # Errors
    /// A URDF that cannot be read.
    pub fn visuals(&mut self, files: &RobotFiles) -> Result<(Vec<Visual>, Vec<String>), FileError> {
        let (text, _) = self.xml(&files.urdf)?;
        let packages = self.packages.with(&files.packages);
        let mut meshes =
            |name: &str, scale| self.mesh(name, scale, &packages, folder_of(&files.urdf));
        urdf::visuals(&text, &mut meshes).map_err(|source| FileError::Robot {
            file: files.urdf.clone(),
            source,
        })
    }
}
