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
use super::reach::{Ranges, Reach};
use super::validator::Validator;
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
    columns: Vec<Column>,
    most_deviation: f64,
}

/// Segments that are proved as one, and E (m).
struct Run {
    segments: Range<usize>,
    deviation: f64,
}

impl Run {
    /// The proofs of its segments, from that of its chord.
    fn proofs(&self, chord: &SegmentProof) -> impl Iterator<Item = SegmentProof> + use<> {
        let proof = SegmentProof {
            clearance_m: chord.clearance_m - self.deviation,
            ..*chord
        };
        std::iter::repeat_n(proof, self.segments.len())
    }
}

/// A column of a path, which is a number.
struct Column {
    q: usize,
    v: usize,
    /// How far a chord may go in it.
    most_turn: f64,
}

impl Column {
    /// `None` for a quaternion, whose columns do not go straight.
    fn of(component: &Component) -> Option<Self> {
        let (q, v, most_turn) = match *component {
            Component::Line { q, v } => (q, v, f64::INFINITY),
            Component::Circle { q, v } => (q, v, MOST_TURN),
            Component::Rotation { .. } => return None,
        };
        Some(Self { q, v, most_turn })
    }

    /// Whether a chord goes too far in it.
    fn turns_too_far(&self, [first, last]: [&[f64]; 2]) -> bool {
        (last[self.q] - first[self.q]).abs() > self.most_turn
    }

    /// How far a waypoint is from the place `s` of a chord.
    fn off(&self, waypoint: &[f64], [first, last]: [&[f64]; 2], s: f64) -> f64 {
        let q = self.q;
        (waypoint[q] - (first[q] + s * (last[q] - first[q]))).abs()
    }
}

impl<'p> Runs<'p> {
    /// `None` where the robot has columns that are no numbers, and where there are constraints, of which
    /// a chord says nothing.
    pub(super) fn new(validator: &Validator, path: &'p Path) -> Option<Self> {
        if !validator.constraints().is_empty() {
            return None;
        }
        let components = validator.examiner.space.components().iter();
        let mut ranges = Ranges::none(path.nq());
        path.waypoints()
            .for_each(|waypoint| ranges.add(waypoint));
        Some(Self {
            path,
            columns: components
                .map(Column::of)
                .collect::<Option<_>>()?,
            // Between two waypoints no column leaves their range.
            reach: Reach::new(validator.model(), validator.examiner.held, &ranges, 0.0),
            most_deviation: DEVIATION * validator.floors().common(),
        })
    }

    /// Whether the chord of a run would turn a circle farther than it may.
    fn turns_too_far(&self, segments: &Range<usize>) -> bool {
        let chord = self.chord(segments);
        let mut columns = self.columns.iter();
        columns.any(|column| column.turns_too_far(chord))
    }

    /// Both ends of a run.
    fn chord(&self, segments: &Range<usize>) -> [&'p [f64]; 2] {
        [segments.start, segments.end].map(|waypoint| self.path.waypoint(waypoint))
    }

    /// About how far bodies move on the segment that ends at a waypoint (m).
    fn step(&self, to: usize) -> f64 {
        let from = self.path.waypoint(to - 1);
        let to = self.path.waypoint(to);
        let moved = self.columns.iter();
        moved
            .map(|&Column { q, v, .. }| self.reach.all()[v] * (to[q] - from[q]).abs())
            .sum::<f64>()
    }

    /// E of a run (m).
    fn deviation(&self, segments: &Range<usize>) -> f64 {
        if segments.len() <= 1 {
            return 0.0;
        }
        if self.turns_too_far(segments) {
            return f64::INFINITY;
        }
        let whole: f64 = (segments.start + 1..=segments.end)
            .map(|to| self.step(to))
            .sum();
        let mut farthest = vec![0.0_f64; self.reach.all().len()];
        let mut travelled = 0.0;
        for number in segments.start + 1..segments.end {
            travelled += self.step(number);
            // Any places that grow will do; where the bodies move evenly, c is near.
            let s = (travelled / whole.max(f64::MIN_POSITIVE)).min(1.0);
            self.take_in(number, segments, s, &mut farthest);
        }
        self.reach.cost(&farthest)
    }

    /// Takes in how far a waypoint is from the place `s` of the chord of a run, in each coordinate.
    fn take_in(&self, waypoint: usize, segments: &Range<usize>, s: f64, farthest: &mut [f64]) {
        let chord = self.chord(segments);
        let waypoint = self.path.waypoint(waypoint);
        for column in &self.columns {
            let farthest = &mut farthest[column.v];
            *farthest = farthest.max(column.off(waypoint, chord, s));
        }
    }

    /// The next run: of up to so many segments, fewer where the path is not straight enough.
    fn next(&self, segments: Range<usize>, most: usize) -> Run {
        let mut length = most.min(segments.len());
        loop {
            let run = self.run(segments.start..segments.start + length);
            if run.deviation <= self.most_deviation || length <= 1 {
                return run;
            }
            length /= 2;
        }
    }

    fn run(&self, segments: Range<usize>) -> Run {
        Run {
            deviation: self.deviation(&segments),
            segments,
        }
    }

    /// The next runs that are proved together, from the start of `segments` on.
    fn together(&self, segments: Range<usize>, most: usize) -> Vec<Run> {
        let mut left = segments;
        let runs = std::iter::from_fn(|| {
            let run = (!left.is_empty()).then(|| self.next(left.clone(), most))?;
            left.start = run.segments.end;
            Some(run)
        });
        runs.take(TOGETHER).collect()
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
        let together = runs.together(segments.clone(), most);
        let refused = self.first_refused_run(runs.path, &together, stop)?;
        let proved = &together[..refused.unwrap_or(together.len())];
        for (run, proof) in proved
            .iter()
            .zip(&self.examiner.scratch.segments.proofs)
        {
            proofs.extend(run.proofs(proof));
        }
        let end = together
            .last()
            .map_or(segments.start, |run| run.segments.end);
        Some((
            refused.map_or(end, |run| together[run].segments.start),
            refused.is_some(),
        ))
    }

    /// Looks at the chords of runs, with every floor higher by the largest E.
    fn first_refused_run(
        &mut self,
        path: &Path,
        together: &[Run],
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Option<usize>> {
        let raise = together
            .iter()
            .map(|run| run.deviation)
            .fold(0.0, f64::max);
        let (examiner, mut demand) = self.at_raised_floors(raise);
        examiner.begin(&mut demand);
        for Run { segments, .. } in together {
            examiner.add([path.waypoint(segments.start), path.waypoint(segments.end)].into());
        }
        examiner.first_refused(&mut demand, stop)
    }
}
