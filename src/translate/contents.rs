//! Robots, scenes and diffs as control messages bring them, read.

use std::path::Path;
use std::sync::Arc;

use taut_ipc::control::Refusal;
use taut_ipc::limits::{FILE_NAME_MAX, FILES_MAX};
use taut_ipc::wire::{Code, label_id};

use super::models::{file_refusal, model_refusal, scene_refusal};
use crate::collision::Count;
use crate::collision::{CollisionModel, neutral_warnings, reach_weights};
use crate::files::{FileError, GivenFiles, Packages, Reader, RobotFiles};
use crate::robot::{RobotDescription, RobotModel};
use crate::scene::diff_file::SceneDiff;
use crate::scene::{Scene, diff_file, scene_file};
use crate::store::{PreparedModel, PreparedScene, Step};
use crate::warning::Warning;

/// A reader of its own each time: it keeps meshes, and nobody may ask for these again. It reads the
/// files that were given; where there are none, the disk.
pub fn reader(given: Option<GivenFiles>) -> Reader {
    match given {
        Some(files) => Reader::given(files),
        None => Reader::new(Packages::with_environment(Default::default())),
    }
}

/// Why nothing was read.
#[derive(Debug)]
pub enum Unread {
    /// It is wrong.
    Refused(Refusal),
    /// Files of these names were not given.
    Wanted(Vec<String>),
}

impl From<Refusal> for Unread {
    fn from(refusal: Refusal) -> Self {
        Self::Refused(refusal)
    }
}

impl Unread {
    /// The refusal; of what is not given, where nobody is asked for it.
    pub fn into_refusal(self) -> Refusal {
        match self {
            Self::Refused(refusal) => refusal,
            Self::Wanted(names) => Refusal::new(
                Code::UnreadableFile,
                format!("not given: {}", names.join(", ")),
            ),
        }
    }
}

/// What a reader has read, if it had all that it asked for. What is wrong whatever is given, is told
/// first.
fn whole<T>(reader: &Reader, read: Result<T, FileError>) -> Result<T, Unread> {
    let wanted = reader.wanted();
    match read {
        Ok(read) if wanted.is_empty() => Ok(read),
        Ok(_) | Err(FileError::NotGiven(_)) => asked_for(wanted),
        Err(error) => Err(file_refusal(&error).into()),
    }
}

fn asked_for<T>(mut wanted: Vec<String>) -> Result<T, Unread> {
    if let Some(name) = wanted
        .iter()
        .find(|name| name.len() > FILE_NAME_MAX)
    {
        let text = format!(
            "a file name of {} bytes; at most {FILE_NAME_MAX} may be given",
            name.len()
        );
        return Err(Refusal::new(Code::InvalidModel, text).into());
    }
    wanted.truncate(FILES_MAX);
    Err(Unread::Wanted(wanted))
}

/// A robot that was read.
pub struct ReadRobot {
    /// The robot.
    pub robot: Arc<RobotModel>,
    /// Its default weights.
    pub weights: Arc<[f64]>,
    /// Its collision model with nothing around it, which others need not make again.
    pub alone: Arc<CollisionModel>,
    /// Whether its solids were made for it.
    pub is_new: bool,
}

/// A robot, its default weights and its collision model, which shares the solids of `like` where
/// its links have the same shapes; `makes` hears, once the files are read, what is made of them.
///
/// # Errors
/// A file that cannot be read, or is no robot.
pub fn robot_of(
    mut reader: Reader,
    files: &RobotFiles,
    like: Option<&CollisionModel>,
    makes: impl FnOnce(&Step),
) -> Result<ReadRobot, Unread> {
    let read = reader.robot_of(files);
    let description = whole(&reader, read)?;
    let robot = robot_described(description, &files.urdf)?;
    if let Some(like) = like.filter(|like| like.robot().shapes_hash() == robot.shapes_hash()) {
        return Ok(sharing(like, robot)?);
    }
    let links = robot.links().iter();
    makes(&Step::Links(Count::of(links.map(|link| &*link.shapes))));
    Ok(read_robot(robot)?)
}

/// The robot of a description, with a warning for each pair of links that collides as it stands
/// where its SRDF disables none, and its default weights, which depend on its own bodies only.
///
/// # Errors
/// A description that makes no robot.
pub fn prepared(description: RobotDescription, urdf: &Path) -> Result<ReadRobot, Refusal> {
    read_robot(robot_described(description, urdf)?)
}

