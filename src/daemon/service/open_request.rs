//! Requests whose streams are open: those that are read or computed, and watches between two
//! checks.

use std::collections::BTreeMap;
use std::sync::Arc;

use taut::scene::SensedFrame;
use taut::store::{ModelStore, Snapshot};
use taut_ipc::wire::{RequestFlags, RequestHeader, ResponseFlags, ResponseHeader};

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
    /// Of a watch: whether its client could not be told of the last verdict.
    pub is_untold: bool,
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
    /// The oldest of the frames that its scene is seen by.
    pub seen: Option<SensedFrame>,
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
            seen: job
                .snapshot
                .scene
                .oldest_frame()
                .map(|(_, frame)| *frame),
            question,
        }
    }

    /// Whether its scene is what the label still names.
    pub(crate) fn is_newest(&self, store: &ModelStore) -> bool {
        store.scene_version(self.scene_id) == Some(self.scene_version)
    }

    /// Enters into an answer how old its world is at `now_ns`, and whether its scene is no longer
    /// what its label names.
    pub(crate) fn stamp(&self, header: &mut ResponseHeader, store: &ModelStore, now_ns: u64) {
        header.world_age_ns = self
            .seen
            .map_or(0, |frame| frame.age_ns(now_ns));
        if !self.is_newest(store) {
            header.flags |= ResponseFlags::SUPERSEDED;
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

    /// When (ns) a watched path that was proved stops being so, because its world is older than the
    /// request allows.
    pub(crate) fn too_old_ns(&self, store: &ModelStore) -> u64 {
        let max_age_ns = self.header.max_age_ns;
        if max_age_ns == 0 || self.was_proved != Some(true) {
            return u64::MAX;
        }
        let entry = store.scene_of(self.header.scene_id);
        let seen = entry.and_then(|entry| entry.scene.oldest_frame());
        seen.map_or(u64::MAX, |(_, frame)| {
            frame
                .taken_ns
                .saturating_add(max_age_ns)
                .saturating_add(1)
        })
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
