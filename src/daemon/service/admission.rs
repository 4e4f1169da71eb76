//! What a request's header alone decides: refusals at once, before anything is copied.

use std::collections::BTreeMap;
use std::sync::Arc;

use taut::store::{ModelStore, Snapshot, StoreError};
use taut_ipc::control::Refusal;
use taut_ipc::wire::{Code, RequestHeader};

use super::reading::Reading;
use crate::daemon::translate::{check_layout, check_seen, store_refusal, wanted};

/// When to try again after a stop.
const RETRY_STOPPED_MS: u32 = 100;
/// Longest retry hint.
const RETRY_MOST_MS: u64 = 5_000;

/// What admission looks at besides the header.
pub(crate) struct Doorkeeper<'a> {
    /// What is loaded.
    pub store: &'a mut ModelStore,
    /// What is being loaded, by the ids of its labels.
    pub loading: &'a BTreeMap<u64, Arc<Reading>>,
    /// Jobs that wait.
    pub waiting: usize,
    /// Jobs that may wait.
    pub most_waiting: usize,
    /// When (ns from now) this one would be begun.
    pub wait_ns: u64,
    /// Whether the daemon is ending.
    pub is_draining: bool,
}

impl Doorkeeper<'_> {
    /// Lets a request in, with what it is computed with.
    ///
    /// # Errors
    /// A refusal, with a retry hint where waiting helps.
    pub(crate) fn admit(
        &mut self,
        header: &RequestHeader,
        now_ns: u64,
    ) -> Result<Snapshot, Refusal> {
        self.check_room(header, now_ns)?;
        let snapshot = self
            .store
            .snapshot(&wanted(header))
            .map_err(|error| self.not_there(header, &error, now_ns))?;
        check_layout(header, &snapshot)?;
        check_seen(&snapshot, header, now_ns)?;
        Ok(snapshot)
    }

    fn check_room(&self, header: &RequestHeader, now_ns: u64) -> Result<(), Refusal> {
        if self.is_draining {
            Err(stopping())
        } else if self.waiting >= self.most_waiting {
            Err(self.overloaded("as many as may wait"))
        } else if self.is_hopeless(header.deadline_ns, now_ns) {
            Err(self.overloaded("too many for this one's deadline"))
        } else {
            Ok(())
        }
    }

    /// What comes to nothing is not begun, so that what others wait for comes to something.
    fn is_hopeless(&self, deadline_ns: u64, now_ns: u64) -> bool {
        let begun_ns = now_ns.saturating_add(self.wait_ns);
        self.wait_ns > 0 && deadline_ns != 0 && deadline_ns <= begun_ns
    }

    fn overloaded(&self, why: &str) -> Refusal {
        let retry_after_ms = (self.wait_ns / 1_000_000).clamp(1, RETRY_MOST_MS) as u32;
        let message = format!(
            "{} requests wait already, {why}; send again in {retry_after_ms} ms",
            self.waiting
        );
        Refusal {
            code: Code::Overloaded.into(),
            message,
            retry_after_ms,
        }
    }

    /// What is unknown may just be on its way.
    fn not_there(&self, header: &RequestHeader, error: &StoreError, now_ns: u64) -> Refusal {
        let id = match error {
            StoreError::UnknownRobot { .. } => header.robot_id,
            StoreError::UnknownScene { .. } => header.scene_id,
            _ => return store_refusal(error),
        };
        match self.loading.get(&id) {
            Some(reading) => reading.refusal(now_ns),
            None => store_refusal(error),
        }
    }
}

/// The refusal of what comes while the daemon ends.
pub(super) fn stopping() -> Refusal {
    let message = "the daemon is stopping; send again to the next one".to_owned();
    Refusal {
        code: Code::Overloaded.into(),
        message,
        retry_after_ms: RETRY_STOPPED_MS,
    }
}
