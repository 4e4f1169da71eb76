//! The requests of one client: those that run, and how the last ones ended.

use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use taut_ipc::client::Relayed;
use taut_ipc::limits::ACTIVE_REQUESTS_PER_CLIENT;
use zenoh::bytes::ZBytes;
use zenoh::query::Query;

/// How long final answers are kept.
const KEPT_FOR: Duration = Duration::from_secs(30);
/// How many of a client.
const MOST_KEPT: usize = 64;
/// And how many bytes, besides those of the last requests that it may have had in flight at once.
const MOST_BYTES: usize = 8 * 1024 * 1024;

/// A request that the daemon has.
#[derive(Debug)]
pub(super) struct Run {
    pub(super) request: u64,
    /// Gone once it was cancelled.
    pub(super) pending: Mutex<Option<Relayed>>,
    /// Who gets the answers: the last that asked.
    pub(super) query: Mutex<Query>,
}

/// The requests of one client.
#[derive(Debug, Default)]
pub(super) struct Runs {
    active: HashMap<u64, Arc<Run>>,
    kept: VecDeque<Kept>,
    bytes: usize,
}

#[derive(Debug)]
struct Kept {
    request: u64,
    answer: ZBytes,
    until: Instant,
}

/// What is known of a request.
pub(super) enum Known {
    /// It runs.
    Runs(Arc<Run>),
    /// It ended with this answer.
    Ended(ZBytes),
    /// Nothing.
    Nothing,
}

impl Runs {
    pub(super) fn find(&self, request: u64) -> Known {
        if let Some(run) = self.active.get(&request) {
            return Known::Runs(run.clone());
        }
        let kept = self
            .kept
            .iter()
            .find(|kept| kept.request == request);
        match kept {
            Some(kept) => Known::Ended(kept.answer.clone()),
            None => Known::Nothing,
        }
    }

    pub(super) fn begin(&mut self, request: u64, pending: Relayed, query: Query) {
        let run = Run {
            request,
            pending: Mutex::new(Some(pending)),
            query: Mutex::new(query),
        };
        self.active.insert(request, Arc::new(run));
    }

    /// Those that run now.
    pub(super) fn active(&self) -> Vec<Arc<Run>> {
        self.active.values().cloned().collect()
    }

    pub(super) fn is_idle(&self) -> bool {
        self.active.is_empty()
    }

    pub(super) fn remove(&mut self, request: u64) -> Option<Arc<Run>> {
        self.active.remove(&request)
    }

    /// A request has ended; false where it was cancelled meanwhile.
    pub(super) fn end(&mut self, request: u64, answer: ZBytes, now: Instant) -> bool {
        let was_active = self.active.remove(&request).is_some();
        if was_active {
            self.bytes += answer.len();
            let until = now + KEPT_FOR;
            self.kept.push_back(Kept {
                request,
                answer,
                until,
            });
            self.forget(now);
        }
        was_active
    }

    /// Lets answers go that are old or too many.
    pub(super) fn forget(&mut self, now: Instant) {
        while let Some(oldest) = self.kept.front() {
            let is_due = oldest.until <= now || self.has_too_much();
            if !is_due {
                return;
            }
            self.bytes -= oldest.answer.len();
            self.kept.pop_front();
        }
    }

    fn has_too_much(&self) -> bool {
        let is_large = self.bytes > MOST_BYTES && self.kept.len() > ACTIVE_REQUESTS_PER_CLIENT;
        is_large || self.kept.len() > MOST_KEPT
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept(count: u64, bytes: usize) -> Runs {
        let mut runs = Runs::default();
        let now = Instant::now();
        for request in 0..count {
            let answer = ZBytes::from(vec![0_u8; bytes]);
            let until = now + KEPT_FOR;
            runs.bytes += bytes;
            runs.kept.push_back(Kept {
                request,
                answer,
                until,
            });
            runs.forget(now);
        }
        runs
    }

    #[test]
    fn so_many_answers_are_kept_and_the_oldest_go_first() {
        let runs = kept(100, 8);
        assert!(matches!(runs.find(35), Known::Nothing));
        assert!(matches!(runs.find(36), Known::Ended(_)));
        assert_eq!(runs.kept.len(), MOST_KEPT);
        assert_eq!(runs.bytes, MOST_KEPT * 8);
    }

    #[test]
    fn so_many_bytes_are_kept() {
        assert_eq!(kept(20, 1 << 20).bytes, MOST_BYTES);
        // Those that may all be lost with a link.
        assert_eq!(kept(20, 16 << 20).kept.len(), ACTIVE_REQUESTS_PER_CLIENT);
    }

    #[test]
    fn old_answers_go() {
        let mut runs = kept(3, 8);
        runs.forget(Instant::now() + KEPT_FOR);
        assert_eq!((runs.kept.len(), runs.bytes), (0, 0));
    }
}
