//! Workers: the threads that compute.

use std::cell::Cell;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use taut::answer::{self, Answered as Computed};
use taut::optimize::{Improvement, Workspace};
use taut_ipc::monotonic_ns;

use super::event::{Answered, Event, EventSender, Way};
use super::job::{Job, StopCause};
use super::live::Live;
use super::mailbox::Mailbox;
use super::schedule::{Schedule, Turn};
use super::threads::spawn_nice;
use super::translate::{self, Lengths, Reply};

/// With `fault_injection` in the configuration, a request with this seed panics. For tests.
pub const PANIC_SEED: u64 = 0xfa17_fa17_fa17_fa17;
/// With `fault_injection`, a request with this seed stays at its first improvement until it is told
/// to stop: work that lasts, however fast the optimizers become. For tests.
pub const HANG_SEED: u64 = 0x4a46_4a46_4a46_4a46;

/// Time (ns) between two improvements that a client is told of: each wakes two processes, and only
/// the newest is worth it. The first and the last are told at once.
const TELL_NS: u64 = 2_000_000;

/// Time (ns) after which a worker lets threads go first that wait for its core, the I/O thread and
/// clients: they take microseconds, and would wait out its time slice of milliseconds.
const GIVE_WAY_NS: u64 = 1_000_000;

/// Where each worker's improvements go, by its number.
pub(super) type Mailboxes = Vec<Arc<Mailbox>>;

/// What all workers share.
#[derive(Clone)]
pub(super) struct Crew {
    /// Where their jobs come from.
    pub schedule: Arc<Schedule>,
    /// Where their answers go.
    pub events: EventSender,
    /// What the page shows, where there is one.
    pub live: Option<Arc<Live>>,
    /// Whether requests with [`PANIC_SEED`] panic and those with [`HANG_SEED`] hang.
    pub fault_injection: bool,
    /// Niceness of their threads.
    pub niceness: i32,
}

impl Crew {
    /// Starts so many workers, and gives where their improvements go; their threads end when the
    /// schedule is closed and nothing waits.
    pub(super) fn start(self, count: usize) -> std::io::Result<(Mailboxes, Vec<JoinHandle<()>>)> {
        let mailboxes: Mailboxes = (0..count).map(|_| Arc::default()).collect();
        let threads = self.start_workers(&mailboxes)?;
        Ok((mailboxes, threads))
    }

    fn start_workers(&self, mailboxes: &[Arc<Mailbox>]) -> std::io::Result<Vec<JoinHandle<()>>> {
        let numbered = mailboxes.iter().cloned().enumerate();
        numbered
            .map(|(index, mailbox)| self.worker(index, mailbox).start())
            .collect()
    }

    fn worker(&self, index: usize, mailbox: Arc<Mailbox>) -> Worker {
        Worker {
            index,
            mailbox,
            crew: self.clone(),
        }
    }

    fn show(&self, enter: impl FnOnce(&Live)) {
        if let Some(live) = &self.live {
            enter(live);
        }
    }
}

/// One worker thread's own things.
struct Worker {
    /// Its number.
    index: usize,
    /// Where its improvements go.
    mailbox: Arc<Mailbox>,
    crew: Crew,
}

impl Worker {
    /// Starts the thread; it ends when the schedule is closed and nothing waits.
    fn start(self) -> std::io::Result<JoinHandle<()>> {
        let name = format!("taut-worker-{}", self.index);
        spawn_nice(&name, self.crew.niceness, || self.work())
    }

    fn work(self) {
        let mut workspace = Workspace::default();
        while let Some((job, turn)) = self.crew.schedule.take(self.index) {
            let turn = Cell::new(turn);
            let computed = self.compute_shown(&job, &turn, &mut workspace);
            let mut turn = turn.into_inner();
            self.crew.schedule.finish(&mut turn);
            self.answer(&job, &turn, computed);
        }
    }

    /// Computes a job whose time is not over, and has the page show it.
    fn compute_shown(
        &self,
        job: &Job,
        turn: &Cell<Turn>,
        workspace: &mut Workspace,
    ) -> Option<Computed> {
        self.crew.show(|live| live.begin(job));
        let is_expired = job.is_expired(monotonic_ns());
        let computed = (!is_expired).then(|| self.compute(job, turn, workspace));
        if let Some(computed) = &computed {
            self.show_answer(job, computed);
        }
        self.crew.show(|live| live.ended(job.id));
        computed
    }

    fn show_answer(&self, job: &Job, computed: &Computed) {
        if let Some((outcome, code)) = &computed.outcome {
            self.crew
                .show(|live| live.answered(job, outcome, *code));
        }
    }

    fn answer(&self, job: &Job, turn: &Turn, computed: Option<Computed>) {
        let passed_ns = monotonic_ns().saturating_sub(job.received_ns);
        let crashed = self.crashed(job, computed.as_ref());
        let (mut reply, way) = replied(job, computed);
        reply.header.compute_ns = turn.computed_ns;
        reply.header.queue_ns = passed_ns.saturating_sub(turn.computed_ns);
        let answered = Answered {
            job: job.id,
            reply,
            way,
            pauses: turn.pauses,
            crashed,
        };
        self.crew
            .events
            .send(Event::Answered(Box::new(answered)));
    }

