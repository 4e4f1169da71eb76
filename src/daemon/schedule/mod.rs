//! Jobs that wait, and who computes when.
//!
//! There are as many *slots* as jobs may be computed at once, and more threads than slots: a long
//! job that has to make room gives up its slot where it stands and keeps its thread, so that it
//! goes on later as if nothing had been. Its answer is the same, bit for bit.

mod order;
#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use taut_ipc::monotonic_ns;

use super::job::Job;
use order::Standing;

/// Jobs that may have made room at once, for each slot; as many more only for a higher class.
const PAUSED_PER_SLOT: usize = 4;
/// By how much each interval between two jobs that are begun moves what is taken for usual.
const PACE: f64 = 0.1;
/// Computing time (ns) between two looks at who waits.
const LOOK_NS: u64 = 500_000;
/// After this time (ns) half of what a client has had is forgotten: who was greedy long ago, or
/// away, is as any other.
const HALF_LIFE_NS: f64 = 1e8;
/// Time (ns) between two times of forgetting.
const FORGET_NS: u64 = 5_000_000;

/// Threads that a schedule with this many slots needs.
pub(super) const fn threads(slots: usize) -> usize {
    slots * (1 + 2 * PAUSED_PER_SLOT)
}

/// Jobs that wait for a slot. Locks are held for a look through those that wait, never while
/// anything is computed.
pub(super) struct Schedule {
    state: Mutex<State>,
    /// Where each thread waits, for a job or, if its job has made room, for a slot.
    seats: Vec<Condvar>,
    /// Jobs that could be computed now: while there are none, nobody needs to look.
    ready: AtomicUsize,
    /// The highest class among them.
    urgent: AtomicU32,
}

struct State {
    free_slots: usize,
    slots: usize,
    /// Threads without a job, the last that had one last: what it computed with is still warm.
    idle: Vec<usize>,
    /// Not begun.
    waiting: Vec<Job>,
    /// Begun, without a slot.
    paused: Vec<Turn>,
    /// Given a slot, on their way to their thread.
    handed: Vec<(usize, Job)>,
    clients: HashMap<u128, Share>,
    /// When what clients have had was last halved in part.
    forgotten_ns: u64,
    begun: Begun,
    closed: bool,
}

/// How fast jobs are begun while others wait.
#[derive(Default)]
struct Begun {
    last_ns: Option<u64>,
    interval_ns: f64,
}

impl Begun {
    /// A job is begun; `others` wait.
    fn one(&mut self, others: usize) {
        let now_ns = monotonic_ns();
        if let Some(last_ns) = self.last_ns {
            self.interval_ns += PACE * (now_ns.saturating_sub(last_ns) as f64 - self.interval_ns);
        }
        self.last_ns = (others > 0).then_some(now_ns);
    }
}

/// What a client has had of the workers of late.
#[derive(Default)]
struct Share {
    used_ns: u64,
    jobs: usize,
}

/// A thread's turn at a job.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turn {
    /// The job.
    pub job: u64,
    /// Time that it was computed, without pauses.
    pub computed_ns: u64,
    /// How often it made room.
    pub pauses: u32,
    thread: usize,
    client: u128,
    class: u32,
    deadline_ns: u64,
    /// When it got its slot, and until when that is charged.
    begun_ns: u64,
    since_ns: u64,
    has_slot: bool,
}

impl Turn {
    /// The turn of a thread that gets a slot for a job.
    fn new(thread: usize, job: &Job) -> Self {
        let now_ns = monotonic_ns();
        Self {
            job: job.id,
            computed_ns: 0,
            pauses: 0,
            thread,
            client: job.client,
            class: job.priority,
            deadline_ns: job.deadline_ns.unwrap_or(u64::MAX),
            begun_ns: now_ns,
            since_ns: now_ns,
            has_slot: true,
        }
    }

    /// How long it has had its slot.
    fn lasts_ns(&self) -> u64 {
        self.since_ns.saturating_sub(self.begun_ns)
    }

    /// Counts what was computed since it was last counted, and gives that.
    fn charged_until(&mut self, now_ns: u64) -> u64 {
        let used_ns = now_ns.saturating_sub(self.since_ns);
        self.since_ns = now_ns;
        self.computed_ns += used_ns;
        used_ns
    }

    /// Time until its deadline.
    fn left(&self) -> Duration {
        Duration::from_nanos(self.deadline_ns.saturating_sub(monotonic_ns()))
    }

    /// It has a slot again.
    fn goes_on(&mut self) {
        self.has_slot = true;
        self.since_ns = monotonic_ns();
        self.begun_ns = self.since_ns;
    }

