//! How far the control messages of a client are.

use std::collections::VecDeque;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use zenoh::bytes::ZBytes;

/// The control messages of one client, one at a time.
#[derive(Debug, Default)]
pub(super) struct Controls {
    pub(super) waiting: AtomicU32,
    pub(super) done: Mutex<VecDeque<(u64, ZBytes)>>,
    /// Whether the daemon knows whom the port is for.
    pub(super) is_introduced: AtomicBool,
}

impl Controls {
    /// Whether any waits or is being done.
    pub(super) fn are_waiting(&self) -> bool {
        self.waiting.load(Ordering::Relaxed) > 0
    }
}
