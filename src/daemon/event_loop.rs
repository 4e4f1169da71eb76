//! The I/O thread: receives, hands to workers, sends. It never computes and never waits for a
//! client.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;
use std::time::Duration;

use taut::store::ModelStore;
use taut_ipc::monotonic_ns;
use taut_ipc::server::{IncomingControl, Janitor, Server, ServerError};
use taut_ipc::wire::{RobotEntry, SceneEntry, StatusRecord};

use super::clients::Clients;
use super::event::{Event, Events};
use super::keeping::Keeping;
use super::live::Live;
use super::loader::Loader;
use super::mailbox::Mailbox;
use super::metrics::Metrics;
use super::open_request::{OpenRequest, Watch};
use super::poison::Poison;
use super::preparer::ToPrepare;
use super::pulse::Pulse;
use super::recording::Recorder;
use super::schedule::Schedule;
use super::story::Stories;

/// Messages taken in one round, so that a client that floods does not keep answers from being sent.
pub(super) const ROUND: usize = 128;
/// How long a hanging janitor goes unmentioned.
const JANITOR_PATIENCE: Duration = Duration::from_secs(10);

/// Everything that the I/O thread owns.
pub(super) struct EventLoop {
    pub(super) janitor: Janitor,
    pub(super) store: ModelStore,
    pub(super) schedule: Arc<Schedule>,
    /// Where models go that are to be made; gone once the daemon ends.
    pub(super) preparer: Option<ToPrepare>,
    pub(super) clients: Clients,
    pub(super) stories: Stories,
    pub(super) recorder: Recorder,
    /// What the page shows, where there is one.
    pub(super) live: Option<Arc<Live>>,
    pub(super) poison: Poison,
    pub(super) workers: usize,
    pub(super) keeping: Keeping,
    pub(super) pulse: Pulse,
    pub(super) mailboxes: Vec<Arc<Mailbox>>,
    pub(super) events: Events,
    /// Gone once the daemon ends.
    pub(super) loader: Option<Loader>,
    pub(super) metrics: Metrics,
    pub(super) default_clearance_m: f64,
    pub(super) queue_limit: usize,
    pub(super) status_period_ns: u64,
    /// Requests whose final response is not sent yet, by job.
    pub(super) open: HashMap<u64, OpenRequest>,
    /// Paths that are watched and not being checked now.
    pub(super) watches: BTreeMap<u64, Watch>,
    /// Control requests that wait for another thread, by token.
    pub(super) loads: BTreeMap<u64, IncomingControl>,
    /// Ids of the labels that these load.
    pub(super) loading: HashSet<u64>,
    pub(super) next_number: u64,
    pub(super) next_status_ns: u64,
    pub(super) is_draining: bool,
    pub(super) janitor_was_slow: bool,
    /// Last: requests and the janitor hold its node, and only the last to go can leave nothing
    /// behind.
    pub(super) server: Server,
}

impl EventLoop {
    /// Serves until somebody asks the daemon to stop and all requests have ended.
    ///
    /// # Errors
    /// A port that stopped working: the daemon cannot go on.
    pub(super) fn run(&mut self) -> Result<(), ServerError> {
        let mut is_flooded = false;
        while !(self.is_draining && self.open.is_empty() && self.keeping.is_idle()) {
            let patience = if is_flooded || !self.events.may_sleep() {
                Duration::ZERO
            } else {
                self.patience()
            };
            self.server.wait(patience)?;
            self.events.woke();
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
        self.schedule.close();
        self.loader = None;
        self.preparer = None;
        self.keeping.close(self.is_draining);
        self.recorder.close();
        self.pulse.close();
    }

    /// How long nothing needs to be done unless somebody calls.
    fn patience(&self) -> Duration {
        let next = self
            .schedule
            .next_deadline_ns()
            .unwrap_or(u64::MAX)
            .min(self.next_status_ns);
        Duration::from_nanos(next.saturating_sub(monotonic_ns()))
    }

    fn handle_events(&mut self) -> Result<(), ServerError> {
        while let Some(event) = self.events.next() {
            match event {
                Event::Improved { worker } => self.send_improvement(worker),
                Event::Answered(answered) => self.finish(*answered),
                Event::Loaded(loaded) => self.finish_load(*loaded)?,
                Event::Written { token, answer } => self.answer_control(token, &answer),
                Event::Kept(kept) => self.kept(&kept)?,
                Event::Stop => self.drain(),
            }
        }
        Ok(())
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
        self.clients.forget(monotonic_ns());
        self.recorder.end_forgotten(monotonic_ns());
        self.pulse.beat();
        let status = self.status();
        self.server.publish_status(&status)?;
        if let Some(live) = self.live.clone() {
            live.counted(self.stats().numbers, self.clients.summaries(monotonic_ns()));
        }
        let is_slow = self.janitor.busy_for() > JANITOR_PATIENCE;
        if is_slow && !self.janitor_was_slow {
            tracing::error!(
                "cleaning up after dead clients hangs; restart the daemon when convenient"
            );
        }
        self.janitor_was_slow = is_slow;
        Ok(())
    }

    /// The state of the daemon.
    pub(super) fn status(&mut self) -> StatusRecord {
        let queued = self.schedule.waiting();
        let mut status = StatusRecord {
            workers: self.workers as u32,
            queued: queued as u32,
            running: self.open.len().saturating_sub(queued) as u32,
            clients: self.server.clients() as u32,
            robots: self.store.robots().len() as u32,
            scenes: self.store.scenes().len() as u32,
            cleaned_nodes: self.janitor.cleaned(),
            ..StatusRecord::default()
        };
        for (entry, robot) in status.robot.iter_mut().zip(self.store.robots().values()) {
            *entry = RobotEntry {
                id: robot.id,
                hash: robot.robot.hash(),
            };
        }
        for (entry, scene) in status.scene.iter_mut().zip(self.store.scenes().values()) {
            *entry = SceneEntry {
                id: scene.id,
                hash: scene.scene.hash(),
                version: scene.version,
            };
        }
        self.metrics.made(self.store.made());
        self.metrics.enter(&mut status);
        status
    }
}
