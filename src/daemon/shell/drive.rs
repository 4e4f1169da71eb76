//! The service among threads: events go in one at a time, what is to be done is done.

use std::collections::{BTreeMap, VecDeque};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use taut::optimize::Workspace;
use taut::store::ModelStore;
use taut_ipc::control::{ClientSummary, Refusal};
use taut_ipc::monotonic_ns;
use taut_ipc::server::ServerError;
use taut_ipc::wire::{ResponseBody, ResponseHeader, SceneEvent};

use super::crew::Crew;
use super::lines::Lines;
use super::port::Port;
use super::rests::Rests;
use crate::daemon::observe::live::Live;
use crate::daemon::service::Service;
use crate::daemon::service::effect::{Effect, InOrder};
use crate::daemon::service::event::{Event, Ticket};
use crate::daemon::service::job::Job;
use crate::daemon::service::schedule::Pressure;
use crate::daemon::threads::locked;
use crate::daemon::translate::Reply;

/// Messages taken in one round, so that a client that floods does not keep the port from what else
/// is to be done.
const ROUND: usize = 128;

/// What every thread of the daemon shares.
pub(super) struct Shell {
    service: Mutex<Service>,
    /// Until when (ns, monotonic) who waits at the port sleeps.
    sleeps_until_ns: AtomicU64,
    /// Gone once the daemon ends.
    lines: Mutex<Option<Lines>>,
    pub(super) crew: Crew,
    pub(super) rests: Rests,
    pub(super) pressure: Arc<Pressure>,
    /// What the page shows, where there is one.
    pub(super) live: Option<Arc<Live>>,
    /// The last one used is used next: what it holds is still warm.
    workspaces: Mutex<Vec<Workspace>>,
    failure: Mutex<Option<ServerError>>,
    /// Whether a thread of the crew ended by a panic.
    is_broken: AtomicBool,
    port: Port,
}

/// Why a daemon does not serve any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ended {
    /// It was asked to stop.
    Stopped,
    /// Files by which clients find it are gone.
    Removed,
}

/// What a thread has in hand while things are done.
#[derive(Default)]
pub(super) struct Hand<'a> {
    /// Whether it can compute a job.
    is_free: bool,
    /// The job that it computes next.
    job: Option<Box<Job>>,
    /// What is found on the way that it tells of.
    found: ResponseBody<'a>,
}

impl Hand<'_> {
    /// Of a thread that computes next what it can.
    pub(super) fn free() -> Self {
        Self {
            is_free: true,
            ..Self::default()
        }
    }
}

impl Shell {
    /// Threads of a crew of this size share these.
    pub(super) fn new(
        service: Service,
        port: Port,
        threads: usize,
        pressure: Arc<Pressure>,
        live: Option<Arc<Live>>,
    ) -> Self {
        Self {
            service: Mutex::new(service),
            sleeps_until_ns: AtomicU64::new(0),
            lines: Mutex::new(None),
            crew: Crew::new(threads),
            rests: Rests::default(),
            pressure,
            live,
            workspaces: Mutex::default(),
            failure: Mutex::new(None),
            is_broken: AtomicBool::new(false),
            port,
        }
    }

    /// Gives it the ways to other threads.
    pub(super) fn connect(&self, lines: Lines) {
        *locked(&self.lines) = Some(lines);
    }

    /// Lets the other threads end, once the crew has; gives why it did.
    ///
    /// # Errors
    /// A port that stopped working, unless its files are gone.
    pub(super) fn close(&self) -> Result<Ended, ServerError> {
        let failure = locked(&self.failure).take();
        let is_removed = self.service().is_removed();
        if let Some(lines) = locked(&self.lines).take() {
            lines.close(failure.is_none() && !is_removed);
        }
        match failure {
            _ if is_removed => Ok(Ended::Removed),
            Some(error) => Err(error),
            None => Ok(Ended::Stopped),
        }
    }

    /// What is loaded; closes the ports.
    pub(super) fn into_store(self) -> ModelStore {
        let service = self.service.into_inner();
        service
            .unwrap_or_else(PoisonError::into_inner)
            .into_store()
    }

    /// The service cannot go on.
    pub(super) fn fail(&self, error: ServerError) {
        locked(&self.failure).get_or_insert(error);
        self.end_crew();
    }

    /// A thread of the crew ends by a panic: so do the others.
    pub(super) fn break_off(&self) {
        self.is_broken.store(true, Ordering::Relaxed);
        self.end_crew();
    }

