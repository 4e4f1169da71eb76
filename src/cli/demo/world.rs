//! The robots and scenes of the demo, which travel inside the program: it runs wherever it is
//! started.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use taut::files::{FileError, Geometry, Reader};
use taut::robot::RobotModel;
use taut::scene::Scene;

/// Problems by name, each of another robot or another scene than the one before.
pub(super) const PROBLEMS: [&str; 6] = [
    "arm_window",
    "rooms",
    "arm_shelf",
    "ell_window",
    "corner",
    "slalom",
];

macro_rules! shipped {
    ($($file:literal),* $(,)?) => {
        [$( ($file, include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/config/", $file))), )*]
    };
}

/// Files below `config/` and their text.
const FILES: [(&str, &str); 16] = shipped![
    "problems/arm_window.json",
    "problems/rooms.json",
    "problems/arm_shelf.json",
    "problems/ell_window.json",
    "problems/corner.json",
    "problems/slalom.json",
    "robots/panda_like.urdf",
    "robots/panda_like.srdf",
    "robots/disc.urdf",
    "robots/disc.srdf",
    "robots/ell.urdf",
    "robots/ell.srdf",
    "robots/bar.urdf",
    "robots/bar.srdf",
    "robots/lift.urdf",
    "robots/lift.srdf",
];

/// Writes the files below a folder, where daemon and planners read them.
pub(super) fn unpack(folder: &Path) -> io::Result<()> {
    for (name, text) in FILES {
        let file = folder.join(name);
        fs::create_dir_all(file.parent().unwrap_or(folder))?;
        fs::write(file, text)?;
    }
    Ok(())
}

/// The file of a problem below that folder.
pub(super) fn problem_file(folder: &Path, name: &str) -> PathBuf {
    folder
        .join("problems")
        .join(format!("{name}.json"))
}

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
