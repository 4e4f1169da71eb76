//! Candidates of shortcuts: what a part of a path would become with some components moving
//! straight.

use std::ops::Range;

use super::best::Change;
use super::progress::{Progress, Tried};
use super::task::{SHORTER, columns};

/// Least gain, as a part of the length, for each waypoint that a candidate adds: waypoints cost
/// time ever after.
const WORTH_A_WAYPOINT: f64 = 1e-4;

/// A place on the path: a ratio in [0, 1) of a segment, or the last waypoint.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    segment: usize,
    ratio: f64,
    /// Length of the path up to it.
    arc: f64,
}

/// The path, the candidate for a part of it, and scratch.
pub struct Search<'s, 'r, 'm> {
    pub progress: &'s mut Progress<'r, 'm>,
    /// Columns of each component that may move.
    pub moving: Vec<Range<usize>>,
    /// Flat rows that would replace waypoints `replaced`, the two ends of which they repeat.
    candidate: Vec<f64>,
    replaced: Range<usize>,
    /// What would replace the waypoints from the last of those on, where the candidate ends whole
    /// turns away; else empty.
    tail: Vec<f64>,
    velocity: Vec<f64>,
    ends: [Vec<f64>; 2],
    row: Vec<f64>,
    straight: Vec<f64>,
}

impl<'s, 'r, 'm> Search<'s, 'r, 'm> {
    pub fn new(progress: &'s mut Progress<'r, 'm>) -> Self {
        let task = progress.task;
        let components = task.space.components().iter();
        let row = vec![0.0; task.space.nq()];
        Self {
            moving: components
                .filter(|component| task.may_move(component))
                .map(columns)
                .collect(),
            candidate: Vec::new(),
            replaced: 0..0,
            tail: Vec::new(),
            velocity: vec![0.0; task.space.nv()],
            ends: [row.clone(), row.clone()],
            straight: row.clone(),
            row,
            progress,
        }
    }

    pub fn length(&self) -> f64 {
        self.progress.best.length()
    }

    fn arcs(&self) -> &[f64] {
        self.progress.best.arcs()
    }

    /// Number of stretches between neighbouring fixed waypoints.
    pub fn stretches(&self) -> usize {
        self.progress
            .best
            .fixed()
            .iter()
            .filter(|fixed| **fixed)
            .count()
            - 1
    }

    pub fn whole_stretch(&self, stretch: usize) -> (Place, Place) {
        let mut ends = (0..self.progress.best.fixed().len())
            .filter(|&i| self.progress.best.fixed()[i])
            .skip(stretch);
        let mut next = || self.at_waypoint(ends.next().unwrap_or(0));
        (next(), next())
    }

    fn at_waypoint(&self, waypoint: usize) -> Place {
        Place {
            segment: waypoint,
            ratio: 0.0,
            arc: self.arcs()[waypoint],
        }
    }

    /// Two random places on different segments of one stretch, in order; each is a waypoint with
    /// probability `snapped`.
    pub fn draw_places(&mut self, snapped: f64) -> Option<(Place, Place)> {
        let anywhere = self.progress.random.f64() * self.length();
        let segment = self.segment_at(anywhere);
        let start = (0..=segment)
            .rev()
            .find(|&i| self.progress.best.fixed()[i])?;
        let end = (segment + 1..self.progress.best.fixed().len())
            .find(|&i| self.progress.best.fixed()[i])?;
        let other = self.arcs()[start]
            + self.progress.random.f64() * (self.arcs()[end] - self.arcs()[start]);
        let [from, to] = [anywhere.min(other), anywhere.max(other)].map(|arc| {
            let place = self.place_at(arc);
            let nearest = place.segment + usize::from(place.ratio > 0.5);
            if self.progress.random.f64() < snapped {
                self.at_waypoint(nearest)
            } else {
                place
            }
        });
        let last = to.segment - usize::from(to.ratio == 0.0 && to.segment > 0);
        (from.segment < last).then_some((from, to))
    }

    fn segment_at(&self, arc: f64) -> usize {
        let after = self.arcs().partition_point(|&start| start <= arc);
        after.clamp(1, self.arcs().len() - 1) - 1
    }

    fn place_at(&self, arc: f64) -> Place {
        let segment = self.segment_at(arc);
        let length = self.arcs()[segment + 1] - self.arcs()[segment];
        let ratio = if length > 0.0 {
            (arc - self.arcs()[segment]) / length
        } else {
            0.0
        };
        if ratio < 1.0 {
            Place {
                segment,
                ratio,
                arc,
            }
        } else {
            self.at_waypoint(segment + 1)
        }
    }

