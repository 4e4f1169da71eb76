//! Changes on their way to the journal, and whom they are told to.

use std::collections::VecDeque;

use taut_ipc::control::{ControlReply, Refusal};
use taut_ipc::wire::{Code, SceneEvent};

use super::effect::{Effect, Effects, InOrder};
use super::event::{KeptUpTo, Ticket};
use crate::daemon::durability::journal::{Content, Entry, Key, State};

/// What changed in the store, by label.
pub(crate) enum Changed {
    /// A robot is there, is another, or is gone.
    Robot(String),
    /// A scene is there, has a new version, or is gone.
    Scene(String),
}

/// Whom a change is told to.
pub(crate) struct Acknowledgement {
    /// The control request that asked for it.
    pub ticket: Ticket,
    /// Its answer.
    pub answer: ControlReply,
    /// What listeners hear.
    pub event: Option<SceneEvent>,
}

impl Acknowledgement {
    /// Of what leaves nothing to show.
    pub(crate) fn done(ticket: Ticket, event: Option<SceneEvent>) -> Self {
        Self {
            ticket,
            answer: ControlReply::Done,
            event,
        }
    }

    /// Has everybody told.
    fn tell(self, effects: &mut Effects) {
        if let Some(event) = self.event {
            effects.in_order(InOrder::Publish(event));
        }
        effects.push(Effect::Reply(self.ticket, Box::new(self.answer)));
    }
}

/// Changes on their way to the journal.
pub(crate) struct Keeping {
    /// Whether anything is kept.
    keeps: bool,
    /// The number of the last change.
    changes: u64,
    waiting: VecDeque<(u64, Acknowledgement)>,
    due: Effects,
}

impl Keeping {
    /// Keeps changes, or does not.
    pub(crate) fn new(keeps: bool) -> Self {
        Self {
            keeps,
            changes: 0,
            waiting: VecDeque::new(),
            due: Effects::default(),
        }
    }

    /// Whether every change is acknowledged.
    pub(crate) fn is_idle(&self) -> bool {
        self.waiting.is_empty()
    }

    /// What is to be done by now.
    pub(crate) fn due(&mut self) -> &mut Effects {
        &mut self.due
    }

    /// Hands what a label names now to the journal; who waits is told at once where nothing is
    /// kept.
    pub(crate) fn keep(&mut self, key: Key, content: Content, told: Acknowledgement) {
        if !self.keeps {
            return told.tell(&mut self.due);
        }
        self.write(key, content);
        self.waiting.push_back((self.changes, told));
    }

    /// Tells at once of a change that is not kept.
    pub(crate) fn pass(&mut self, told: Acknowledgement) {
        told.tell(&mut self.due);
    }

    /// Hands a change to the journal, under a number that comes back when it is kept.
    fn write(&mut self, key: Key, content: Content) {
        self.changes += 1;
        let state = State {
            content,
            configured: false,
        };
        let entry = Entry::Changed(self.changes, key, state);
        self.due.in_order(InOrder::Keep(entry));
    }

    /// The journal has dealt with changes: tells of them.
    pub(crate) fn kept(&mut self, kept: &KeptUpTo) {
        while let Some(told) = self.next_kept(kept) {
            told.tell(&mut self.due);
        }
    }

    /// The next change that the journal has dealt with.
    fn next_kept(&mut self, kept: &KeptUpTo) -> Option<Acknowledgement> {
        let (_, mut told) = self
            .waiting
            .pop_front_if(|(change, _)| *change <= kept.change)?;
        if let Some(reason) = &kept.failure {
            told.answer = ControlReply::Refused(not_kept(reason));
        }
        Some(told)
    }
}

fn not_kept(reason: &str) -> Refusal {
    let text = format!(
        "the change is made, but a daemon that is started again would not know it: {reason}; free space there and send it again"
    );
    Refusal::new(Code::ResourceExhausted, text)
}
