//! Requests whose streams are open: those that are read or computed, and watches between two
//! checks.

use std::collections::BTreeMap;
use std::sync::Arc;

use taut::store::{ModelStore, Snapshot};
use taut_ipc::wire::{RequestFlags, RequestHeader, ResponseFlags};

use super::client::Client;
use super::event::Ticket;
use super::job::{Job, StopFlag};
use crate::daemon::observe::recording::Question;

/// A request that a client waits for.
pub(crate) struct OpenRequest {
    /// Who waits.
    pub client: Client,
    /// What its header says.
    pub header: RequestHeader,
    /// Bytes of its payload, on its client's account while it is worked on.
    pub bytes: usize,
    /// Whether its client wants the best so far, now.
    pub is_hinted: bool,
    /// Of a watch that has been checked before: whether it was proved then.
    pub was_proved: Option<bool>,
    /// How far it is.
    pub stage: Stage,
}

/// How far a request is.
pub(crate) enum Stage {
    /// Its payload is copied out and checked; it came at this time (ns).
    Reading(u64, Box<Snapshot>),
    /// It waits for a slot, or is computed.
    Computing(Computing),
    /// Nothing is done for it: it has just come, or is a watch between two checks.
    Idle,
}

/// What is known of a request while its job is on its way.
#[derive(Clone)]
pub(crate) struct Computing {
    pub stop: Arc<StopFlag>,
    pub received_ns: u64,
    pub scene_id: u64,
    pub scene_version: u64,
    pub question: Arc<Question>,
}

impl Computing {
    /// The way of a job.
    pub(crate) fn new(job: &Job, question: Arc<Question>) -> Self {
        Self {
            stop: job.stop.clone(),
            received_ns: job.received_ns,
            scene_id: job.snapshot.scene_id,
            scene_version: job.snapshot.scene_version,
            question,
        }
    }

    /// Whether its scene is what the label still names.
    pub(crate) fn is_newest(&self, store: &ModelStore) -> bool {
        store.scene_version(self.scene_id) == Some(self.scene_version)
    }

    /// The flag of an answer whose scene is no longer what its label names.
    pub(crate) fn superseded(&self, store: &ModelStore) -> u32 {
        if self.is_newest(store) {
            0
        } else {
            ResponseFlags::SUPERSEDED
        }
    }
}

impl OpenRequest {
    /// Whether it is a watch.
    pub(crate) fn is_watch(&self) -> bool {
        self.header.flags & RequestFlags::WATCH != 0
    }

    /// Whether it is a watch between two checks.
    pub(crate) fn is_watching(&self) -> bool {
        matches!(self.stage, Stage::Idle)
    }

    /// Whether it has been checked before, and follows the newest version now.
    pub(crate) fn is_again(&self) -> bool {
        self.was_proved.is_some()
    }

    /// Its job, where it has one.
    pub(crate) fn computing(&self) -> Option<&Computing> {
        match &self.stage {
            Stage::Computing(computing) => Some(computing),
            Stage::Reading(..) | Stage::Idle => None,
        }
    }

    /// Whether it is a watch that waits for a change of what this label names.
    fn is_watched_about(&self, label_id: u64) -> bool {
        let header = &self.header;
        self.is_watching() && (header.scene_id == label_id || header.robot_id == label_id)
    }
}

/// Requests whose final response is not sent yet.
#[derive(Default)]
pub(crate) struct OpenRequests(BTreeMap<Ticket, OpenRequest>);

impl OpenRequests {
    pub(crate) fn insert(&mut self, ticket: Ticket, open: OpenRequest) {
        self.0.insert(ticket, open);
    }

    pub(crate) fn get(&self, ticket: Ticket) -> Option<&OpenRequest> {
        self.0.get(&ticket)
    }

    pub(crate) fn get_mut(&mut self, ticket: Ticket) -> Option<&mut OpenRequest> {
        self.0.get_mut(&ticket)
    }

    pub(crate) fn remove(&mut self, ticket: Ticket) -> Option<OpenRequest> {
        self.0.remove(&ticket)
    }

    /// The job of a request, where it has one.
    pub(crate) fn computing(&self, ticket: Ticket) -> Option<&Computing> {
        self.get(ticket)?.computing()
    }

    /// Whether all streams have ended.
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// How many are worked on: all but watches between two checks.
    pub(crate) fn worked_on(&self) -> usize {
        let open = self.0.values();
        open.filter(|open| !open.is_watching()).count()
    }

    /// The jobs of all that have one.
    pub(crate) fn jobs(&self) -> impl Iterator<Item = (Ticket, &Computing)> {
        let open = self.0.iter();
        open.filter_map(|(ticket, open)| Some((*ticket, open.computing()?)))
    }

    /// Watches that wait for a change of what this label names.
    pub(crate) fn watched_about(&self, label_id: u64) -> Vec<Ticket> {
        self.tickets_where(|open| open.is_watched_about(label_id))
    }

    /// Watches between two checks.
    pub(crate) fn watching(&self) -> Vec<Ticket> {
        self.tickets_where(OpenRequest::is_watching)
    }

    fn tickets_where(&self, is_meant: impl Fn(&OpenRequest) -> bool) -> Vec<Ticket> {
        let open = self.0.iter();
        open.filter(|(_, open)| is_meant(open))
            .map(|(ticket, _)| *ticket)
            .collect()
    }
}
