//! The figures of one problem.

use std::collections::BTreeMap;

use serde::Serialize;

use super::curve::Curve;
use super::moment::{self, Moment};

/// One problem.
#[derive(Debug, Default, Serialize)]
pub(super) struct Row {
    /// Folder of the problem.
    pub set: String,
    /// File name without its ending.
    pub name: String,
    /// Which of the robot's models was taken.
    pub geometry: &'static str,
    /// Why the problem could not be read or run.
    pub error: Option<String>,
    /// Length of the path given.
    pub length_before: Option<f64>,
    /// Distance of its ends.
    pub lower_bound: Option<f64>,
    /// Our answers by mode.
    pub answers: BTreeMap<&'static str, Figures>,
    /// Recorded answers by name.
    pub peers: BTreeMap<String, PeerFigures>,
    /// The best recorded answer that is valid.
    pub best_honest_peer: Option<(String, PeerFigures)>,
    /// Which recorded paths collide with the exact meshes, by their recorded names; `raw` is the
    /// planner's.
    pub mesh_check: BTreeMap<String, bool>,
}

/// One answer of ours.
#[derive(Debug, Serialize)]
pub(super) struct Figures {
    /// Whether the answer is proved.
    pub proved: bool,
    /// Code of the answer.
    pub code: &'static str,
    /// Remaining length, as a part of the given path's; 1 where the answer is not proved, for it is
    /// that path.
    pub ratio: f64,
    /// Remaining length.
    pub length: f64,
    /// Runs that the times are medians of.
    pub runs: usize,
    /// CPU time (s).
    pub cpu_s: f64,
    /// Time on the clock (s).
    pub time_s: f64,
    /// When the first improvement came (s).
    pub first_improvement_s: Option<f64>,
    /// Remaining length, as a part, at each of the report's budgets.
    pub ratio_at: Vec<f64>,
    /// Length over time: steps (s, length), from the given path's at 0 to the answer's.
    pub curve: Curve,
    /// Ours ÷ the best honest peer's, by moment.
    pub over_best_honest_peer: BTreeMap<&'static str, f64>,
    /// Travel of coordinates that end where they start, in the path given (plain rad and m).
    pub idle_travel_before: f64,
    /// The same in the answer.
    pub idle_travel: f64,
    /// Content hash of the answer's bits.
    pub path_hash: String,
    /// Smallest floor of any pair (m).
    pub floor_m: f64,
    /// Pairs with a lowered floor.
    pub floors_lowered: usize,
    /// Iterations of the optimizer.
    pub iterations: u64,
    /// Pairs examined at nodes.
    pub work: u64,
    /// How the run ended.
    pub termination: &'static str,
    /// Why the input was refused.
    pub refusal: Option<String>,
}

/// A recorded answer, relative to the length of the path given.
#[derive(Clone, Debug, Serialize)]
pub(super) struct PeerFigures {
    /// Remaining length, as a part.
    pub ratio: f64,
    /// CPU time (s).
    pub cpu_s: f64,
    /// Whether every check found it valid.
    pub honest: bool,
}

impl Row {
    /// Set and name.
    pub(super) fn label(&self) -> String {
        format!("{}/{}", self.set, self.name)
    }

    /// Distance of the ends, as a part of the length of the path given.
    pub(super) fn lower_bound_ratio(&self) -> Option<f64> {
        Some(self.lower_bound? / self.length_before?)
    }

    /// Compares each answer with the best honest peer's.
    pub(super) fn compare(&mut self) {
        let Some((_, best)) = &self.best_honest_peer else {
            return;
        };
        for figures in self.answers.values_mut() {
            let quotient = |moment: Moment| (moment.name(), figures.over(best, moment));
            figures.over_best_honest_peer = moment::AGAINST_BEST.map(quotient).into();
        }
    }
}

impl Figures {
    /// Ours ÷ a peer's length, at a moment.
    pub(super) fn over(&self, peer: &PeerFigures, moment: Moment) -> f64 {
        match self.curve.remaining(moment.time_s(peer.cpu_s)) {
            ours if peer.ratio > 0.0 => ours / peer.ratio,
            0.0 => 1.0,
            _ => f64::INFINITY,
        }
    }
}
