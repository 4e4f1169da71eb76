//! Shortcuts, the baselines of the paper: straight lines between two random places of the path.
//!
//! [`random`] straightens all coordinates at once (Geraerts and Overmars, *Creating high-quality paths for
//! motion planning*, 2007: "shortcut"), [`partial`] one joint at a time, the others moving as before
//! ("partial shortcut"). A candidate counts only when every segment that changed is proved and the path
//! is strictly shorter. It never reaches across a fixed waypoint.

use std::ops::Range;

use super::outcome::Termination;
use super::task::{Improvement, SHORTER, Task, columns};
use crate::path::Path;
use crate::validation::{SegmentVerdict, Validator};

/// A candidate that gains less than this part of the length counts as a failure, though it is taken.
const WORTHWHILE: f64 = 3e-4;

/// Least gain, as a part of the length, for each waypoint that a candidate adds: waypoints cost time ever after.
const WORTH_A_WAYPOINT: f64 = 1e-4;

/// So many failures in a row for each waypoint end the search.
const PATIENCE_PER_WAYPOINT: u64 = 20;

/// So many for each component that moves on its own.
const PATIENCE_PER_COMPONENT: u64 = 10;

/// So many at least.
const LEAST_PATIENCE: u64 = 200;

/// How often a place of a partial shortcut is moved to the nearest waypoint, where it adds none.
const SNAPPED: f64 = 0.5;

/// Random shortcuts over all coordinates that may move.
///
/// Leaves the best path in `path` and returns the candidates tried and why they ended.
pub fn random(
    task: &Task,
    path: &mut Path,
    validator: &mut Validator,
    stop: &mut dyn FnMut() -> bool,
    publish: &mut dyn FnMut(Improvement),
) -> (u64, Termination) {
    let mut search = Search::new(task, path);
    let everything = 0..search.moving.len();
    search.run(validator, stop, publish, &mut |search| {
        let places = search.draw_places(0.0)?;
        search.build(places, everything.clone());
        Some(())
    })
}

/// Partial shortcuts: one factor of the configuration space (a joint's angle, a rotation) at a time.
///
/// Each is first tried over every whole stretch between fixed waypoints, then between random places.
/// Leaves the best path in `path` and returns the candidates tried and why they ended.
pub fn partial(
    task: &Task,
    path: &mut Path,
    validator: &mut Validator,
    stop: &mut dyn FnMut() -> bool,
    publish: &mut dyn FnMut(Improvement),
) -> (u64, Termination) {
    let mut search = Search::new(task, path);
    let mut whole: Vec<(usize, usize)> =
        (0..search.moving.len()).flat_map(|c| (0..search.stretches()).map(move |s| (c, s))).collect();
    search.run(validator, stop, publish, &mut |search| {
        let (component, places) = match whole.pop() {
            Some((component, stretch)) => (component, search.whole_stretch(stretch)),
            None if search.moving.is_empty() => return None,
            None => (search.random.usize(..search.moving.len()), search.draw_places(SNAPPED)?),
        };
        search.build(places, component..component + 1);
        Some(())
    })
}

/// A place on the path: a ratio in [0, 1) of a segment, or the last waypoint.
#[derive(Clone, Copy, Debug)]
struct Place {
    segment: usize,
    ratio: f64,
    /// Length of the path up to it.
    arc: f64,
}

/// The path, the candidate for a part of it, and scratch.
struct Search<'a, 'p> {
    task: &'a Task<'a>,
    path: &'p mut Path,
    fixed: Vec<bool>,
    /// Length of the path up to each waypoint.
    arcs: Vec<f64>,
    /// Columns of each component that may move.
    moving: Vec<Range<usize>>,
    random: fastrand::Rng,
    /// Flat rows that would replace waypoints `replaced`, the two ends of which they repeat.
    candidate: Vec<f64>,
    replaced: Range<usize>,
    velocity: Vec<f64>,
    ends: [Vec<f64>; 2],
    row: Vec<f64>,
    straight: Vec<f64>,
}

impl<'a, 'p> Search<'a, 'p> {
    fn new(task: &'a Task<'a>, path: &'p mut Path) -> Self {
        let components = task.space.components().iter();
        let row = vec![0.0; task.space.nq()];
        let mut search = Self {
            task,
            fixed: task.fixed.to_vec(),
            arcs: Vec::new(),
            moving: components.filter(|component| task.may_move(component)).map(columns).collect(),
            random: fastrand::Rng::with_seed(task.seed),
            candidate: Vec::new(),
            replaced: 0..0,
            velocity: vec![0.0; task.space.nv()],
            ends: [row.clone(), row.clone()],
            straight: row.clone(),
            row,
            path,
        };
        search.measure();
        search
    }

