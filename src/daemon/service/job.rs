//! One request on its way to a worker.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use super::client::Client;
use taut::answer;
pub use taut::answer::{Stopped, Stops};
use taut::optimize::Settings;
use taut::path::Path;
use taut::store::Snapshot;
pub use taut::translate::StopCause;
use taut::translate::Timing;

/// Most time (ns) by which LOADING comes before the deadline.
const MOST_BEFORE_NS: u64 = 10_000_000;

/// Everything that a worker needs; nothing in it is shared memory.
pub(crate) struct Job {
    /// Number of the job in this daemon.
    pub id: u64,
    /// The client's id of the request, for logs.
    pub request_id: u64,
    /// Who asks.
    pub client: Client,
    /// Robot and scene.
    pub snapshot: Snapshot,
    /// The input, copied, its numbers unchecked.
    pub path: Arc<Path>,
    /// What is asked for.
    pub settings: Arc<Settings>,
    /// What is asked of its times, if anything is.
    pub timing: Option<Arc<Timing>>,
    /// When to end, on the monotonic clock; `None` = when done.
    pub deadline_ns: Option<u64>,
    /// When it was received.
    pub received_ns: u64,
    /// Its class; a higher one goes first.
    pub priority: u32,
    /// Where the service says to stop.
    pub stop: Arc<StopFlag>,
    /// Who asks and what about, where there is a page to show it.
    pub asked: Asked,
}

impl Job {
    /// Hash of what is asked for: equal for requests that differ in id and deadline only. Not for
    /// keeping.
    pub(crate) fn content(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        (self.snapshot.robot.hash(), self.snapshot.scene_hash).hash(&mut hasher);
        format!("{:?}{:?}", self.settings, self.timing).hash(&mut hasher);
        self.path
            .as_flat()
            .iter()
            .for_each(|number| number.to_bits().hash(&mut hasher));
        hasher.finish()
    }

    /// When it is answered without having been begun. Of a model that is still made its client
    /// hears before the deadline, so that it hears at all.
    pub(crate) fn last_ns(&self) -> Option<u64> {
        let deadline_ns = self.deadline_ns?;
        let before_ns = deadline_ns
            .saturating_sub(self.received_ns)
            .min(8 * MOST_BEFORE_NS)
            / 8;
        Some(
            deadline_ns
                - if self.snapshot.model.is_ready() {
                    0
                } else {
                    before_ns
                },
        )
    }

    /// What of it is computed.
    pub(crate) fn question(&self) -> answer::Job<'_> {
        answer::Job {
            snapshot: &self.snapshot,
            path: &self.path,
            settings: &self.settings,
            timing: self.timing.as_deref(),
        }
    }

    /// Whether its time is over.
    pub(crate) fn is_expired(&self, now_ns: u64) -> bool {
        self.deadline_ns
            .is_some_and(|deadline| now_ns >= deadline)
    }
}

/// Who asks, and what about, as people call it.
#[derive(Clone, Default, serde::Serialize)]
pub(crate) struct Asked {
    /// Label of the robot.
    pub robot: String,
    /// Label of the scene.
    pub scene: String,
    /// The client's process; 0 = not known.
    pub pid: u32,
}

/// Set by the service, read by the worker.
#[derive(Debug, Default)]
pub(crate) struct StopFlag(AtomicU8);

impl StopFlag {
    /// Asks the job to end; the first cause stays. Tells whether this was it.
    pub(crate) fn set(&self, cause: StopCause) -> bool {
        self.0
            .compare_exchange(0, cause as u8 + 1, Ordering::Relaxed, Ordering::Relaxed)
            .is_ok()
    }

    /// Why the job is to end, if it is.
    pub(crate) fn get(&self) -> Option<StopCause> {
        use StopCause::*;
        let set = usize::from(self.0.load(Ordering::Relaxed)).checked_sub(1)?;
        [Deadline, Cancelled, FinishedEarly, Shutdown]
            .get(set)
            .copied()
    }
}
