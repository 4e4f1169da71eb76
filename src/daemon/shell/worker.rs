//! A thread of the crew: it waits at the port when it is its turn, and computes.

use std::cell::{Cell, RefCell};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use taut::answer::{self, Answered as Computed, Found, Part};
use taut::optimize::{Improvement, Workspace};
use taut_ipc::monotonic_ns;
use taut_ipc::server::ServerError;
use taut_ipc::wire::{ResponseBody, ResponseHeader};

use super::crew::Duty;
use super::drive::Shell;
use crate::daemon::observe::live::Live;
use crate::daemon::service::event::{Answered, Event, Way};
use crate::daemon::service::job::{Job, StopCause};
use crate::daemon::threads::spawn_nice;
use crate::daemon::translate::{self, Lengths, Reply};

/// With `fault_injection` in the configuration, a request with this seed panics. For tests.
pub const PANIC_SEED: u64 = 0xfa17_fa17_fa17_fa17;
/// With `fault_injection`, a request with this seed stays at its first improvement until it is told
/// to stop: work that lasts, however fast the optimizers become. For tests.
pub const HANG_SEED: u64 = 0x4a46_4a46_4a46_4a46;
/// With `fault_injection`, a request with this seed ends the thread that computes it by a panic,
/// as a broken transport does. For tests.
pub const BREAK_SEED: u64 = 0xb4ea_b4ea_b4ea_b4ea;

/// Time (ns) between two improvements that a client is told of, and before the first: each wakes
/// its process, and only the newest is worth it. A job that is shorter is told of in its answer.
const TELL_NS: u64 = 2_000_000;

/// Time (ns) after which a worker lets threads go first that wait for its core, who is at the port and
/// clients: they take microseconds, and would wait out its time slice of milliseconds.
const GIVE_WAY_NS: u64 = 1_000_000;

/// Computing time (ns) after which a thread that rests is woken to go to the port, if nobody is
/// there: that costs both of them some microseconds, and most checks end before.
const PORT_NS: u64 = 500_000;
/// The same where another request could be computed at once.
const PORT_SOON_NS: u64 = 100_000;

/// Starts the crew; its threads end when it is closed and nothing is left to compute.
pub(super) fn start(
    shell: &Arc<Shell>,
    niceness: i32,
    fault_injection: bool,
) -> std::io::Result<Vec<JoinHandle<()>>> {
    let threads = 0..shell.crew.size();
    threads
        .map(|number| worker(number, shell, niceness, fault_injection))
        .collect()
}

fn worker(
    number: usize,
    shell: &Arc<Shell>,
    niceness: i32,
    fault_injection: bool,
) -> std::io::Result<JoinHandle<()>> {
    let worker = Worker {
        number,
        shell: Arc::clone(shell),
        fault_injection,
    };
    let name = format!("taut-worker-{number}");
    spawn_nice(&name, niceness, move || worker.work())
}

/// One thread's own things.
struct Worker {
    number: usize,
    shell: Arc<Shell>,
    /// Whether requests with [`PANIC_SEED`] panic and those with [`HANG_SEED`] hang.
    fault_injection: bool,
}

/// A thread that ends by a panic ends the daemon: whoever supervises it starts the next.
impl Drop for Worker {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.shell.break_off();
        }
    }
}

impl Worker {
    fn work(self) {
        loop {
            match self.shell.crew.duty(self.number) {
                Duty::Lead => self.lead(),
                Duty::Compute(job) => self.compute_all(job),
                Duty::End => return self.shell.stop_if_failed(),
            }
        }
    }

    /// Waits at the port until somebody else does, or the daemon ends.
    fn lead(&self) {
        if let Err(error) = self.try_lead() {
            self.shell.fail(error);
        }
    }

    fn try_lead(&self) -> Result<(), ServerError> {
        let crew = &self.shell.crew;
        // Who was here before may have left with the first that came.
        let mut may_sleep = false;
        while !crew.is_closed() {
            let Some(job) = self.shell.attend(&mut may_sleep)? else {
                continue;
            };
            crew.leave_port();
            self.compute_all(job);
            if !crew.return_to_port() {
                return Ok(());
            }
            may_sleep = false;
        }
        crew.leave_port();
        Ok(())
    }

    /// Computes a job, then those that get its slot.
    fn compute_all(&self, job: Box<Job>) {
        let away = Away::new();
        let mut workspace = self.shell.workspace();
        let mut next = Some(job);
        while let Some(job) = next {
            next = self.compute_one(&job, &away, &mut workspace);
            // Who was answered may have been woken on this core, and would wait out what comes next.
            std::thread::yield_now();
        }
        self.shell.put_workspace(workspace);
    }

    /// Computes a job and answers it; gives the next.
    fn compute_one(&self, job: &Job, away: &Away, workspace: &mut Workspace) -> Option<Box<Job>> {
        let work = Work::new(self, job, away);
        let computed = self.compute_shown(&work, workspace);
        assert!(
            !work.is_injected(BREAK_SEED),
            "injected fault of the service"
        );
        let answered = self.answered(&work, computed);
        self.shell
            .answered(Event::Answered(Box::new(answered)))
    }

