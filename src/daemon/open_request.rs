//! Requests whose streams are open: those that are computed, and watches between two checks.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use taut::store::ModelStore;
use taut_ipc::control::Refusal;
use taut_ipc::server::IncomingRequest;
use taut_ipc::wire::ResponseFlags;

use super::job::{Job, StopFlag};
use super::recording::Question;

/// A request that a client waits for.
pub(super) struct OpenRequest {
    pub(super) request: IncomingRequest,
    pub(super) stop: Arc<StopFlag>,
    pub(super) bytes: usize,
    pub(super) received_ns: u64,
    pub(super) scene_id: u64,
    pub(super) scene_version: u64,
    pub(super) question: Arc<Question>,
    /// Of a watch that has been checked before: whether it was proved then.
    pub(super) was_proved: Option<bool>,
}

impl OpenRequest {
    /// The request that a job comes from.
    pub(super) fn new(
        request: IncomingRequest,
        job: &Job,
        question: Arc<Question>,
        was_proved: Option<bool>,
    ) -> Self {
        Self {
            bytes: request.payload().len(),
            request,
            stop: job.stop.clone(),
            received_ns: job.received_ns,
            scene_id: job.snapshot.scene_id,
            scene_version: job.snapshot.scene_version,
            question,
            was_proved,
        }
    }
}

/// A request that is not let in, and why.
pub(super) struct TurnedAway {
    pub(super) request: Box<IncomingRequest>,
    pub(super) refusal: Refusal,
}

impl TurnedAway {
    pub(super) fn new(request: IncomingRequest, refusal: Refusal) -> Self {
        Self {
            request: Box::new(request),
            refusal,
        }
    }
}

/// Requests whose final response is not sent yet, by job.
#[derive(Default)]
pub(super) struct OpenRequests(HashMap<u64, OpenRequest>);

impl OpenRequests {
    pub(super) fn insert(&mut self, job: u64, open: OpenRequest) {
        self.0.insert(job, open);
    }

    pub(super) fn get(&self, job: u64) -> Option<&OpenRequest> {
        self.0.get(&job)
    }

    pub(super) fn get_mut(&mut self, job: u64) -> Option<&mut OpenRequest> {
        self.0.get_mut(&job)
    }

    pub(super) fn remove(&mut self, job: u64) -> Option<OpenRequest> {
        self.0.remove(&job)
    }

    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Jobs whose client is gone, or has dropped them.
    pub(super) fn abandoned(&self) -> Vec<u64> {
        let open = self.0.iter();
        open.filter(|(_, open)| !open.request.is_connected())
            .map(|(job, _)| *job)
            .collect()
    }

    /// Jobs whose client wants the best so far, and how to stop them.
    pub(super) fn hinted(&self) -> Vec<(u64, Arc<StopFlag>)> {
        let open = self.0.iter();
        open.filter(|(_, open)| open.request.has_disconnect_hint())
            .map(|(job, open)| (*job, open.stop.clone()))
            .collect()
    }

    /// All jobs, and how to stop them.
    pub(super) fn flags(&self) -> impl Iterator<Item = (u64, &StopFlag)> {
        self.0
            .iter()
            .map(|(job, open)| (*job, &*open.stop))
    }
}

/// A path that is watched and not being checked now.
pub(super) struct Watch {
    pub(super) request: IncomingRequest,
    pub(super) is_proved: bool,
}

impl Watch {
    /// Whether a label names its scene or its robot.
    fn is_about(&self, label_id: u64) -> bool {
        let header = self.request.header();
        header.scene_id == label_id || header.robot_id == label_id
    }
}

/// Paths that are watched and not being checked now, by number.
#[derive(Default)]
pub(super) struct Watches(BTreeMap<u64, Watch>);

impl Watches {
    pub(super) fn insert(&mut self, number: u64, watch: Watch) {
        self.0.insert(number, watch);
    }

    /// Takes out those in a scene or with a robot.
    pub(super) fn take_about(&mut self, label_id: u64) -> Vec<(u64, Watch)> {
        self.take_where(|watch| watch.is_about(label_id))
    }

    /// Takes out those whose client is gone, or has dropped them.
    pub(super) fn take_abandoned(&mut self) -> Vec<(u64, Watch)> {
        self.take_where(|watch| !watch.request.is_connected())
    }

    /// Takes out those whose client wants no more.
    pub(super) fn take_ended(&mut self) -> Vec<(u64, Watch)> {
        self.take_where(|watch| watch.request.has_disconnect_hint())
    }

    /// Takes out all.
    pub(super) fn take_all(&mut self) -> Vec<(u64, Watch)> {
        self.take_where(|_| true)
    }

    fn take_where(&mut self, is_meant: impl Fn(&Watch) -> bool) -> Vec<(u64, Watch)> {
        self.0
            .extract_if(.., |_, watch| is_meant(watch))
            .collect()
    }
}

/// The flag of an answer whose scene is no longer what its label names.
pub(super) fn superseded(store: &ModelStore, open: &OpenRequest) -> u32 {
    let is_newest = store.scene_version(open.scene_id) == Some(open.scene_version);
    if is_newest {
        0
    } else {
        ResponseFlags::SUPERSEDED
    }
}
