//! How a recording goes, for both who hands over and who writes.

use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};

use taut_ipc::control::{RecordingState, Refusal};
use taut_ipc::wire::Code;

/// Bytes that may wait to be written; a slow disk does not fill the memory.
const WAITING_BYTES: u64 = 64 * 1024 * 1024;

/// What both sides count.
#[derive(Default)]
pub(crate) struct Counts {
    pub(super) requests: AtomicU64,
    pub(super) answers: AtomicU64,
    pub(super) missed: AtomicU64,
    pub(super) bytes: AtomicU64,
    waiting: AtomicU64,
    has_failed: AtomicBool,
    failure: Mutex<String>,
}

impl Counts {
    pub(super) fn begin(&self) {
        for count in [&self.requests, &self.answers, &self.missed, &self.bytes] {
            count.store(0, Relaxed);
        }
        self.has_failed.store(false, Relaxed);
    }

    pub(super) fn fail(&self, text: String) {
        tracing::error!("not recorded: {text}");
        *self
            .failure
            .lock()
            .unwrap_or_else(PoisonError::into_inner) = text;
        self.has_failed.store(true, Relaxed);
    }

    /// How the recording goes.
    pub(super) fn state(&self, file: &Path) -> Result<RecordingState, Refusal> {
        match self.failure() {
            Some(failure) => Err(Refusal::new(
                Code::ResourceExhausted,
                format!("not recorded: {failure}"),
            )),
            None => Ok(RecordingState {
                file: file.to_owned(),
                requests: self.requests.load(Relaxed),
                answers: self.answers.load(Relaxed),
                missed: self.missed.load(Relaxed),
                bytes: self.bytes.load(Relaxed),
            }),
        }
    }

    pub(super) fn has_failed(&self) -> bool {
        self.has_failed.load(Relaxed)
    }

    pub(super) fn failure(&self) -> Option<String> {
        let text = || {
            self.failure
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
        };
        self.has_failed().then(|| text().clone())
    }

    /// Whether so many bytes more may wait to be written; what may not is counted as missed.
    pub(super) fn takes(&self, bytes: u64) -> bool {
        let takes = self.waiting.load(Relaxed) + bytes <= WAITING_BYTES;
        match takes {
            true => self.waiting.fetch_add(bytes, Relaxed),
            false => self.missed.fetch_add(1, Relaxed),
        };
        takes
    }

    /// So many bytes wait no longer.
    pub(super) fn came(&self, bytes: usize) {
        self.waiting.fetch_sub(bytes as u64, Relaxed);
    }
}
