//! A path, and a robot and a scene that are there to answer about it.

use std::path::{Path as FilePath, PathBuf};
use std::sync::Arc;

use taut::constraint::ConstraintsFile;
use taut::files::result::{ResultSubject, RobotSource, SceneSource};
use taut::files::{self, Reader};
use taut::path::Path;
use taut::warning::Warning;
use taut_ipc::control::{Listing, RobotDescription, SceneSummary};
use taut_ipc::planner::{EMPTY_SCENE, Planner, Request};
use taut_ipc::wire::Code;

use super::asked::Asked;
use super::error::CliError;
use super::labelled::{self, Labelled};
use super::load::{self, Loaded};
use super::place::Place;
use super::source::{Source, folder_of};
use super::subject::Subject;
use super::weights::weights;
use crate::daemon::translate;

/// A path, and a robot and a scene that are there to answer about it.
pub(super) struct Prepared {
    /// Who answers.
    pub planner: Planner,
    /// What the report says about them.
    pub subject: Subject,
    /// The robot.
    pub robot: Arc<RobotDescription>,
    /// The scene.
    pub scene: SceneSummary,
    /// What was read here to know which; `None` where both were named by their labels.
    loaded: Option<Loaded>,
    /// The path.
    pub path: Path,
    /// What the files ask the path to keep besides clearance.
    constraints: ConstraintsFile,
    /// The problem's weights.
    pub weights: Option<Vec<f64>>,
}

/// Sees to it that robot and scene of a file are there.
///
/// They are read here too: their hashes say which ones the daemon must have, and the answer is for
/// no others.
///
/// # Errors
/// A file that cannot be used, or what the daemon refuses to load.
pub(super) fn prepare(
    place: &Place,
    reader: &mut Reader,
    file: &FilePath,
    source: &Source,
    held: &[(String, f64)],
) -> Result<Prepared, CliError> {
    if let Some(planner) = place.daemon()
        && let Some(label) = label(source)?
    {
        let labelled = labelled::read(planner, file, label, source.scene.as_deref(), held)?;
        return Ok(Prepared::of_labels(planner.clone(), labelled));
    }
    Prepared::of_files(
        place,
        load::load_holding(reader, file, source, false, held)?,
    )
}

/// The label of a robot that the daemon has loaded.
fn label(source: &Source) -> Result<Option<&str>, CliError> {
    let robot = source
        .robot
        .as_deref()
        .and_then(name_of_no_file);
    let scene = source
        .scene
        .as_deref()
        .and_then(name_of_no_file);
    match (robot, scene) {
        (None, Some(label)) => Err(scene_without_robot(label)),
        (robot, _) => Ok(robot),
    }
}

fn scene_without_robot(label: &str) -> CliError {
    CliError::Usage(format!(
        "--scene {label} is a label; name the robot by its label too, or give a scene file"
    ))
}

/// A name on the command line that is no file's.
fn name_of_no_file(name: &FilePath) -> Option<&str> {
    let text = name.to_str()?;
    let is_a_files = text.contains('/') || name.is_file() || ends_like_a_file(text);
    (!is_a_files).then_some(text)
}

fn ends_like_a_file(name: &str) -> bool {
    const ENDS: [&str; 6] = [".urdf", ".xml", ".json", ".scene", ".yaml", ".yml"];
    ENDS.iter().any(|end| name.ends_with(end))
}

impl Prepared {
    fn of_labels(planner: Planner, labelled: Labelled) -> Self {
        Self {
            planner,
            subject: labelled.subject,
            robot: labelled.robot,
            scene: labelled.scene,
            loaded: None,
            path: labelled.path,
            constraints: labelled.constraints,
            weights: None,
        }
    }

    fn of_files(place: &Place, loaded: Loaded) -> Result<Self, CliError> {
        let robot_label = file_label(loaded.robot.name(), loaded.robot.hash());
        let scene_label = file_label(loaded.scene_name(), loaded.scene.hash());
        let planner = place.planner(&loaded, &robot_label, &scene_label)?;
        let listing = planner.list()?;
        let robot = robot(&planner, &listing, &loaded, &robot_label)?;
        let scene = scene(&planner, &listing, &loaded, &scene_label)?;
        // The answer tells what is to be known of both; but where the daemon has the same content
        // from other files, only these were read for what they leave out.
        let mut subject = Subject::of_files(&loaded);
        subject.warnings.retain(Warning::is_uncovered);
        Ok(Self {
            planner,
            subject,
            robot,
            scene,
            path: loaded.path.clone(),
            constraints: loaded.constraints.clone(),
            weights: loaded.weights.clone(),
            loaded: Some(loaded),
        })
    }

    /// What is asked about them.
    ///
    /// # Errors
    /// The problem's weights where it has none.
    pub(super) fn request(&self, asked: &Asked) -> Result<Request, CliError> {
        let nv = self.robot.nv as usize;
        let metric = weights(asked.weights, self.weights.as_ref(), nv).map_err(CliError::Usage)?;
        Ok(Request {
            robot: self.robot.label.clone(),
            robot_hash: self.robot.robot_hash,
            scene: Some(self.scene.label.clone()),
            scene_hash: self.hash_of_version(asked.request.scene_version),
            metric: metric.unwrap_or_default(),
            constraints: self.constraints(asked).text(),
            ..asked.request.clone()
        })
    }

