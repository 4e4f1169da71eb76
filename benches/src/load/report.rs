//! What `taut load` prints.

use serde::Serialize;

use super::orders::Memory;
use super::tally::{LATE_NS, Tally};
use super::times::Times;
use crate::units;

/// Three figures of a distribution (s).
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(super) struct Quantiles {
    /// The median.
    pub p50_s: f64,
    /// What 99 % do not exceed.
    pub p99_s: f64,
    /// The longest.
    pub max_s: f64,
}

impl Quantiles {
    fn of(times: &Times) -> Self {
        Self {
            p50_s: times.quantile(0.5),
            p99_s: times.quantile(0.99),
            max_s: times.max(),
        }
    }

    fn line(&self, name: &str) -> String {
        let [p50, p99, max] = [self.p50_s, self.p99_s, self.max_s].map(units::time);
        format!("{name:<10}{p50:>12}{p99:>12}{max:>12}\n")
    }
}

/// How evenly the clients were served.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(super) struct Fairness {
    /// Jain's index of the clients' served requests: 1 = all alike, 1/n = one has all.
    pub jain: f64,
    /// Served requests of the client that got least, as part of the mean.
    pub min: f64,
    /// The same of the one that got most.
    pub max: f64,
}

impl Fairness {
    /// Of what each client was served.
    pub(super) fn of(served: &[u64]) -> Self {
        let served: Vec<f64> = served
            .iter()
            .map(|count| *count as f64)
            .collect();
        let count = served.len().max(1) as f64;
        let sum: f64 = served.iter().sum();
        let squares: f64 = served.iter().map(|x| x * x).sum();
        let of_mean = |served: Option<f64>| part(served.unwrap_or(0.0), sum / count);
        Self {
            jain: part(sum * sum, count * squares),
            min: of_mean(served.iter().copied().min_by(f64::total_cmp)),
            max: of_mean(served.iter().copied().max_by(f64::total_cmp)),
        }
    }
}

/// As part of the whole; 1 of nothing.
fn part(some: f64, whole: f64) -> f64 {
    if whole > 0.0 { some / whole } else { 1.0 }
}

/// What came of a load test.
#[derive(Debug, Default, Serialize)]
pub(super) struct Report {
    /// Client processes.
    pub clients: usize,
    /// Seed of arrivals and choices.
    pub seed: u64,
    /// Length of the test (s).
    pub time_s: f64,
    /// Requests that arrived.
    pub sent: u64,
    /// Proved answers in time.
    pub served: u64,
    /// Other ends, by code; LATE = proved, but more than 1 ms after its deadline.
    pub refused: std::collections::BTreeMap<String, u64>,
    /// Requests without an end; 0 unless something is broken.
    pub lost: u64,
    /// Answers for another scene than asked for; 0 unless something is broken.
    pub other_scene: u64,
    /// Equal requests with unequal answers where no deadline cut in; 0 unless something is broken.
    pub unequal: u64,
    /// Improvements before final answers.
    pub improvements: u64,
    /// Proved answers in time, per second.
    pub goodput_hz: f64,
    /// From arrival to final answer.
    pub latency: Quantiles,
    /// Waiting in the daemon.
    pub queue: Quantiles,
    /// Computing in the daemon.
    pub compute: Quantiles,
    /// Latency from sending, less waiting and computing.
    pub overhead: Quantiles,
    /// From sending to a refusal.
    pub refusal: Quantiles,
    /// After the deadline; `None` without deadlines.
    pub lateness: Option<Quantiles>,
    /// Part of the answers later than 1 ms after their deadline.
    pub late_share: f64,
    /// Between the clients.
    pub fairness: Fairness,
    /// CPU time of the daemon for each answer (s).
    pub daemon_cpu_s: f64,
    /// CPU time of a client for each request (s).
    pub client_cpu_s: f64,
    /// Private memory of a client, the largest (bytes).
    pub client_private_bytes: u64,
    /// What a connection adds to it, the largest (bytes).
    pub client_added_bytes: u64,
}

impl Report {
    /// From the tallies of the clients.
    pub(super) fn new(tallies: &[Tally], memory: &[Memory], daemon_cpu_ns: u64, seed: u64) -> Self {
        let sum = Tally::of(tallies);
        let served: Vec<u64> = tallies
            .iter()
            .map(|tally| tally.served)
            .collect();
        let answers = sum.latency.len() + sum.refusal.len();
        Self {
            clients: tallies.len(),
            seed,
            fairness: Fairness::of(&served),
            daemon_cpu_s: each(daemon_cpu_ns, answers),
            client_private_bytes: most(memory, |memory| memory.after),
            client_added_bytes: most(memory, Memory::added),
            ..Self::of(sum)
        }
    }

