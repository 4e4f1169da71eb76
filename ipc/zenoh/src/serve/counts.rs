//! What happened at a gateway.

use std::sync::atomic::{AtomicU64, Ordering};

/// What happened since the start.
#[derive(Debug, Default)]
pub(super) struct Counts {
    /// Requests sent on to the daemon.
    pub(super) requests: AtomicU64,
    /// Final answers of the daemon.
    pub(super) finished: AtomicU64,
    /// Requests that came again while they were known.
    pub(super) known: AtomicU64,
    /// Requests refused here.
    pub(super) refused: AtomicU64,
    /// Requests dropped because their client said so or left.
    pub(super) cancelled: AtomicU64,
}

pub(super) fn count(counter: &AtomicU64) {
    counter.fetch_add(1, Ordering::Relaxed);
}