    /// Says in the report what lengths are measured in, and what the path must keep.
    pub(super) fn tell_what_is_asked(&mut self, asked: &Asked) {
        self.subject.metric = asked.metric(self.weights.is_some());
        self.subject.constraints = self.constraints(asked);
    }

    /// What the path must keep besides clearance: what its files say, and the flags.
    fn constraints(&self, asked: &Asked) -> ConstraintsFile {
        self.constraints
            .clone()
            .and(asked.constraints.clone())
    }

    /// The hash that a version of the scene has to have; 0 for another than the one that is known
    /// here.
    fn hash_of_version(&self, version: u64) -> u64 {
        match version {
            0 => self.scene.scene_hash,
            _ => 0,
        }
    }

    /// Where robot and scene of an answer come from: from what was read here, else the daemon is
    /// asked for the scene.
    pub(super) fn source(
        &self,
        request: &Request,
        packages: &[(String, PathBuf)],
    ) -> ResultSubject {
        match &self.loaded {
            Some(loaded) => loaded.source(packages),
            None => ResultSubject {
                robot: self.robot_source(),
                scene: self.scene_source(request.scene_version),
                ..ResultSubject::default()
            },
        }
    }

    fn robot_source(&self) -> RobotSource {
        RobotSource {
            label: Some(self.robot.label.clone()),
            hash: format!("{:016x}", self.robot.robot_hash),
            files: None,
        }
    }

    /// A version of the scene, as the daemon tells it.
    fn scene_source(&self, version: u64) -> SceneSource {
        let version = match version {
            0 => self.scene.version,
            version => version,
        };
        let label = &self.scene.label;
        let told = self.planner.show_scene(label, version, 0).ok();
        let hash = told.as_ref().map(|text| text.scene_hash);
        SceneSource {
            label: Some(label.clone()),
            version: Some(version),
            hash: format!("{:016x}", hash.unwrap_or(self.scene.scene_hash)),
            file: None,
            content: told.and_then(|text| serde_json::from_str(&text.json).ok()),
        }
    }
}

/// The label of what comes from a file: its name and the start of its hash.
fn file_label(name: &str, hash: u64) -> String {
    format!("{name}@{:08x}", hash >> 32)
}

fn robot(
    planner: &Planner,
    listing: &Listing,
    loaded: &Loaded,
    label: &str,
) -> Result<Arc<RobotDescription>, CliError> {
    let hash = loaded.robot.hash();
    match listing
        .robots
        .iter()
        .find(|robot| robot.robot_hash == hash)
    {
        Some(robot) => Ok(planner.robot(&robot.label)?),
        None => robot_of_files(planner, loaded, label),
    }
}

fn robot_of_files(
    planner: &Planner,
    loaded: &Loaded,
    label: &str,
) -> Result<Arc<RobotDescription>, CliError> {
    let source = translate::robot_source(&loaded.robot_files);
    let robot = planner.load_robot(label, &source, false)?;
    check_same("robot", &robot.label, robot.robot_hash, loaded.robot.hash())?;
    Ok(robot)
}

fn scene(
    planner: &Planner,
    listing: &Listing,
    loaded: &Loaded,
    label: &str,
) -> Result<SceneSummary, CliError> {
    let hash = loaded.scene.hash();
    if let Some(scene) = listing
        .scenes
        .iter()
        .find(|scene| scene.scene_hash == hash)
    {
        return Ok(scene.clone());
    }
    let scene = match &loaded.scene_file {
        Some(file) => scene_of_file(planner, file, loaded.selected.as_deref(), label)?,
        None => empty_scene(planner)?,
    };
    check_same("scene", &scene.label, scene.scene_hash, hash)?;
    Ok(scene)
}

fn scene_of_file(
    planner: &Planner,
    file: &FilePath,
    selected: Option<&str>,
    label: &str,
) -> Result<SceneSummary, CliError> {
    let text = files::selected_scene_text(file, selected)?;
    Ok(planner.load_scene(label, &text, folder_of(file).as_deref(), false)?)
}

/// The scene with nothing in it.
fn empty_scene(planner: &Planner) -> Result<SceneSummary, CliError> {
    planner.empty_scene()?;
    labelled::scene(planner, EMPTY_SCENE)
}

/// Two processes that read the same files may find different packages.
fn check_same(kind: &str, label: &str, daemon: u64, own: u64) -> Result<(), CliError> {
    if daemon == own {
        return Ok(());
    }
    let message = format!(
        "the daemon reads {kind} {label} with hash {daemon:016x}, this process with {own:016x}; name packages with --package NAME=FOLDER, or load it under a label"
    );
    Err(CliError::refused(Code::VersionConflict, message))
}
