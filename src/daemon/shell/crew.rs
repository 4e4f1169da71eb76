//! Who of the crew does what: one thread waits at the port, the others rest until there is
//! something to compute.
//!
//! Whoever has a request in hand computes it where it stands: that saves a hop to another thread
//! and back. The port is handed on when that takes longer, or when there is more to do at once. The
//! thread that rested last is woken first, for what it computed with is still warm.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use crate::daemon::service::job::Job;

/// What a thread is to do next.
pub(super) enum Duty {
    /// Wait at the port.
    Lead,
    /// Compute this.
    Compute(Box<Job>),
    /// End.
    End,
}

/// The crew's threads, by number.
pub(super) struct Crew {
    state: Mutex<State>,
    /// Where each thread rests.
    seats: Vec<Condvar>,
}

#[derive(Default)]
struct State {
    /// Threads that rest; who came last is woken first.
    resting: Vec<usize>,
    /// Jobs that have a slot and no thread yet.
    jobs: VecDeque<Box<Job>>,
    has_leader: bool,
    is_closed: bool,
}

impl Crew {
    /// Seats for so many threads.
    pub(super) fn new(threads: usize) -> Self {
        let seats = (0..threads).map(|_| Condvar::new());
        Self {
            state: Mutex::default(),
            seats: seats.collect(),
        }
    }

    /// How many threads it has.
    pub(super) fn size(&self) -> usize {
        self.seats.len()
    }

    /// What a thread is to do next; it rests until there is something.
    pub(super) fn duty(&self, thread: usize) -> Duty {
        let mut state = self.lock();
        loop {
            if let Some(duty) = state.duty() {
                return duty;
            }
            state.resting.push(thread);
            let woken = self.seats[thread].wait(state);
            state = woken.unwrap_or_else(PoisonError::into_inner);
            // Nobody may have woken it.
            state
                .resting
                .retain(|resting| *resting != thread);
        }
    }

    /// Gives a job to a thread that rests; false where none does, and whoever waits at the port has
    /// to be woken.
    pub(super) fn hand_on(&self, job: Box<Job>) -> bool {
        let mut state = self.lock();
        state.jobs.push_back(job);
        self.wake_one(&mut state)
    }

    /// A job that was handed on and that no other thread has taken.
    pub(super) fn take(&self) -> Option<Box<Job>> {
        self.lock().jobs.pop_front()
    }

    /// Who waits at the port has something else to do: another one goes there.
    pub(super) fn hand_port_on(&self) {
        let mut state = self.lock();
        state.has_leader = false;
        self.wake_one(&mut state);
    }

    /// Lets all threads end.
    pub(super) fn close(&self) {
        self.lock().is_closed = true;
        self.seats.iter().for_each(Condvar::notify_one);
    }

    /// Whether they are to end.
    pub(super) fn is_closed(&self) -> bool {
        self.lock().is_closed
    }

    fn wake_one(&self, state: &mut State) -> bool {
        match state.resting.pop() {
            Some(thread) => {
                self.seats[thread].notify_one();
                true
            }
            None => false,
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // Nothing that can panic runs under the lock.
        self.state
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn duty(&mut self) -> Option<Duty> {
        if let Some(job) = self.jobs.pop_front() {
            return Some(Duty::Compute(job));
        }
        if self.is_closed {
            return Some(Duty::End);
        }
        let leads = !std::mem::replace(&mut self.has_leader, true);
        leads.then_some(Duty::Lead)
    }
}
