//! Where jobs that have made room stand until they go on.

use std::collections::HashMap;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use crate::daemon::service::event::Ticket;
use crate::daemon::threads::locked;

/// Jobs that have made room. A job is told to pause once and to go on once, in whichever order the
/// two are done: by different threads.
#[derive(Default)]
pub(super) struct Rests(Mutex<HashMap<Ticket, Arc<Rest>>>);

#[derive(Default)]
struct Rest {
    /// How often it was told to go on, less how often to pause.
    told: Mutex<i32>,
    called: Condvar,
}

impl Rests {
    /// A job is to pause.
    pub(super) fn pause(&self, job: Ticket) {
        *locked(&self.of(job).told) -= 1;
    }

    /// A job is to go on.
    pub(super) fn go_on(&self, job: Ticket) {
        let rest = self.of(job);
        *locked(&rest.told) += 1;
        rest.called.notify_one();
    }

    /// A job that rests is to look whether it is over.
    pub(super) fn look(&self, job: Ticket) {
        if let Some(rest) = self.known(job) {
            // Who looks holds this until it sleeps.
            drop(locked(&rest.told));
            rest.called.notify_one();
        }
    }

    /// Rests until the job is to go on. `over` is asked each time that it is woken, and after
    /// `left`; once it says so, `end` is called, after which it is told to go on. Tells whether it
    /// was to pause at all.
    pub(super) fn rest(
        &self,
        job: Ticket,
        left: impl Fn() -> Duration,
        over: impl Fn() -> bool,
        end: impl FnOnce(),
    ) -> bool {
        let Some(rest) = self.known(job) else {
            return false;
        };
        if rest.until(left, over) {
            end();
            rest.until(|| Duration::MAX, || false);
        }
        locked(&self.0).remove(&job);
        true
    }

    fn known(&self, job: Ticket) -> Option<Arc<Rest>> {
        locked(&self.0).get(&job).cloned()
    }

    fn of(&self, job: Ticket) -> Arc<Rest> {
        locked(&self.0).entry(job).or_default().clone()
    }
}

impl Rest {
    /// Sleeps until the job is to go on, or is over: then true.
    fn until(&self, left: impl Fn() -> Duration, over: impl Fn() -> bool) -> bool {
        let mut told = locked(&self.told);
        while *told < 0 {
            if over() {
                return true;
            }
            let woken = self.called.wait_timeout(told, left());
            told = woken.unwrap_or_else(PoisonError::into_inner).0;
        }
        false
    }
}
