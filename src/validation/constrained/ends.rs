//! What constraints keep on a straight segment, seen from its ends: the cheapest proof.
//!
//! What accelerates by at most A stays within (b − a)²A/8 of the straight way between where it is at a
//! and at b. So where both of these lie that deep in a convex region, all between does too: the theorem
//! of [`crate::constraint`] without velocities. Neighbouring segments share a waypoint, so that most of a
//! planner's path costs one look a segment; else it is halved where that does not do.

use super::{Constrained, ROUNDING};
use crate::constraint::{Held, Stand, Vector};
use crate::math::Vec3;

/// No part of a segment is halved that is shorter.
const SHORTEST: f64 = 1.0 / 256.0;

/// Where everything that is watched is, where it was looked at.
#[derive(Debug, Default)]
pub(super) struct Ends {
    /// Where the segment ends that was proved last.
    last: Vec<f64>,
    /// Where everything is: at the beginning of the part that is next (or at `last`), then at the places
    /// ahead, the nearest last.
    at: Vec<Vec3>,
    /// The ratios of the places ahead.
    ahead: Vec<f64>,
}

impl Constrained<'_> {
    /// Whether a segment is proved to keep every constraint by a few looks; where not, nothing is known.
    pub(in crate::validation) fn keeps_all(&mut self, ends: [&[f64]; 2]) -> bool {
        self.set_out(ends);
        self.begin(ends);
        let keeps = self.keeps_parts(ends[0]);
        if keeps {
            self.ends.last.extend_from_slice(ends[1]);
        }
        keeps
    }

    /// Looks at both ends of a segment.
    fn begin(&mut self, [from, to]: [&[f64]; 2]) {
        let is_known = self.ends.last == from;
        self.ends
            .at
            .truncate(if is_known { self.allowed.len() } else { 0 });
        self.ends.last.clear();
        if !is_known {
            self.look_at(from);
        }
        self.ends.ahead.clear();
        self.ends.ahead.push(1.0);
        self.look_at(to);
    }

    /// Goes from part to part, and halves the next as long as that is open.
    fn keeps_parts(&mut self, from: &[f64]) -> bool {
        let mut begin = 0.0;
        while let Some(&end) = self.ends.ahead.last() {
            if self.keeps_part(end - begin) {
                self.go_on();
                begin = end;
            } else if end - begin < SHORTEST || self.is_outside() {
                return false;
            } else {
                let middle = 0.5 * (begin + end);
                self.ends.ahead.push(middle);
                self.look_between(from, middle);
            }
        }
        true
    }

    /// To the place that is next.
    fn go_on(&mut self) {
        let next = self.ends.at.len() - self.allowed.len();
        self.ends.at.copy_within(next.., 0);
        self.ends.at.truncate(next);
        self.ends.ahead.pop();
    }

    /// Where everything is at the beginning of the next part, and at its end.
    fn next_part(&self) -> [&[Vec3]; 2] {
        let at = &self.ends.at;
        let count = self.allowed.len();
        [&at[..count], &at[at.len() - count..]]
    }

    /// Whether one end of the next part violates a constraint.
    fn is_outside(&self) -> bool {
        let outside = |at: &[Vec3]| {
            let mut watched = self.allowed.iter().zip(at);
            watched.any(|(held, at)| held.depth(*at) < 0.0)
        };
        self.next_part().into_iter().any(outside)
    }

    /// Whether everything is kept on the next part, of this length.
    fn keeps_part(&self, length: f64) -> bool {
        let mut constraints = 0..self.allowed.len();
        constraints.all(|constraint| self.kept_on_part(constraint, length) >= 0.0)
    }

    fn kept_on_part(&self, constraint: usize, length: f64) -> f64 {
        let held = &self.allowed[constraint];
        let [here, there] = self.next_part().map(|at| at[constraint]);
        let there = match held.watched.vector() {
            Vector::Point(_) | Vector::Direction(_) => there,
            // As far as it goes: the other end of a long way may seem near on the circle.
            Vector::Joint(_) => here + self.rate(held) * length,
        };
        let acceleration = self.bounds[constraint].acceleration(0);
        held.kept(
            [here, there],
            0.125 * length * length * acceleration + ROUNDING,
        )
    }

    /// How fast a joint's value changes on the segment.
    fn rate(&self, held: &Held) -> Vec3 {
        held.watched.rate(&Stand {
            kinematics: &self.standing.kinematics,
            configuration: &[],
            velocity: &self.standing.velocity,
        })
    }

    /// Looks where everything is at a place of the segment that begins at `from`.
    fn look_between(&mut self, from: &[f64], t: f64) {
        let mut configuration = std::mem::take(&mut self.standing.configuration);
        let velocity = &self.standing.velocity;
        self.standing
            .space
            .integrate(from, velocity, t, &mut configuration);
        self.look_at(&configuration);
        self.standing.configuration = configuration;
    }

    /// Looks where everything is at a configuration.
    fn look_at(&mut self, configuration: &[f64]) {
        self.looks += 1;
        let robot = self.standing.model.robot();
        let at = |held: &Held| {
            held.watched
                .at_configuration(robot, configuration, self.standing.held)
        };
        self.ends.at.extend(self.allowed.iter().map(at));
    }
}
