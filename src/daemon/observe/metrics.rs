//! Counters and times: for the status message, for people, and as Prometheus reads them.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::metrics::histogram::{Histogram, exponential_buckets};
use prometheus_client::registry::{Registry, Unit};
use taut::store::Made;
use taut_ipc::wire::{Code, ResponseHeader, StatusRecord};

/// Answers that the percentiles are taken of.
const WINDOW: usize = 512;

/// What happened since the start.
pub(crate) struct Metrics {
    started_ns: u64,
    received: Counter,
    ended: Family<[(&'static str, &'static str); 1], Counter>,
    cancelled: Counter,
    panics: Counter,
    pauses: Counter,
    running: Gauge,
    queued: Gauge,
    clients: Gauge,
    scenes: Gauge,
    robots_made: Gauge,
    models_made: Gauge,
    queue: Times,
    compute: Times,
    latency: Times,
    registry: Arc<Registry>,
}

/// Something measured, with its name and what it is.
type Named<'a, T> = (&'static str, &'static str, &'a T);

/// The last times of one kind.
pub(crate) struct Times {
    last: Vec<u64>,
    next: usize,
    /// All of them, in seconds.
    histogram: Histogram,
    // Taken again only after new times: an idle daemon sorts nothing.
    percentiles: Option<[u64; 2]>,
}

impl Default for Times {
    fn default() -> Self {
        // 10 µs to 5 s.
        let histogram = Histogram::new(exponential_buckets(1e-5, 2.0, 20));
        Self {
            last: Vec::new(),
            next: 0,
            histogram,
            percentiles: None,
        }
    }
}

impl Times {
    /// One more, in nanoseconds.
    pub(crate) fn push(&mut self, time: u64) {
        self.histogram.observe(time as f64 * 1e-9);
        self.remember(time);
        self.percentiles = None;
    }

    fn remember(&mut self, time: u64) {
        if self.last.len() < WINDOW {
            self.last.push(time);
        } else {
            self.last[self.next] = time;
        }
        self.next = (self.next + 1) % WINDOW;
    }

    /// The median and the 99th percentile.
    pub(crate) fn percentiles(&mut self) -> [u64; 2] {
        let last = &self.last;
        *self
            .percentiles
            .get_or_insert_with(|| percentiles(last.clone()))
    }
}

fn percentiles(mut times: Vec<u64>) -> [u64; 2] {
    times.sort_unstable();
    let count = times.len() as f64;
    let at = |part: f64| times.get((count * part) as usize).copied();
    [0.5, 0.99].map(|part| at(part).unwrap_or(0))
}

impl Metrics {
    /// Nothing happened yet.
    pub(crate) fn new(now_ns: u64) -> Self {
        let mut metrics = Self {
            started_ns: now_ns,
            received: Counter::default(),
            ended: Family::default(),
            cancelled: Counter::default(),
            panics: Counter::default(),
            pauses: Counter::default(),
            running: Gauge::default(),
            queued: Gauge::default(),
            clients: Gauge::default(),
            scenes: Gauge::default(),
            robots_made: Gauge::default(),
            models_made: Gauge::default(),
            queue: Times::default(),
            compute: Times::default(),
            latency: Times::default(),
            registry: Arc::default(),
        };
        metrics.registry = Arc::new(metrics.registered());
        metrics
    }

    fn registered(&self) -> Registry {
        let mut registry = Registry::with_prefix("taut");
        self.register_counters(&mut registry);
        self.register_gauges(&mut registry);
        self.register_times(&mut registry);
        registry
    }

    fn register_counters(&self, registry: &mut Registry) {
        registry.register(
            "requests_received",
            "Requests received",
            self.received.clone(),
        );
        registry.register(
            "requests_ended",
            "Final responses by code",
            self.ended.clone(),
        );
        for (name, help, counter) in self.counters() {
            registry.register(name, help, counter.clone());
        }
    }

    fn counters(&self) -> [Named<'_, Counter>; 3] {
        [
            (
                "requests_cancelled",
                "Requests whose client cancelled or vanished",
                &self.cancelled,
            ),
            (
                "worker_panics",
                "Requests on which the core panicked",
                &self.panics,
            ),
            ("job_pauses", "Jobs that made room for others", &self.pauses),
        ]
    }

    fn register_gauges(&self, registry: &mut Registry) {
        for (name, help, gauge) in self.gauges() {
            registry.register(name, help, gauge.clone());
        }
    }

    fn gauges(&self) -> [Named<'_, Gauge>; 6] {
        [
            (
                "requests_running",
                "Requests being worked on",
                &self.running,
            ),
            ("requests_queued", "Requests that wait", &self.queued),
            ("clients", "Connected clients", &self.clients),
            ("scenes", "Scenes loaded", &self.scenes),
            (
                "robots_made",
                "Robots whose solids were made since the start",
                &self.robots_made,
            ),
            (
                "models_made",
                "Robots and scenes put together since the start",
                &self.models_made,
            ),
        ]
    }

    fn register_times(&self, registry: &mut Registry) {
        for (name, help, times) in self.times() {
            let histogram = times.histogram.clone();
            registry.register_with_unit(name, help, Unit::Seconds, histogram);
        }
    }

    fn times(&self) -> [Named<'_, Times>; 3] {
        [
            ("queue", "Time that requests waited", &self.queue),
            ("compute", "Time that requests were computed", &self.compute),
            (
                "latency",
                "Time from request to final response, in the daemon",
                &self.latency,
            ),
        ]
    }

