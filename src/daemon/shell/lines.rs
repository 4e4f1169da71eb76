//! The ways to the threads that do what takes long.

use std::sync::Arc;

use crossbeam_channel::Sender;
use taut::store::PreparedModel;

use super::preparer::ToPrepare;
use super::pulse::Pulse;
use crate::daemon::durability::journal::Entry;
use crate::daemon::observe::recording::Line;
use crate::daemon::service::effect::{FrameTask, Task, Work};

/// Where frames go that are to be read. A connection has one frame here at a time.
pub(super) type ToRead = Sender<FrameTask>;

/// A way to each thread, which ends when all of them are gone.
pub(super) struct Lines {
    /// Reads robots and scenes.
    pub models: Sender<Task>,
    /// Reads diffs and writes texts.
    pub diffs: Sender<Task>,
    /// Reads sensors' frames.
    pub frames: ToRead,
    /// Makes models.
    pub to_prepare: ToPrepare,
    /// Writes recordings.
    pub recorder: Sender<Line>,
    /// Keeps robots and scenes, where they are kept.
    pub journal: Option<Sender<Entry>>,
    /// Tells whoever watches that the daemon lives.
    pub pulse: Pulse,
}

impl Lines {
    /// Lets the threads end; `in_order` if everything was answered.
    pub(super) fn close(self, in_order: bool) {
        if in_order {
            self.keep(Entry::End);
        }
    }

    /// Has something read or written. Diffs and texts have a thread of their own: a change to a
    /// scene that is in use must not wait until some robot is read.
    pub(super) fn load(&self, task: Task) {
        let line = match &task.work {
            Work::Read { source, .. } if source.is_model() => &self.models,
            Work::Check { .. } => &self.models,
            Work::Read { .. } | Work::Write { .. } => &self.diffs,
        };
        // Each thread lives until its line is gone.
        let _ = line.send(task);
    }

    /// Has a frame read.
    pub(super) fn frame(&self, task: FrameTask) {
        let _ = self.frames.send(task);
    }

    /// Has a model made.
    pub(super) fn prepare(&self, model: Arc<PreparedModel>) {
        let _ = self.to_prepare.send(model);
    }

    /// Has a line written to the recording.
    pub(super) fn record(&self, line: Line) {
        let _ = self.recorder.send(line);
    }

    /// Has a change kept.
    pub(super) fn keep(&self, entry: Entry) {
        if let Some(journal) = &self.journal {
            let _ = journal.send(entry);
        }
    }
}