fn robot_described(description: RobotDescription, urdf: &Path) -> Result<Arc<RobotModel>, Refusal> {
    let refuse = |source| {
        file_refusal(&FileError::Robot {
            file: urdf.to_owned(),
            source,
        })
    };
    RobotModel::new(description)
        .map(Arc::new)
        .map_err(refuse)
}

/// The same of a robot that is made already.
///
/// # Errors
/// A robot without which nothing can be put together.
pub fn read_robot(robot: Arc<RobotModel>) -> Result<ReadRobot, Refusal> {
    let alone = CollisionModel::new(robot.clone(), Arc::new(Scene::default()));
    let alone = alone.map_err(|error| model_refusal(&error, &robot))?;
    Ok(ReadRobot {
        is_new: true,
        ..looked_at(robot, alone)
    })
}

/// A loaded robot with these variables only, of the same solids.
///
/// # Errors
/// Variables that it does not have, or not all of a joint's.
pub fn selected(alone: &PreparedModel, variables: Vec<String>) -> Result<ReadRobot, Refusal> {
    let model = alone
        .get()
        .map_err(|error| model_refusal(error, alone.robot()))?;
    sharing(model, Arc::new(with_variables(alone.robot(), variables)?))
}

fn sharing(model: &CollisionModel, robot: Arc<RobotModel>) -> Result<ReadRobot, Refusal> {
    let alone = model
        .with_robot(robot.clone())
        .map_err(|error| model_refusal(&error, &robot))?;
    Ok(looked_at(robot, alone))
}

fn with_variables(robot: &RobotModel, variables: Vec<String>) -> Result<RobotModel, Refusal> {
    let description = RobotDescription {
        variables: Some(variables),
        ..robot.description().clone()
    };
    RobotModel::new(description)
        .map_err(|error| Refusal::new(Code::InvalidRobotState, error.to_string()))
}

/// The label of a robot of which these are the variables, by that of the whole one.
pub fn selected_label(label: &str, variables: &[String]) -> String {
    format!("{label}@{:08x}", label_id(&variables.join(",")) >> 32)
}

fn looked_at(robot: Arc<RobotModel>, alone: CollisionModel) -> ReadRobot {
    ReadRobot {
        weights: reach_weights(&robot, alone.bodies()).into(),
        robot: with_warnings(robot, neutral_warnings(&alone)),
        alone: Arc::new(alone),
        is_new: false,
    }
}

fn with_warnings(robot: Arc<RobotModel>, more: Vec<Warning>) -> Arc<RobotModel> {
    match more.is_empty() {
        true => robot,
        false => Arc::new(RobotModel::clone(&robot).with_warnings(more)),
    }
}

/// A scene of this text. Messages call it `file`, and its meshes are found beside that.
///
/// # Errors
/// A text that is no scene, a mesh that cannot be read.
pub fn scene_of(mut reader: Reader, text: &str, file: &Path) -> Result<Arc<Scene>, Unread> {
    let read = reader.scene_of_text(text, file);
    whole(&reader, read).map(Arc::new)
}

/// The same scene, with the solids of its objects made; `makes` hears before what that takes.
pub fn warm_scene(scene: Arc<Scene>, makes: impl FnOnce(&Step)) -> Arc<PreparedScene> {
    let prepared = PreparedScene::new(scene);
    makes(&Step::Objects(prepared.count()));
    prepared.solids();
    Arc::new(prepared)
}

/// A diff of this text, as [`scene_of`].
///
/// # Errors
/// A text that is no diff, a mesh that cannot be read.
pub fn diff_of(mut reader: Reader, text: &str, file: &Path) -> Result<SceneDiff, Unread> {
    let read = reader.diff_of_text(text, file);
    whole(&reader, read)
}

/// A scene's text, or that of the diff which makes it of `base`.
///
/// # Errors
/// A change that no text says.
pub fn scene_text(scene: &Scene, base: Option<&Scene>) -> Result<String, Refusal> {
    match base {
        None => Ok(scene_file::text(scene, true)),
        Some(base) => diff_file::text(base, &base.changes_to(scene), true)
            .map_err(|error| scene_refusal(&error)),
    }
}
