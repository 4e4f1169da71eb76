//! What a planner of the demo plans in.

use std::path::Path;

use taut::files::{FileError, Geometry, Reader};
use taut::robot::RobotModel;
use taut::scene::Scene;

/// What a planner plans in.
pub(super) struct World {
    /// The robot.
    pub(super) robot: RobotModel,
    /// Its label.
    pub(super) robot_name: String,
    /// The obstacles.
    pub(super) scene: Scene,
    /// First waypoint.
    pub(super) start: Vec<f64>,
    /// Last waypoint.
    pub(super) goal: Vec<f64>,
}

impl World {
    /// Reads a problem.
    ///
    /// # Errors
    /// Never, as long as the shipped files are as their tests want them.
    pub(super) fn read(file: &Path) -> Result<Self, FileError> {
        let problem = Reader::default().problem(file, Geometry::Given)?;
        let robot = problem.model()?;
        let path = &problem.path;
        Ok(Self {
            robot_name: robot.name().to_owned(),
            robot,
            start: path.waypoint(0).to_vec(),
            goal: path.waypoint(path.len() - 1).to_vec(),
            scene: problem.scene,
        })
    }
}
