//! What came of a client's requests: counts and times, merged over processes.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use taut_ipc::wire::{Code, ResponseFlags, ResponseHeader, Termination};

use super::rounds::Round;
use super::times::Times;

/// An answer counts as late this long after its deadline (ns).
pub(super) const LATE_NS: u64 = 1_000_000;

/// A request whose daemon went away.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Loss {
    /// When it was sent (ns).
    pub sent_ns: u64,
    /// When its client knew (ns).
    pub known_ns: u64,
    /// When the same client had its next proved answer (ns); 0 = not within the window.
    pub good_ns: u64,
}

/// What came of some requests.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Tally {
    /// Requests that arrived.
    pub sent: u64,
    /// Proved answers, in time where there was a deadline.
    pub served: u64,
    /// Other answers, and requests that were not sent, by the name of their code.
    pub refused: BTreeMap<String, u64>,
    /// OVERLOADED, QUOTA and LOADING of the daemon without a hint when to try again.
    pub without_hint: u64,
    /// Requests without a final answer or an error; none may be.
    pub lost: u64,
    /// Answers for another scene than asked for; none may be.
    pub other_scene: u64,
    /// Improvements that came before a final answer.
    pub improvements: u64,
    /// Bytes of the requests' and of the final answers' paths.
    pub bytes: [u64; 2],
    /// From arrival to the final answer, of what a worker had.
    pub latency: Times,
    /// The daemon's waiting times.
    pub queue: Times,
    /// The daemon's computing times.
    pub compute: Times,
    /// From sending to the final answer, less waiting and computing.
    pub overhead: Times,
    /// The same requests one by one; those of one client in one window, which are not merged.
    pub rounds: Vec<Round>,
    /// From sending to a refusal of the daemon.
    pub refusal: Times,
    /// How long after the deadline the answer came; 0 = before.
    pub lateness: Times,
    /// From cancelling to the next answer, less its waiting and computing.
    pub cancel: Times,
    /// Hash of the answer of each job, where no deadline and no cancelling cut in.
    pub answers: BTreeMap<u64, u64>,
    /// Answers of a job that differ from its first; none may.
    pub unequal: u64,
    /// Requests whose daemon went away.
    pub losses: Vec<Loss>,
    /// CPU time of the client process (ns).
    pub cpu_ns: u64,
    /// Length of the window (ns).
    pub elapsed_ns: u64,
}

/// What is known of one request at its end.
pub(super) struct Ending<'a> {
    /// Number of its job.
    pub job: u64,
    /// When it arrived (ns).
    pub arrived_ns: u64,
    /// When it was sent (ns).
    pub sent_ns: u64,
    /// When its end was known (ns).
    pub ended_ns: u64,
    /// Its deadline (ns); 0 = none.
    pub deadline_ns: u64,
    /// The final response's header and path.
    pub header: &'a ResponseHeader,
    /// Its path.
    pub path: &'a [f64],
}

impl Ending<'_> {
    fn code(&self) -> Code {
        // A code of a newer daemon is a code all the same.
        Code::try_from(self.header.code).unwrap_or(Code::MalformedRequest)
    }

    fn is_proved(&self) -> bool {
        self.header.flags & ResponseFlags::PROVED != 0 && self.code() == Code::Success
    }

    fn is_late(&self) -> bool {
        self.deadline_ns != 0 && self.ended_ns > self.deadline_ns + LATE_NS
    }

    fn taken_ns(&self) -> u64 {
        self.ended_ns.saturating_sub(self.sent_ns)
    }

    /// Whether no deadline and no cancelling cut in.
    fn ended_by_itself(&self) -> bool {
        let ends = [
            Termination::Converged,
            Termination::WorkBudget,
            Termination::Checked,
        ];
        ends.map(u32::from)
            .contains(&self.header.termination)
    }
}

impl Tally {
    /// Counts a request that ends with this code and without an answer of the daemon.
    pub(super) fn refuse(&mut self, code: Code) {
        *self
            .refused
            .entry(code.name().to_owned())
            .or_default() += 1;
    }

    /// Counts a final response.
    pub(super) fn end(&mut self, ending: &Ending) {
        if ending.deadline_ns != 0 {
            let late_ns = ending
                .ended_ns
                .saturating_sub(ending.deadline_ns);
            self.lateness.add(late_ns);
        }
        let code = ending.code();
        if code.is_retryable() {
            self.refusal.add(ending.taken_ns());
            self.without_hint += u64::from(ending.header.retry_after_ms == 0);
            return self.refuse(code);
        }
        self.time(ending);
        match ending.is_proved() {
            true if ending.is_late() => {
                *self
                    .refused
                    .entry("LATE".to_owned())
                    .or_default() += 1
            }
            true => self.served += 1,
            false => self.refuse(code),
        }
        if ending.ended_by_itself() {
            self.remember(ending.job, hash(ending.header, ending.path));
        }
    }

    /// Counts the times of what a worker had.
    fn time(&mut self, ending: &Ending) {
        let header = ending.header;
        let worked_ns = header.queue_ns + header.compute_ns;
        let since_arrival_ns = ending
            .ended_ns
            .saturating_sub(ending.arrived_ns);
        self.latency.add(since_arrival_ns);
        self.queue.add(header.queue_ns);
        self.compute.add(header.compute_ns);
        self.overhead
            .add(ending.taken_ns().saturating_sub(worked_ns));
        self.bytes[1] += size_of_val(ending.path) as u64;
        self.rounds.push(Round {
            sent_ns: ending.sent_ns,
            ended_ns: ending.ended_ns,
            compute_ns: header.compute_ns,
        });
    }

