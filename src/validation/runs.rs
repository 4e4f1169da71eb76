//! Waypoints that follow each other closely, proved as one segment: what planners hand over is
//! often resampled.
//!
//! Let c be the straight segment between the ends of a run of waypoints, and give each waypoint l a
//! place s_l on it, s growing from 0 to 1. With e_j the largest |w_l − c(s_l)| of column j, no
//! configuration q of the run is farther than e_j from a place p of c in any column, because
//! between two waypoints both q and p go straight. By [`reach`](super::reach) every pair is at q at
//! least as far apart as at p, less E = Σ_j reach_j e_j. So a run is proved by proving c with every
//! floor higher by E.
//!
//! Only for columns that are numbers: on a circle below half a turn, and not for quaternions.

use std::ops::Range;

use super::SegmentProof;
use super::continuous::Validator;
use super::reach::{Ranges, Reach};
use crate::path::Path;
use crate::robot::Component;

/// E of a run is at most this part of the clearance.
const DEVIATION: f64 = 1.0 / 8.0;
/// The chord of a run turns no circle farther than this (rad).
const MOST_TURN: f64 = 3.0;
/// Runs that are proved together.
const TOGETHER: usize = 16;

/// What runs of a path are measured with.
pub(super) struct Runs<'p> {
    path: &'p Path,
    reach: Reach,
    /// Column, velocity coordinate, and how far a chord may go in it.
    columns: Vec<(usize, usize, f64)>,
    most_deviation: f64,
}

/// Segments that are proved as one, and E (m).
struct Run {
    segments: Range<usize>,
    deviation: f64,
}

impl<'p> Runs<'p> {
    /// `None` where the robot has columns that are no numbers.
    pub(super) fn new(validator: &Validator, path: &'p Path) -> Option<Self> {
        let column = |component: &Component| match *component {
            Component::Line { q, v } => Some((q, v, f64::INFINITY)),
            Component::Circle { q, v } => Some((q, v, MOST_TURN)),
            Component::Rotation { .. } => None,
        };
        let columns = validator
            .space
            .components()
            .iter()
            .map(column)
            .collect::<Option<Vec<_>>>()?;
        let mut ranges = Ranges::none(path.nq());
        path.waypoints().for_each(|waypoint| ranges.add(waypoint));
        let reach = Reach::new(validator.model, validator.held, &ranges, 0.0);
        let most_deviation = DEVIATION * validator.scratch.floors.common();
        Some(Self {
            path,
            reach,
            columns,
            most_deviation,
        })
    }

    /// E of a run (m).
    fn deviation(&self, segments: &Range<usize>) -> f64 {
        if segments.len() <= 1 {
            return 0.0;
        }
        let first = self.path.waypoint(segments.start);
        let last = self.path.waypoint(segments.end);
        if self
            .columns
            .iter()
            .any(|&(q, _, most)| (last[q] - first[q]).abs() > most)
        {
            return f64::INFINITY;
        }
        let step = |to: usize| {
            let from = self.path.waypoint(to - 1);
            let to = self.path.waypoint(to);
            self.columns
                .iter()
                .map(|&(q, v, _)| self.reach.all()[v] * (to[q] - from[q]).abs())
                .sum::<f64>()
        };
        let whole: f64 = (segments.start + 1..=segments.end).map(step).sum();
        let mut farthest = vec![0.0_f64; self.reach.all().len()];
        let mut travelled = 0.0;
        for number in segments.start + 1..segments.end {
            travelled += step(number);
            let waypoint = self.path.waypoint(number);
            let s = (travelled / whole.max(f64::MIN_POSITIVE)).min(1.0);
            for &(q, v, _) in &self.columns {
                farthest[v] =
                    farthest[v].max((waypoint[q] - (first[q] + s * (last[q] - first[q]))).abs());
            }
        }
        self.reach.cost(&farthest)
    }

    /// The next run: of up to so many segments, fewer where the path is not straight enough.
    fn next(&self, segments: Range<usize>, most: usize) -> Run {
        let mut length = most.min(segments.len());
        loop {
            let segments = segments.start..segments.start + length;
            let deviation = self.deviation(&segments);
            if deviation <= self.most_deviation || length <= 1 {
                return Run {
                    segments,
                    deviation,
                };
            }
            length /= 2;
        }
    }
}

impl Validator<'_> {
    /// Proves the next segments of a path in runs of up to `most`, and appends the proofs of those
    /// before the first run that is refused; where that begins or, if none is, where they end; and
    /// whether one is. `None` where stopped.
    pub(super) fn prove_runs(
        &mut self,
        runs: &Runs,
        segments: Range<usize>,
        most: usize,
        proofs: &mut Vec<SegmentProof>,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<(usize, bool)> {
        let mut at = segments.start;
        let mut together = Vec::new();
        while at < segments.end && together.len() < TOGETHER {
            together.push(runs.next(at..segments.end, most));
            at = together[together.len() - 1].segments.end;
        }
        let raise = together.iter().map(|run| run.deviation).fold(0.0, f64::max);
        let refused = self.with_floors_raised(raise, |validator| {
            validator.begin();
            for Run { segments, .. } in &together {
                validator.add(
                    runs.path.waypoint(segments.start),
                    runs.path.waypoint(segments.end),
                );
            }
            validator.first_refused(stop)
        })?;
        let proved = &together[..refused.unwrap_or(together.len())];
        for (run, proof) in proved.iter().zip(&self.scratch.segments.proofs) {
            let clearance_m = proof.clearance_m - run.deviation;
            proofs.extend(run.segments.clone().map(|_| SegmentProof {
                clearance_m,
                ..*proof
            }));
        }
        Some((
            refused.map_or(at, |run| together[run].segments.start),
            refused.is_some(),
        ))
    }

    /// With every floor higher by this (m).
    fn with_floors_raised<T>(&mut self, raise: f64, prove: impl FnOnce(&mut Self) -> T) -> T {
        let mut wide = std::mem::take(&mut self.scratch.wide);
        wide.reset(
            self.model.pairs().len(),
            self.scratch.floors.common() + raise,
        );
        self.scratch
            .floors
            .lowered()
            .for_each(|(pair, floor)| wide.set(pair, floor + raise));
        let floors = std::mem::replace(&mut self.scratch.floors, wide);
        let found = prove(self);
        self.scratch.wide = std::mem::replace(&mut self.scratch.floors, floors);
        found
    }
}
