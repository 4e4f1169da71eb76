//! What happened at a gateway.

use std::sync::atomic::{AtomicU64, Ordering};

/// What happened since the start.
#[derive(Debug, Default)]
pub(super) struct Counts {
    /// Requests sent on to the daemon.
    pub(super) requests: AtomicU64,
    /// Of them, those that had been sent before, here or elsewhere, and were not known here: what may
    /// have been computed twice.
    pub(super) begun_again: AtomicU64,
    /// Final answers of the daemon.
    pub(super) finished: AtomicU64,
    /// Requests that came again while they were known.
    pub(super) known: AtomicU64,
    /// Requests refused here.
    pub(super) refused: AtomicU64,
    /// Requests dropped because their client said so or left.
    pub(super) cancelled: AtomicU64,
}

impl Counts {
    /// The counts by name.
    pub(super) fn named(&self) -> [(&'static str, u64); 6] {
        let counts = [
            ("gateway_requests", &self.requests),
            ("gateway_begun_again", &self.begun_again),
            ("gateway_finished", &self.finished),
            ("gateway_known", &self.known),
            ("gateway_refused", &self.refused),
            ("gateway_cancelled", &self.cancelled),
        ];
        counts.map(|(name, counter)| (name, counter.load(Ordering::Relaxed)))
    }
}

pub(super) fn count(counter: &AtomicU64) {
    counter.fetch_add(1, Ordering::Relaxed);
}
