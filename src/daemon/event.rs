//! What other threads tell the I/O thread.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crossbeam_channel::{Receiver, Sender, unbounded};
use taut::scene::diff_file::SceneDiff;
use taut::store::PreparedScene;
use taut_ipc::control::{ControlReply, Refusal};
use taut_ipc::server::Waker;

use super::job::Stopped;
use super::keeping::KeptUpTo;
use super::translate::{ReadRobot, Reply};

/// Everything that happens besides messages of clients.
pub(super) enum Event {
    /// A worker's mailbox has a shorter path.
    Improved {
        /// The worker.
        worker: usize,
    },
    /// A job is done.
    Answered(Box<Answered>),
    /// A robot or scene is read, or cannot be.
    Loaded(Box<Loaded>),
    /// The journal has dealt with changes.
    Kept(KeptUpTo),
    /// The answer to a control request is written.
    Written {
        /// The control request.
        token: u64,
        /// Its answer.
        answer: ControlReply,
    },
    /// The process is asked to end.
    Stop,
}

/// The end of a job.
pub(super) struct Answered {
    /// The job.
    pub job: u64,
    /// What its client is told.
    pub reply: Reply,
    /// How the answer came about.
    pub way: Way,
    /// How often it made room for others.
    pub pauses: u32,
    /// What was asked for, where the core panicked on it.
    pub crashed: Option<u64>,
}

/// How an answer came about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// The core computed it, and was perhaps told to end.
    Computed(Option<Stopped>),
    /// Its time was over, or it was not wanted any more, before it was begun.
    Untouched,
}

/// The end of a load.
pub(super) struct Loaded {
    /// The control request that asked for it.
    pub token: u64,
    /// Its label.
    pub label: String,
    /// What to do with it.
    pub purpose: Purpose,
    /// What was read.
    pub content: Result<Content, Refusal>,
}

/// What something is read for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    /// To be what its label names.
    Load {
        /// Whether the label may be taken away from other content.
        replace: bool,
    },
    /// To change the scene that its label names.
    Change {
        /// Version that the scene has to have; 0 = any.
        base_version: u64,
    },
}

impl Purpose {
    /// Whether a label may be taken away from other content.
    pub(super) fn replaces(self) -> bool {
        match self {
            Self::Load { replace } => replace,
            Self::Change { .. } => true,
        }
    }

    /// Version that the scene has to have; 0 = any.
    pub(super) fn base_version(self) -> u64 {
        match self {
            Self::Load { .. } => 0,
            Self::Change { base_version } => base_version,
        }
    }
}

/// What can be loaded.
pub(super) enum Content {
    /// A robot.
    Robot(ReadRobot),
    /// A scene.
    Scene(Arc<PreparedScene>),
    /// A change to one.
    Diff(SceneDiff),
}

/// Sends events and wakes the I/O thread.
#[derive(Clone)]
pub(super) struct EventSender {
    channel: Sender<Event>,
    waker: Waker,
    sleeps: Arc<AtomicBool>,
}

/// The I/O thread's end.
pub(super) struct Events {
    channel: Receiver<Event>,
    sleeps: Arc<AtomicBool>,
}

impl EventSender {
    /// A sender and the I/O thread's end. There are at most as many events as jobs, loads and
    /// workers, so the channel needs no bound of its own.
    pub(super) fn new(waker: Waker) -> (Self, Events) {
        let (sender, receiver) = unbounded();
        let sleeps = Arc::new(AtomicBool::new(false));
        (
            Self {
                channel: sender,
                waker,
                sleeps: sleeps.clone(),
            },
            Events {
                channel: receiver,
                sleeps,
            },
        )
    }

    /// Sends an event. Once the I/O thread has ended nobody needs it any more.
    pub(super) fn send(&self, event: Event) {
        let _ = self.channel.send(event);
        // A wake is a system call, and one that is awake looks again before it sleeps.
        if self.sleeps.swap(false, Ordering::SeqCst) {
            self.waker.wake();
        }
    }
}

impl Events {
    /// The next event, if there is one.
    pub(super) fn next(&self) -> Option<Event> {
        self.channel.try_recv().ok()
    }

    /// Announces a sleep; false if an event is there already, which nobody would wake the sleeper
    /// for.
    pub(super) fn may_sleep(&self) -> bool {
        self.sleeps.store(true, Ordering::SeqCst);
        self.channel.is_empty()
    }

    /// Awake again.
    pub(super) fn woke(&self) {
        self.sleeps.store(false, Ordering::SeqCst);
    }
}
