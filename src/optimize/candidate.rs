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

impl Place {
    fn nearest_waypoint(&self) -> usize {
        self.segment + usize::from(self.ratio > 0.5)
    }

    /// The first waypoint that does not lie before it.
    fn next_waypoint(&self) -> usize {
        self.segment + usize::from(self.ratio > 0.0)
    }

    /// The last segment that begins before it.
    fn last_segment(&self) -> usize {
        self.segment - usize::from(self.ratio == 0.0 && self.segment > 0)
    }
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
        let mut ends = self.fixed_from(0).skip(stretch);
        let mut next = || self.at_waypoint(ends.next().unwrap_or_default());
        (next(), next())
    }

    /// The stretch between neighbouring fixed waypoints that a segment lies on.
    fn stretch_around(&self, segment: usize) -> Option<(usize, usize)> {
        let start = (0..=segment)
            .rev()
            .find(|&i| self.is_fixed(i))?;
        let end = self.fixed_from(segment + 1).next()?;
        Some((start, end))
    }

    fn is_fixed(&self, waypoint: usize) -> bool {
        self.progress.best.fixed()[waypoint]
    }

    /// The fixed waypoints from this one on.
    fn fixed_from(&self, first: usize) -> impl Iterator<Item = usize> {
        let waypoints = first..self.progress.best.fixed().len();
        waypoints.filter(|&waypoint| self.is_fixed(waypoint))
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
        let arcs = self.draw_arcs()?;
        let [from, to] = arcs.map(|arc| self.draw_place(arc, snapped));
        (from.segment < to.last_segment()).then_some((from, to))
    }

    /// Two random lengths along the path on one stretch, in order.
    fn draw_arcs(&mut self) -> Option<[f64; 2]> {
        let anywhere = self.progress.random.f64() * self.length();
        let (start, end) = self.stretch_around(self.segment_at(anywhere))?;
        let from = self.arcs()[start];
        let other = from + self.progress.random.f64() * (self.arcs()[end] - from);
        Some([anywhere.min(other), anywhere.max(other)])
    }

    /// The place at an arc length; or, with probability `snapped`, the waypoint nearest to it.
    fn draw_place(&mut self, arc: f64, snapped: f64) -> Place {
        let place = self.place_at(arc);
        match self.progress.random.f64() < snapped {
            true => self.at_waypoint(place.nearest_waypoint()),
            false => place,
        }
    }

    fn segment_at(&self, arc: f64) -> usize {
        let after = self
            .arcs()
            .partition_point(|&start| start <= arc);
        after.clamp(1, self.arcs().len() - 1) - 1
    }

    fn place_at(&self, arc: f64) -> Place {
        let segment = self.segment_at(arc);
        let ratio = self.ratio_at(segment, arc);
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

    fn ratio_at(&self, segment: usize, arc: f64) -> f64 {
        let start = self.arcs()[segment];
        let length = self.arcs()[segment + 1] - start;
        if length > 0.0 {
            (arc - start) / length
        } else {
            0.0
        }
    }

    /// Builds the candidate that moves the components `straightened` straight from one place to the
    /// other.
    pub fn build(&mut self, (from, to): (Place, Place), straightened: Range<usize>) {
        let last = to.next_waypoint();
        self.start(from, to);
        // Where everything moves straight, nothing is left of the waypoints between.
        if straightened.len() < self.progress.task.space.components().len() {
            self.straighten_between(from, to, straightened);
        }
        push_different(&mut self.candidate, &self.ends[1]);
        self.close(last);
    }

    /// Begins a candidate between two places.
    fn start(&mut self, from: Place, to: Place) {
        self.replaced = from.segment..to.next_waypoint() + 1;
        self.stand_at(0, from);
        self.stand_at(1, to);
        self.candidate.clear();
        self.candidate
            .extend_from_slice(self.progress.best.path().waypoint(from.segment));
        push_different(&mut self.candidate, &self.ends[0]);
    }

    /// `ends[side]` ← the configuration at a place.
    fn stand_at(&mut self, side: usize, place: Place) {
        let space = self.progress.task.space;
        let path = self.progress.best.path();
        let from = path.waypoint(place.segment);
        let to = path.waypoint((place.segment + 1).min(path.len() - 1));
        let at = &mut self.ends[side];
        space.difference(to, from, &mut self.velocity);
        space.integrate(from, &self.velocity, place.ratio, at);
        // A waypoint keeps its bits: integrating by 0 may round a rotation.
        if place.ratio == 0.0 {
            at.copy_from_slice(from);
        }
    }

    /// Adds the waypoints between two places, straightened.
    fn straighten_between(&mut self, from: Place, to: Place, straightened: Range<usize>) {
        let [start, end] = &self.ends;
        self.progress
            .task
            .space
            .difference(end, start, &mut self.velocity);
        for waypoint in from.segment + 1..self.replaced.end - 1 {
            let ratio = (self.arcs()[waypoint] - from.arc) / (to.arc - from.arc);
            self.straighten(waypoint, ratio, straightened.clone());
        }
    }

    /// Adds the last waypoint that the candidate replaces, unless it ends there.
    fn close(&mut self, last: usize) {
        let end = self.progress.best.path().waypoint(last);
        if !self.ends_at(end) {
            self.candidate.extend_from_slice(end);
        }
    }

    /// Both ends stand in the candidate, also where the stretch comes back to where it begins.
    fn ends_at(&self, end: &[f64]) -> bool {
        let has_two = self.candidate.len() > end.len();
        has_two && self.candidate.ends_with(end)
    }

    /// Adds a waypoint whose components `straightened` are at `ratio` of the straight line, the
    /// others as they were.
    fn straighten(&mut self, waypoint: usize, ratio: f64, straightened: Range<usize>) {
        let Progress { task, best, .. } = &*self.progress;
        task.space
            .integrate(&self.ends[0], &self.velocity, ratio, &mut self.straight);
        self.row
            .copy_from_slice(best.path().waypoint(waypoint));
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
        let gain = self
            .progress
            .best
            .gain(&self.replaced, &self.candidate);
        (gain > self.least_gain()).then_some(gain)
    }

    /// What a candidate with so many waypoints must gain.
    fn least_gain(&self) -> f64 {
        let added = self
            .candidate_len()
            .saturating_sub(self.replaced.len());
        SHORTER.max(WORTH_A_WAYPOINT * added as f64) * self.length()
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
        let progress = &mut *self.progress;
        let tried = progress.try_part(&self.replaced, &self.candidate, &self.tail, change);
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
        if waypoints
            .clone()
            .any(|waypoint| self.is_fixed(waypoint))
        {
            return false;
        }
        self.join(waypoints.start - 1, waypoints.end);
        self.gain().is_some() && self.try_candidate(Change::Shortens) == Tried::Taken
    }

    /// The candidate that moves straight from one waypoint to another.
    fn join(&mut self, from: usize, to: usize) {
        let path = self.progress.best.path();
        self.replaced = from..to + 1;
        self.candidate.clear();
        self.candidate
            .extend_from_slice(path.waypoint(from));
        self.candidate
            .extend_from_slice(path.waypoint(to));
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
            match self.drop(waypoint) {
                Tried::Taken => end -= 1,
                Tried::Refused(_) | Tried::NotShorter => waypoint += 1,
                Tried::Stopped => return,
            }
        }
    }

    /// Tries to do without a waypoint. What lies on the straight line between its neighbours is dropped
    /// too: not longer is enough.
    fn drop(&mut self, waypoint: usize) -> Tried {
        if self.is_fixed(waypoint) {
            return Tried::NotShorter;
        }
        self.join(waypoint - 1, waypoint + 1);
        if !self.unroll() {
            return Tried::NotShorter;
        }
        self.try_candidate(Change::Simplifies)
    }
}

/// Adds a row unless it equals the last one.
fn push_different(rows: &mut Vec<f64>, row: &[f64]) {
    if !rows.ends_with(row) {
        rows.extend_from_slice(row);
    }
}