    /// Tries what `propose` builds until nothing is gained any more. `None` proposes nothing, which is a failure.
    fn run(
        &mut self,
        validator: &mut Validator,
        stop: &mut dyn FnMut() -> bool,
        publish: &mut dyn FnMut(Improvement),
        propose: &mut dyn FnMut(&mut Self) -> Option<()>,
    ) -> (u64, Termination) {
        let (mut tried, mut failures) = (0, 0);
        while failures < self.patience() {
            if stop() {
                return (tried, Termination::Stopped);
            }
            if validator.work() >= self.task.work_budget {
                return (tried, Termination::WorkBudget);
            }
            tried += 1;
            failures += 1;
            let Some(gain) = propose(self).and_then(|()| self.gain()) else { continue };
            match self.proves(validator, stop) {
                Proof::Refused => continue,
                Proof::Stopped => return (tried, Termination::Stopped),
                Proof::Proved => self.accept(),
            }
            if gain >= WORTHWHILE * self.length() {
                failures = 0;
            }
            self.drop_needless(validator, stop);
            publish(Improvement { path: self.path, length: self.length(), iterations: tried });
        }
        (tried, Termination::Converged)
    }

    fn patience(&self) -> u64 {
        let waypoints = PATIENCE_PER_WAYPOINT * self.path.len() as u64;
        LEAST_PATIENCE.max(waypoints).max(PATIENCE_PER_COMPONENT * self.moving.len() as u64)
    }

    fn length(&self) -> f64 {
        self.arcs[self.arcs.len() - 1]
    }

    fn measure(&mut self) {
        self.arcs.clear();
        let mut arc = 0.0;
        self.arcs.push(arc);
        for i in 1..self.path.len() {
            let (from, to) = (self.path.waypoint(i - 1), self.path.waypoint(i));
            arc += self.task.metric.distance(self.task.space, from, to, &mut self.velocity);
            self.arcs.push(arc);
        }
    }

    /// Number of stretches between neighbouring fixed waypoints.
    fn stretches(&self) -> usize {
        self.fixed.iter().filter(|fixed| **fixed).count() - 1
    }

    fn whole_stretch(&self, stretch: usize) -> (Place, Place) {
        let mut ends = (0..self.fixed.len()).filter(|&i| self.fixed[i]).skip(stretch);
        let mut next = || self.at_waypoint(ends.next().unwrap_or(0));
        (next(), next())
    }

    fn at_waypoint(&self, waypoint: usize) -> Place {
        Place { segment: waypoint, ratio: 0.0, arc: self.arcs[waypoint] }
    }

    /// Two random places on different segments of one stretch, in order; each is a waypoint with
    /// probability `snapped`.
    fn draw_places(&mut self, snapped: f64) -> Option<(Place, Place)> {
        let anywhere = self.random.f64() * self.length();
        let segment = self.segment_at(anywhere);
        let start = (0..=segment).rev().find(|&i| self.fixed[i])?;
        let end = (segment + 1..self.fixed.len()).find(|&i| self.fixed[i])?;
        let other = self.arcs[start] + self.random.f64() * (self.arcs[end] - self.arcs[start]);
        let [from, to] = [anywhere.min(other), anywhere.max(other)].map(|arc| {
            let place = self.place_at(arc);
            let nearest = place.segment + usize::from(place.ratio > 0.5);
            if self.random.f64() < snapped { self.at_waypoint(nearest) } else { place }
        });
        let last = to.segment - usize::from(to.ratio == 0.0 && to.segment > 0);
        (from.segment < last).then_some((from, to))
    }

    fn segment_at(&self, arc: f64) -> usize {
        let after = self.arcs.partition_point(|&start| start <= arc);
        after.clamp(1, self.arcs.len() - 1) - 1
    }

    fn place_at(&self, arc: f64) -> Place {
        let segment = self.segment_at(arc);
        let length = self.arcs[segment + 1] - self.arcs[segment];
        let ratio = if length > 0.0 { (arc - self.arcs[segment]) / length } else { 0.0 };
        if ratio < 1.0 { Place { segment, ratio, arc } } else { self.at_waypoint(segment + 1) }
    }

