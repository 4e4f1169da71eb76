//! The I/O thread: receives, hands to workers, sends. It never computes and never waits for a client.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;
use std::time::Duration;

use crossbeam_channel::{Receiver, Sender};
use taut::store::ModelStore;
use taut_ipc::control::Refusal;
use taut_ipc::monotonic_ns;
use taut_ipc::server::{IncomingControl, IncomingRequest, Janitor, SendError, Server, ServerError};
use taut_ipc::wire::{Code, ResponseFlags, RobotEntry, SceneEntry, StatusRecord};

use super::admission::Doorkeeper;
use super::event::{Answered, Event};
use super::job::{Job, StopCause, StopFlag};
use super::keep::Keeping;
use super::loader;
use super::mailbox::{Mailbox, Progress};
use super::metrics::Metrics;
use super::pulse::Pulse;
use super::queue::{JobQueue, Place, place};
use super::translate::{self, Reply};

/// Messages taken in one round, so that a client that floods does not keep answers from being sent.
pub(super) const ROUND: usize = 128;
/// How long a hanging janitor goes unmentioned.
const JANITOR_PATIENCE: Duration = Duration::from_secs(10);

/// Everything that the I/O thread owns.
pub(super) struct EventLoop {
    pub(super) janitor: Janitor,
    pub(super) store: ModelStore,
    pub(super) keeping: Keeping,
    pub(super) pulse: Pulse,
    pub(super) queue: Arc<JobQueue>,
    pub(super) mailboxes: Vec<Arc<Mailbox>>,
    pub(super) events: Receiver<Event>,
    /// Gone once the daemon ends.
    pub(super) loader: Option<Sender<loader::Task>>,
    pub(super) metrics: Metrics,
    pub(super) default_clearance_m: f64,
    pub(super) queue_limit: usize,
    pub(super) status_period_ns: u64,
    /// Requests whose final response is not sent yet, by job.
    pub(super) open: HashMap<u64, OpenRequest>,
    /// Control requests that wait for the loader, by token.
    pub(super) loads: BTreeMap<u64, IncomingControl>,
    /// Ids of the labels that these load.
    pub(super) loading: HashSet<u64>,
    pub(super) next_number: u64,
    pub(super) next_status_ns: u64,
    pub(super) is_draining: bool,
    pub(super) janitor_was_slow: bool,
    /// Last: requests and the janitor hold its node, and only the last to go can leave nothing behind.
    pub(super) server: Server,
}

/// A request that a client waits for.
pub(super) struct OpenRequest {
    request: IncomingRequest,
    stop: Arc<StopFlag>,
    place: Place,
    scene_id: u64,
    scene_version: u64,
}

impl EventLoop {
    /// Serves until somebody asks the daemon to stop and all requests have ended.
    ///
    /// # Errors
    /// A port that stopped working: the daemon cannot go on.
    pub(super) fn run(&mut self) -> Result<(), ServerError> {
        let mut is_flooded = false;
        while !(self.is_draining && self.open.is_empty() && self.keeping.is_idle()) {
            let patience = if is_flooded { Duration::ZERO } else { self.patience() };
            self.server.wait(patience)?;
            self.handle_events()?;
            is_flooded = self.receive_requests()?;
            is_flooded |= self.receive_controls()?;
            self.end_abandoned();
            self.end_expired();
            self.publish_status_when_due()?;
        }
        Ok(())
    }

    /// Lets workers and loader end, after [`Self::run`].
    pub(super) fn close(&mut self) {
        self.queue.close();
        self.loader = None;
        self.keeping.close(self.is_draining);
        self.pulse.close();
    }

    /// How long nothing needs to be done unless somebody calls.
    fn patience(&self) -> Duration {
        let next = self.queue.next_deadline_ns().unwrap_or(u64::MAX).min(self.next_status_ns);
        Duration::from_nanos(next.saturating_sub(monotonic_ns()))
    }

    fn handle_events(&mut self) -> Result<(), ServerError> {
        while let Ok(event) = self.events.try_recv() {
            match event {
                Event::Improved { worker } => self.send_improvement(worker),
                Event::Answered(answered) => self.finish(*answered),
                Event::Loaded(loaded) => self.finish_load(*loaded)?,
                Event::Kept(kept) => self.kept(&kept)?,
                Event::Stop => self.drain(),
            }
        }
        Ok(())
    }

