//! What an answer is about.

use taut::collision::shared_names;
use taut::constraint::ConstraintsFile;
use taut::files::result::{ResultSubject, rows};
use taut::path::Path;
use taut::warning::Warning;
use taut_ipc::control::RobotDescription;

use super::load::Loaded;

/// What was answered about.
pub(super) struct Subject {
    /// Label of the problem, or the file's name.
    pub name: String,
    /// Which of the robot's models was taken.
    pub geometry: &'static str,
    /// What a person should know of robot and scene, where the answer itself does not tell.
    pub warnings: Vec<Warning>,
    /// What the request leaves to be known.
    pub notes: Vec<Warning>,
    /// Columns of the path.
    pub variables: Vec<String>,
    /// What lengths are measured in.
    pub metric: String,
    /// The input's waypoints.
    pub path_before: Vec<Vec<f64>>,
    /// What the path must keep besides clearance.
    pub constraints: ConstraintsFile,
    /// Where robot and scene come from; empty where no result file is wanted.
    pub source: ResultSubject,
}

impl Subject {
    /// What was read from files.
    pub(super) fn of_files(loaded: &Loaded) -> Self {
        let variables = loaded.robot.variables().iter();
        Self {
            name: loaded.name.clone(),
            geometry: loaded.geometry_name(),
            warnings: warnings(loaded),
            notes: loaded.notes.clone(),
            variables: variables
                .map(|variable| variable.name.clone())
                .collect(),
            metric: String::new(),
            path_before: rows(&loaded.path),
            constraints: ConstraintsFile::default(),
            source: ResultSubject::default(),
        }
    }

    /// A path for a robot that was loaded before.
    pub(super) fn of_labels(
        name: String,
        robot: &RobotDescription,
        path: &Path,
        notes: Vec<Warning>,
    ) -> Self {
        let variables = robot.variables.iter();
        Self {
            name,
            geometry: "loaded",
            warnings: Vec::new(),
            notes,
            variables: variables
                .map(|variable| variable.name.clone())
                .collect(),
            metric: String::new(),
            path_before: rows(path),
            constraints: ConstraintsFile::default(),
            source: ResultSubject::default(),
        }
    }
}

/// What a person should know of robot and scene.
pub(super) fn warnings(loaded: &Loaded) -> Vec<Warning> {
    [
        loaded.robot.warnings(),
        loaded.scene.warnings(),
        &shared_names(&loaded.robot, &loaded.scene),
    ]
    .concat()
}
