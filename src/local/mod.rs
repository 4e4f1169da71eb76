//! Answers requests in this process as the daemon does, bit for bit: for programs that have no
//! daemon.
//!
//! ```
//! use taut::local::LocalService;
//! use taut_ipc::planner::Planner;
//!
//! let planner = Planner::in_process(LocalService::default());
//! assert!(planner.list().unwrap().robots.is_empty());
//! ```

mod models;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, MutexGuard, PoisonError};

use taut_ipc::control::{ControlReply, ControlRequest, Refusal};
use taut_ipc::monotonic_ns;
use taut_ipc::planner::{Ending, Service, Tell};
use taut_ipc::wire::{Code, RequestView, label_id};

use crate::optimize::{self, Improvement, Settings, Workspace};
use crate::store::{ModelStore, Snapshot};
use crate::translate::{self, Lengths, Reply, StopCause};

/// Robots and scenes of this process, and the work on paths.
#[derive(Debug)]
pub struct LocalService {
    store: Mutex<ModelStore>,
    /// Changes of scenes are made one after the other.
    changing: Mutex<()>,
}

impl Default for LocalService {
    fn default() -> Self {
        Self {
            store: Mutex::new(ModelStore::new(label_id)),
            changing: Mutex::default(),
        }
    }
}

impl Service for LocalService {
    fn control(&self, message: ControlRequest) -> ControlReply {
        let reply = catch_unwind(AssertUnwindSafe(|| self.answer_control(message)));
        let reply = reply.unwrap_or_else(|_| Err(crash("loading or changing this")));
        reply.unwrap_or_else(ControlReply::Refused)
    }

    fn answer(&self, request: &RequestView<'_>, ending: &Ending, tell: &Tell<'_>) {
        let received_ns = monotonic_ns();
        let reply = catch_unwind(AssertUnwindSafe(|| self.compute(request, ending, tell)));
        let mut reply = match reply {
            Ok(Ok(reply)) => reply,
            Ok(Err(refusal)) => translate::refused(refusal),
            Err(_) => translate::refused(crash("computing this request")),
        };
        reply.header.compute_ns = monotonic_ns().saturating_sub(received_ns);
        tell(&reply.header, &reply.body());
    }
}

fn crash(what: &str) -> Refusal {
    Refusal::new(
        Code::Crash,
        format!("{what} panicked; report it with the request as a defect"),
    )
}

impl LocalService {
    fn store(&self) -> MutexGuard<'_, ModelStore> {
        self.store.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Works on a request and tells of its improvements.
    fn compute(
        &self,
        request: &RequestView<'_>,
        ending: &Ending,
        tell: &Tell<'_>,
    ) -> Result<Reply, Refusal> {
        let header = &request.header;
        if header.flags & taut_ipc::wire::RequestFlags::WATCH != 0 {
            let text = "a path is watched by a daemon only; check it again after each change";
            return Err(Refusal::new(Code::MalformedRequest, text));
        }
        let snapshot = self.store().snapshot(&translate::wanted(header));
        let snapshot = snapshot.map_err(|error| translate::store_refusal(&error))?;
        translate::check_layout(header, &snapshot)?;
        let (settings, path) =
            translate::settings_and_path(request, &snapshot, Settings::DEFAULT_CLEARANCE_M)?;
        let model = snapshot.model.get();
        let model = model.map_err(|error| translate::model_refusal(error, &snapshot.robot))?;
        let is_late = || header.deadline_ns != 0 && monotonic_ns() >= header.deadline_ns;
        if is_late() {
            return Ok(translate::expired(&snapshot, &path));
        }
        let mut cause = None;
        let mut stop = || {
            cause = match ending.asked() {
                Some(true) => Some(StopCause::FinishedEarly),
                Some(false) => Some(StopCause::Cancelled),
                None => is_late().then_some(StopCause::Deadline),
            };
            cause.is_some()
        };
        let mut lengths = Lengths::new(&snapshot, &settings, &path);
        let mut publish =
            |improvement: Improvement| improved(&snapshot, &mut lengths, &improvement, tell);
        let result = optimize::run(
            model,
            &path,
            &settings,
            &mut Workspace::default(),
            &mut stop,
            &mut publish,
        );
        let outcome = result.map_err(|error| translate::request_refusal(&error))?;
        Ok(translate::answered(&snapshot, &outcome, cause))
    }
}

fn improved(
    snapshot: &Snapshot,
    lengths: &mut Lengths<'_>,
    improvement: &Improvement<'_>,
    tell: &Tell<'_>,
) {
    let header = translate::progress(snapshot, improvement, lengths.of(improvement.length));
    let body = taut_ipc::wire::ResponseBody {
        path: improvement.path.as_flat(),
        ..Default::default()
    };
    tell(&header, &body);
}