    /// Takes requests; tells whether more may be waiting.
    fn receive_requests(&mut self) -> Result<bool, ServerError> {
        for _ in 0..ROUND {
            let Some(request) = self.server.receive()? else { return Ok(false) };
            self.metrics.received();
            if let Err((request, refusal)) = self.take(request) {
                self.refuse(*request, &refusal);
            }
        }
        Ok(true)
    }

    /// Lets a request in and gives it to the workers.
    fn take(&mut self, request: IncomingRequest) -> Result<(), (Box<IncomingRequest>, Refusal)> {
        let number = self.next_number();
        match self.job(number, &request) {
            Err(refusal) => Err((Box::new(request), refusal)),
            Ok(job) => {
                tracing::debug!(request = job.request_id, job = number, "taken");
                let (stop, place) = (job.stop.clone(), place(&job));
                let (scene_id, scene_version) = (job.snapshot.scene_id, job.snapshot.scene_version);
                self.open.insert(number, OpenRequest { request, stop, place, scene_id, scene_version });
                self.queue.push(job);
                Ok(())
            }
        }
    }

    fn job(&mut self, id: u64, request: &IncomingRequest) -> Result<Job, Refusal> {
        let view = request.view().map_err(|error| Refusal::new(error.code(), error.to_string()))?;
        let mut doorkeeper = Doorkeeper {
            store: &mut self.store,
            loading: &self.loading,
            queued: self.queue.len(),
            queue_limit: self.queue_limit,
            compute_p50_ns: self.metrics.compute_p50_ns(),
            workers: self.mailboxes.len(),
            is_draining: self.is_draining,
        };
        let snapshot = doorkeeper.admit(&view.header)?;
        let (settings, path) = translate::settings_and_path(&view, &snapshot, self.default_clearance_m)?;
        Ok(Job {
            id,
            request_id: view.header.request_id,
            snapshot,
            path,
            settings,
            deadline_ns: Some(view.header.deadline_ns).filter(|deadline| *deadline != 0),
            received_ns: monotonic_ns(),
            priority: view.header.priority,
            stop: Arc::default(),
        })
    }

    fn refuse(&mut self, request: IncomingRequest, refusal: &Refusal) {
        tracing::info!(request = request.header().request_id, code = refusal.code, "refused: {}", refusal.message);
        self.metrics.ended(refusal.code);
        let code = Code::try_from(refusal.code).unwrap_or(Code::MalformedRequest);
        if let Err(error) = request.refuse(code, &refusal.message, refusal.retry_after_ms) {
            tracing::warn!("a refusal was not sent: {error}");
        }
    }

    fn send_improvement(&mut self, worker: usize) {
        let Some(mailbox) = self.mailboxes.get(worker).cloned() else { return };
        mailbox.fetch(|progress: &Progress| {
            let Some(open) = self.open.get_mut(&progress.job) else { return };
            let mut header = progress.header;
            header.flags |= superseded(&self.store, open);
            let body = taut_ipc::wire::ResponseBody { path: &progress.path, ..Default::default() };
            if let Err(error) = open.request.send(&header, &body) {
                tracing::warn!(request = open.request.header().request_id, "an improvement was not sent: {error}");
            }
        });
    }

    fn finish(&mut self, answered: Answered) {
        if answered.panicked {
            self.metrics.panicked();
        }
        self.metrics.timed(&answered.reply.header);
        if let Some(open) = self.open.remove(&answered.job) {
            self.send_final(open, answered.reply);
        }
    }

    fn send_final(&mut self, mut open: OpenRequest, mut reply: Reply) {
        if reply.header.scene_version != 0 {
            reply.header.flags |= superseded(&self.store, &open);
        }
        self.metrics.ended(reply.header.code);
        let request = open.request.header().request_id;
        tracing::debug!(request, code = reply.header.code, compute_ns = reply.header.compute_ns, "answered");
        let Err(error) = open.request.send(&reply.header, &reply.body()) else { return };
        tracing::warn!(request, "the answer was not sent: {error}");
        let code = match error {
            SendError::TooLarge(_) | SendError::NoMemory(_) => Code::ResourceExhausted,
            _ => return,
        };
        let refused = open.request.refuse(code, &error.to_string(), 0);
        if let Err(error) = refused {
            tracing::warn!(request, "its refusal neither: {error}");
        }
    }

