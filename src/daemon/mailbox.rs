//! The newest improvement of a worker, on its way to the I/O thread.

use std::sync::{Mutex, MutexGuard, PoisonError};

use taut_ipc::wire::ResponseHeader;

/// One per worker and used again for every job: an improvement that the I/O thread has not fetched
/// yet is overwritten, because only the newest is worth sending, and memory stays as it is.
#[derive(Default)]
pub(super) struct Mailbox {
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    is_full: bool,
    progress: Progress,
}

/// A shorter path.
#[derive(Default)]
pub(super) struct Progress {
    /// The job.
    pub job: u64,
    /// Header of the response.
    pub header: ResponseHeader,
    /// The path, row by row.
    pub path: Vec<f64>,
}

impl Progress {
    /// In place, so that the path's memory stays.
    fn set(&mut self, job: u64, header: &ResponseHeader, path: &[f64]) {
        self.job = job;
        self.header = *header;
        self.path.clear();
        self.path.extend_from_slice(path);
    }
}

impl Mailbox {
    /// Puts an improvement in.
    pub(super) fn put(&self, job: u64, header: &ResponseHeader, path: &[f64]) {
        let mut state = self.lock();
        state.progress.set(job, header, path);
        state.is_full = true;
    }

    /// Hands over what is in it, in place.
    pub(super) fn fetch(&self, hand_over: impl FnOnce(&Progress)) {
        let mut state = self.lock();
        if std::mem::take(&mut state.is_full) {
            hand_over(&state.progress);
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}
