//! Changes on their way to the journal, and whom they are told to.

use std::collections::VecDeque;

use crossbeam_channel::Sender;
use taut_ipc::control::{ControlReply, Refusal};
use taut_ipc::server::IncomingControl;
use taut_ipc::wire::{Code, SceneEvent};

use super::journal::{Content, Entry, Key, State};

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

impl Acknowledgement {
    /// Of what leaves nothing to show.
    pub(super) fn done(control: IncomingControl, event: Option<SceneEvent>) -> Self {
        Self {
            control: Some(control),
            answer: ControlReply::Done,
            event,
        }
    }
}

/// Changes on their way to the journal.
#[derive(Default)]
pub(super) struct Keeping {
    /// Where they go; `None` where nothing is kept.
    journal: Option<Sender<Entry>>,
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
    /// Keeps in this journal; the default keeps nothing.
    pub(super) fn new(journal: Sender<Entry>) -> Self {
        Self {
            journal: Some(journal),
            ..Self::default()
        }
    }

    /// Whether every change is acknowledged.
    pub(super) fn is_idle(&self) -> bool {
        self.waiting.is_empty()
    }

    /// Lets the journal end; `in_order` if everything was answered.
    pub(super) fn close(&mut self, in_order: bool) {
        if let Some(journal) = self.journal.take().filter(|_| in_order) {
            // The thread lives until the sender is gone.
            let _ = journal.send(Entry::End);
        }
    }

    /// Hands what a label names now to the journal; gives the acknowledgement back where nothing is
    /// kept and nothing need be waited for.
    pub(super) fn keep(
        &mut self,
        key: Key,
        content: Content,
        told: Acknowledgement,
    ) -> Option<Acknowledgement> {
        if self.journal.is_none() {
            return Some(told);
        }
        let ticket = self.write(key, content);
        self.waiting.push_back((ticket, told));
        None
    }

    /// Hands a change to the journal; gives the ticket that comes back when it is kept.
    fn write(&mut self, key: Key, content: Content) -> u64 {
        self.tickets += 1;
        let state = State {
            content,
            configured: false,
        };
        if let Some(journal) = &self.journal {
            // The thread lives until this sender is gone.
            let _ = journal.send(Entry::Changed(self.tickets, key, state));
        }
        self.tickets
    }

    /// The next change that the journal has dealt with.
    pub(super) fn next_kept(&mut self, kept: &KeptUpTo) -> Option<Acknowledgement> {
        let (_, mut told) = self
            .waiting
            .pop_front_if(|(ticket, _)| *ticket <= kept.ticket)?;
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
