//! The loader: threads that read robots and scenes, and changes to scenes.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;

use crossbeam_channel::{Sender, unbounded};
use taut::collision::{CollisionModel, neutral_warnings, reach_weights};
use taut::files::{FileError, Packages, Reader, RobotFiles};
use taut::robot::{RobotDescription, RobotModel};
use taut::scene::{Scene, diff_file, scene_file};
use taut_ipc::control::{ControlReply, Refusal, SceneText};
use taut_ipc::wire::Code;

use super::event::{Content, Event, EventSender, Loaded, Purpose};
use super::translate::{file_refusal, model_refusal, scene_refusal};

/// Something to do for a control request.
pub(super) struct Task {
    /// The control request that asked for it.
    pub token: u64,
    /// What to do.
    pub work: Work,
}

/// What a loader does.
pub(super) enum Work {
    /// Reads something.
    Read {
        /// Its label.
        label: String,
        /// What to do with it.
        purpose: Purpose,
        /// What to read.
        source: Source,
    },
    /// Writes the text of a scene.
    Write {
        /// All of the answer but the text.
        answer: SceneText,
        /// The scene.
        scene: Arc<Scene>,
        /// Where the text is to lead to it from; `None` = the whole scene.
        base: Option<Arc<Scene>>,
    },
}

/// Where it is.
pub(super) enum Source {
    /// A robot's files.
    Robot(RobotFiles),
    /// A scene's text, and the file that messages call it; meshes are found beside that.
    Scene(String, PathBuf),
    /// A diff's text, and the file that messages call it.
    Diff(String, PathBuf),
}

/// The way to the loader's threads. Diffs and texts have one of their own: a change to a scene that is in use must not
/// wait until some robot is read.
pub(super) struct Loader {
    models: Sender<Task>,
    diffs: Sender<Task>,
}

impl Loader {
    /// Starts the threads; they end when this is dropped.
    pub(super) fn start(events: &EventSender) -> std::io::Result<(Self, [JoinHandle<()>; 2])> {
        let (models, models_thread) = thread("taut-loader", events.clone())?;
        let (diffs, diffs_thread) = thread("taut-diffs", events.clone())?;
        Ok((Self { models, diffs }, [models_thread, diffs_thread]))
    }

    /// Has something read.
    pub(super) fn send(&self, task: Task) {
        let is_model = matches!(&task.work, Work::Read { source: Source::Robot(_) | Source::Scene(..), .. });
        let tasks = if is_model { &self.models } else { &self.diffs };
        // Its thread reads until this is dropped.
        let _ = tasks.send(task);
    }
}

/// A thread that reads what it is sent. One client has one control request at a time, so the channel needs no bound
/// of its own.
fn thread(name: &str, events: EventSender) -> std::io::Result<(Sender<Task>, JoinHandle<()>)> {
    let (tasks, receiver) = unbounded::<Task>();
    let thread = std::thread::Builder::new().name(name.to_owned()).spawn(move || {
        for task in receiver {
            let token = task.token;
            events.send(match task.work {
                Work::Read { label, purpose, source } => {
                    let content = read(&source);
                    Event::Loaded(Box::new(Loaded { token, label, purpose, content }))
                }
                Work::Write { answer, scene, base } => {
                    let answer = match guarded(|| write(&scene, base.as_deref())) {
                        Ok(json) => ControlReply::SceneText(SceneText { json, ..answer }),
                        Err(refusal) => ControlReply::Refused(refusal),
                    };
                    Event::Written { token, answer }
                }
            });
        }
    })?;
    Ok((tasks, thread))
}

fn read(source: &Source) -> Result<Content, Refusal> {
    guarded(|| match source {
        Source::Robot(files) => robot(files),
        Source::Scene(text, file) => scene(text, file),
        Source::Diff(text, file) => diff(text, file),
    })
}

/// Files are input like any other: what panics on one must not end the daemon.
fn guarded<T>(work: impl FnOnce() -> Result<T, Refusal>) -> Result<T, Refusal> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| {
        let message = "the loader panicked on this; report it as a defect";
        Err(Refusal::new(Code::Crash, message))
    })
}

fn robot(files: &RobotFiles) -> Result<Content, Refusal> {
    // A reader of its own: it keeps meshes, and nobody may ask for these again.
    let mut reader = Reader::new(Packages::with_environment(Default::default()));
    let description = reader.robot_of(files).map_err(|error| file_refusal(&error))?;
    let (robot, weights) = prepared(description, &files.urdf)?;
    Ok(Content::Robot(robot, weights))
}

/// The robot of a description, with a warning for each pair of links that collides as it stands where no SRDF
/// speaks for it, and its default weights, which depend on its own bodies only.
pub(super) fn prepared(description: RobotDescription, urdf: &Path) -> Result<(Arc<RobotModel>, Arc<[f64]>), Refusal> {
    let has_srdf = description.semantics.is_some();
    let refuse = |source| file_refusal(&FileError::Robot { file: urdf.to_owned(), source });
    let robot = Arc::new(RobotModel::new(description).map_err(refuse)?);
    let alone = CollisionModel::new(robot.clone(), Arc::new(Scene::default()));
    let alone = alone.map_err(|error| model_refusal(&error, &robot))?;
    let weights = reach_weights(&robot, alone.bodies()).into();
    if has_srdf {
        return Ok((robot, weights));
    }
    let warned = RobotModel::clone(&robot).with_warnings(neutral_warnings(&alone));
    Ok((Arc::new(warned), weights))
}

fn scene(text: &str, file: &Path) -> Result<Content, Refusal> {
    let mut reader = Reader::new(Packages::with_environment(Default::default()));
    let scene = reader.scene_of_text(text, file).map_err(|error| file_refusal(&error))?;
    Ok(Content::Scene(Arc::new(scene)))
}

fn diff(text: &str, file: &Path) -> Result<Content, Refusal> {
    let mut reader = Reader::new(Packages::with_environment(Default::default()));
    let diff = reader.diff_of_text(text, file).map_err(|error| file_refusal(&error))?;
    Ok(Content::Diff(diff))
}

fn write(scene: &Scene, base: Option<&Scene>) -> Result<String, Refusal> {
    match base {
        None => Ok(scene_file::text(scene, true)),
        Some(base) => diff_file::text(base, &base.changes_to(scene), true).map_err(|error| scene_refusal(&error)),
    }
}