    /// After a failure, what is computed is to end too. A port may be the first to notice that
    /// files are gone.
    pub(super) fn stop_if_failed(&self) {
        if self.is_broken.load(Ordering::Relaxed) || locked(&self.failure).is_some() {
            self.tell(self.look_for_files().unwrap_or(Event::Stop));
        }
    }

    fn look_for_files(&self) -> Option<Event> {
        self.port.missing_file().map(Event::Removed)
    }

    /// Lets the crew end.
    fn end_crew(&self) {
        self.crew.close();
        self.port.wake();
    }

    /// Something happened, on a thread that does not compute.
    pub(super) fn tell(&self, event: Event) {
        self.drive(event, &mut Hand::default());
    }

    /// Has a look at the body of a control request, in place; `None` where its client is gone.
    pub(super) fn with_body<T>(
        &self,
        ticket: Ticket,
        look: impl FnOnce(&[u8]) -> Result<T, Refusal>,
    ) -> Option<Result<T, Refusal>> {
        self.port.with_body(ticket, look)
    }

    /// A job is done: its client is answered, and the next one taken that has a slot.
    pub(super) fn answered(&self, event: Event) -> Option<Box<Job>> {
        let mut hand = Hand::free();
        self.drive(event, &mut hand);
        hand.job
    }

    /// A job has a shorter path, or a faster trajectory.
    pub(super) fn improved(&self, ticket: Ticket, header: &ResponseHeader, found: ResponseBody) {
        let header = Box::new(*header);
        let mut hand = Hand {
            found,
            ..Hand::default()
        };
        self.drive(Event::Improved { ticket, header }, &mut hand);
    }

    /// Waits at the port and deals with what has come; gives the first job that is to be begun.
    /// `may_sleep` unless more may have come.
    pub(super) fn attend(&self, may_sleep: &mut bool) -> Result<Option<Box<Job>>, ServerError> {
        let mut hand = Hand::free();
        if *may_sleep {
            self.port.wait(self.patience())?;
            self.sleeps_until_ns.store(0, Ordering::Relaxed);
        } else {
            self.take_others(&mut hand)?;
        }
        let are_all = self.take_all(|| self.port.receive(), &mut hand)?;
        // A job is begun first; the rest comes after it, or from who is at the port next.
        *may_sleep = hand.job.is_none() && are_all && self.take_others(&mut hand)?;
        Ok(hand.job.or_else(|| self.crew.take()))
    }

    /// How long nothing is to be done by itself.
    fn patience(&self) -> Duration {
        let service = self.service();
        let next_ns = service.next_ns();
        // Under the lock: whoever makes it earlier wakes the sleeper.
        self.sleeps_until_ns
            .store(next_ns, Ordering::Relaxed);
        drop(service);
        Duration::from_nanos(next_ns.saturating_sub(monotonic_ns()))
    }

    /// Deals with what is no request; whether that was all.
    fn take_others(&self, hand: &mut Hand) -> Result<bool, ServerError> {
        for event in self.port.ended() {
            self.drive(event, hand);
        }
        self.tick_when_due(hand);
        self.take_all(|| self.port.receive_control(), hand)
    }

    /// Takes messages of one kind; whether those were all. What is left at the port has no order
    /// that is fair: the port gives them always by client.
    fn take_all(
        &self,
        receive: impl Fn() -> Result<Option<Event>, ServerError>,
        hand: &mut Hand,
    ) -> Result<bool, ServerError> {
        for _ in 0..ROUND {
            match receive()? {
                Some(event) => self.drive(event, hand),
                None => return Ok(true),
            }
        }
        Ok(false)
    }

    fn tick_when_due(&self, hand: &mut Hand) {
        let is_due = monotonic_ns() >= self.service().next_ns();
        if is_due {
            self.drive(Event::Tick(self.port.around()), hand);
        }
    }

    /// Something happened: does what is to be done, and what follows from that.
    fn drive(&self, event: Event, hand: &mut Hand) {
        let mut events = VecDeque::from([event]);
        while let Some(event) = events.pop_front() {
            let effects = self.handle(event, &mut events);
            let outcomes = effects
                .into_iter()
                .filter_map(|effect| self.perform(effect, hand));
            events.extend(outcomes);
        }
    }

