//! The daemon's logic: what happens, and when, makes what is to be done.
//!
//! [`Service::handle`] is a function of events and time: no port, thread, disk or clock is in here,
//! and who asks is a [`client::Client`] with an identity, whatever it came through. The
//! [`shell`](super::shell) brings events and does what is to be done.

mod admission;
pub(crate) mod client;
mod clients;
mod contents;
mod control;
pub(crate) mod effect;
mod ending;
pub(crate) mod event;
mod frames;
mod give;
pub(crate) mod job;
mod keep;
pub(crate) mod keeping;
mod loading;
mod open_request;
mod poison;
pub(crate) mod reading;
mod recordings;
mod requests;
mod scenes;
pub(crate) mod schedule;
mod status;
mod status_clock;
#[cfg(test)]
mod tests;
mod watch;

use std::sync::Arc;

use taut::store::ModelStore;

use super::config::Config;
use super::observe::metrics::Metrics;
use super::observe::recording::Recorder;
use super::observe::story::Stories;
use clients::Clients;
use contents::Contents;
use effect::{Effect, Effects, InOrder};
use event::Event;
pub(crate) use frames::FRAMES_PER_ENTRY;
pub(crate) use keep::kept;
use keeping::Keeping;
use loading::Loading;
use open_request::OpenRequests;
use poison::Poison;
use schedule::{Granted, Pressure, Schedule};
use status_clock::StatusClock;

/// What the configuration says of every request.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Jobs that are computed at once.
    pub workers: usize,
    /// Requests that may wait.
    pub queue: usize,
    /// Clearance (m) of those that name none.
    pub clearance_m: f64,
}

impl Limits {
    pub(crate) fn of(config: &Config) -> Self {
        Self {
            workers: config.worker_count(),
            queue: config.queue,
            clearance_m: config.clearance_m,
        }
    }
}

/// What a service begins with besides its configuration.
pub(crate) struct Outfit {
    /// What is loaded.
    pub store: ModelStore,
    /// Counts what happens.
    pub metrics: Metrics,
    /// Remembers answers, and what is to be recorded.
    pub recorder: Recorder,
    /// Whether changes are kept on the disk.
    pub keeps: bool,
    /// Whether there is a page that shows what runs.
    pub shows: bool,
    /// Changes with every start.
    pub boot_id: u64,
    /// What threads that compute see.
    pub pressure: Arc<Pressure>,
}

/// The service: rooms of their own, and what is to be done next.
pub(crate) struct Service {
    store: ModelStore,
    schedule: Schedule,
    clients: Clients,
    open: OpenRequests,
    loading: Loading,
    contents: Contents,
    keeping: Keeping,
    poison: Poison,
    limits: Limits,
    stories: Stories,
    recorder: Recorder,
    metrics: Metrics,
    status_clock: StatusClock,
    /// When (ns) watches are to be looked at by themselves.
    watches_ns: u64,
    shows: bool,
    boot_id: u64,
    is_draining: bool,
    /// It ends because its files were removed.
    is_removed: bool,
    /// When (ns, monotonic) what is handled happened.
    now_ns: u64,
    effects: Effects,
}

impl Service {
    /// A service that nobody has asked anything.
    pub(crate) fn new(config: &Config, outfit: Outfit, now_ns: u64) -> Self {
        let limits = Limits::of(config);
        Self {
            store: outfit.store,
            schedule: Schedule::new(limits.workers, outfit.pressure),
            clients: Clients::new(config.quota, limits.workers),
            open: OpenRequests::default(),
            loading: Loading::default(),
            contents: Contents::new(config.files_mb * 1_000_000),
            keeping: Keeping::new(outfit.keeps),
            poison: Poison::default(),
            limits,
            stories: Stories::default(),
            recorder: outfit.recorder,
            metrics: outfit.metrics,
            status_clock: StatusClock::new(config.status_rate_hz, now_ns),
            shows: outfit.shows,
            boot_id: outfit.boot_id,
            watches_ns: u64::MAX,
            is_draining: false,
            is_removed: false,
            now_ns,
            effects: Effects::default(),
        }
    }

    /// Deals with what happened at `now_ns` (monotonic); gives what is to be done.
    pub(crate) fn handle(&mut self, event: Event, now_ns: u64) -> Effects {
        // Threads take the time before they get here.
        self.now_ns = self.now_ns.max(now_ns);
        self.dispatch(event);
        self.end_expired();
        self.look_at_watches();
        self.hand_over();
        std::mem::take(&mut self.effects)
    }

    /// When (ns, monotonic) something is to be done by itself: an [`Event::Tick`] then.
    pub(crate) fn next_ns(&self) -> u64 {
        let deadline_ns = self
            .schedule
            .next_deadline_ns()
            .unwrap_or(u64::MAX);
        deadline_ns
            .min(self.watches_ns)
            .min(self.status_clock.next_ns())
    }

    fn dispatch(&mut self, event: Event) {
        match event {
            Event::Asked(asked) => self.asked(*asked),
            Event::Read { ticket, read } => self.read(ticket, read),
            Event::Controlled {
                ticket,
                client,
                message,
                around,
            } => self.controlled(ticket, client, message, around),
            Event::Gone(ticket) => self.gone(ticket),
            Event::Hinted(ticket) => self.hinted(ticket),
            Event::Improved { ticket, header } => self.improved(ticket, header),
            Event::MayPause(ticket) => self.may_pause(ticket),
            Event::Over(ticket) => self.schedule.over(ticket, self.now_ns),
            Event::Answered(answered) => self.answered(*answered),
            Event::NotTold(ticket) => self.not_told(ticket),
            Event::Prepared => self.schedule.fill_slots(self.now_ns),
            Event::Loaded(loaded) => self.loaded(*loaded),
            Event::Framed(framed) => self.framed(*framed),
            Event::Checked { file, content } => self.checked(&file, content),
            Event::Written { ticket, answer } => self.effects.push(Effect::Reply(ticket, answer)),
            Event::Kept(kept) => self.kept(&kept),
            Event::Tick(around) => self.tick(around),
            Event::Stop => self.drain(),
            Event::Removed(missing) => self.drain_removed(&missing),
        }
    }

    /// Adds what rooms have written down to what is to be done.
    fn hand_over(&mut self) {
        let granted = self.schedule.granted().into_iter();
        self.effects
            .alone
            .extend(granted.map(|granted| match granted {
                Granted::Begin(job) => Effect::Begin(job),
                Granted::GoOn(job) => Effect::GoOn(job),
            }));
        self.effects.append(self.keeping.due());
        let lines = self.recorder.lines().map(InOrder::Record);
        self.effects.in_order.extend(lines);
    }

    /// Has something done that others see in order.
    fn in_order(&mut self, effect: InOrder) {
        self.effects.in_order(effect);
    }
}