    /// What Prometheus reads; any thread may.
    pub(crate) fn registry(&self) -> Arc<Registry> {
        Arc::clone(&self.registry)
    }

    /// A request came.
    pub(crate) fn received(&self) {
        self.received.inc();
    }

    /// A client cancelled or vanished.
    pub(crate) fn cancelled(&self) {
        self.cancelled.inc();
    }

    /// The core panicked.
    pub(crate) fn panicked(&self) {
        self.panics.inc();
    }

    /// A job made room for others so many times.
    pub(crate) fn paused(&self, times: u32) {
        self.pauses.inc_by(times.into());
    }

    /// A final response with this code.
    pub(crate) fn ended(&self, code: i32) {
        let name = Code::try_from(code).map_or("UNKNOWN", Code::name);
        self.ended
            .get_or_create(&[("code", name)])
            .inc();
    }

    fn ended_with(&self, code: Code) -> u64 {
        self.ended
            .get(&[("code", code.name())])
            .map_or(0, |counter| counter.get())
    }

    /// A final response this long after its request.
    pub(crate) fn answered_after(&mut self, latency_ns: u64) {
        self.latency.push(latency_ns);
    }

    /// Times of a job that a worker had.
    pub(crate) fn timed(&mut self, header: &ResponseHeader) {
        self.queue.push(header.queue_ns);
        self.compute.push(header.compute_ns);
    }

    /// Time since the start.
    pub(crate) fn uptime_ns(&self, now_ns: u64) -> u64 {
        now_ns.saturating_sub(self.started_ns)
    }

    /// Enters the counters into a status message, and the message's numbers into what Prometheus
    /// reads.
    pub(crate) fn enter(&mut self, status: &mut StatusRecord, now_ns: u64) {
        status.uptime_ns = self.uptime_ns(now_ns);
        self.enter_counts(status);
        self.enter_endings(status);
        [status.queue_p50_ns, status.queue_p99_ns] = self.queue.percentiles();
        [status.compute_p50_ns, status.compute_p99_ns] = self.compute.percentiles();
        self.show(status);
    }

    fn enter_counts(&self, status: &mut StatusRecord) {
        status.received = self.received.get();
        status.cancelled = self.cancelled.get();
        status.panics = self.panics.get();
    }

    fn enter_endings(&self, status: &mut StatusRecord) {
        let ended: u64 = Code::ALL
            .iter()
            .map(|code| self.ended_with(*code))
            .sum();
        status.answered = self.ended_with(Code::Success);
        status.refused = ended - status.answered;
        status.overloaded = self.ended_with(Code::Overloaded) + self.ended_with(Code::Quota);
        status.timed_out = self.ended_with(Code::TimedOut);
    }

    /// Lets Prometheus read the numbers of a status message.
    fn show(&self, status: &StatusRecord) {
        self.running.set(status.running.into());
        self.queued.set(status.queued.into());
        self.clients.set(status.clients.into());
        self.scenes.set(status.scenes.into());
    }

    /// How often models were made.
    pub(crate) fn made(&mut self, made: &Made) {
        self.robots_made.set(count(&made.robots));
        self.models_made.set(count(&made.models));
    }

    /// Percentiles of the time from request to final response, pauses, and how often models were
    /// made, by name.
    pub(crate) fn more(&mut self) -> [(String, f64); 5] {
        let [p50, p99] = self.latency.percentiles();
        let more = [
            ("latency_p50_ns", p50),
            ("latency_p99_ns", p99),
            ("job_pauses", self.pauses.get()),
            ("robots_made", self.robots_made.get() as u64),
            ("models_made", self.models_made.get() as u64),
        ];
        more.map(|(name, value)| (name.to_owned(), value as f64))
    }
}

/// The numbers of a status message by name, the unit last.
pub(crate) fn numbers(status: &StatusRecord) -> BTreeMap<String, f64> {
    let named = now(status)
        .into_iter()
        .chain(since_start(status))
        .chain(times(status));
    named
        .map(|(name, value)| (name.to_owned(), value))
        .collect()
}

fn now(status: &StatusRecord) -> [(&'static str, f64); 4] {
    [
        ("workers", status.workers.into()),
        ("requests_running", status.running.into()),
        ("requests_queued", status.queued.into()),
        ("clients", status.clients.into()),
    ]
}

fn since_start(status: &StatusRecord) -> [(&'static str, f64); 8] {
    [
        ("requests_received", status.received as f64),
        ("requests_answered", status.answered as f64),
        ("requests_refused", status.refused as f64),
        ("requests_overloaded", status.overloaded as f64),
        ("requests_cancelled", status.cancelled as f64),
        ("requests_timed_out", status.timed_out as f64),
        ("worker_panics", status.panics as f64),
        ("clients_cleaned_up", status.cleaned_nodes as f64),
    ]
}

fn times(status: &StatusRecord) -> [(&'static str, f64); 4] {
    [
        ("queue_p50_ns", status.queue_p50_ns as f64),
        ("queue_p99_ns", status.queue_p99_ns as f64),
        ("compute_p50_ns", status.compute_p50_ns as f64),
        ("compute_p99_ns", status.compute_p99_ns as f64),
    ]
}

fn count(count: &AtomicU64) -> i64 {
    count.load(Ordering::Relaxed) as i64
}