    /// Has the service deal with an event. What others are told in the order in which it happened,
    /// they are told before the next event.
    fn handle(&self, event: Event, outcomes: &mut VecDeque<Event>) -> Vec<Effect> {
        let now_ns = monotonic_ns();
        let mut service = self.service();
        let effects = service.handle(event, now_ns);
        let in_order = effects.in_order.into_iter();
        outcomes.extend(in_order.filter_map(|effect| self.perform_in_order(effect)));
        self.wake_if_earlier(service.next_ns());
        if service.is_done() {
            self.end_crew();
        }
        effects.alone
    }

    /// Whoever waits at the port sleeps until something is to be done.
    fn wake_if_earlier(&self, next_ns: u64) {
        let sleeps_until_ns = self.sleeps_until_ns.load(Ordering::Relaxed);
        if next_ns < sleeps_until_ns {
            self.sleeps_until_ns.store(0, Ordering::Relaxed);
            self.port.wake();
        }
    }

    fn perform_in_order(&self, effect: InOrder) -> Option<Event> {
        let lines = locked(&self.lines);
        let lines = lines.as_ref()?;
        match effect {
            InOrder::Tell(ticket, reply, event) => {
                return self.tell_verdict(ticket, &reply, event.as_ref());
            }
            InOrder::Publish(event) => self.checked(self.port.publish(&event)),
            InOrder::Status(status) => {
                lines.pulse.beat();
                self.checked(self.port.publish_status(&status));
            }
            InOrder::Show(numbers, clients) => self.show(numbers, clients),
            InOrder::Prepare(model) => lines.prepare(model),
            InOrder::Load(task) => lines.load(task),
            InOrder::Frame(task) => lines.frame(*task),
            InOrder::Keep(entry) => lines.keep(entry),
            InOrder::Record(line) => lines.record(line),
        }
        None
    }

    fn show(&self, numbers: BTreeMap<String, f64>, clients: Vec<ClientSummary>) {
        if let Some(live) = &self.live {
            live.counted(numbers, clients);
        }
    }

    fn checked(&self, done: Result<(), ServerError>) {
        if let Err(error) = done {
            self.fail(error);
        }
    }

    /// Does what stands for itself; gives what follows from it.
    fn perform(&self, effect: Effect, hand: &mut Hand) -> Option<Event> {
        match effect {
            Effect::Read {
                ticket,
                snapshot,
                clearance_m,
            } => {
                let read = self.port.read(ticket, &snapshot, clearance_m)?;
                return Some(Event::Read { ticket, read });
            }
            Effect::LookForFiles => return self.look_for_files(),
            // One that does not arrive is followed by others, or by the answer.
            Effect::Improve(ticket, header) => {
                self.port.tell(ticket, &header, &hand.found);
            }
            Effect::Answer(ticket, reply) => self.port.answer(ticket, &reply),
            Effect::Refuse(ticket, refusal) => self.port.refuse(ticket, &refusal),
            Effect::Drop(ticket) => self.port.drop(ticket),
            Effect::Reply(ticket, reply) => self.port.reply(ticket, &reply),
            Effect::Begin(job) => self.begin(job, hand),
            Effect::Pause(ticket) => self.rests.pause(ticket),
            Effect::GoOn(ticket) => self.rests.go_on(ticket),
            Effect::Look(ticket) => self.rests.look(ticket),
        }
        None
    }

    /// Tells a client, and everybody who listens what became of its path.
    fn tell_verdict(
        &self,
        ticket: Ticket,
        reply: &Reply,
        event: Option<&SceneEvent>,
    ) -> Option<Event> {
        if !self
            .port
            .tell(ticket, &reply.header, &reply.body())
        {
            return Some(Event::NotTold(ticket));
        }
        if let Some(Err(error)) = event.map(|event| self.port.publish(event)) {
            tracing::warn!("that a watched path became unsafe was not published: {error}");
        }
        None
    }

    /// The first job that a free hand gets it keeps; others go to threads that rest.
    fn begin(&self, job: Box<Job>, hand: &mut Hand) {
        if hand.is_free && hand.job.is_none() {
            hand.job = Some(job);
        } else if !self.crew.hand_on(job) {
            self.port.wake();
        }
    }

    /// A workspace that nobody uses.
    pub(super) fn workspace(&self) -> Workspace {
        locked(&self.workspaces)
            .pop()
            .unwrap_or_default()
    }

    /// Gives a workspace back.
    pub(super) fn put_workspace(&self, workspace: Workspace) {
        locked(&self.workspaces).push(workspace);
    }

    fn service(&self) -> MutexGuard<'_, Service> {
        locked(&self.service)
    }
}