    fn standing(&self, clients: &HashMap<u128, Share>) -> Standing {
        standing(
            clients,
            self.client,
            self.class,
            Some(self.deadline_ns),
            self.job,
            self.computed_ns,
        )
    }
}

fn standing(
    clients: &HashMap<u128, Share>,
    client: u128,
    class: u32,
    deadline_ns: Option<u64>,
    number: u64,
    computed_ns: u64,
) -> Standing {
    let used_ns = clients
        .get(&client)
        .map_or(0, |share| share.used_ns);
    Standing {
        class,
        lead_ns: used_ns + computed_ns,
        deadline_ns: deadline_ns.unwrap_or(u64::MAX),
        number,
    }
}

impl State {
    /// Standings of the jobs that can be computed now: first those that wait, then those that have
    /// made room.
    fn standings(&self) -> impl Iterator<Item = Standing> + Clone {
        let waiting = self
            .ready_jobs()
            .map(|(_, job)| self.standing_of(job));
        waiting.chain(
            self.paused
                .iter()
                .map(|turn| turn.standing(&self.clients)),
        )
    }

    fn standing_of(&self, job: &Job) -> Standing {
        standing(
            &self.clients,
            job.client,
            job.priority,
            job.deadline_ns,
            job.id,
            0,
        )
    }

    /// Those whose model is made, by index.
    fn ready_jobs(&self) -> impl Iterator<Item = (usize, &Job)> + Clone {
        let is_of_use = !self.idle.is_empty();
        let waiting = self.waiting.iter().enumerate();
        waiting.filter(move |(_, job)| is_of_use && job.snapshot.model.is_ready())
    }

    fn charge(&mut self, turn: &mut Turn, now_ns: u64) {
        self.forget(now_ns);
        let used_ns = turn.charged_until(now_ns);
        if let Some(share) = self.clients.get_mut(&turn.client) {
            share.used_ns += used_ns;
        }
    }

    /// A turn is over, and its slot free.
    fn end(&mut self, turn: &mut Turn, now_ns: u64) {
        self.charge(turn, now_ns);
        self.leave(turn.client);
        self.free_slots += usize::from(turn.has_slot);
    }

    /// A client has one job more.
    fn enter(&mut self, client: u128, now_ns: u64) {
        self.forget(now_ns);
        self.clients.entry(client).or_default().jobs += 1;
    }

    fn forget(&mut self, now_ns: u64) {
        let passed_ns = now_ns.saturating_sub(self.forgotten_ns);
        if passed_ns >= FORGET_NS {
            self.forgotten_ns = now_ns;
            self.keep_part(0.5_f64.powf(passed_ns as f64 / HALF_LIFE_NS));
        }
    }

    /// Of what clients have had, only a part counts from now on.
    fn keep_part(&mut self, part: f64) {
        for share in self.clients.values_mut() {
            share.used_ns = (share.used_ns as f64 * part) as u64;
        }
        self.clients
            .retain(|_, share| share.jobs > 0 || share.used_ns > 0);
    }

    fn leave(&mut self, client: u128) {
        if let Some(share) = self.clients.get_mut(&client) {
            share.jobs -= 1;
        }
    }

    fn take_job(&mut self, index: usize) -> Job {
        let job = self.waiting.swap_remove(index);
        self.leave(job.client);
        job
    }

    fn take_waiting(&mut self, job: u64) -> Option<Job> {
        let index = self
            .waiting
            .iter()
            .position(|waiting| waiting.id == job)?;
        Some(self.take_job(index))
    }

    /// The highest class of those that can be computed now.
    fn highest_class(&self) -> u32 {
        let classes = self.standings().map(|standing| standing.class);
        classes.max().unwrap_or(0)
    }

    /// The next to be computed.
    fn best(&self) -> Option<Standing> {
        let standings: Vec<Standing> = self.standings().collect();
        order::next(standings.iter().copied()).map(|index| standings[index])
    }

    /// Jobs that wait and would be taken before this one.
    fn ahead_of(&self, standing: &Standing) -> usize {
        let waiting = self
            .waiting
            .iter()
            .map(|job| self.standing_of(job));
        waiting
            .filter(|job| !job.goes_after(standing))
            .count()
    }

    fn new(slots: usize) -> Self {
        Self {
            free_slots: slots,
            slots,
            idle: Vec::new(),
            waiting: Vec::new(),
            paused: Vec::new(),
            handed: Vec::new(),
            clients: HashMap::new(),
            forgotten_ns: 0,
            begun: Begun::default(),
            closed: false,
        }
    }