    /// What was asked for, where the core panicked on it.
    fn crashed(&self, job: &Job, computed: Option<&Computed>) -> Option<u64> {
        let crash = computed.filter(|computed| computed.panicked)?;
        tracing::error!(
            request = job.request_id,
            worker = self.index,
            "{}",
            crash.reply.message()
        );
        Some(job.content())
    }

    /// Computes a job, tells of its improvements on the way, and makes room for others.
    fn compute(&self, job: &Job, turn: &Cell<Turn>, workspace: &mut Workspace) -> Computed {
        let work = Work {
            worker: self,
            job,
            turn,
            told: Told::default(),
            given_way_ns: Cell::new(0),
        };
        let mut lengths = Lengths::new(&job.snapshot, &job.settings, &job.path);
        let mut stop = || work.stop();
        let mut publish = |improvement: Improvement| {
            work.publish(&improvement, lengths.of(improvement.length));
        };
        answer::answer(job.question(), workspace, &mut stop, &mut publish)
    }
}

/// What a client is told, and how that came about.
fn replied(job: &Job, computed: Option<Computed>) -> (Reply, Way) {
    match computed {
        Some(Computed { reply, stopped, .. }) => (reply, Way::Computed(stopped)),
        None => (translate::expired(&job.snapshot, &job.path), Way::Untouched),
    }
}

/// A job while it is computed.
struct Work<'a> {
    worker: &'a Worker,
    job: &'a Job,
    turn: &'a Cell<Turn>,
    told: Told,
    /// When other threads were last let go first.
    given_way_ns: Cell<u64>,
}

impl Work<'_> {
    /// Asked again and again on the way; a cause where the job is over.
    fn stop(&self) -> Option<StopCause> {
        let now_ns = monotonic_ns();
        self.give_way(now_ns);
        self.tell_when_due(now_ns);
        assert!(!self.is_injected(PANIC_SEED), "injected fault");
        self.asked_to_stop(now_ns)
    }

    /// A shorter path was found.
    fn publish(&self, improvement: &Improvement, lengths: [f64; 3]) {
        self.show_improvement(improvement, lengths[0]);
        let header = translate::progress(&self.job.snapshot, improvement, lengths);
        let path = improvement.path.as_flat();
        self.worker
            .mailbox
            .put(self.job.id, &header, path);
        self.told.waits.set(true);
        self.tell_when_due(monotonic_ns());
        self.hang_if_injected();
    }

    fn show_improvement(&self, improvement: &Improvement, length_before: f64) {
        let crew = &self.worker.crew;
        let length = improvement.length;
        crew.show(|live| live.improved(self.job.id, length_before, length));
    }

    fn is_injected(&self, seed: u64) -> bool {
        self.worker.crew.fault_injection && self.job.settings.seed == seed
    }

    fn hang_if_injected(&self) {
        let hangs = self.is_injected(HANG_SEED);
        while hangs && self.asked_to_stop(monotonic_ns()).is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn give_way(&self, now_ns: u64) {
        if now_ns >= self.given_way_ns.get() + GIVE_WAY_NS {
            self.given_way_ns.set(now_ns);
            std::thread::yield_now();
        }
    }

    /// Tells the I/O thread of an improvement that it does not know of.
    fn tell_when_due(&self, now_ns: u64) {
        if self.told.is_due(now_ns) {
            self.told.now(now_ns);
            let worker = self.worker.index;
            self.worker
                .crew
                .events
                .send(Event::Improved { worker });
        }
    }

    fn over(&self, now_ns: u64) -> Option<StopCause> {
        let is_expired = self.job.is_expired(now_ns);
        let cause = self.job.stop.get();
        cause.or_else(|| is_expired.then_some(StopCause::Deadline))
    }

    /// The only place between two iterations where the outside comes in: it is over, or others may
    /// go first.
    fn asked_to_stop(&self, now_ns: u64) -> Option<StopCause> {
        self.over(now_ns)
            .or_else(|| self.make_room(now_ns))
    }

    /// Lets others go first; a cause where the job was over meanwhile.
    fn make_room(&self, now_ns: u64) -> Option<StopCause> {
        let mut turn = self.turn.get();
        let cause = Cell::new(None);
        let is_over = || {
            cause.set(self.over(monotonic_ns()));
            cause.get().is_some()
        };
        let schedule = &self.worker.crew.schedule;
        schedule.make_room(&mut turn, now_ns, is_over);
        self.turn.set(turn);
        cause.get()
    }
}

/// What the I/O thread was told of a job's improvements.
#[derive(Default)]
struct Told {
    last_ns: Cell<u64>,
    waits: Cell<bool>,
}

impl Told {
    /// Whether there is something to tell, and it is time.
    fn is_due(&self, now_ns: u64) -> bool {
        self.waits.get() && now_ns >= self.last_ns.get() + TELL_NS
    }

    fn now(&self, now_ns: u64) {
        self.last_ns.set(now_ns);
        self.waits.set(false);
    }
}
