//! The I/O thread: receives, hands to workers, sends. It never computes and never waits for a
//! client.

use std::sync::Arc;
use std::time::Duration;

use taut::store::ModelStore;
use taut_ipc::monotonic_ns;
use taut_ipc::server::{Server, ServerError};

use super::cleaning::Cleaning;
use super::clients::Clients;
use super::config::Config;
use super::event::{Event, Events};
use super::keeping::Keeping;
use super::live::Live;
use super::loading::Loading;
use super::mailbox::Mailbox;
use super::metrics::Metrics;
use super::open_request::{OpenRequests, Watches};
use super::poison::Poison;
use super::preparer::ToPrepare;
use super::pulse::Pulse;
use super::recording::Recorder;
use super::schedule::Schedule;
use super::status_clock::StatusClock;
use super::story::Stories;

/// Messages taken in one round, so that a client that floods does not keep answers from being sent.
pub(super) const ROUND: usize = 128;

/// What the configuration says of every request.
pub(super) struct Limits {
    /// Jobs that are computed at once.
    pub workers: usize,
    /// Requests that may wait.
    pub queue: usize,
    /// Clearance (m) of those that name none.
    pub clearance_m: f64,
}

impl Limits {
    pub(super) fn of(config: &Config) -> Self {
        Self {
            workers: config.worker_count(),
            queue: config.queue,
            clearance_m: config.clearance_m,
        }
    }
}

/// Everything that the I/O thread owns.
pub(super) struct EventLoop {
    pub(super) cleaning: Cleaning,
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
    pub(super) limits: Limits,
    pub(super) keeping: Keeping,
    pub(super) pulse: Pulse,
    pub(super) mailboxes: Vec<Arc<Mailbox>>,
    pub(super) events: Events,
    pub(super) loading: Loading,
    pub(super) metrics: Metrics,
    pub(super) open: OpenRequests,
    pub(super) watches: Watches,
    pub(super) next_number: u64,
    pub(super) status_clock: StatusClock,
    pub(super) is_draining: bool,
    /// It ends because its files were removed.
    pub(super) is_removed: bool,
    /// Last: requests and the janitor hold its node, and only the last to go can leave nothing
    /// behind.
    pub(super) server: Server,
}

/// Why a daemon does not serve any more.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Ended {
    /// Somebody asked it to stop.
    Stopped,
    /// Files by which its clients find it are gone.
    Removed,
}

impl EventLoop {
    /// Serves until somebody asks the daemon to stop, or its files are gone, and all requests have
    /// ended.
    ///
    /// # Errors
    /// A port that stopped working: the daemon cannot go on.
    pub(super) fn run(&mut self) -> Result<Ended, ServerError> {
        match self.serve() {
            Ok(()) if self.is_removed => Ok(Ended::Removed),
            Ok(()) => Ok(Ended::Stopped),
            // A port may be the first to notice.
            Err(_) if self.server.missing_file().is_some() => Ok(Ended::Removed),
            Err(error) => Err(error),
        }
    }

    /// What the daemon has loaded; lets go of the instance.
    pub(super) fn into_store(self) -> ModelStore {
        self.store
    }

    fn serve(&mut self) -> Result<(), ServerError> {
        let mut is_flooded = false;
        while !self.is_done() {
            let patience = self.patience(is_flooded);
            self.server.wait(patience)?;
            self.events.woke();
            is_flooded = self.round()?;
        }
        Ok(())
    }

    fn is_done(&self) -> bool {
        self.is_draining && self.open.is_empty() && self.keeping.is_idle()
    }

    /// Deals with what has come; tells whether more may be waiting.
    fn round(&mut self) -> Result<bool, ServerError> {
        self.handle_events()?;
        let more_requests = self.receive_requests()?;
        let more_controls = self.receive_controls()?;
        self.end_unwanted();
        self.publish_status_when_due()?;
        Ok(more_requests || more_controls)
    }

    /// Ends what nobody waits for any more.
    fn end_unwanted(&mut self) {
        self.end_abandoned();
        self.end_expired();
    }

    /// Lets workers and loader end, after [`Self::run`].
    pub(super) fn close(&mut self) {
        self.schedule.close();
        self.loading.close();
        self.preparer = None;
        self.keeping
            .close(self.is_draining && !self.is_removed);
        self.recorder.close();
        self.pulse.close();
    }

    /// How long to sleep unless somebody calls.
    fn patience(&self, is_flooded: bool) -> Duration {
        if is_flooded || !self.events.may_sleep() {
            Duration::ZERO
        } else {
            self.idle_time()
        }
    }

    /// How long nothing needs to be done by itself.
    fn idle_time(&self) -> Duration {
        let deadline_ns = self
            .schedule
            .next_deadline_ns()
            .unwrap_or(u64::MAX);
        let next_ns = deadline_ns.min(self.status_clock.next_ns());
        Duration::from_nanos(next_ns.saturating_sub(monotonic_ns()))
    }

    fn handle_events(&mut self) -> Result<(), ServerError> {
        while let Some(event) = self.events.next() {
            self.handle(event)?;
        }
        Ok(())
    }

    fn handle(&mut self, event: Event) -> Result<(), ServerError> {
        match event {
            Event::Improved { worker } => self.send_improvement(worker),
            Event::Answered(answered) => self.finish(*answered),
            Event::Loaded(loaded) => self.finish_load(*loaded)?,
            Event::Written { token, answer } => self.answer_control(token, &answer),
            Event::Kept(kept) => self.kept(&kept)?,
            Event::Stop => self.drain(),
        }
        Ok(())
    }

    pub(super) fn next_number(&mut self) -> u64 {
        self.next_number += 1;
        self.next_number
    }
}