    /// Of all requests together.
    fn of(sum: Tally) -> Self {
        Self {
            time_s: sum.elapsed_ns as f64 * 1e-9,
            sent: sum.sent,
            served: sum.served,
            lost: sum.sent.saturating_sub(sum.ended()),
            other_scene: sum.other_scene,
            unequal: sum.unequal,
            improvements: sum.improvements,
            goodput_hz: sum.goodput(),
            latency: Quantiles::of(&sum.latency),
            queue: Quantiles::of(&sum.queue),
            compute: Quantiles::of(&sum.compute),
            overhead: Quantiles::of(&sum.overhead),
            refusal: Quantiles::of(&sum.refusal),
            lateness: (sum.lateness.len() > 0).then(|| Quantiles::of(&sum.lateness)),
            late_share: sum.lateness.share_above(LATE_NS),
            client_cpu_s: each(sum.cpu_ns, sum.sent),
            refused: sum.refused,
            ..Self::default()
        }
    }

    /// Whether everything came to an end, and to the right one.
    pub(super) fn is_sound(&self) -> bool {
        self.lost == 0 && self.other_scene == 0 && self.unequal == 0
    }

    /// For people.
    pub(super) fn table(&self) -> String {
        [
            self.counts(),
            self.times(),
            self.late(),
            self.costs(),
            self.broken(),
        ]
        .concat()
    }

    fn counts(&self) -> String {
        format!(
            "{} clients  {}  seed {}\n\
             sent      {}  served {} ({:.1} a second)  lost {}\n\
             refused   {}\n",
            self.clients,
            units::time(self.time_s),
            self.seed,
            self.sent,
            self.served,
            self.goodput_hz,
            self.lost,
            self.refusals(),
        )
    }

    fn refusals(&self) -> String {
        let by_code = self.refused.iter();
        let by_code: Vec<String> = by_code
            .map(|(code, count)| format!("{code} {count}"))
            .collect();
        match by_code.is_empty() {
            true => "none".to_owned(),
            false => by_code.join(", "),
        }
    }

    fn times(&self) -> String {
        let rows = [
            ("latency", self.latency),
            ("queue", self.queue),
            ("compute", self.compute),
            ("overhead", self.overhead),
            ("refusal", self.refusal),
        ];
        let lateness = self
            .lateness
            .map(|lateness| ("lateness", lateness));
        let head = format!("{:<10}{:>12}{:>12}{:>12}\n", "", "p50", "p99", "max");
        let rows = rows.into_iter().chain(lateness);
        head + &rows
            .map(|(name, times)| times.line(name))
            .collect::<String>()
    }

    fn late(&self) -> String {
        match self.lateness {
            None => String::new(),
            Some(_) => format!(
                "late      {:.3} % of the answers came more than 1 ms after their deadline\n",
                self.late_share * 1e2
            ),
        }
    }

    fn costs(&self) -> String {
        let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
        format!(
            "fairness  Jain {:.3}, least served {:.2} and most served {:.2} of the mean\n\
             cpu       daemon {} an answer, client {} a request\n\
             memory    {:.2} MiB private to a client, {:.2} MiB of it by the connection\n",
            self.fairness.jain,
            self.fairness.min,
            self.fairness.max,
            units::time(self.daemon_cpu_s),
            units::time(self.client_cpu_s),
            mib(self.client_private_bytes),
            mib(self.client_added_bytes),
        )
    }

    fn broken(&self) -> String {
        let counts = [
            (self.other_scene, "answers for another scene"),
            (self.unequal, "unequal answers to equal requests"),
        ];
        let some = counts.iter().filter(|(count, _)| *count > 0);
        some.map(|(count, what)| format!("BROKEN    {count} {what}\n"))
            .collect()
    }
}

/// Seconds for each of so many.
fn each(ns: u64, count: u64) -> f64 {
    ns as f64 * 1e-9 / count.max(1) as f64
}

/// Of all clients.
fn most(memory: &[Memory], bytes: impl Fn(&Memory) -> u64) -> u64 {
    memory.iter().map(bytes).max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fairness_is_one_where_all_are_alike_and_a_part_where_one_has_all() {
        let even = Fairness::of(&[5, 5, 5, 5]);
        assert_eq!((even.jain, even.min, even.max), (1.0, 1.0, 1.0));
        let greedy = Fairness::of(&[8, 0, 0, 0]);
        assert_eq!((greedy.jain, greedy.min, greedy.max), (0.25, 0.0, 4.0));
        assert_eq!(Fairness::of(&[0, 0]).jain, 1.0);
    }
}
