//! The loader: threads that read robots and scenes, and changes to scenes.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;

use crossbeam_channel::{Sender, unbounded};
use taut::collision::{CollisionModel, neutral_warnings, reach_weights};
use taut::files::{FileError, Packages, Reader, RobotFiles};
use taut::robot::{RobotDescription, RobotModel};
use taut::scene::Scene;
use taut_ipc::control::Refusal;
use taut_ipc::wire::Code;

use super::event::{Content, Event, EventSender, Loaded, Purpose};
use super::translate::{file_refusal, model_refusal};

/// Something to read.
pub(super) struct Task {
    /// The control request that asked for it.
    pub token: u64,
    /// Its label.
    pub label: String,
    /// What to do with it.
    pub purpose: Purpose,
    /// What to read.
    pub source: Source,
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

/// The way to the loader's threads. Diffs have one of their own: a change to a scene that is in use must not wait
/// until some robot is read.
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
        let tasks = if matches!(task.source, Source::Diff(..)) { &self.diffs } else { &self.models };
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
            let Task { token, label, purpose, source } = task;
            let content = read(&source);
            events.send(Event::Loaded(Box::new(Loaded { token, label, purpose, content })));
        }
    })?;
    Ok((tasks, thread))
}

fn read(source: &Source) -> Result<Content, Refusal> {
    // Files are input like any other: a reader that panics on one must not end the daemon.
    let result = catch_unwind(AssertUnwindSafe(|| match source {
        Source::Robot(files) => robot(files),
        Source::Scene(text, file) => scene(text, file),
        Source::Diff(text, file) => diff(text, file),
    }));
    result.unwrap_or_else(|_| {
        let message = "the loader panicked on this file; report it as a defect";
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
