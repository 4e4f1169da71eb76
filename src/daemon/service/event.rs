//! Everything that happens to the service.

use std::path::PathBuf;
use std::sync::Arc;

use taut::scene::diff_file::SceneDiff;
use taut::store::{Place, PreparedScene};
use taut_ipc::control::{ControlReply, ControlRequest, FileId, Refusal};
use taut_ipc::wire::{RequestHeader, ResponseHeader};

use super::client::Client;
use super::job::Stops;
use crate::daemon::translate::{Question, ReadRobot, Reply, TakenFrame, Unread};

/// Names a message of a client until its last answer; later ones have higher numbers.
pub(crate) type Ticket = u64;

/// Everything that happens.
pub(crate) enum Event {
    /// A client asks for something about a path.
    Asked(Box<Asked>),
    /// The payload of a request has been copied out and checked.
    Read {
        /// The request.
        ticket: Ticket,
        /// What it asks for.
        read: Result<Question, Refusal>,
    },
    /// A client asks for something else, or sends what is none.
    Controlled {
        /// The control request.
        ticket: Ticket,
        /// Who asks.
        client: Client,
        /// What it says.
        message: Result<Box<ControlRequest>, Refusal>,
        /// What the service is not told otherwise.
        around: Surroundings,
    },
    /// The client of a request has dropped it, or is gone.
    Gone(Ticket),
    /// The client of a request wants the best so far, now.
    Hinted(Ticket),
    /// A job has a shorter path, and this to say of it.
    Improved {
        /// The job.
        ticket: Ticket,
        /// Of the response.
        header: Box<ResponseHeader>,
    },
    /// A job asks whether it is to make room for another.
    MayPause(Ticket),
    /// A job that has made room is over without going on.
    Over(Ticket),
    /// A job is done.
    Answered(Box<Answered>),
    /// The verdict of a watch could not be sent.
    NotTold(Ticket),
    /// A model has been made, or given up.
    Prepared,
    /// A robot or scene is read, or cannot be.
    Loaded(Box<Loaded>),
    /// A frame is read, or cannot be.
    Framed(Box<Framed>),
    /// All of a file was compared with the hash that it was given under.
    Checked {
        /// The file.
        file: FileId,
        /// Its bytes; `None` where they are not what the hash says.
        content: Option<Arc<[u8]>>,
    },
    /// The answer to a control request is written.
    Written {
        /// The control request.
        ticket: Ticket,
        /// Its answer.
        answer: Box<ControlReply>,
    },
    /// The journal has dealt with changes.
    Kept(KeptUpTo),
    /// The time has come that [`super::Service::next_ns`] named.
    Tick(Surroundings),
    /// The process is asked to end.
    Stop,
    /// This file is gone, by which clients find the daemon.
    Removed(PathBuf),
}

/// A request, before its payload is looked at.
pub(crate) struct Asked {
    /// Its number.
    pub ticket: Ticket,
    /// Who asks.
    pub client: Client,
    /// What its header says.
    pub header: RequestHeader,
    /// Bytes of its payload.
    pub bytes: usize,
    /// Whether header and payload belong together.
    pub checked: Result<(), Refusal>,
}

/// What is known outside only.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Surroundings {
    /// Clients that are connected.
    pub clients: u32,
    /// Dead clients that were cleaned up after.
    pub cleaned_nodes: u64,
}

/// The end of a job.
pub(crate) struct Answered {
    /// The job.
    pub ticket: Ticket,
    /// What its client is told.
    pub reply: Reply,
    /// How the answer came about.
    pub way: Way,
    /// What was asked for, where the core panicked on it.
    pub crashed: Option<u64>,
}

/// How an answer came about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// The core computed it, and was perhaps told to end.
    Computed(Stops),
    /// Its time was over, or it was not wanted any more, before it was begun.
    Untouched,
}

/// The journal has dealt with all changes up to one.
pub(crate) struct KeptUpTo {
    /// Its number.
    pub change: u64,
    /// Why they are not kept.
    pub failure: Option<String>,
}

/// The end of a load.
pub(crate) struct Loaded {
    /// The control request that asked for it.
    pub ticket: Ticket,
    /// Its label.
    pub label: String,
    /// What to do with it.
    pub purpose: Purpose,
    /// What was read.
    pub content: Result<Content, Unread>,
}

/// The end of a frame's reading.
pub(crate) struct Framed {
    /// The control request that brought it.
    pub ticket: Ticket,
    /// Label of its scene.
    pub label: String,
    /// The sensed object.
    pub object: String,
    /// What it is.
    pub taken: Result<TakenFrame, Refusal>,
}

/// What something is read for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// To be what its label names.
    Load {
        /// Whether the label may be taken away from other content.
        replace: bool,
        /// Version that a scene is to have; `None` = the next.
        version: Option<u64>,
    },
    /// To change the scene that its label names.
    Change {
        /// Version that the scene has to have; 0 = any.
        base_version: u64,
        /// Version that it is to have; `None` = the next.
        version: Option<u64>,
    },
}

impl Purpose {
    /// Whether a label may be taken away from other content, and the version of that.
    pub(crate) fn place(self) -> Place {
        match self {
            Self::Load { replace, version } => Place { replace, version },
            Self::Change { version, .. } => Place {
                replace: true,
                version,
            },
        }
    }

    /// Version that the scene has to have; 0 = any.
    pub(crate) fn base_version(self) -> u64 {
        match self {
            Self::Load { .. } => 0,
            Self::Change { base_version, .. } => base_version,
        }
    }
}

/// What can be loaded.
pub(crate) enum Content {
    /// A robot.
    Robot(ReadRobot),
    /// A scene.
    Scene(Arc<PreparedScene>),
    /// A change to one.
    Diff(SceneDiff),
}