    /// The job that a thread was given.
    fn take_handed(&mut self, thread: usize) -> Option<Job> {
        let index = self
            .handed
            .iter()
            .position(|(to, _)| *to == thread)?;
        Some(self.handed.swap_remove(index).1)
    }

    fn paused_index(&self, job: u64) -> Option<usize> {
        self.paused
            .iter()
            .position(|paused| paused.job == job)
    }

    /// Whether a job has to let another one go first.
    fn yields(&self, turn: &Turn) -> bool {
        self.best().is_some_and(|best| {
            let own = turn.standing(&self.clients);
            self.may_pause(best.class > own.class) && own.yields_to(&best, turn.lasts_ns())
        })
    }

    fn may_pause(&self, for_higher_class: bool) -> bool {
        let factor = if for_higher_class { 2 } else { 1 };
        self.paused.len() < self.slots * PAUSED_PER_SLOT * factor
    }

    /// Gives a slot to whoever is next; gives their thread.
    fn fill_slot(&mut self) -> Option<usize> {
        let next = order::next(self.standings())?;
        let ready: Vec<usize> = self
            .ready_jobs()
            .map(|(index, _)| index)
            .collect();
        self.free_slots -= 1;
        match ready.get(next) {
            Some(&index) => Some(self.begin(index)),
            None => Some(
                self.paused
                    .swap_remove(next - ready.len())
                    .thread,
            ),
        }
    }

    /// Hands a job that waits to an idle thread.
    fn begin(&mut self, index: usize) -> usize {
        let Some(thread) = self.idle.pop() else {
            unreachable!("jobs are ready only for idle threads")
        };
        let job = self.waiting.swap_remove(index);
        self.begun.one(self.waiting.len());
        self.handed.push((thread, job));
        thread
    }

    /// Takes out those that were not begun and are meant, in order of arrival.
    fn take_where(&mut self, is_meant: impl Fn(&Job) -> bool) -> Vec<Job> {
        let meant = self.indices_where(is_meant).into_iter();
        // From the last on: taking one out moves only what stands after it.
        let mut taken: Vec<Job> = meant
            .rev()
            .map(|index| self.take_job(index))
            .collect();
        taken.sort_by_key(|job| job.id);
        taken
    }

    fn indices_where(&self, is_meant: impl Fn(&Job) -> bool) -> Vec<usize> {
        let waiting = self.waiting.iter().enumerate();
        let meant = waiting.filter(|(_, job)| is_meant(job));
        meant.map(|(index, _)| index).collect()
    }
}

impl Schedule {
    /// A schedule with this many slots and [`threads`] threads.
    pub(super) fn new(slots: usize) -> Self {
        Self {
            state: Mutex::new(State::new(slots)),
            seats: (0..threads(slots))
                .map(|_| Condvar::new())
                .collect(),
            ready: AtomicUsize::new(0),
            urgent: AtomicU32::new(0),
        }
    }

    /// Adds a job.
    pub(super) fn push(&self, job: Job) {
        let mut state = self.lock();
        state.enter(job.client, monotonic_ns());
        state.waiting.push(job);
        self.fill_slots(&mut state);
    }

    /// Looks again after a model was made that jobs wait for.
    pub(super) fn look_again(&self) {
        self.fill_slots(&mut self.lock());
    }

