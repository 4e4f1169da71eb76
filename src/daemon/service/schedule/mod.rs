//! Jobs that wait, and who computes when.
//!
//! There are as many *slots* as jobs may be computed at once. A long job that has to make room gives
//! up its slot where it stands and keeps its thread, so that it goes on later as if nothing had
//! been: its answer is the same, bit for bit. Nothing here waits: what gets a slot is written down,
//! and [`Schedule::granted`] hands it over.

mod order;
mod pressure;
#[cfg(test)]
mod tests;
mod turn;

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use super::job::Job;
use order::Standing;
pub(crate) use pressure::Pressure;
pub(crate) use turn::Turn;

/// Jobs that may have made room at once, for each slot; as many more only for a higher class.
const PAUSED_PER_SLOT: usize = 4;
/// By how much each interval between two jobs that are begun moves what is taken for usual.
const PACE: f64 = 0.1;
/// After this time (ns) half of what a client or job has had is forgotten: who was greedy long ago,
/// or away, is as any other.
const HALF_LIFE_NS: f64 = 1e8;
/// Time (ns) between two times of forgetting.
const FORGET_NS: u64 = 5_000_000;

/// Jobs that may be begun and not ended at once, each on a thread of its own.
pub(crate) const fn most_begun(slots: usize) -> usize {
    slots * (1 + 2 * PAUSED_PER_SLOT)
}

/// What has got a slot.
pub(crate) enum Granted {
    /// A job that is to be begun.
    Begin(Box<Job>),
    /// A job that had made room and goes on, or ends.
    GoOn(u64),
}

/// Jobs that wait for a slot, and those that have been begun.
pub(crate) struct Schedule {
    free_slots: usize,
    slots: usize,
    /// Not begun.
    waiting: Vec<Job>,
    /// Begun and not ended, by number.
    begun: BTreeMap<u64, Turn>,
    clients: HashMap<u128, Share>,
    /// When what clients have had was last halved in part.
    forgotten_ns: u64,
    pace: Pace,
    granted: Vec<Granted>,
    pressure: Arc<Pressure>,
}

/// How fast jobs are begun while others wait.
#[derive(Default)]
struct Pace {
    last_ns: Option<u64>,
    interval_ns: f64,
}

