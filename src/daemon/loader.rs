//! The loader: threads that read robots and scenes, and changes to scenes.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::Arc;
use std::thread::JoinHandle;

use crossbeam_channel::{Sender, unbounded};
use taut::files::RobotFiles;
use taut::scene::Scene;
use taut::store::{PreparedModel, Step};
use taut_ipc::control::{ControlReply, Refusal, SceneText};
use taut_ipc::wire::Code;

use super::event::{Content, Event, EventSender, Loaded, Purpose};
use super::prepared::Prepared;
use super::reading::Reading;
use super::threads::spawn_nice;
use super::translate::{diff_of, robot_of, scene_of, scene_text, selected, step_words, warm_scene};

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
        /// Where it says how far it is.
        reading: Arc<Reading>,
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
    /// A loaded robot, and the variables that it is to have.
    Variables(Arc<PreparedModel>, Vec<String>),
    /// A scene's text, and the file that messages call it; meshes are found beside that.
    Scene(String, PathBuf),
    /// A diff's text, and the file that messages call it.
    Diff(String, PathBuf),
}

impl Source {
    /// Whether it may take long to read.
    fn is_model(&self) -> bool {
        match self {
            Self::Robot(_) | Self::Variables(..) | Self::Scene(..) => true,
            Self::Diff(..) => false,
        }
    }

    /// Whether it is a robot.
    pub(super) fn is_robot(&self) -> bool {
        matches!(self, Self::Robot(_) | Self::Variables(..))
    }

    /// Reads it and makes what requests need of it.
    fn read(&self, reading: &Reading) -> Result<Content, Refusal> {
        let makes = |step: &Step| reading.makes(step_words(step));
        match self {
            Self::Robot(files) => robot_of(files, makes).map(Content::Robot),
            Self::Variables(alone, names) => selected(alone, names.clone()).map(Content::Robot),
            Self::Scene(text, file) => {
                let scene = scene_of(text, file)?;
                Ok(Content::Scene(warm_scene(scene, makes)))
            }
            Self::Diff(text, file) => diff_of(text, file).map(Content::Diff),
        }
    }
}

/// The way to the loader's threads. Diffs and texts have one of their own: a change to a scene that
/// is in use must not wait until some robot is read.
pub(super) struct Loader {
    models: Sender<Task>,
    diffs: Sender<Task>,
}

impl Loader {
    /// Starts the threads; they end when this is dropped. Solids of robots are kept in `prepared`.
    pub(super) fn start(
        events: &EventSender,
        niceness: i32,
        prepared: Option<Prepared>,
    ) -> std::io::Result<(Self, [JoinHandle<()>; 2])> {
        let (models, models_thread) = thread("taut-loader", niceness, events.clone(), prepared)?;
        let (diffs, diffs_thread) = thread("taut-diffs", niceness, events.clone(), None)?;
        Ok((Self { models, diffs }, [models_thread, diffs_thread]))
    }

    /// Has something read.
    pub(super) fn send(&self, task: Task) {
        let tasks = match &task.work {
            Work::Read { source, .. } if source.is_model() => &self.models,
            Work::Read { .. } | Work::Write { .. } => &self.diffs,
        };
        // Its thread reads until this is dropped.
        let _ = tasks.send(task);
    }
}

/// A thread that reads what it is sent. One client has one control request at a time, so the
/// channel needs no bound of its own.
fn thread(
    name: &str,
    niceness: i32,
    events: EventSender,
    prepared: Option<Prepared>,
) -> std::io::Result<(Sender<Task>, JoinHandle<()>)> {
    let (tasks, receiver) = unbounded::<Task>();
    let work = move || {
        receiver
            .iter()
            .for_each(|task| events.send(done(task, prepared.as_ref())))
    };
    Ok((tasks, spawn_nice(name, niceness, work)?))
}

/// Does what a control request needs, and gives what the I/O thread hears of it.
fn done(Task { token, work }: Task, prepared: Option<&Prepared>) -> Event {
    match work {
        Work::Read {
            label,
            purpose,
            source,
            reading,
        } => {
            let content = guarded(|| source.read(&reading));
            // Before the answer: a robot that is warm costs no more than its requests.
            if let (Ok(Content::Robot(robot)), Some(prepared)) = (&content, prepared) {
                prepared.keep(&robot.alone);
            }
            Event::Loaded(Box::new(Loaded {
                token,
                label,
                purpose,
                content,
            }))
        }
        Work::Write {
            answer,
            scene,
            base,
        } => Event::Written {
            token,
            answer: written(answer, &scene, base.as_deref()),
        },
    }
}

fn written(answer: SceneText, scene: &Scene, base: Option<&Scene>) -> ControlReply {
    let text = guarded(|| scene_text(scene, base));
    text.map_or_else(ControlReply::Refused, |json| {
        ControlReply::SceneText(SceneText { json, ..answer })
    })
}

/// Files are input like any other: what panics on one must not end the daemon.
fn guarded<T>(work: impl FnOnce() -> Result<T, Refusal>) -> Result<T, Refusal> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| {
        let message = "the loader panicked on this; report it as a defect";
        Err(Refusal::new(Code::Crash, message))
    })
}
