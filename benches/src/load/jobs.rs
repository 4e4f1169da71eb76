//! From problem files to requests: the daemon has their robots and scenes, or loads them.

use std::path::{Path as File, PathBuf};

use taut::files::{self, Geometry, Reader};
use taut::translate::robot_source;
use taut_ipc::Client;
use taut_ipc::control::{ControlRequest, Listing, RobotDescription, SceneSummary};

use super::control;
use super::orders::Job;
use super::problems::Problem;
use crate::error::Error;

/// The label of a file's robot and scene.
pub(super) fn label(file: &File) -> String {
    file.file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

/// A request for this problem; it asks for just the robot and the scene that were read here.
pub(super) fn job(
    client: &Client,
    reader: &mut Reader,
    file: &File,
    problem: &Problem,
) -> Result<Job, Error> {
    let listing = control::listing(client)?;
    let robot = robot(client, &listing, reader, file, problem)?;
    let scene = scene(client, &listing, file, problem)?;
    Ok(Job {
        name: label(file),
        robot_id: robot.robot_id,
        robot_hash: problem.model.robot().hash(),
        layout_hash: robot.layout_hash,
        scene_id: scene.scene_id,
        scene_hash: problem.model.scene().hash(),
        variables: robot.nq,
        path: problem.path.as_flat().to_vec(),
        weights: problem.weights.clone().unwrap_or_default(),
    })
}

fn robot(
    client: &Client,
    listing: &Listing,
    reader: &mut Reader,
    file: &File,
    problem: &Problem,
) -> Result<RobotDescription, Error> {
    let hash = problem.model.robot().hash();
    if let Some(known) = listing
        .robots
        .iter()
        .find(|one| one.robot_hash == hash)
    {
        let label = known.label.clone();
        return control::robot(client, &ControlRequest::Describe { label });
    }
    let files = reader
        .problem(file, Geometry::Given)?
        .robot_files;
    let message = ControlRequest::LoadRobot {
        label: with_hash(problem.model.robot().name(), hash),
        source: robot_source(&files),
        replace: false,
        files: None,
    };
    control::robot(client, &message)
}

fn scene(
    client: &Client,
    listing: &Listing,
    file: &File,
    problem: &Problem,
) -> Result<SceneSummary, Error> {
    let hash = problem.model.scene().hash();
    if let Some(known) = listing
        .scenes
        .iter()
        .find(|one| one.scene_hash == hash)
    {
        return Ok(known.clone());
    }
    let message = ControlRequest::LoadScene {
        label: with_hash(&label(file), hash),
        json: files::scene_text(file)?,
        base_dir: folder_of(file),
        replace: false,
        files: None,
        version: None,
    };
    control::scene(client, &message)
}

/// The label of what comes from a file: its name and the start of its hash.
fn with_hash(name: &str, hash: u64) -> String {
    format!("{name}@{:08x}", hash >> 32)
}

/// The absolute folder of a file, for a daemon that was started elsewhere.
fn folder_of(file: &File) -> Option<PathBuf> {
    let file = std::path::absolute(file).ok()?;
    file.parent().map(File::to_owned)
}