    /// Builds the candidate that moves the components `straightened` straight from one place to the
    /// other.
    pub fn build(&mut self, (from, to): (Place, Place), straightened: Range<usize>) {
        let first = from.segment;
        let last = to.segment + usize::from(to.ratio > 0.0);
        self.replaced = first..last + 1;
        for (side, place) in [from, to].into_iter().enumerate() {
            let start = place.segment;
            let end = (place.segment + 1).min(self.progress.best.path().len() - 1);
            self.progress.task.space.difference(
                self.progress.best.path().waypoint(end),
                self.progress.best.path().waypoint(start),
                &mut self.velocity,
            );
            let at = &mut self.ends[side];
            self.progress.task.space.integrate(
                self.progress.best.path().waypoint(start),
                &self.velocity,
                place.ratio,
                at,
            );
            if place.ratio == 0.0 {
                at.copy_from_slice(self.progress.best.path().waypoint(start));
            }
        }
        self.candidate.clear();
        self.candidate
            .extend_from_slice(self.progress.best.path().waypoint(first));
        push_different(&mut self.candidate, &self.ends[0]);
        let is_straight = straightened.len() == self.progress.task.space.components().len();
        if !is_straight {
            self.progress
                .task
                .space
                .difference(&self.ends[1], &self.ends[0], &mut self.velocity);
            for waypoint in first + 1..last {
                self.straighten(
                    waypoint,
                    (self.arcs()[waypoint] - from.arc) / (to.arc - from.arc),
                    straightened.clone(),
                );
            }
        }
        push_different(&mut self.candidate, &self.ends[1]);
        // Both ends stand in it, also where the stretch comes back to where it begins.
        let ends = self.candidate.len() > self.progress.best.path().nq();
        if !(ends
            && self
                .candidate
                .ends_with(self.progress.best.path().waypoint(last)))
        {
            self.candidate
                .extend_from_slice(self.progress.best.path().waypoint(last));
        }
    }

    /// Adds a waypoint whose components `straightened` are at `ratio` of the straight line, the
    /// others as they were.
    fn straighten(&mut self, waypoint: usize, ratio: f64, straightened: Range<usize>) {
        self.row
            .copy_from_slice(self.progress.best.path().waypoint(waypoint));
        self.progress.task.space.integrate(
            &self.ends[0],
            &self.velocity,
            ratio,
            &mut self.straight,
        );
        for columns in &self.moving[straightened] {
            self.row[columns.clone()].copy_from_slice(&self.straight[columns.clone()]);
        }
        push_different(&mut self.candidate, &self.row);
    }

    /// Writes the candidate so that its numbers say how it moves, and says how much shorter it is;
    /// `None` where it cannot be taken or is not worth it.
    pub fn gain(&mut self) -> Option<f64> {
        if !self.unroll() {
            return None;
        }
        let gain = self.progress.best.gain(&self.replaced, &self.candidate);
        let added = self.candidate_len().saturating_sub(self.replaced.len());
        let least = SHORTER.max(WORTH_A_WAYPOINT * added as f64);
        (gain > least * self.length()).then_some(gain)
    }

    /// [`Best::unroll_part`](super::best::Best::unroll_part) of the candidate.
    fn unroll(&mut self) -> bool {
        let best = &self.progress.best;
        best.unroll_part(&self.replaced, &mut self.candidate, &mut self.tail)
    }

    /// Waypoints of the candidate.
    fn candidate_len(&self) -> usize {
        self.candidate.len() / self.progress.task.space.nq()
    }

    /// Proves the candidate, and what follows where that moves by whole turns, and puts it in its
    /// place; `replaced` is then where it lies.
    pub fn try_candidate(&mut self, change: Change) -> Tried {
        let range = &self.replaced;
        let tried = self
            .progress
            .try_part(range, &self.candidate, &self.tail, change);
        if tried == Tried::Taken {
            self.replaced.end = self.replaced.start + self.candidate_len();
        }
        tried
    }

    /// Whether all components may move: else a straight line moves those that may not otherwise
    /// than before.
    pub fn moves_everything(&self) -> bool {
        self.moving.len() == self.progress.task.space.components().len()
    }

    /// [`Self::drop_needless`] of the whole path.
    pub fn drop_needless_of_all(&mut self) {
        self.replaced = 0..self.progress.best.path().len();
        self.drop_needless();
    }

    /// Leaves out these waypoints if none is fixed, it gains, and the straight line is proved; says
    /// whether.
    pub fn leave_out(&mut self, waypoints: Range<usize>) -> bool {
        if self.progress.best.fixed()[waypoints.clone()].contains(&true) {
            return false;
        }
        self.replaced = waypoints.start - 1..waypoints.end + 1;
        self.candidate.clear();
        self.candidate
            .extend_from_slice(self.progress.best.path().waypoint(waypoints.start - 1));
        self.candidate
            .extend_from_slice(self.progress.best.path().waypoint(waypoints.end));
        self.gain().is_some() && self.try_candidate(Change::Shortens) == Tried::Taken
    }

    /// Drops those waypoints of the candidate just accepted that the path can do without.
    ///
    /// Without this, partial shortcuts add waypoints without end, and each makes the next candidate
    /// dearer.
    pub fn drop_needless(&mut self) {
        if !self.moves_everything() {
            return;
        }
        let mut waypoint = self.replaced.start + 1;
        let mut end = self.replaced.end - 1;
        while waypoint < end {
            if self.progress.best.fixed()[waypoint] {
                waypoint += 1;
                continue;
            }
            self.replaced = waypoint - 1..waypoint + 2;
            self.candidate.clear();
            self.candidate
                .extend_from_slice(self.progress.best.path().waypoint(waypoint - 1));
            self.candidate
                .extend_from_slice(self.progress.best.path().waypoint(waypoint + 1));
            // What lies on the straight line between its neighbours is dropped too: not longer is
            // enough.
            let tried = self
                .unroll()
                .then(|| self.try_candidate(Change::Simplifies));
            match tried {
                Some(Tried::Taken) => end -= 1,
                Some(Tried::Refused(_) | Tried::NotShorter) | None => waypoint += 1,
                Some(Tried::Stopped) => return,
            }
        }
    }
}

/// Adds a row unless it equals the last one.
fn push_different(rows: &mut Vec<f64>, row: &[f64]) {
    if !rows.ends_with(row) {
        rows.extend_from_slice(row);
    }
}
