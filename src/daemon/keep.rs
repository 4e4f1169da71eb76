//! Changes of the store: told to their client, and to everybody who listens, once they are kept.
//!
//! A change is served from the moment it is made, and acknowledged when the journal has it. Where
//! the journal cannot be written (a full disk), the change stays, for listeners already hear of it,
//! and its client is told RESOURCE_EXHAUSTED: made, but not kept. The next change that is kept
//! keeps all of those before it too.

use std::collections::VecDeque;
use std::sync::Arc;

use crossbeam_channel::Sender;
use taut::store::PreparedModel;
use taut_ipc::control::{ControlReply, Refusal};
use taut_ipc::server::{IncomingControl, ServerError};
use taut_ipc::wire::{Code, SceneEvent};

use super::event_loop::EventLoop;
use super::journal::{Content, Entry, Key, Kind, State};

/// What changed in the store, by label.
pub(super) enum Changed {
    /// A robot is there, is another, or is gone.
    Robot(String),
    /// A scene is there, has a new version, or is gone.
    Scene(String),
}

/// Whom a change is told to.
pub(super) struct Acknowledgement {
    /// The control request that asked for it.
    pub control: Option<IncomingControl>,
    /// Its answer.
    pub answer: ControlReply,
    /// What listeners hear.
    pub event: Option<SceneEvent>,
}

/// Changes on their way to the journal.
#[derive(Default)]
pub(super) struct Keeping {
    /// Where they go; `None` where nothing is kept.
    journal: Option<Sender<Entry>>,
    /// Where robots go whose solids are to be kept.
    prepared: Option<Sender<Arc<PreparedModel>>>,
    tickets: u64,
    waiting: VecDeque<(u64, Acknowledgement)>,
}

/// The journal has dealt with all changes up to one.
pub(super) struct KeptUpTo {
    /// Its ticket.
    pub ticket: u64,
    /// Why they are not kept.
    pub failure: Option<String>,
}

impl Keeping {
    /// Keeps with these two; the default keeps nothing.
    pub(super) fn new(journal: Sender<Entry>, prepared: Sender<Arc<PreparedModel>>) -> Self {
        Self {
            journal: Some(journal),
            prepared: Some(prepared),
            ..Self::default()
        }
    }

    /// Whether every change is acknowledged.
    pub(super) fn is_idle(&self) -> bool {
        self.waiting.is_empty()
    }

    /// Lets the journal end; `in_order` if everything was answered.
    pub(super) fn close(&mut self, in_order: bool) {
        self.prepared = None;
        if let Some(journal) = self.journal.take().filter(|_| in_order) {
            // The thread lives until the sender is gone.
            let _ = journal.send(Entry::End);
        }
    }
}

impl EventLoop {
    /// Keeps a change that was made to the store, then tells of it.
    pub(super) fn keep(
        &mut self,
        changed: &Changed,
        told: Acknowledgement,
    ) -> Result<(), ServerError> {
        let (key, content) = self.named(changed);
        let Some(journal) = &self.keeping.journal else {
            return self.tell(told);
        };
        if let (Content::Robot(robot, _), Some(prepared)) = (&content, &self.keeping.prepared)
            && let Some(alone) = self.store.alone(robot)
        {
            let _ = prepared.send(alone.clone());
        }
        self.keeping.tickets += 1;
        let ticket = self.keeping.tickets;
        // The thread lives until this sender is gone.
        let _ = journal.send(Entry::Changed(
            ticket,
            key,
            State {
                content,
                configured: false,
            },
        ));
        self.keeping.waiting.push_back((ticket, told));
        Ok(())
    }

    /// What the label of a change names now.
    fn named(&self, changed: &Changed) -> (Key, Content) {
        match changed {
            Changed::Robot(label) => {
                let robot = self.store.robots().get(label);
                let content =
                    robot.map(|entry| Content::Robot(entry.robot.clone(), entry.weights.clone()));
                (
                    (Kind::Robot, label.clone()),
                    content.unwrap_or(Content::Gone),
                )
            }
            Changed::Scene(label) => {
                let scene = self.store.scenes().get(label);
                let content = scene.map(|entry| Content::Scene(entry.version, entry.scene.clone()));
                (
                    (Kind::Scene, label.clone()),
                    content.unwrap_or(Content::Gone),
                )
            }
        }
    }

    /// Tells of the changes that the journal has dealt with.
    pub(super) fn kept(&mut self, kept: &KeptUpTo) -> Result<(), ServerError> {
        while self
            .keeping
            .waiting
            .front()
            .is_some_and(|(ticket, _)| *ticket <= kept.ticket)
        {
            let Some((_, mut told)) = self.keeping.waiting.pop_front() else {
                break;
            };
            if let Some(reason) = &kept.failure {
                let text = format!(
                    "the change is made, but a daemon that is started again would not know it: {reason}; free space there and send it again"
                );
                told.answer = ControlReply::Refused(Refusal::new(Code::ResourceExhausted, text));
            }
            self.tell(told)?;
        }
        Ok(())
    }

    fn tell(&self, told: Acknowledgement) -> Result<(), ServerError> {
        if let Some(event) = &told.event {
            self.server.publish_scene_event(event)?;
        }
        if let Some(control) = told.control {
            reply(control, &told.answer);
        }
        Ok(())
    }
}

/// A reply that is too large, or has no room, becomes a refusal; a client that is gone needs none.
pub(super) fn reply(control: IncomingControl, reply: &ControlReply) {
    if let Err(error) = control.reply(reply) {
        tracing::warn!("a control reply was not sent: {error}");
    }
}
