//! Requests whose streams are open: those that are computed, and watches between two checks.

use std::sync::Arc;

use taut::store::ModelStore;
use taut_ipc::server::IncomingRequest;
use taut_ipc::wire::ResponseFlags;

use super::job::StopFlag;
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

/// A path that is watched and not being checked now.
pub(super) struct Watch {
    pub(super) request: IncomingRequest,
    pub(super) is_proved: bool,
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
