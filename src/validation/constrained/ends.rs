//! What constraints keep on a straight segment, seen from places on it: the cheapest proof.
//!
//! What accelerates by at most A stays within (b − a)²A/8 of the straight way between where it is at a
//! and at b. So where both of these lie that deep in a convex region, all between does too: the theorem
//! of [`crate::constraint`] without velocities. Neighbouring segments share a waypoint, so that most of a
//! planner's path costs one look a segment.

use super::{Constrained, ROUNDING};
use crate::constraint::{Held, Vector};
use crate::math::Vec3;

/// Parts in which a segment is looked at: the first number that may do is tried.
const PARTS: [usize; 3] = [1, 2, 4];

/// What is watched, where it was looked at.
#[derive(Debug, Default)]
pub(super) struct Ends {
    /// The configuration that was looked at last, ...
    last: Vec<f64>,
    /// ... and where all that is watched was there.
    there: Vec<Vec3>,
    /// The same at the beginning of a part.
    here: Vec<Vec3>,
    /// The rows of the segments, one after the other, that were proved last, ...
    rows: Vec<f64>,
    /// ... and the depth that each constraint keeps on each.
    kept: Vec<f64>,
}

impl Ends {
    /// Forgets what is proved.
    pub(super) fn forget(&mut self) {
        self.rows.clear();
        self.kept.clear();
    }

    /// Begins anew, unless a segment follows those that are proved.
    fn follow(&mut self, from: &[f64]) {
        if !self.rows.ends_with(from) || self.kept.is_empty() {
            self.forget();
            self.rows.extend_from_slice(from);
        }
    }
}

impl Constrained<'_> {
    /// Whether a segment is proved to keep every constraint by a few looks; where not, nothing is known.
    pub(in crate::validation) fn keeps_all(&mut self, ends: [&[f64]; 2]) -> bool {
        self.set_out(ends);
        if self.ends.last != ends[0] {
            self.look_at(ends[0]);
        }
        self.ends.follow(ends[0]);
        let parts = PARTS
            .into_iter()
            .find(|parts| self.may_do(*parts));
        let keeps = parts.is_some_and(|parts| self.keeps_in_parts(ends, parts));
        match keeps {
            true => self.ends.rows.extend_from_slice(ends[1]),
            false => self.ends.forget(),
        }
        keeps
    }

    /// Depth that each constraint keeps on the segment that was proved last.
    pub(super) fn kept_last(&self) -> &[f64] {
        let kept = &self.ends.kept;
        &kept[kept.len() - self.allowed.len()..]
    }

    /// Depth that each constraint keeps on each segment between rows, one after the other; where that is
    /// what was proved last.
    pub(super) fn kept_between(&self, rows: &[f64]) -> Option<&[f64]> {
        (self.ends.rows == rows).then_some(&self.ends.kept)
    }

    /// What may be lost between two places next to each other, of so many parts.
    fn bend(&self, constraint: usize, parts: usize) -> f64 {
        let acceleration = self.bounds[constraint].acceleration(0);
        acceleration / (8 * parts * parts) as f64 + ROUNDING
    }

    /// Whether every constraint is deep enough where the segment begins.
    fn may_do(&self, parts: usize) -> bool {
        let mut constraints = 0..self.allowed.len();
        constraints.all(|constraint| {
            let at = self.ends.there[constraint];
            self.allowed[constraint].depth(at) >= self.bend(constraint, parts)
        })
    }

    fn keeps_in_parts(&mut self, ends: [&[f64]; 2], parts: usize) -> bool {
        let kept = &mut self.ends.kept;
        // What has no boundary has no depth.
        kept.resize(kept.len() + self.allowed.len(), f64::MAX);
        (1..=parts).all(|part| self.keeps_part(ends, part, parts))
    }

    /// Goes on to the end of a part; whether everything is kept on the way there.
    fn keeps_part(&mut self, ends: [&[f64]; 2], part: usize, parts: usize) -> bool {
        std::mem::swap(&mut self.ends.here, &mut self.ends.there);
        if part == parts {
            self.look_at(ends[1]);
        } else {
            self.look_between(ends[0], part as f64 / parts as f64);
        }
        let segment = self.ends.kept.len() - self.allowed.len();
        (0..self.allowed.len()).all(|constraint| {
            let kept = self.kept_on_part(constraint, parts);
            let least = &mut self.ends.kept[segment + constraint];
            *least = least.min(kept);
            kept >= 0.0
        })
    }

    fn kept_on_part(&self, constraint: usize, parts: usize) -> f64 {
        let held = &self.allowed[constraint];
        let here = self.ends.here[constraint];
        let there = match held.watched.vector() {
            Vector::Point(_) | Vector::Direction(_) => self.ends.there[constraint],
            // As far as it goes: the other end of a long way may seem near on the circle.
            Vector::Joint(_) => here + self.rate(held) / parts as f64,
        };
        held.kept([here, there], self.bend(constraint, parts))
    }

    /// How fast a joint's value changes on the segment.
    fn rate(&self, held: &Held) -> Vec3 {
        held.watched.rate(&self.standing.seen())
    }

    /// `there` ← where everything is at a place of the segment.
    fn look_between(&mut self, from: &[f64], t: f64) {
        let mut configuration = std::mem::take(&mut self.standing.configuration);
        self.standing
            .space
            .integrate(from, &self.standing.velocity, t, &mut configuration);
        self.look_at(&configuration);
        self.standing.configuration = configuration;
    }

    /// `there` ← where everything is at a configuration.
    fn look_at(&mut self, configuration: &[f64]) {
        self.looks += 1;
        let Ends { last, there, .. } = &mut self.ends;
        let robot = self.standing.model.robot();
        let at = |held: &Held| {
            held.watched
                .at_configuration(robot, configuration, self.standing.held)
        };
        there.clear();
        there.extend(self.allowed.iter().map(at));
        last.clear();
        last.extend_from_slice(configuration);
    }
}