impl Pace {
    /// A job is begun; `others` wait.
    fn one(&mut self, others: usize, now_ns: u64) {
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

/// A job that could be computed now.
#[derive(Clone, Copy)]
enum Candidate<'a> {
    /// Waits, at this index.
    Waiting(usize, &'a Job),
    /// Has made room.
    Paused(&'a Turn),
}

impl Candidate<'_> {
    fn class(self) -> u32 {
        match self {
            Self::Waiting(_, job) => job.priority,
            Self::Paused(turn) => turn.class,
        }
    }

    fn chosen(self) -> Chosen {
        match self {
            Self::Waiting(index, _) => Chosen::Waiting(index),
            Self::Paused(turn) => Chosen::Paused(turn.job),
        }
    }
}

/// The next to be computed.
enum Chosen {
    /// In [`Schedule::waiting`], at this index.
    Waiting(usize),
    /// Has made room.
    Paused(u64),
}

impl Schedule {
    /// A schedule with this many slots, which shows through `pressure` who waits.
    pub(crate) fn new(slots: usize, pressure: Arc<Pressure>) -> Self {
        Self {
            free_slots: slots,
            slots,
            waiting: Vec::new(),
            begun: BTreeMap::new(),
            clients: HashMap::new(),
            forgotten_ns: 0,
            pace: Pace::default(),
            granted: Vec::new(),
            pressure,
        }
    }

    /// Takes what has got a slot since this was last asked.
    pub(crate) fn granted(&mut self) -> Vec<Granted> {
        std::mem::take(&mut self.granted)
    }

    /// Adds a job.
    pub(crate) fn push(&mut self, job: Job, now_ns: u64) {
        self.enter(job.client.id, now_ns);
        self.waiting.push(job);
        self.fill_slots(now_ns);
    }

    /// Gives every free slot to whoever is next; to be asked again after a model was made that jobs
    /// wait for. The one place where jobs get slots.
    pub(crate) fn fill_slots(&mut self, now_ns: u64) {
        while self.free_slots > 0 {
            let Some(chosen) = self.next() else {
                break;
            };
            self.free_slots -= 1;
            let granted = self.grant(chosen, now_ns);
            self.granted.push(granted);
        }
        self.show();
    }

    fn grant(&mut self, chosen: Chosen, now_ns: u64) -> Granted {
        match chosen {
            Chosen::Waiting(index) => Granted::Begin(Box::new(self.begin(index, now_ns))),
            Chosen::Paused(job) => {
                if let Some(turn) = self.begun.get_mut(&job) {
                    turn.goes_on(now_ns);
                }
                Granted::GoOn(job)
            }
        }
    }

    fn begin(&mut self, index: usize, now_ns: u64) -> Job {
        let job = self.waiting.swap_remove(index);
        self.pace.one(self.waiting.len(), now_ns);
        self.begun
            .insert(job.id, Turn::new(&job, now_ns));
        job
    }

    /// Lets the threads that compute see whether somebody waits.
    fn show(&self) {
        let classes = || self.candidates().map(Candidate::class);
        let highest = classes().max().unwrap_or(0);
        self.pressure
            .show(classes().count(), highest, self.free_slots);
    }

    /// Whether a job that is computed has to let another one go first; it has then given up its
    /// slot.
    pub(crate) fn makes_room(&mut self, job: u64, now_ns: u64) -> bool {
        self.charge(job, now_ns);
        let makes_room = self
            .begun
            .get(&job)
            .is_some_and(|turn| self.yields(turn));
        if makes_room {
            self.pause(job, now_ns);
        }
        makes_room
    }

    fn pause(&mut self, job: u64, now_ns: u64) {
        if let Some(turn) = self.begun.get_mut(&job) {
            turn.pause();
        }
        self.free_slots += 1;
        self.fill_slots(now_ns);
    }

    /// A job that has made room goes on without a slot, to its end.
    pub(crate) fn over(&mut self, job: u64, now_ns: u64) {
        if let Some(turn) = self.begun.get_mut(&job)
            && turn.over(now_ns)
        {
            self.granted.push(Granted::GoOn(job));
        }
        self.fill_slots(now_ns);
    }

    /// Ends a turn, whose job is answered.
    pub(crate) fn finish(&mut self, job: u64, now_ns: u64) -> Option<Turn> {
        self.charge(job, now_ns);
        let turn = self.begun.remove(&job)?;
        self.leave(turn.client);
        self.free_slots += usize::from(turn.has_slot());
        self.fill_slots(now_ns);
        Some(turn)
    }

    /// Takes a job out, if it was not begun.
    pub(crate) fn remove(&mut self, job: u64, now_ns: u64) -> Option<Job> {
        self.take_where(|waiting| waiting.id == job, now_ns)
            .pop()
    }

    /// Whether a job has made room and waits for a slot.
    pub(crate) fn is_paused(&self, job: u64) -> bool {
        self.begun
            .get(&job)
            .is_some_and(Turn::is_paused)
    }

    /// Takes out the jobs that were not begun before their deadline.
    pub(crate) fn take_expired(&mut self, now_ns: u64) -> Vec<Job> {
        self.take_where(
            |job| job.last_ns().is_some_and(|last| now_ns >= last),
            now_ns,
        )
    }

    /// Takes out all jobs that were not begun.
    pub(crate) fn take_all(&mut self, now_ns: u64) -> Vec<Job> {
        self.take_where(|_| true, now_ns)
    }

    /// Takes out those that were not begun and are meant, in order of arrival.
    fn take_where(&mut self, is_meant: impl Fn(&Job) -> bool, now_ns: u64) -> Vec<Job> {
        let mut taken: Vec<Job> = self
            .waiting
            .extract_if(.., |job| is_meant(job))
            .collect();
        if !taken.is_empty() {
            taken.sort_by_key(|job| job.id);
            taken
                .iter()
                .for_each(|job| self.leave(job.client.id));
            self.fill_slots(now_ns);
        }
        taken
    }

    /// The next deadline of a job that was not begun.
    pub(crate) fn next_deadline_ns(&self) -> Option<u64> {
        self.waiting
            .iter()
            .filter_map(Job::last_ns)
            .min()
    }

    /// Jobs that were not begun.
    pub(crate) fn waiting(&self) -> usize {
        self.waiting.len()
    }

    /// When (ns from now) a job of this client, class and deadline would be begun, as fast as jobs
    /// are begun now.
    pub(crate) fn wait_ns(&self, client: u128, class: u32, deadline_ns: Option<u64>) -> u64 {
        let new = self.standing(client, class, deadline_ns, u64::MAX, 0);
        (self.ahead_of(&new) as f64 * self.pace.interval_ns) as u64
    }

    fn standing(
        &self,
        client: u128,
        class: u32,
        deadline_ns: Option<u64>,
        number: u64,
        of_job_ns: u64,
    ) -> Standing {
        let of_client_ns = self
            .clients
            .get(&client)
            .map_or(0, |share| share.used_ns);
        Standing {
            class,
            lead_ns: of_client_ns + of_job_ns,
            deadline_ns: deadline_ns.unwrap_or(u64::MAX),
            number,
        }
    }

    fn standing_of(&self, job: &Job) -> Standing {
        self.standing(job.client.id, job.priority, job.deadline_ns, job.id, 0)
    }

    fn standing_of_turn(&self, turn: &Turn) -> Standing {
        let deadline_ns = Some(turn.deadline_ns);
        self.standing(turn.client, turn.class, deadline_ns, turn.job, turn.used_ns)
    }

    fn standing_of_candidate(&self, candidate: Candidate) -> Standing {
        match candidate {
            Candidate::Waiting(_, job) => self.standing_of(job),
            Candidate::Paused(turn) => self.standing_of_turn(turn),
        }
    }

    /// The jobs that can be computed now: first those that wait, then those that have made room.
    fn candidates(&self) -> impl Iterator<Item = Candidate<'_>> + Clone {
        let waiting = self.waiting.iter().enumerate();
        let ready = waiting.filter(|(_, job)| job.snapshot.model.is_ready());
        let ready = ready.map(|(index, job)| Candidate::Waiting(index, job));
        ready.chain(self.paused().map(Candidate::Paused))
    }

    /// Those that have made room.
    fn paused(&self) -> impl Iterator<Item = &Turn> + Clone {
        self.begun
            .values()
            .filter(|turn| turn.is_paused())
    }

    /// Begun jobs that have a thread and no slot: also those that are on their way to their end.
    fn without_slot(&self) -> usize {
        self.begun
            .values()
            .filter(|turn| !turn.has_slot())
            .count()
    }

    /// The next to be computed.
    fn next(&self) -> Option<Chosen> {
        let standings = self.standings();
        let index = order::next(standings.iter().copied())?;
        self.candidates()
            .nth(index)
            .map(Candidate::chosen)
    }

    fn best(&self) -> Option<Standing> {
        let standings = self.standings();
        order::next(standings.iter().copied()).map(|index| standings[index])
    }

    fn standings(&self) -> Vec<Standing> {
        self.candidates()
            .map(|candidate| self.standing_of_candidate(candidate))
            .collect()
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

    /// Whether a job has to let another one go first.
    fn yields(&self, turn: &Turn) -> bool {
        self.best().is_some_and(|best| {
            let own = self.standing_of_turn(turn);
            self.may_pause(best.class > own.class) && own.yields_to(&best, turn.lasts_ns())
        })
    }

    fn may_pause(&self, for_higher_class: bool) -> bool {
        let factor = if for_higher_class { 2 } else { 1 };
        self.without_slot() < self.slots * PAUSED_PER_SLOT * factor
    }

    /// Counts on its client's account what a job was computed since it was last counted.
    fn charge(&mut self, job: u64, now_ns: u64) {
        self.forget(now_ns);
        let Some(turn) = self.begun.get_mut(&job) else {
            return;
        };
        let used_ns = turn.charged_until(now_ns);
        if let Some(share) = self.clients.get_mut(&turn.client) {
            share.used_ns += used_ns;
        }
    }

    /// A client has one job more.
    fn enter(&mut self, client: u128, now_ns: u64) {
        self.forget(now_ns);
        self.clients.entry(client).or_default().jobs += 1;
    }

    fn leave(&mut self, client: u128) {
        if let Some(share) = self.clients.get_mut(&client) {
            share.jobs -= 1;
        }
    }

    fn forget(&mut self, now_ns: u64) {
        let passed_ns = now_ns.saturating_sub(self.forgotten_ns);
        if passed_ns >= FORGET_NS {
            self.forgotten_ns = now_ns;
            self.keep_part(0.5_f64.powf(passed_ns as f64 / HALF_LIFE_NS));
        }
    }

    /// Of what clients and jobs have had, only a part counts from now on.
    fn keep_part(&mut self, part: f64) {
        let shares = self.clients.values_mut();
        let turns = self.begun.values_mut();
        let used = shares
            .map(|share| &mut share.used_ns)
            .chain(turns.map(|turn| &mut turn.used_ns));
        used.for_each(|used_ns| *used_ns = (*used_ns as f64 * part) as u64);
        self.clients
            .retain(|_, share| share.jobs > 0 || share.used_ns > 0);
    }
}
