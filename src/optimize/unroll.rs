//! How a trial is written: a step means its numbers ([`configuration`](crate::robot::configuration)),
//! so a trial that steps by more than half a turn means the short way round, and is written as such,
//! with all that follows whole turns on, before it is proved.

use std::f64::consts::TAU;
use std::ops::Range;

use super::best::Best;
use super::cost::segments;
use crate::path::Path;
use crate::robot::configuration::turns_between;

/// A caller's angle, as many whole turns on as a number that means the same.
pub(super) fn whole_turns_on(given: f64, number: f64) -> f64 {
    given + turns_between(given, number) as f64 * TAU
}

impl Best<'_> {
    /// Writes all of a trial so that its numbers say how it moves; false where it cannot be taken:
    /// a rotation of it names no way, or the goal must keep its numbers and would not.
    pub fn unroll(&self, trial: &mut Path, fixed: &[bool]) -> bool {
        let has_turned = self.task().space.unroll(trial.as_flat_mut());
        if has_turned {
            self.keep_fixed(trial.as_flat_mut(), fixed, 0);
        }
        let goal_stays = !(has_turned && self.task().keep_goal);
        goal_stays && self.names_its_way(trial.as_flat())
    }

    /// The same for `rows` in the place of the waypoints `range`; where what follows moves by whole
    /// turns, `tail` gets it, from the last of them on, else nothing.
    pub fn unroll_part(&self, range: &Range<usize>, rows: &mut [f64], tail: &mut Vec<f64>) -> bool {
        tail.clear();
        if self.task().space.unroll(rows) {
            self.turn_tail(range.end - 1, rows, tail);
        }
        (tail.is_empty() || !self.task().keep_goal) && self.names_its_way(rows)
    }

    /// `tail` ← the waypoints from `first` on, as many whole turns on as the last of `rows` is from
    /// the first of them.
    fn turn_tail(&self, first: usize, rows: &mut [f64], tail: &mut Vec<f64>) {
        let nq = self.path().nq();
        let last = rows.len() - nq;
        for q in self.task().space.circles() {
            let turns = turns_between(self.path().waypoint(first)[q], rows[last + q]);
            if turns != 0 {
                self.turn_column(first, q, turns, tail);
            }
        }
        if !tail.is_empty() {
            let known = self.fixed()[..first]
                .iter()
                .filter(|fixed| **fixed)
                .count();
            self.keep_fixed(tail, &self.fixed()[first..], known);
            rows[last..].copy_from_slice(&tail[..nq]);
        }
    }

    /// Moves a column of the waypoints from `first` on by whole turns.
    fn turn_column(&self, first: usize, q: usize, turns: i64, tail: &mut Vec<f64>) {
        let nq = self.path().nq();
        if tail.is_empty() {
            tail.extend_from_slice(&self.path().as_flat()[first * nq..]);
        }
        tail.iter_mut()
            .skip(q)
            .step_by(nq)
            .for_each(|number| *number += turns as f64 * TAU);
    }

    /// Gives the angles of fixed waypoints the caller's numbers and whole turns, exactly; `first`
    /// fixed ones come before.
    fn keep_fixed(&self, rows: &mut [f64], fixed: &[bool], first: usize) {
        let nq = self.path().nq();
        let rows = rows.chunks_exact_mut(nq).zip(fixed);
        let stay = rows
            .filter(|(_, fixed)| **fixed)
            .map(|(row, _)| row);
        for (row, given) in stay.zip(
            self.task()
                .fixed_rows
                .chunks_exact(nq)
                .skip(first),
        ) {
            for q in self.task().space.circles() {
                row[q] = whole_turns_on(given[q], row[q]);
            }
        }
    }

    fn names_its_way(&self, rows: &[f64]) -> bool {
        let space = self.task().space;
        segments(rows, space.nq()).all(|(from, to)| space.half_turn(from, to).is_none())
    }
}
