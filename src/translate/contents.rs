//! Robots, scenes and diffs as control messages bring them, read.

use std::path::Path;
use std::sync::Arc;

use taut_ipc::control::Refusal;

use super::{file_refusal, model_refusal, scene_refusal};
use crate::collision::{CollisionModel, neutral_warnings, reach_weights};
use crate::files::{FileError, Packages, Reader, RobotFiles};
use crate::robot::{RobotDescription, RobotModel};
use crate::scene::diff_file::SceneDiff;
use crate::scene::{Scene, diff_file, scene_file};

/// A reader of its own each time: it keeps meshes, and nobody may ask for these again.
fn reader() -> Reader {
    Reader::new(Packages::with_environment(Default::default()))
}

/// A robot and its default weights.
///
/// # Errors
/// A file that cannot be read, or is no robot.
pub fn robot_of(files: &RobotFiles) -> Result<(Arc<RobotModel>, Arc<[f64]>), Refusal> {
    let description = reader().robot_of(files).map_err(|error| file_refusal(&error))?;
    prepared(description, &files.urdf)
}

/// The robot of a description, with a warning for each pair of links that collides as it stands where its SRDF
/// disables none, and its default weights, which depend on its own bodies only.
///
/// # Errors
/// A description that makes no robot.
pub fn prepared(description: RobotDescription, urdf: &Path) -> Result<(Arc<RobotModel>, Arc<[f64]>), Refusal> {
    let refuse = |source| file_refusal(&FileError::Robot { file: urdf.to_owned(), source });
    let robot = Arc::new(RobotModel::new(description).map_err(refuse)?);
    let alone = CollisionModel::new(robot.clone(), Arc::new(Scene::default()));
    let alone = alone.map_err(|error| model_refusal(&error, &robot))?;
    let weights = reach_weights(&robot, alone.bodies()).into();
    let warnings = neutral_warnings(&alone);
    if warnings.is_empty() {
        return Ok((robot, weights));
    }
    Ok((Arc::new(RobotModel::clone(&robot).with_warnings(warnings)), weights))
}

/// A scene of this text. Messages call it `file`, and its meshes are found beside that.
///
/// # Errors
/// A text that is no scene, a mesh that cannot be read.
pub fn scene_of(text: &str, file: &Path) -> Result<Arc<Scene>, Refusal> {
    reader().scene_of_text(text, file).map(Arc::new).map_err(|error| file_refusal(&error))
}

/// A diff of this text, as [`scene_of`].
///
/// # Errors
/// A text that is no diff, a mesh that cannot be read.
pub fn diff_of(text: &str, file: &Path) -> Result<SceneDiff, Refusal> {
    reader().diff_of_text(text, file).map_err(|error| file_refusal(&error))
}

/// A scene's text, or that of the diff which makes it of `base`.
///
/// # Errors
/// A change that no text says.
pub fn scene_text(scene: &Scene, base: Option<&Scene>) -> Result<String, Refusal> {
    match base {
        None => Ok(scene_file::text(scene, true)),
        Some(base) => diff_file::text(base, &base.changes_to(scene), true).map_err(|error| scene_refusal(&error)),
    }
}
