//! The loader: threads that read robots and scenes, and changes to scenes.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Weak};

use crossbeam_channel::{Sender, unbounded};
use sha2::{Digest, Sha256};
use taut::collision::CollisionModel;
use taut::files::GivenFiles;
use taut::scene::Scene;
use taut::store::Step;
use taut_ipc::control::{ControlReply, FileId, Refusal, SceneText};
use taut_ipc::wire::Code;

use crate::daemon::durability::prepared::Prepared;
use crate::daemon::service::effect::{Source, Task, Work};
use crate::daemon::service::event::{Content, Event, Loaded};
use crate::daemon::service::reading::Reading;
use crate::daemon::threads::{Started, spawn_nice};
use crate::daemon::translate::{
    Unread, diff_of, reader, robot_of, scene_of, scene_text, selected, step_words, warm_scene,
};

/// Starts a thread that reads what it is sent, and tells of it; it ends when the sender is dropped.
/// One client has one control request at a time, so the channel needs no bound of its own. Solids of
/// robots are kept in `prepared`.
pub(super) fn start(
    name: &str,
    niceness: i32,
    prepared: Option<Prepared>,
    tell: impl Fn(Event) -> bool + Send + 'static,
) -> Started<Sender<Task>> {
    let (tasks, receiver) = unbounded::<Task>();
    let work = move || {
        let mut last = Last::new();
        // What nobody needs any more is not begun.
        let _ = receiver
            .iter()
            .all(|task| tell(done(task, prepared.as_ref(), &mut last)));
    };
    Ok((tasks, spawn_nice(name, niceness, work)?))
}

/// The robot that was read last, while it is loaded: one that is loaded again, or by two at once,
/// is made once.
type Last = Weak<CollisionModel>;

/// Does what a control request needs, and gives what the service hears of it.
fn done(Task { ticket, work }: Task, prepared: Option<&Prepared>, last: &mut Last) -> Event {
    match work {
        Work::Read {
            label,
            purpose,
            source,
            given,
            reading,
        } => {
            let content = guarded(|| read(&source, given, last, &reading));
            if let Ok(Content::Robot(robot)) = &content {
                *last = Arc::downgrade(&robot.alone);
                // Before the answer: a robot that is warm costs no more than its requests.
                if let Some(prepared) = prepared {
                    prepared.keep(&robot.alone);
                }
            }
            Event::Loaded(Box::new(Loaded {
                ticket,
                label,
                purpose,
                content,
            }))
        }
        Work::Check { file, pieces } => Event::Checked {
            file,
            content: compared(&file, pieces),
        },
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

/// The bytes of a file, if they are what its hash says.
fn compared(file: &FileId, pieces: Vec<Vec<u8>>) -> Option<Arc<[u8]>> {
    let bytes = pieces.concat();
    // Not three times at once.
    drop(pieces);
    let hash: [u8; 32] = Sha256::digest(&bytes).into();
    (hash == file.sha256).then(|| bytes.into())
}

/// Reads it and makes what requests need of it.
fn read(
    source: &Source,
    given: Option<GivenFiles>,
    last: &Last,
    reading: &Reading,
) -> Result<Content, Unread> {
    let files = reader(given);
    let makes = |step: &Step| reading.makes(step_words(step));
    match source {
        Source::Robot(robot) => {
            robot_of(files, robot, last.upgrade().as_deref(), makes).map(Content::Robot)
        }
        Source::Variables(alone, names) => Ok(Content::Robot(selected(alone, names.clone())?)),
        Source::Scene(text, file) => {
            let scene = scene_of(files, text, file)?;
            Ok(Content::Scene(warm_scene(scene, makes)))
        }
        Source::Diff(text, file) => diff_of(files, text, file).map(Content::Diff),
    }
}

fn written(answer: SceneText, scene: &Scene, base: Option<&Scene>) -> ControlReply {
    let text = guarded(|| scene_text(scene, base));
    text.map_or_else(ControlReply::Refused, |json| {
        ControlReply::SceneText(SceneText { json, ..answer })
    })
}

/// Files are input like any other: what panics on one must not end the daemon.
fn guarded<T, E: From<Refusal>>(work: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| {
        let message = "the loader panicked on this; report it as a defect";
        Err(Refusal::new(Code::Crash, message).into())
    })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use taut::files::RobotFiles;
    use taut::translate::ReadRobot;

    use super::*;
    use crate::daemon::service::event::Purpose;

    /// What comes of loading a robot of this project.
    fn loaded(file: &str, last: &mut Last) -> ReadRobot {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/robots");
        let files = RobotFiles {
            urdf: folder.join(file),
            ..RobotFiles::default()
        };
        let work = Work::Read {
            label: "robot".to_owned(),
            purpose: Purpose::Load {
                replace: true,
                version: None,
            },
            source: Box::new(Source::Robot(files)),
            given: None,
            reading: Arc::new(Reading::new("robot", true, 0)),
        };
        match done(Task { ticket: 1, work }, None, last) {
            Event::Loaded(loaded) => match loaded.content {
                Ok(Content::Robot(robot)) => robot,
                _ => panic!("{file} is no robot"),
            },
            _ => panic!("{file} was not loaded"),
        }
    }

    #[test]
    fn a_robot_that_is_loaded_again_is_made_once_for_as_long_as_it_is_there() {
        let mut last = Last::new();
        let first = loaded("disc.urdf", &mut last);
        let second = loaded("disc.urdf", &mut last);
        assert!(first.is_new && !second.is_new);
        assert_eq!(first.robot.hash(), second.robot.hash());
        let solids = |robot: &ReadRobot| -> Vec<_> {
            let solids = robot.alone.link_solids();
            solids
                .map(|solid| solid.map(std::ptr::from_ref))
                .collect()
        };
        assert_eq!(solids(&first), solids(&second), "one and the same");
        assert!(loaded("duo.urdf", &mut last).is_new, "another one");
        assert!(loaded("duo.urdf", &mut last).is_new, "the first is gone");
    }
}