    /// Waits for a job for a thread; `None` once the schedule is closed and nothing waits.
    pub(super) fn take(&self, thread: usize) -> Option<(Job, Turn)> {
        let mut state = self.lock();
        state.idle.push(thread);
        self.fill_slots(&mut state);
        loop {
            if let Some(job) = state.take_handed(thread) {
                let turn = Turn::new(thread, &job);
                return Some((job, turn));
            }
            if state.closed && state.waiting.is_empty() {
                return None;
            }
            let woken = self.seats[thread].wait(state);
            state = woken.unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Where a job may make room for another; returns when it is to go on. `is_over` tells that it
    /// has to end, which needs no slot. Costs two reads where nobody waits.
    pub(super) fn make_room(&self, turn: &mut Turn, now_ns: u64, is_over: impl Fn() -> bool) {
        if !self.is_time_to_look(turn, now_ns) {
            return;
        }
        let mut state = self.lock();
        state.charge(turn, now_ns);
        if state.yields(turn) {
            self.pause(&mut state, turn);
            self.wait_for_slot(state, turn, is_over);
        }
    }

    fn is_time_to_look(&self, turn: &Turn, now_ns: u64) -> bool {
        let somebody_waits = self.ready.load(Ordering::Relaxed) != 0;
        let has_lasted = now_ns >= turn.since_ns + LOOK_NS;
        somebody_waits && turn.has_slot && (has_lasted || self.is_urgent(turn))
    }

    /// Whether a job of a higher class waits.
    fn is_urgent(&self, turn: &Turn) -> bool {
        self.urgent.load(Ordering::Relaxed) > turn.class
    }

    fn pause(&self, state: &mut State, turn: &mut Turn) {
        turn.has_slot = false;
        turn.pauses += 1;
        state.paused.push(*turn);
        state.free_slots += 1;
        self.fill_slots(state);
    }

    fn wait_for_slot(
        &self,
        mut state: MutexGuard<'_, State>,
        turn: &mut Turn,
        is_over: impl Fn() -> bool,
    ) {
        // Whoever gives a paused job a slot takes it from the list.
        while let Some(index) = state.paused_index(turn.job) {
            if is_over() {
                state.paused.swap_remove(index);
                self.fill_slots(&mut state);
                turn.since_ns = monotonic_ns();
                return;
            }
            state = self.sleep(state, turn);
        }
        turn.goes_on();
    }

    /// Sleeps until somebody wakes the turn's thread, or its deadline comes.
    fn sleep<'a>(&self, state: MutexGuard<'a, State>, turn: &Turn) -> MutexGuard<'a, State> {
        let woken = self.seats[turn.thread].wait_timeout(state, turn.left());
        woken.unwrap_or_else(PoisonError::into_inner).0
    }

    /// Ends a turn, whose job is answered.
    pub(super) fn finish(&self, turn: &mut Turn) {
        let mut state = self.lock();
        state.end(turn, monotonic_ns());
        self.fill_slots(&mut state);
    }

    /// Takes a job out, if it was not begun.
    pub(super) fn remove(&self, job: u64) -> Option<Job> {
        let mut state = self.lock();
        let job = state.take_waiting(job)?;
        self.fill_slots(&mut state);
        Some(job)
    }

    /// Lets a job look whether it is over, if it has made room.
    pub(super) fn wake(&self, job: u64) {
        let state = self.lock();
        if let Some(index) = state.paused_index(job) {
            self.seats[state.paused[index].thread].notify_one();
        }
    }

    /// Takes out the jobs that were not begun before their deadline.
    pub(super) fn take_expired(&self, now_ns: u64) -> Vec<Job> {
        self.take_where(|job| job.last_ns().is_some_and(|last| now_ns >= last))
    }

    /// Takes out all jobs that were not begun.
    pub(super) fn take_all(&self) -> Vec<Job> {
        self.take_where(|_| true)
    }

    fn take_where(&self, is_meant: impl Fn(&Job) -> bool) -> Vec<Job> {
        let mut state = self.lock();
        let taken = state.take_where(is_meant);
        self.fill_slots(&mut state);
        taken
    }

    /// The next deadline of a job that was not begun.
    pub(super) fn next_deadline_ns(&self) -> Option<u64> {
        self.lock()
            .waiting
            .iter()
            .filter_map(Job::last_ns)
            .min()
    }

    /// Jobs that were not begun.
    pub(super) fn waiting(&self) -> usize {
        self.lock().waiting.len()
    }

    /// When (ns from now) a job of this client, class and deadline would be begun, as fast as jobs
    /// are begun now.
    pub(super) fn wait_ns(&self, client: u128, class: u32, deadline_ns: Option<u64>) -> u64 {
        let state = self.lock();
        let new = standing(&state.clients, client, class, deadline_ns, u64::MAX, 0);
        (state.ahead_of(&new) as f64 * state.begun.interval_ns) as u64
    }

    /// Ends the threads once nothing waits.
    pub(super) fn close(&self) {
        self.lock().closed = true;
        self.seats.iter().for_each(Condvar::notify_one);
    }

    /// Gives every free slot to whoever is next. The one place where jobs get slots.
    fn fill_slots(&self, state: &mut State) {
        while state.free_slots > 0 {
            let Some(thread) = state.fill_slot() else {
                break;
            };
            self.seats[thread].notify_one();
        }
        self.show_ready(state);
    }

    /// Lets the threads that compute see whether somebody waits.
    fn show_ready(&self, state: &State) {
        let count = state.standings().count();
        self.ready.store(count, Ordering::Relaxed);
        self.urgent
            .store(state.highest_class(), Ordering::Relaxed);
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // Nothing that can panic runs under the lock.
        self.state
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}
