//! Changes of the store: told to their client, and to everybody who listens, once they are kept.

use taut_ipc::control::ControlReply;
use taut_ipc::server::{IncomingControl, ServerError};
use taut_ipc::wire::SceneEvent;

use super::event_loop::EventLoop;

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

impl EventLoop {
    /// Keeps a change that was made to the store, then tells of it.
    pub(super) fn keep(&mut self, _changed: &Changed, told: Acknowledgement) -> Result<(), ServerError> {
        self.tell(told)
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
