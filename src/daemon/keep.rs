//! Changes of the store: told to their client, and to everybody who listens, once they are kept.
//!
//! A change is served from the moment it is made, and acknowledged when the journal has it. Where
//! the journal cannot be written (a full disk), the change stays, for listeners already hear of it,
//! and its client is told RESOURCE_EXHAUSTED: made, but not kept. The next change that is kept
//! keeps all of those before it too.

use taut_ipc::control::{ControlReply, Refusal};
use taut_ipc::server::{IncomingControl, ServerError};

use super::event_loop::EventLoop;
use super::journal::{Content, Key, Kind};
use super::keeping::{Acknowledgement, Changed, KeptUpTo};

impl EventLoop {
    /// Keeps a change that was made to the store, then tells of it.
    pub(super) fn keep(
        &mut self,
        changed: &Changed,
        told: Acknowledgement,
    ) -> Result<(), ServerError> {
        let (key, content) = self.named(changed);
        match self.keeping.keep(key, content, told) {
            Some(told) => self.tell(told),
            None => Ok(()),
        }
    }

    /// What the label of a change names now.
    fn named(&self, changed: &Changed) -> (Key, Content) {
        match changed {
            Changed::Robot(label) => ((Kind::Robot, label.clone()), self.robot_named(label)),
            Changed::Scene(label) => ((Kind::Scene, label.clone()), self.scene_named(label)),
        }
    }

    fn robot_named(&self, label: &str) -> Content {
        match self.store.robots().get(label) {
            Some(entry) => Content::Robot(entry.robot.clone(), entry.weights.clone()),
            None => Content::Gone,
        }
    }

    fn scene_named(&self, label: &str) -> Content {
        match self.store.scenes().get(label) {
            Some(entry) => Content::Scene(entry.version, entry.scene.clone()),
            None => Content::Gone,
        }
    }

    /// Tells of the changes that the journal has dealt with.
    pub(super) fn kept(&mut self, kept: &KeptUpTo) -> Result<(), ServerError> {
        while let Some(told) = self.keeping.next_kept(kept) {
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

/// Replies with a refusal.
pub(super) fn refuse(control: IncomingControl, refusal: Refusal) {
    reply(control, &ControlReply::Refused(refusal));
}

/// A reply that is too large, or has no room, becomes a refusal; a client that is gone needs none.
pub(super) fn reply(control: IncomingControl, reply: &ControlReply) {
    if let Err(error) = control.reply(reply) {
        tracing::warn!("a control reply was not sent: {error}");
    }
}
