//! The thread that reads sensors' frames, so that no thread that serves requests touches a point.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use crossbeam_channel::{Receiver, unbounded};
use taut_ipc::control::Refusal;
use taut_ipc::wire::Code;

use super::drive::Shell;
use super::lines::ToRead;
use crate::daemon::service::effect::FrameTask;
use crate::daemon::service::event::{Event, Framed};
use crate::daemon::threads::{Started, spawn_nice};
use crate::daemon::translate::{TakenFrame, read_frame};

/// Starts the thread; it ends when the sender is dropped.
pub(super) fn start(shell: &Arc<Shell>, niceness: i32) -> Started<ToRead> {
    let (frames, receiver) = unbounded();
    let shell = Arc::clone(shell);
    let work = move || {
        while let Some(tasks) = next(&receiver) {
            for (task, is_newest) in newest_last(tasks) {
                shell.tell(Event::Framed(Box::new(framed(&shell, task, is_newest))));
                if shell.crew.is_closed() {
                    return;
                }
            }
        }
    };
    Ok((frames, spawn_nice("taut-frames", niceness, work)?))
}

/// All frames that wait, at least one.
fn next(receiver: &Receiver<FrameTask>) -> Option<Vec<FrameTask>> {
    let first = receiver.recv().ok()?;
    Some(
        std::iter::once(first)
            .chain(receiver.try_iter())
            .collect(),
    )
}

/// Whether each is the newest of its object, which alone is read.
fn newest_last(tasks: Vec<FrameTask>) -> Vec<(FrameTask, bool)> {
    let key = |task: &FrameTask| (task.label.clone(), task.object.clone());
    let keys: Vec<_> = tasks
        .iter()
        .map(|task| (key(task), task.frame.taken_ns))
        .collect();
    let is_newest = |index: usize| {
        let (own, taken_ns) = &keys[index];
        let later = &keys[index + 1..];
        !later
            .iter()
            .any(|(other, other_ns)| other == own && other_ns >= taken_ns)
    };
    let tasks = tasks.into_iter().enumerate();
    tasks
        .map(|(index, task)| (task, is_newest(index)))
        .collect()
}

fn framed(shell: &Shell, task: FrameTask, is_newest: bool) -> Framed {
    let taken = match is_newest {
        true => taken(shell, &task),
        false => Err(passed_over(&task)),
    };
    Framed {
        ticket: task.ticket,
        label: task.label,
        object: task.object,
        taken,
    }
}

/// A frame is input like any other: what panics on one must not end the daemon.
fn taken(shell: &Shell, task: &FrameTask) -> Result<TakenFrame, Refusal> {
    let read = || {
        shell.with_body(task.ticket, |body| {
            read_frame(&task.scenery, &task.object, &task.frame, body)
        })
    };
    let read = catch_unwind(AssertUnwindSafe(read));
    // Whoever is gone meanwhile hears nothing.
    read.unwrap_or_else(|_| Some(Err(crash())))
        .unwrap_or_else(|| Err(passed_over(task)))
}

fn crash() -> Refusal {
    let message = "the reader of frames panicked on this; report it as a defect";
    Refusal::new(Code::Crash, message)
}

fn passed_over(task: &FrameTask) -> Refusal {
    let text = format!(
        "object {:?}: a newer frame of it came before this one was read; send the next",
        task.object
    );
    Refusal::new(Code::Preempted, text)
}