    /// Computes a job whose time is not over, and has the page show it.
    fn compute_shown(&self, work: &Work, workspace: &mut Workspace) -> Option<Computed> {
        let job = work.job;
        self.show(|live| live.begin(job));
        let is_expired = job.is_expired(monotonic_ns());
        let computed = (!is_expired).then(|| work.compute(workspace));
        if let Some(computed) = &computed {
            self.show_answer(job, computed);
        }
        self.show(|live| live.ended(job.id));
        computed
    }

    fn show(&self, enter: impl FnOnce(&Live)) {
        if let Some(live) = &self.shell.live {
            enter(live);
        }
    }

    fn show_answer(&self, job: &Job, computed: &Computed) {
        if let Some((outcome, code)) = &computed.outcome {
            self.show(|live| live.answered(job, outcome, *code));
        }
    }

    fn answered(&self, work: &Work, computed: Option<Computed>) -> Answered {
        let job = work.job;
        let now_ns = monotonic_ns();
        let passed_ns = now_ns.saturating_sub(job.received_ns);
        let compute_ns = work.computed_ns(now_ns);
        let crashed = self.crashed(job, computed.as_ref());
        let (mut reply, way) = replied(job, computed);
        reply.header.compute_ns = compute_ns;
        reply.header.queue_ns = passed_ns.saturating_sub(compute_ns);
        Answered {
            ticket: job.id,
            reply,
            way,
            crashed,
        }
    }

    /// What was asked for, where the core panicked on it.
    fn crashed(&self, job: &Job, computed: Option<&Computed>) -> Option<u64> {
        let crash = computed.filter(|computed| computed.panicked)?;
        tracing::error!(
            request = job.request_id,
            worker = self.number,
            "{}",
            crash.reply.message()
        );
        Some(job.content())
    }
}

fn of_path(path: &[f64]) -> ResponseBody<'_> {
    ResponseBody {
        path,
        ..ResponseBody::default()
    }
}

/// What a client is told, and how that came about.
fn replied(job: &Job, computed: Option<Computed>) -> (Reply, Way) {
    match computed {
        Some(Computed { reply, stops, .. }) => (reply, Way::Computed(stops)),
        None => (translate::expired(&job.snapshot, &job.path), Way::Untouched),
    }
}

/// A job while it is computed.
struct Work<'a> {
    worker: &'a Worker,
    job: &'a Job,
    away: &'a Away,
    begun_ns: u64,
    /// Time that it has made room for others.
    paused_ns: Cell<u64>,
    /// When it last asked whether to make room.
    asked_ns: Cell<u64>,
    told: RefCell<Told>,
    /// When other threads were last let go first.
    given_way_ns: Cell<u64>,
}

impl<'a> Work<'a> {
    fn new(worker: &'a Worker, job: &'a Job, away: &'a Away) -> Self {
        let now_ns = monotonic_ns();
        Self {
            worker,
            job,
            away,
            begun_ns: now_ns,
            paused_ns: Cell::new(0),
            asked_ns: Cell::new(now_ns),
            told: RefCell::new(Told::since(now_ns)),
            given_way_ns: Cell::new(now_ns),
        }
    }

    /// Computes the job, tells of its improvements on the way, and makes room for others.
    fn compute(&self, workspace: &mut Workspace) -> Computed {
        let job = self.job;
        let mut lengths = Lengths::new(&job.snapshot, &job.settings, &job.path);
        let mut stop = |part| self.stop(part);
        let mut publish = |found: Found| match found {
            Found::Path(improvement) => {
                self.publish(&improvement, lengths.of(improvement.length));
            }
            Found::Times(reply) => self.publish_times(reply),
        };
        answer::answer(job.question(), workspace, &mut stop, &mut publish)
    }

    /// Time that it was computed, without pauses.
    fn computed_ns(&self, now_ns: u64) -> u64 {
        now_ns
            .saturating_sub(self.begun_ns)
            .saturating_sub(self.paused_ns.get())
    }

    fn keep_port_when_due(&self, now_ns: u64) {
        let after_ns = match self.worker.shell.pressure.has_free_slot() {
            true => PORT_SOON_NS,
            false => PORT_NS,
        };
        if now_ns >= self.away.since_ns + after_ns {
            self.keep_port();
        }
    }

    /// Somebody else goes to the port, if nobody is there.
    fn keep_port(&self) {
        if !self.away.port_is_kept.replace(true) {
            self.worker.shell.crew.send_to_port();
        }
    }

    /// Asked again and again on the way; a cause where the job is over.
    fn stop(&self, part: Part) -> Option<StopCause> {
        let now_ns = monotonic_ns();
        self.keep_port_when_due(now_ns);
        self.give_way(now_ns);
        self.tell_when_due(now_ns);
        assert!(!self.is_injected(PANIC_SEED), "injected fault");
        self.asked_to_stop(now_ns)
            .or_else(|| self.end_of(part, now_ns))
    }

