//! What a request's header alone decides: refusals at once, before anything is copied.

use std::collections::HashSet;

use taut::store::{ModelStore, Snapshot, StoreError, Wanted};
use taut_ipc::control::Refusal;
use taut_ipc::wire::{Code, RequestHeader};

use super::translate::store_refusal;

/// When to try again after LOADING or a stop.
const RETRY_LOADING_MS: u32 = 100;
/// Longest retry hint.
const RETRY_MOST_MS: u64 = 5_000;

/// What admission looks at besides the header.
pub(super) struct Doorkeeper<'a> {
    /// What is loaded.
    pub store: &'a mut ModelStore,
    /// Ids of labels that are being loaded.
    pub loading: &'a HashSet<u64>,
    /// Jobs that wait, and how many may.
    pub queued: usize,
    /// Jobs that may wait.
    pub queue_limit: usize,
    /// Median computing time, and the workers that share the work.
    pub compute_p50_ns: u64,
    /// Worker threads.
    pub workers: usize,
    /// Whether the daemon is ending.
    pub is_draining: bool,
}

impl Doorkeeper<'_> {
    /// Lets a request in, with what it is computed with.
    ///
    /// # Errors
    /// A refusal, with a retry hint where waiting helps.
    pub(super) fn admit(&mut self, header: &RequestHeader) -> Result<Snapshot, Refusal> {
        if self.is_draining {
            let message = "the daemon is stopping; send again to the next one".to_owned();
            return Err(Refusal { code: Code::Overloaded.into(), message, retry_after_ms: RETRY_LOADING_MS });
        }
        if self.queued >= self.queue_limit {
            return Err(self.overloaded());
        }
        let snapshot = self.store.snapshot(&wanted(header)).map_err(|error| self.not_there(header, &error))?;
        check_layout(header, &snapshot)?;
        Ok(snapshot)
    }

    fn overloaded(&self) -> Refusal {
        let wait_ms = self.queued as u64 * self.compute_p50_ns / self.workers.max(1) as u64 / 1_000_000;
        let retry_after_ms = wait_ms.clamp(1, RETRY_MOST_MS) as u32;
        let message = format!("{} requests wait already; send again in {retry_after_ms} ms", self.queued);
        Refusal { code: Code::Overloaded.into(), message, retry_after_ms }
    }

    /// What is unknown may just be on its way.
    fn not_there(&self, header: &RequestHeader, error: &StoreError) -> Refusal {
        let id = match error {
            StoreError::UnknownRobot { .. } => header.robot_id,
            StoreError::UnknownScene { .. } => header.scene_id,
            _ => return store_refusal(error),
        };
        if !self.loading.contains(&id) {
            return store_refusal(error);
        }
        let message = "it is being loaded; send again soon".to_owned();
        Refusal { code: Code::Loading.into(), message, retry_after_ms: RETRY_LOADING_MS }
    }
}

fn wanted(header: &RequestHeader) -> Wanted {
    Wanted {
        robot_id: header.robot_id,
        robot_hash: header.robot_hash,
        scene_id: header.scene_id,
        scene_hash: header.scene_hash,
        scene_version: header.scene_version,
    }
}

/// Columns by position would be silently wrong for another maker's robot of the same name.
fn check_layout(header: &RequestHeader, snapshot: &Snapshot) -> Result<(), Refusal> {
    let layout = snapshot.robot.layout_hash();
    if header.layout_hash == layout {
        return Ok(());
    }
    let names: Vec<&str> = snapshot.robot.variables().iter().map(|variable| variable.name.as_str()).collect();
    let text = format!(
        "the request has layout hash {:016x}, the robot {layout:016x}: columns {}; describe the robot and send in its order",
        header.layout_hash,
        names.join(", ")
    );
    Err(Refusal::new(Code::InvalidRobotState, text))
}
