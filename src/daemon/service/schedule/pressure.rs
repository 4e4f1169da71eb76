//! What threads that compute see of those that wait, without asking.

use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};

/// Computing time (ns) between two looks at who waits.
const LOOK_NS: u64 = 500_000;

/// Whether somebody waits for a slot: while nobody does, nobody needs to ask whether to make room.
#[derive(Debug, Default)]
pub(crate) struct Pressure {
    /// Jobs that could be computed now.
    ready: AtomicUsize,
    /// The highest class among them.
    urgent: AtomicU32,
    /// Slots that nobody has.
    free: AtomicUsize,
}

impl Pressure {
    pub(super) fn show(&self, ready: usize, highest_class: u32, free: usize) {
        self.free.store(free, Ordering::Relaxed);
        self.ready.store(ready, Ordering::Relaxed);
        self.urgent
            .store(highest_class, Ordering::Relaxed);
    }

    /// Whether another job could be begun at once.
    pub(crate) fn has_free_slot(&self) -> bool {
        self.free.load(Ordering::Relaxed) != 0
    }

    /// Whether a job of this class, which last asked at `asked_ns`, is to ask whether it makes
    /// room. Costs two reads.
    pub(crate) fn is_felt(&self, class: u32, asked_ns: u64, now_ns: u64) -> bool {
        let somebody_waits = self.ready.load(Ordering::Relaxed) != 0;
        let has_lasted = now_ns >= asked_ns + LOOK_NS;
        somebody_waits && (has_lasted || self.urgent.load(Ordering::Relaxed) > class)
    }
}