    /// Compares an answer with the first to the same job.
    fn remember(&mut self, job: u64, hash: u64) {
        let first = *self.answers.entry(job).or_insert(hash);
        self.unequal += u64::from(first != hash);
    }

    /// The client has a proved answer again: whoever was cut off before has got over it.
    pub(super) fn recovered(&mut self, good_ns: u64) {
        for loss in self
            .losses
            .iter_mut()
            .filter(|loss| loss.good_ns == 0)
        {
            loss.good_ns = good_ns;
        }
    }

    /// Adds another client's, or another window's.
    pub(super) fn merge(&mut self, other: &Self) {
        self.merge_counts(other);
        self.merge_times(other);
        self.merge_answers(other);
        self.losses.extend_from_slice(&other.losses);
    }

    fn merge_counts(&mut self, other: &Self) {
        self.sent += other.sent;
        self.served += other.served;
        for (code, count) in &other.refused {
            *self.refused.entry(code.clone()).or_default() += count;
        }
        self.without_hint += other.without_hint;
        self.lost += other.lost;
        self.other_scene += other.other_scene;
        self.improvements += other.improvements;
        for (sum, bytes) in self.bytes.iter_mut().zip(other.bytes) {
            *sum += bytes;
        }
    }

    fn merge_times(&mut self, other: &Self) {
        self.latency.merge(&other.latency);
        self.queue.merge(&other.queue);
        self.compute.merge(&other.compute);
        self.overhead.merge(&other.overhead);
        self.refusal.merge(&other.refusal);
        self.lateness.merge(&other.lateness);
        self.cancel.merge(&other.cancel);
        self.cpu_ns += other.cpu_ns;
        self.elapsed_ns = self.elapsed_ns.max(other.elapsed_ns);
    }

    fn merge_answers(&mut self, other: &Self) {
        self.unequal += other.unequal;
        for (job, hash) in &other.answers {
            self.remember(*job, *hash);
        }
    }

    /// Those of all.
    pub(super) fn of<'a>(all: impl IntoIterator<Item = &'a Self>) -> Self {
        all.into_iter()
            .fold(Self::default(), |mut sum, one| {
                sum.merge(one);
                sum
            })
    }

    /// How many ended with this code.
    pub(super) fn with(&self, code: Code) -> u64 {
        self.refused
            .get(code.name())
            .copied()
            .unwrap_or(0)
    }

    /// Every request that ended with an answer or an error.
    pub(super) fn ended(&self) -> u64 {
        self.served + self.refused.values().sum::<u64>()
    }

    /// Proved answers in time, per second.
    pub(super) fn goodput(&self) -> f64 {
        self.served as f64 / (self.elapsed_ns as f64 * 1e-9).max(1e-9)
    }
}

/// Of everything in an answer that must be equal, whoever computed it.
fn hash(header: &ResponseHeader, path: &[f64]) -> u64 {
    let numbers = [
        header.length_after,
        header.lower_bound,
        header.clearance_m,
        header.floor_m,
    ];
    let counts = [
        header.iterations,
        header.work,
        header.robot_hash,
        header.scene_hash,
        u64::from(header.waypoints),
    ];
    let bits = path
        .iter()
        .chain(&numbers)
        .map(|number| number.to_bits())
        .chain(counts);
    // FNV-1a over words: the same in every process.
    bits.fold(0xcbf2_9ce4_8422_2325, |hash, bits| {
        (hash ^ bits)
            .wrapping_mul(0x0000_0100_0000_01b3)
            .rotate_left(23)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(code: Code, flags: u32) -> ResponseHeader {
        let termination = Termination::Converged.into();
        ResponseHeader {
            code: code.into(),
            flags,
            termination,
            queue_ns: 20,
            compute_ns: 30,
            ..Default::default()
        }
    }

    fn ending<'a>(header: &'a ResponseHeader, path: &'a [f64], ended_ns: u64) -> Ending<'a> {
        Ending {
            job: 1,
            arrived_ns: 0,
            sent_ns: 100,
            ended_ns,
            deadline_ns: 1000,
            header,
            path,
        }
    }

    #[test]
    fn every_request_is_counted_once_and_the_late_are_not_served() {
        let good = answer(Code::Success, ResponseFlags::PROVED);
        let full = answer(Code::Overloaded, 0);
        let mut tally = Tally::default();
        tally.end(&ending(&good, &[1.0], 200));
        tally.end(&ending(&good, &[1.0], 1001 + 2 * LATE_NS));
        tally.end(&ending(&full, &[], 300));
        tally.refuse(Code::Quota);
        assert_eq!(
            (tally.served, tally.ended(), tally.with(Code::Overloaded)),
            (1, 4, 1)
        );
        assert_eq!(
            (tally.without_hint, tally.latency.len(), tally.refusal.len()),
            (1, 2, 1)
        );
        assert!((tally.overhead.quantile(0.5) - 50e-9).abs() < 1e-12);
        assert!((tally.lateness.share_above(LATE_NS) - 1.0 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn what_goes_over_the_pipe_and_is_merged_stays_the_same() {
        let good = answer(Code::Success, ResponseFlags::PROVED);
        let mut tally = Tally::default();
        for time in [200, 70_000, 123_456_789] {
            tally.end(&ending(&good, &[1.0], time));
        }
        let text = serde_json::to_string(&tally).unwrap();
        let same: Tally = serde_json::from_str(&text).unwrap();
        let both = Tally::of([&tally, &same]);
        assert_eq!((both.served, both.latency.len(), both.unequal), (4, 6, 0));
        assert_eq!(both.latency.quantile(0.5), tally.latency.quantile(0.5));
        let mut other = Tally::default();
        other.end(&ending(&good, &[1.0 + f64::EPSILON], 200));
        assert_eq!(Tally::of([&tally, &other]).unequal, 1);
    }
}
