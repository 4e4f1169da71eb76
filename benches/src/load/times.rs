//! Many times, as few numbers.

use hdrhistogram::Histogram;
use serde::{Deserialize, Serialize};

/// Times in nanoseconds, three digits each.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(from = "Vec<(u64, u64)>", into = "Vec<(u64, u64)>")]
pub(super) struct Times(Histogram<u64>);

impl Default for Times {
    fn default() -> Self {
        Self(Histogram::new(3).expect("3 digits are valid"))
    }
}

impl From<Vec<(u64, u64)>> for Times {
    fn from(counts: Vec<(u64, u64)>) -> Self {
        let mut times = Self::default();
        for (time, count) in counts {
            times
                .0
                .record_n(time, count)
                .expect("it grows as needed");
        }
        times
    }
}

impl From<Times> for Vec<(u64, u64)> {
    fn from(times: Times) -> Self {
        times
            .0
            .iter_recorded()
            .map(|step| (step.value_iterated_to(), step.count_at_value()))
            .collect()
    }
}

impl Times {
    /// One more.
    pub(super) fn add(&mut self, ns: u64) {
        self.0.record(ns).expect("it grows as needed");
    }

    /// Those of both.
    pub(super) fn merge(&mut self, other: &Self) {
        self.0
            .add(&other.0)
            .expect("both grow as needed");
    }

    /// How many.
    pub(super) fn len(&self) -> u64 {
        self.0.len()
    }

    /// The time that this part of them does not exceed (s); 0 of none.
    pub(super) fn quantile(&self, part: f64) -> f64 {
        if self.0.is_empty() {
            0.0
        } else {
            self.0.value_at_quantile(part) as f64 * 1e-9
        }
    }

    /// The longest (s).
    pub(super) fn max(&self) -> f64 {
        self.0.max() as f64 * 1e-9
    }

    /// The part that is longer than this.
    pub(super) fn share_above(&self, ns: u64) -> f64 {
        let above = self.0.len() - self.0.count_between(0, ns);
        if self.0.is_empty() {
            0.0
        } else {
            above as f64 / self.0.len() as f64
        }
    }
}