    /// Builds the candidate that moves the components `straightened` straight from one place to the other.
    fn build(&mut self, (from, to): (Place, Place), straightened: Range<usize>) {
        let (first, last) = (from.segment, to.segment + usize::from(to.ratio > 0.0));
        self.replaced = first..last + 1;
        for (side, place) in [from, to].into_iter().enumerate() {
            let (start, end) = (place.segment, (place.segment + 1).min(self.path.len() - 1));
            self.task.space.difference(self.path.waypoint(end), self.path.waypoint(start), &mut self.velocity);
            let at = &mut self.ends[side];
            self.task.space.integrate(self.path.waypoint(start), &self.velocity, place.ratio, at);
            if place.ratio == 0.0 {
                at.copy_from_slice(self.path.waypoint(start));
            }
        }
        self.candidate.clear();
        self.candidate.extend_from_slice(self.path.waypoint(first));
        push_different(&mut self.candidate, &self.ends[0]);
        let is_straight = straightened.len() == self.task.space.components().len();
        if !is_straight {
            self.task.space.difference(&self.ends[1], &self.ends[0], &mut self.velocity);
            for waypoint in first + 1..last {
                self.straighten(waypoint, (self.arcs[waypoint] - from.arc) / (to.arc - from.arc), straightened.clone());
            }
        }
        push_different(&mut self.candidate, &self.ends[1]);
        if self.candidate.ends_with(self.path.waypoint(last)) {
            return;
        }
        self.candidate.extend_from_slice(self.path.waypoint(last));
    }

    /// Adds a waypoint whose components `straightened` are at `ratio` of the straight line, the others as they were.
    fn straighten(&mut self, waypoint: usize, ratio: f64, straightened: Range<usize>) {
        self.row.copy_from_slice(self.path.waypoint(waypoint));
        self.task.space.integrate(&self.ends[0], &self.velocity, ratio, &mut self.straight);
        for columns in &self.moving[straightened] {
            self.row[columns.clone()].copy_from_slice(&self.straight[columns.clone()]);
        }
        push_different(&mut self.candidate, &self.row);
    }

    /// How much shorter the candidate is; `None` where that is not worth it.
    fn gain(&mut self) -> Option<f64> {
        let before = self.arcs[self.replaced.end - 1] - self.arcs[self.replaced.start];
        let gain = before - self.task.length(&self.candidate, &mut self.velocity);
        let added = (self.candidate.len() / self.path.nq()).saturating_sub(self.replaced.len());
        let least = SHORTER.max(WORTH_A_WAYPOINT * added as f64);
        (gain > least * self.length()).then_some(gain)
    }

    /// Proves the candidate's segments, the new ones in the middle first.
    fn proves(&self, validator: &mut Validator, stop: &mut dyn FnMut() -> bool) -> Proof {
        let nq = self.path.nq();
        let count = self.candidate.len() / nq - 1;
        // The outer two are mostly parts of segments that are proved: refusals come from the middle.
        for segment in (1..count).chain([0]) {
            let (from, to) = self.candidate[segment * nq..(segment + 2) * nq].split_at(nq);
            match validator.segment(from, to, stop) {
                SegmentVerdict::Proved(_) => {}
                SegmentVerdict::Refused(_) => return Proof::Refused,
                SegmentVerdict::Stopped => return Proof::Stopped,
            }
        }
        Proof::Proved
    }

    /// Puts the candidate in its place; `replaced` is then where it lies.
    fn accept(&mut self) {
        let interior = self.replaced.start + 1..self.replaced.end - 1;
        let count = self.candidate.len() / self.path.nq();
        self.fixed.splice(interior, std::iter::repeat_n(false, count - 2));
        self.path.splice(self.replaced.clone(), &self.candidate);
        self.replaced.end = self.replaced.start + count;
        self.measure();
    }

    /// Drops those waypoints of the candidate just accepted that the path can do without.
    ///
    /// Without this, partial shortcuts add waypoints without end, and each makes the next candidate dearer.
    fn drop_needless(&mut self, validator: &mut Validator, stop: &mut dyn FnMut() -> bool) {
        if self.moving.len() < self.task.space.components().len() {
            return; // A straight line would move what may not move otherwise than before.
        }
        let (mut waypoint, mut end) = (self.replaced.start + 1, self.replaced.end - 1);
        while waypoint < end {
            self.replaced = waypoint - 1..waypoint + 2;
            self.candidate.clear();
            self.candidate.extend_from_slice(self.path.waypoint(waypoint - 1));
            self.candidate.extend_from_slice(self.path.waypoint(waypoint + 1));
            // What lies on the straight line between its neighbours is dropped too: not longer is enough.
            match self.proves(validator, stop) {
                Proof::Proved => {
                    self.accept();
                    end -= 1;
                }
                Proof::Refused => waypoint += 1,
                Proof::Stopped => return,
            }
        }
    }
}

/// What the validator says of a candidate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Proof {
    Proved,
    Refused,
    Stopped,
}

/// Adds a row unless it equals the last one.
fn push_different(rows: &mut Vec<f64>, row: &[f64]) {
    if !rows.ends_with(row) {
        rows.extend_from_slice(row);
    }
}
