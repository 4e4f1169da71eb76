//! Problem files.

use std::path::Path;

use taut::files::{self, Geometry, Packages, Reader, RobotFiles};
use taut_ipc::control::{RobotDescription, SceneSummary};
use taut_ipc::planner::{Planner, PlannerError, Refused};
use taut_ipc::wire::Code;

/// What a problem file holds, loaded.
pub struct Loaded {
    pub name: String,
    pub robot: String,
    pub robot_files: RobotFiles,
    pub robot_hash: u64,
    pub scene: String,
    pub columns: Vec<String>,
    pub waypoints: usize,
    pub path: Vec<f64>,
    pub weights: Option<Vec<f64>>,
    pub constraints: String,
    pub warnings: Vec<String>,
}

/// Loads robot and scene of a problem file, under these labels or else under their names and the
/// starts of their hashes.
///
/// # Errors
/// A file that is none, or what whoever answers refuses to load.
pub fn load(
    planner: &Planner,
    file: &Path,
    spheres: bool,
    robot_label: Option<&str>,
    scene_label: Option<&str>,
) -> Result<Loaded, PlannerError> {
    let geometry = if spheres {
        Geometry::Spheres
    } else {
        Geometry::Given
    };
    let mut reader = Reader::new(Packages::with_environment(Default::default()));
    let problem = reader
        .problem(file, geometry)
        .map_err(|error| refused(&error))?;
    let robot = problem
        .model()
        .map_err(|error| refused(&error))?;
    let text = files::scene_text(file).map_err(|error| refused(&error))?;
    let folder = std::path::absolute(file)
        .ok()
        .and_then(|file| file.parent().map(Path::to_owned));
    let listing = planner.list()?;
    let known = listing
        .robots
        .iter()
        .find(|known| known.robot_hash == robot.hash());
    let label = match (robot_label, known) {
        (Some(label), _) => label.to_owned(),
        (None, Some(known)) => known.label.clone(),
        (None, None) => labelled(robot.name(), robot.hash()),
    };
    let source = taut::translate::robot_source(&problem.robot_files);
    let described = planner.load_robot(&label, &source, false)?;
    let known = listing
        .scenes
        .iter()
        .find(|known| known.scene_hash == problem.scene.hash());
    let name = if problem.scene.name().is_empty() {
        &problem.name
    } else {
        problem.scene.name()
    };
    let label = match (scene_label, known) {
        (Some(label), _) => label.to_owned(),
        (None, Some(known)) => known.label.clone(),
        (None, None) => labelled(name, problem.scene.hash()),
    };
    let scene = planner.load_scene(&label, &text, folder.as_deref(), false)?;
    check_same(&described, robot.hash(), &scene, problem.scene.hash())?;
    Ok(Loaded {
        name: problem.name,
        robot: described.label.clone(),
        robot_hash: described.robot_hash,
        robot_files: problem.robot_files,
        scene: scene.label,
        columns: described
            .variables
            .iter()
            .map(|variable| variable.name.clone())
            .collect(),
        waypoints: problem.path.len(),
        path: problem.path.as_flat().to_vec(),
        weights: problem.weights,
        constraints: problem.constraints.text(),
        warnings: [described.warnings.clone(), scene.warnings].concat(),
    })
}

fn labelled(name: &str, hash: u64) -> String {
    format!("{name}@{:08x}", hash >> 32)
}

fn refused(error: &files::FileError) -> PlannerError {
    let refusal = taut::translate::file_refusal(error);
    let code = Code::try_from(refusal.code).unwrap_or(Code::InvalidModel);
    PlannerError::Refused(Box::new(Refused {
        code,
        message: refusal.message,
        retry_after_ms: 0,
        place: None,
    }))
}

/// Two processes that read the same files may find different packages.
fn check_same(
    robot: &RobotDescription,
    robot_hash: u64,
    scene: &SceneSummary,
    scene_hash: u64,
) -> Result<(), PlannerError> {
    let other = [
        ("robot", &robot.label, robot.robot_hash, robot_hash),
        ("scene", &scene.label, scene.scene_hash, scene_hash),
    ];
    for (kind, label, theirs, ours) in other {
        if theirs != ours {
            let message = format!(
                "the daemon reads {kind} {label} with hash {theirs:016x}, this process with {ours:016x}; load it with its packages named"
            );
            return Err(PlannerError::Invalid {
                code: Code::VersionConflict,
                message,
            });
        }
    }
    Ok(())
}
