//! Jobs that wait for a worker: by priority, then in order of arrival.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use super::job::Job;

/// Where a job stands in the queue.
pub(super) type Place = (Reverse<u32>, u64);

/// The place of a job: higher priority first, then the order of its number.
pub(super) fn place(job: &Job) -> Place {
    (Reverse(job.priority), job.id)
}

/// The queue. The I/O thread holds the lock for a push or a removal only, so nobody waits on it for long.
#[derive(Default)]
pub(super) struct JobQueue {
    state: Mutex<State>,
    ready: Condvar,
}

#[derive(Default)]
struct State {
    jobs: BTreeMap<Place, Job>,
    closed: bool,
}

impl JobQueue {
    /// Adds a job.
    pub(super) fn push(&self, job: Job) {
        self.lock().jobs.insert(place(&job), job);
        self.ready.notify_one();
    }

    /// Waits for a job; `None` once the queue is closed.
    pub(super) fn take(&self) -> Option<Job> {
        let mut state = self.lock();
        loop {
            if let Some((_, job)) = state.jobs.pop_first() {
                return Some(job);
            }
            if state.closed {
                return None;
            }
            state = self.ready.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Takes a job out, if no worker has it yet.
    pub(super) fn remove(&self, place: Place) -> Option<Job> {
        self.lock().jobs.remove(&place)
    }

    /// Takes out the jobs whose deadline has passed.
    pub(super) fn take_expired(&self, now_ns: u64) -> Vec<Job> {
        let mut state = self.lock();
        let expired: Vec<Place> =
            state.jobs.iter().filter(|(_, job)| job.is_expired(now_ns)).map(|(place, _)| *place).collect();
        expired.iter().filter_map(|place| state.jobs.remove(place)).collect()
    }

    /// Takes all jobs out.
    pub(super) fn take_all(&self) -> Vec<Job> {
        std::mem::take(&mut self.lock().jobs).into_values().collect()
    }

    /// The next deadline of a job that waits.
    pub(super) fn next_deadline_ns(&self) -> Option<u64> {
        self.lock().jobs.values().filter_map(|job| job.deadline_ns).min()
    }

    /// Jobs that wait.
    pub(super) fn len(&self) -> usize {
        self.lock().jobs.len()
    }

    /// Ends the workers once the queue is empty.
    pub(super) fn close(&self) {
        self.lock().closed = true;
        self.ready.notify_all();
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // Nothing that can panic runs under the lock.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
