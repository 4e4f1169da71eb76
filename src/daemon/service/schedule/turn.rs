//! A job's turn at a slot.

use crate::daemon::service::job::Job;

/// A job that has been begun and not ended.
#[derive(Clone, Debug)]
pub(crate) struct Turn {
    /// The job.
    pub job: u64,
    /// Its client.
    pub client: u128,
    /// Its class.
    pub class: u32,
    /// On the monotonic clock; none = the end of time.
    pub deadline_ns: u64,
    /// Time that it has had a slot, of late: forgotten like what its client has had. A long job that
    /// counted all of it would wait for as long as others send short ones.
    pub used_ns: u64,
    /// How often it made room.
    pub pauses: u32,
    /// When it got its slot, and until when that is charged.
    begun_ns: u64,
    since_ns: u64,
    stands: Stands,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stands {
    /// Is computed.
    HasSlot,
    /// Has made room.
    Paused,
    /// Had made room, and ends without a slot.
    Over,
}

impl Turn {
    /// The turn of a job that gets a slot.
    pub(super) fn new(job: &Job, now_ns: u64) -> Self {
        Self {
            job: job.id,
            client: job.client.id,
            class: job.priority,
            deadline_ns: job.deadline_ns.unwrap_or(u64::MAX),
            used_ns: 0,
            pauses: 0,
            begun_ns: now_ns,
            since_ns: now_ns,
            stands: Stands::HasSlot,
        }
    }

    pub(super) fn has_slot(&self) -> bool {
        self.stands == Stands::HasSlot
    }

    pub(super) fn is_paused(&self) -> bool {
        self.stands == Stands::Paused
    }

    /// How long it has had its slot.
    pub(super) fn lasts_ns(&self) -> u64 {
        self.since_ns.saturating_sub(self.begun_ns)
    }

    /// Counts what was computed since it was last counted, and gives that.
    pub(super) fn charged_until(&mut self, now_ns: u64) -> u64 {
        if self.is_paused() {
            return 0;
        }
        let used_ns = now_ns.saturating_sub(self.since_ns);
        self.since_ns = now_ns;
        self.used_ns += used_ns;
        used_ns
    }

    /// It makes room.
    pub(super) fn pause(&mut self) {
        self.stands = Stands::Paused;
        self.pauses += 1;
    }

    /// It has a slot again.
    pub(super) fn goes_on(&mut self, now_ns: u64) {
        self.stands = Stands::HasSlot;
        self.since_ns = now_ns;
        self.begun_ns = now_ns;
    }

    /// If it waits for a slot, it ends without one: then true.
    pub(super) fn over(&mut self, now_ns: u64) -> bool {
        let is_paused = self.is_paused();
        if is_paused {
            self.stands = Stands::Over;
            self.since_ns = now_ns;
        }
        is_paused
    }
}
