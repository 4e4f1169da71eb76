//! Counters and times for people and tools.

use std::collections::BTreeMap;

use taut_ipc::monotonic_ns;
use taut_ipc::wire::{Code, ResponseHeader, StatusRecord};

/// Answers that the percentiles are taken of.
const WINDOW: usize = 512;

/// What happened since the start.
pub(super) struct Metrics {
    started_ns: u64,
    received: u64,
    answered: u64,
    refused: u64,
    overloaded: u64,
    cancelled: u64,
    timed_out: u64,
    panics: u64,
    queue: Times,
    compute: Times,
}

/// The last times of one kind.
#[derive(Default)]
struct Times {
    last: Vec<u64>,
    next: usize,
    // Taken again only after new times: an idle daemon sorts nothing.
    percentiles: Option<[u64; 2]>,
}

impl Times {
    fn push(&mut self, time: u64) {
        if self.last.len() < WINDOW {
            self.last.push(time);
        } else {
            self.last[self.next] = time;
        }
        self.next = (self.next + 1) % WINDOW;
        self.percentiles = None;
    }

    /// The median and the 99th percentile.
    fn percentiles(&mut self) -> [u64; 2] {
        *self.percentiles.get_or_insert_with(|| {
            let mut sorted = self.last.clone();
            sorted.sort_unstable();
            let at = |part: f64| sorted.get((sorted.len() as f64 * part) as usize).copied().unwrap_or(0);
            [at(0.5), at(0.99)]
        })
    }
}

impl Metrics {
    /// Nothing happened yet.
    pub(super) fn new() -> Self {
        Self {
            started_ns: monotonic_ns(),
            received: 0,
            answered: 0,
            refused: 0,
            overloaded: 0,
            cancelled: 0,
            timed_out: 0,
            panics: 0,
            queue: Times::default(),
            compute: Times::default(),
        }
    }

    /// A request came.
    pub(super) fn received(&mut self) {
        self.received += 1;
    }

    /// A client cancelled or vanished.
    pub(super) fn cancelled(&mut self) {
        self.cancelled += 1;
    }

    /// The core panicked.
    pub(super) fn panicked(&mut self) {
        self.panics += 1;
    }

    /// A final response with this code.
    pub(super) fn ended(&mut self, code: i32) {
        match Code::try_from(code) {
            Ok(Code::Success) => self.answered += 1,
            Ok(code) => {
                self.refused += 1;
                self.overloaded += u64::from(matches!(code, Code::Overloaded | Code::Quota));
                self.timed_out += u64::from(code == Code::TimedOut);
            }
            Err(_) => self.refused += 1,
        }
    }

    /// Times of a job that a worker had.
    pub(super) fn timed(&mut self, header: &ResponseHeader) {
        self.queue.push(header.queue_ns);
        self.compute.push(header.compute_ns);
    }

    /// Median computing time.
    pub(super) fn compute_p50_ns(&mut self) -> u64 {
        self.compute.percentiles()[0]
    }

    /// Time since the start.
    pub(super) fn uptime_ns(&self) -> u64 {
        monotonic_ns().saturating_sub(self.started_ns)
    }

    /// Enters the counters into a status message.
    pub(super) fn enter(&mut self, status: &mut StatusRecord) {
        status.uptime_ns = self.uptime_ns();
        status.received = self.received;
        status.answered = self.answered;
        status.refused = self.refused;
        status.overloaded = self.overloaded;
        status.cancelled = self.cancelled;
        status.timed_out = self.timed_out;
        status.panics = self.panics;
        [status.queue_p50_ns, status.queue_p99_ns] = self.queue.percentiles();
        [status.compute_p50_ns, status.compute_p99_ns] = self.compute.percentiles();
    }
}

/// The numbers of a status message by name, the unit last.
pub(super) fn numbers(status: &StatusRecord) -> BTreeMap<String, f64> {
    let named = [
        ("workers", f64::from(status.workers)),
        ("requests_running", f64::from(status.running)),
        ("requests_queued", f64::from(status.queued)),
        ("clients", f64::from(status.clients)),
        ("requests_received", status.received as f64),
        ("requests_answered", status.answered as f64),
        ("requests_refused", status.refused as f64),
        ("requests_overloaded", status.overloaded as f64),
        ("requests_cancelled", status.cancelled as f64),
        ("requests_timed_out", status.timed_out as f64),
        ("worker_panics", status.panics as f64),
        ("clients_cleaned_up", status.cleaned_nodes as f64),
        ("queue_p50_ns", status.queue_p50_ns as f64),
        ("queue_p99_ns", status.queue_p99_ns as f64),
        ("compute_p50_ns", status.compute_p50_ns as f64),
        ("compute_p99_ns", status.compute_p99_ns as f64),
    ];
    named.map(|(name, value)| (name.to_owned(), value)).into()
}
