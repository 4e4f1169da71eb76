//! What an answer is about.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;
use taut::files::RobotFiles;
use taut_ipc::planner::{Planner, Request};

use super::guard::Own;

/// Files of the robots that a connection has loaded, by the hash of their content.
#[derive(Clone, Default)]
pub struct RobotFilesOf(Arc<Mutex<BTreeMap<u64, RobotFiles>>>);

impl RobotFilesOf {
    /// The files of the robot with this hash, if it was loaded here.
    pub fn of(&self, hash: u64) -> Option<RobotFiles> {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .get(&hash)
            .cloned()
    }

    /// Remembers the files of a robot.
    pub fn learn(&self, hash: u64, files: RobotFiles) {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .insert(hash, files);
    }
}

/// What an answer is about.
pub struct About {
    /// Who answers.
    pub planner: Own<Planner>,
    /// Files of the robots that this connection has loaded.
    pub files: RobotFilesOf,
    /// What was asked for.
    pub request: Request,
    /// When.
    pub start: Instant,
}
