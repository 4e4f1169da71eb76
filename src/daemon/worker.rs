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
use super::translate::{self, Lengths};

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

/// One worker thread's own things.
pub(super) struct Worker {
    /// Its number.
    pub index: usize,
    /// Where its jobs come from.
    pub schedule: Arc<Schedule>,
    /// Where its improvements go.
    pub mailbox: Arc<Mailbox>,
    /// Where its answers go.
    pub events: EventSender,
    /// What the page shows, where there is one.
    pub live: Option<Arc<Live>>,
    /// Whether requests with [`PANIC_SEED`] panic and those with [`HANG_SEED`] hang.
    pub fault_injection: bool,
}

impl Worker {
    /// Starts the thread; it ends when the schedule is closed and nothing waits.
    pub(super) fn start(self) -> std::io::Result<JoinHandle<()>> {
        std::thread::Builder::new()
            .name(format!("taut-worker-{}", self.index))
            .spawn(move || self.work())
    }

    fn work(self) {
        let mut workspace = Workspace::default();
        while let Some((job, turn)) = self.schedule.take(self.index) {
            let turn = Cell::new(turn);
            self.show(|live| live.begin(&job));
            let computed = (!job.is_expired(monotonic_ns()))
                .then(|| self.compute(&job, &turn, &mut workspace));
            if let Some((outcome, code)) = computed
                .as_ref()
                .and_then(|computed| computed.outcome.as_ref())
            {
                self.show(|live| live.answered(&job, outcome, *code));
            }
            self.show(|live| live.ended(job.id));
            let mut turn = turn.into_inner();
            self.schedule.finish(&mut turn);
            let passed_ns = monotonic_ns().saturating_sub(job.received_ns);
            let panicked = computed.as_ref().is_some_and(|computed| computed.panicked);
            let (mut reply, way) = match computed {
                Some(Computed { reply, stopped, .. }) => (reply, Way::Computed(stopped)),
                None => (translate::expired(&job.snapshot, &job.path), Way::Untouched),
            };
            if panicked {
                tracing::error!(
                    request = job.request_id,
                    worker = self.index,
                    "{}",
                    reply.message()
                );
            }
            reply.header.compute_ns = turn.computed_ns;
            reply.header.queue_ns = passed_ns.saturating_sub(turn.computed_ns);
            let crashed = panicked.then(|| job.content());
            let answered = Answered {
                job: job.id,
                reply,
                way,
                pauses: turn.pauses,
                crashed,
            };
            self.events.send(Event::Answered(Box::new(answered)));
        }
    }

    fn show(&self, enter: impl FnOnce(&Live)) {
        if let Some(live) = &self.live {
            enter(live);
        }
    }

    fn tell(&self, told: &Told, now_ns: u64) {
        told.last_ns.set(now_ns);
        told.waits.set(false);
        self.events.send(Event::Improved { worker: self.index });
    }

    /// Computes a job, tells of its improvements on the way, and makes room for others.
    fn compute(&self, job: &Job, turn: &Cell<Turn>, workspace: &mut Workspace) -> Computed {
        let over = |now_ns| {
            job.stop
                .get()
                .or_else(|| job.is_expired(now_ns).then_some(StopCause::Deadline))
        };
        // The only place between two iterations where the outside comes in: others may go first, or
        // it is over.
        let asked_to_stop = |now_ns| {
            over(now_ns).or_else(|| {
                let mut at = turn.get();
                let cause = Cell::new(None);
                self.schedule.make_room(&mut at, now_ns, || {
                    cause.set(over(monotonic_ns()));
                    cause.get().is_some()
                });
                turn.set(at);
                cause.get()
            })
        };
        let panics = self.fault_injection && job.settings.seed == PANIC_SEED;
        let told = Told::default();
        let mut given_way_ns = 0;
        let mut stop = || {
            let now_ns = monotonic_ns();
            if now_ns >= given_way_ns + GIVE_WAY_NS {
                given_way_ns = now_ns;
                std::thread::yield_now();
            }
            if told.is_due(now_ns) {
                self.tell(&told, now_ns);
            }
            assert!(!panics, "injected fault");
            asked_to_stop(now_ns)
        };
        let hangs = self.fault_injection && job.settings.seed == HANG_SEED;
        let mut lengths = Lengths::new(&job.snapshot, &job.settings, &job.path);
        let mut publish = |improvement: Improvement| {
            let lengths = lengths.of(improvement.length);
            self.show(|live| live.improved(job.id, lengths[0], improvement.length));
            let header = translate::progress(&job.snapshot, &improvement, lengths);
            self.mailbox
                .put(job.id, &header, improvement.path.as_flat());
            told.waits.set(true);
            let now_ns = monotonic_ns();
            if told.is_due(now_ns) {
                self.tell(&told, now_ns);
            }
            while hangs && asked_to_stop(monotonic_ns()).is_none() {
                std::thread::sleep(Duration::from_millis(1));
            }
        };
        answer::answer(job.question(), workspace, &mut stop, &mut publish)
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
}
