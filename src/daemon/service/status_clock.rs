//! When the next status message is due.

/// Ticks once a period.
pub(crate) struct StatusClock {
    period_ns: u64,
    next_ns: u64,
}

impl StatusClock {
    /// Due at once, then at this rate.
    pub(crate) fn new(rate_hz: f64, now_ns: u64) -> Self {
        Self {
            period_ns: (1e9 / rate_hz) as u64,
            next_ns: now_ns,
        }
    }

    /// When the next one is due.
    pub(crate) fn next_ns(&self) -> u64 {
        self.next_ns
    }

    /// Whether one is due; the next is then due a period later.
    pub(crate) fn ticks(&mut self, now_ns: u64) -> bool {
        let is_due = now_ns >= self.next_ns;
        if is_due {
            self.next_ns = now_ns + self.period_ns;
        }
        is_due
    }
}
