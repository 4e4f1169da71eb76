//! What was measured on one path.

use serde::Serialize;

use crate::units::{length, time};

/// What was measured on one path; times are medians (s).
#[derive(Debug, Default, Serialize)]
pub(crate) struct Figures {
    pub geometry: &'static str,
    pub waypoints: usize,
    pub proved: bool,
    /// Time to prove the path, or to refuse it.
    pub proof_s: f64,
    /// Intervals of the proof.
    pub intervals: u32,
    /// Tests by layer.
    pub far_tests: u64,
    pub near_tests: u64,
    pub exact_tests: u64,
    /// Distance that all pairs keep (m); `None` where nothing comes near.
    pub clearance_m: Option<f64>,
    /// Pairs with a lowered floor.
    pub floors_lowered: usize,
    /// Time to refuse the straight way from the first waypoint to the last; `None` where it is
    /// free.
    pub refusal_s: Option<f64>,
    /// The same segment proved by samples; `None` where the filter does not see every shape as it
    /// is.
    pub sampled_s: Option<f64>,
    /// Whether all samples are free.
    pub sampled_free: Option<bool>,
    /// Proof over sampling, where both find the path free.
    pub ratio: Option<f64>,
    /// Tests of a whole run of the gradient method, and those that it takes when it remembers no
    /// proof.
    pub run_tests: u64,
    pub run_tests_without_reuse: u64,
    /// What proving its constraints takes; `None` where it has none, or does not keep them.
    pub constraints: Option<ConstraintFigures>,
}

/// What proving the constraints of a path takes, by themselves.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct ConstraintFigures {
    /// Time (s).
    pub time_s: f64,
    /// Places that are looked at, for each segment.
    pub looks_a_segment: f64,
}

impl Figures {
    /// Part of a run's tests that remembered proofs save.
    pub(super) fn saved(&self) -> f64 {
        1.0 - self.run_tests as f64 / self.run_tests_without_reuse.max(1) as f64
    }

    /// Time to prove the constraints over that of all else.
    pub(super) fn constraints_ratio(&self) -> Option<f64> {
        let constraints = self.constraints?;
        Some(constraints.time_s / self.proof_s)
    }

    /// For people.
    pub(super) fn cells(&self) -> String {
        format!(
            "{:>9} {:>9} {:>9} {:>9}  {:>5} {:>10}  {:>22}   {}{}",
            self.waypoints,
            time(self.proof_s),
            or(self.refusal_s, "free"),
            or(self.sampled_s, "-"),
            self.ratio
                .map_or("-".to_owned(), |ratio| format!("{ratio:.2}")),
            self.intervals,
            self.tests(),
            self.keeps(),
            self.lowered(),
        )
    }

    fn tests(&self) -> String {
        format!(
            "{}, {}, {}",
            self.far_tests, self.near_tests, self.exact_tests
        )
    }

    fn keeps(&self) -> String {
        match (self.proved, self.clearance_m) {
            (false, _) => "not proved".to_owned(),
            (true, None) => "far".to_owned(),
            (true, Some(metres)) => length(metres),
        }
    }

    fn lowered(&self) -> String {
        match self.floors_lowered {
            0 => String::new(),
            count => format!(" *{count}"),
        }
    }
}

/// A time, or why there is none.
pub(super) fn or(seconds: Option<f64>, none: &str) -> String {
    seconds.map_or(none.to_owned(), time)
}