    /// Ends the jobs whose client is gone, and asks those to end whose client wants the best so far.
    fn end_abandoned(&mut self) {
        let gone: Vec<u64> =
            self.open.iter().filter(|(_, open)| !open.request.is_connected()).map(|(job, _)| *job).collect();
        for job in gone {
            // Dropping the request frees the client's slot at once; the worker ends on its own.
            let Some(open) = self.open.remove(&job) else { continue };
            open.stop.set(StopCause::Cancelled);
            self.queue.remove(open.place);
            self.metrics.cancelled();
            tracing::debug!(request = open.request.header().request_id, "cancelled");
        }
        let hinted = self.open.values().filter(|open| open.request.has_disconnect_hint());
        let hinted: Vec<Place> =
            hinted.inspect(|open| open.stop.set(StopCause::FinishedEarly)).map(|o| o.place).collect();
        for place in hinted {
            if let Some(job) = self.queue.remove(place) {
                self.answer_untouched(&job, StopCause::FinishedEarly);
            }
        }
    }

    /// Nothing waits past its deadline.
    fn end_expired(&mut self) {
        for job in self.queue.take_expired(monotonic_ns()) {
            self.answer_untouched(&job, StopCause::Deadline);
        }
    }

    fn answer_untouched(&mut self, job: &Job, cause: StopCause) {
        let mut reply = match cause {
            StopCause::Deadline => translate::expired(job),
            cause => translate::preempted(job, cause),
        };
        reply.header.queue_ns = monotonic_ns().saturating_sub(job.received_ns);
        if let Some(open) = self.open.remove(&job.id) {
            self.send_final(open, reply);
        }
    }

    /// Takes nothing new and ends what runs, with the best so far.
    pub(super) fn drain(&mut self) {
        if std::mem::replace(&mut self.is_draining, true) {
            return;
        }
        tracing::info!(open = self.open.len(), "stopping");
        for job in self.queue.take_all() {
            self.answer_untouched(&job, StopCause::Shutdown);
        }
        self.open.values().for_each(|open| open.stop.set(StopCause::Shutdown));
    }

    pub(super) fn next_number(&mut self) -> u64 {
        self.next_number += 1;
        self.next_number
    }

    fn publish_status_when_due(&mut self) -> Result<(), ServerError> {
        if monotonic_ns() < self.next_status_ns {
            return Ok(());
        }
        self.next_status_ns = monotonic_ns() + self.status_period_ns;
        self.pulse.beat();
        let status = self.status();
        self.server.publish_status(&status)?;
        let is_slow = self.janitor.busy_for() > JANITOR_PATIENCE;
        if is_slow && !self.janitor_was_slow {
            tracing::error!("cleaning up after dead clients hangs; restart the daemon when convenient");
        }
        self.janitor_was_slow = is_slow;
        Ok(())
    }

    /// The state of the daemon.
    pub(super) fn status(&mut self) -> StatusRecord {
        let queued = self.queue.len();
        let mut status = StatusRecord {
            workers: self.mailboxes.len() as u32,
            queued: queued as u32,
            running: self.open.len().saturating_sub(queued) as u32,
            clients: self.server.clients() as u32,
            robots: self.store.robots().len() as u32,
            scenes: self.store.scenes().len() as u32,
            cleaned_nodes: self.janitor.cleaned(),
            ..StatusRecord::default()
        };
        for (entry, robot) in status.robot.iter_mut().zip(self.store.robots().values()) {
            *entry = RobotEntry { id: robot.id, hash: robot.robot.hash() };
        }
        for (entry, scene) in status.scene.iter_mut().zip(self.store.scenes().values()) {
            *entry = SceneEntry { id: scene.id, hash: scene.scene.hash(), version: scene.version };
        }
        self.metrics.enter(&mut status);
        status
    }
}

/// The flag of an answer whose scene is no longer what its label names.
fn superseded(store: &ModelStore, open: &OpenRequest) -> u32 {
    let is_newest = store.scene_version(open.scene_id) == Some(open.scene_version);
    if is_newest { 0 } else { ResponseFlags::SUPERSEDED }
}
