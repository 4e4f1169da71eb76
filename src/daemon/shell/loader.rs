//! The loader: threads that read robots and scenes, and changes to scenes.

use std::panic::{AssertUnwindSafe, catch_unwind};

use crossbeam_channel::{Sender, unbounded};
use taut::scene::Scene;
use taut_ipc::control::{ControlReply, Refusal, SceneText};
use taut_ipc::wire::Code;

use crate::daemon::service::effect::{Source, Task, Work};
use crate::daemon::service::event::{Content, Event, Loaded};
use crate::daemon::threads::{Started, spawn};
use crate::daemon::translate::{diff_of, robot_of, scene_of, scene_text, selected};

/// Starts a thread that reads what it is sent, and tells of it; it ends when the sender is dropped.
/// One client has one control request at a time, so the channel needs no bound of its own.
pub(super) fn start(name: &str, tell: impl Fn(Event) + Send + 'static) -> Started<Sender<Task>> {
    let (tasks, receiver) = unbounded::<Task>();
    let work = move || {
        receiver
            .iter()
            .for_each(|task| tell(done(task)))
    };
    Ok((tasks, spawn(name, work)?))
}

/// Does what a control request needs, and gives what the service hears of it.
fn done(Task { ticket, work }: Task) -> Event {
    match work {
        Work::Read {
            label,
            purpose,
            source,
        } => Event::Loaded(Box::new(Loaded {
            ticket,
            label,
            purpose,
            content: guarded(|| read(&source)),
        })),
        Work::Write {
            answer,
            scene,
            base,
        } => Event::Written {
            ticket,
            answer: Box::new(written(answer, &scene, base.as_deref())),
        },
    }
}

fn read(source: &Source) -> Result<Content, Refusal> {
    match source {
        Source::Robot(files) => robot_of(files).map(Content::Robot),
        Source::Variables(alone, names) => selected(alone, names.clone()).map(Content::Robot),
        Source::Scene(text, file) => scene_of(text, file).map(Content::Scene),
        Source::Diff(text, file) => diff_of(text, file).map(Content::Diff),
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