    /// A part of a job may end before the others.
    fn end_of(&self, part: Part, now_ns: u64) -> Option<StopCause> {
        let deadline_ns = self.job.deadline_ns?;
        let is_over = part == Part::Path
            && self.job.timing.is_some()
            && now_ns >= answer::end_of_path_ns(self.begun_ns, deadline_ns);
        is_over.then_some(StopCause::Deadline)
    }

    /// A trajectory was found. Each is told of at once: they are few, and what was found of the path
    /// before is in it.
    fn publish_times(&self, reply: &Reply) {
        self.worker
            .shell
            .improved(self.job.id, &reply.header, reply.body());
        self.told.borrow_mut().now(monotonic_ns());
    }

    /// A shorter path was found.
    fn publish(&self, improvement: &Improvement, lengths: [f64; 3]) {
        self.show_improvement(improvement, lengths[0]);
        let asks_times = self.job.timing.is_some();
        let header = translate::progress(&self.job.snapshot, improvement, lengths, asks_times);
        let path = improvement.path.as_flat();
        let now_ns = monotonic_ns();
        if self.told.borrow().is_time(now_ns) {
            self.tell(&header, path, now_ns);
        } else {
            self.told.borrow_mut().keep(&header, path);
        }
        self.hang_if_injected();
    }

    fn tell(&self, header: &ResponseHeader, path: &[f64], now_ns: u64) {
        self.worker
            .shell
            .improved(self.job.id, header, of_path(path));
        self.told.borrow_mut().now(now_ns);
    }

    /// Tells of an improvement that nobody knows of.
    fn tell_when_due(&self, now_ns: u64) {
        let mut told = self.told.borrow_mut();
        if told.is_due(now_ns) {
            self.worker
                .shell
                .improved(self.job.id, &told.header, of_path(&told.path));
            told.now(now_ns);
        }
    }

    fn show_improvement(&self, improvement: &Improvement, length_before: f64) {
        let length = improvement.length;
        self.worker
            .show(|live| live.improved(self.job.id, length_before, length));
    }

    fn is_injected(&self, seed: u64) -> bool {
        self.worker.fault_injection && self.job.settings.seed == seed
    }

    fn hang_if_injected(&self) {
        let hangs = self.is_injected(HANG_SEED);
        while hangs && self.stop(Part::Path).is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn give_way(&self, now_ns: u64) {
        if now_ns >= self.given_way_ns.get() + GIVE_WAY_NS {
            self.given_way_ns.set(now_ns);
            std::thread::yield_now();
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
        self.over(now_ns).or_else(|| {
            let pressure = &self.worker.shell.pressure;
            let is_felt = pressure.is_felt(self.job.priority, self.asked_ns.get(), now_ns);
            is_felt
                .then(|| self.make_room(now_ns))
                .flatten()
        })
    }

    /// Lets others go first, if they are to; a cause where the job was over meanwhile.
    fn make_room(&self, now_ns: u64) -> Option<StopCause> {
        let shell = &self.worker.shell;
        let job = self.job.id;
        self.keep_port();
        shell.tell(Event::MayPause(job));
        let left = || self.left(monotonic_ns());
        let over = || self.over(monotonic_ns()).is_some();
        let has_rested = shell
            .rests
            .rest(job, left, over, || shell.tell(Event::Over(job)));
        let end_ns = monotonic_ns();
        self.asked_ns.set(end_ns);
        if !has_rested {
            return None;
        }
        let paused_ns = self.paused_ns.get() + end_ns.saturating_sub(now_ns);
        self.paused_ns.set(paused_ns);
        self.over(end_ns)
    }

    /// Time until its deadline.
    fn left(&self, now_ns: u64) -> Duration {
        let deadline_ns = self.job.deadline_ns.unwrap_or(u64::MAX);
        Duration::from_nanos(deadline_ns.saturating_sub(now_ns))
    }
}

/// A thread that computes, perhaps one job after the other, and is not at the port.
struct Away {
    since_ns: u64,
    /// Whether it was seen to that somebody is there.
    port_is_kept: Cell<bool>,
}

impl Away {
    fn new() -> Self {
        Self {
            since_ns: monotonic_ns(),
            port_is_kept: Cell::new(false),
        }
    }
}

/// What a client was told of a job's improvements.
#[derive(Default)]
struct Told {
    last_ns: u64,
    /// Whether there is one that it was not told of: these.
    waits: bool,
    header: ResponseHeader,
    path: Vec<f64>,
}

impl Told {
    /// Of a job that was begun then.
    fn since(begun_ns: u64) -> Self {
        Self {
            last_ns: begun_ns,
            ..Self::default()
        }
    }

    /// Whether it is time for another one.
    fn is_time(&self, now_ns: u64) -> bool {
        now_ns >= self.last_ns + TELL_NS
    }

    /// Whether there is something to tell, and it is time.
    fn is_due(&self, now_ns: u64) -> bool {
        self.waits && self.is_time(now_ns)
    }

    /// Keeps one for later.
    fn keep(&mut self, header: &ResponseHeader, path: &[f64]) {
        self.waits = true;
        self.header = *header;
        self.path.clear();
        self.path.extend_from_slice(path);
    }

    fn now(&mut self, now_ns: u64) {
        self.last_ns = now_ns;
        self.waits = false;
    }
}
