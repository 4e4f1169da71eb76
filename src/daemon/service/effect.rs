//! Everything that the service has done outside.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use taut::files::{GivenFiles, RobotFiles};
use taut::scene::Scene;
use taut::store::{PreparedModel, Snapshot};
use taut_ipc::control::{ClientSummary, CloudFrame, ControlReply, FileId, Refusal, SceneText};
use taut_ipc::wire::{ResponseHeader, SceneEvent, StatusRecord};

use super::event::{Purpose, Ticket};
use super::job::Job;
use super::reading::Reading;
use crate::daemon::durability::journal::Entry;
use crate::daemon::observe::recording::Line;
use crate::daemon::translate::{Reply, Scenery};

/// What is to be done after an event; what nobody needs any more may fail without a word.
#[derive(Default)]
pub(crate) struct Effects {
    /// Before the next event is dealt with.
    pub in_order: Vec<InOrder>,
    /// Later perhaps, in this order.
    pub alone: Vec<Effect>,
}

impl Effects {
    /// Adds what is to be done before the next event is dealt with.
    pub(crate) fn in_order(&mut self, effect: InOrder) {
        self.in_order.push(effect);
    }

    /// Adds what stands for itself.
    pub(crate) fn push(&mut self, effect: Effect) {
        self.alone.push(effect);
    }

    /// Adds what another room has due, and leaves that empty.
    pub(crate) fn append(&mut self, due: &mut Self) {
        self.in_order.append(&mut due.in_order);
        self.alone.append(&mut due.alone);
    }
}

/// What stands for itself.
pub(crate) enum Effect {
    /// Copy the payload of a request out and check it; told by [`super::event::Event::Read`].
    Read {
        /// The request.
        ticket: Ticket,
        /// What it is to be computed with.
        snapshot: Box<Snapshot>,
        /// Clearance (m) where it names none.
        clearance_m: f64,
    },
    /// Send a final response that only says why not.
    Refuse(Ticket, Refusal),
    /// Send the shorter path that was told of, under this header.
    Improve(Ticket, Box<ResponseHeader>),
    /// Send the final response.
    Answer(Ticket, Box<Reply>),
    /// Let a request go whose client is gone.
    Drop(Ticket),
    /// Compute a job: it has a slot.
    Begin(Box<Job>),
    /// Have a job's thread wait: it has made room.
    Pause(Ticket),
    /// Let a job's thread go on: it has a slot again.
    GoOn(Ticket),
    /// Have a job's thread look whether the job is over, if it waits.
    Look(Ticket),
    /// Look whether the files are there by which clients find the daemon; told by
    /// [`super::event::Event::Removed`] if not.
    LookForFiles,
    /// Answer a control request.
    Reply(Ticket, Box<ControlReply>),
}

/// What others see in the order in which it happened.
pub(crate) enum InOrder {
    /// Make a model that requests wait for; told by [`super::event::Event::Prepared`].
    Prepare(Arc<PreparedModel>),
    /// Read or write something, for a control request.
    Load(Task),
    /// Read a frame, which is a control request's body; told by
    /// [`super::event::Event::Framed`].
    Frame(Box<FrameTask>),
    /// Send the verdict of a watch, which is not the last response, and if it was sent, tell
    /// everybody who listens of it; told by [`super::event::Event::NotTold`] if it was not.
    Tell(Ticket, Box<Reply>, Option<SceneEvent>),
    /// Tell everybody who listens.
    Publish(SceneEvent),
    /// Tell everybody how things stand.
    Status(Box<StatusRecord>),
    /// Show this on the page.
    Show(BTreeMap<String, f64>, Vec<ClientSummary>),
    /// Write to the journal; told by [`super::event::Event::Kept`].
    Keep(Entry),
    /// Write to the recording.
    Record(Line),
}

/// A frame to be read.
pub(crate) struct FrameTask {
    /// The control request whose body it is.
    pub ticket: Ticket,
    /// Label of its scene.
    pub label: String,
    /// The sensed object.
    pub object: String,
    /// What it is besides its points.
    pub frame: Box<CloudFrame>,
    /// What it is seen among.
    pub scenery: Scenery,
}

/// Something to do for a control request.
pub(crate) struct Task {
    /// The control request that asked for it.
    pub ticket: Ticket,
    /// What to do.
    pub work: Work,
}

/// What a loader does.
pub(crate) enum Work {
    /// Reads something; told by [`super::event::Event::Loaded`].
    Read {
        /// Its label.
        label: String,
        /// What to do with it.
        purpose: Purpose,
        /// What to read.
        source: Box<Source>,
        /// The files that it is read from; `None` = those of this machine.
        given: Option<GivenFiles>,
        /// Where it says how far it is.
        reading: Arc<Reading>,
    },
    /// Compares a file with the hash that it was given under; told by
    /// [`super::event::Event::Checked`].
    Check {
        /// The file.
        file: FileId,
        /// Its pieces, in order.
        pieces: Vec<Vec<u8>>,
    },
    /// Writes the text of a scene; told by [`super::event::Event::Written`].
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
pub(crate) enum Source {
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
    pub(crate) fn is_model(&self) -> bool {
        match self {
            Self::Robot(_) | Self::Variables(..) | Self::Scene(..) => true,
            Self::Diff(..) => false,
        }
    }

    /// Whether it is a robot.
    pub(crate) fn is_robot(&self) -> bool {
        matches!(self, Self::Robot(_) | Self::Variables(..))
    }
}
