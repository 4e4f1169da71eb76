//! The best path so far, and what every optimizer needs to better it.
//!
//! A step means its numbers ([`configuration`](crate::robot::configuration)): a trial that steps by
//! more than half a turn means the short way round, and is written as such, with all that follows
//! whole turns on, before it is proved.

use std::f64::consts::TAU;
use std::ops::Range;

use super::outcome::{Stage, StageShare, Termination};
use super::task::{Improvement, SHORTER, Task};
use crate::path::Path;
use crate::robot::configuration::turns_between;
use crate::validation::{SegmentsVerdict, Validator};

/// One run on one task: optimizers change `path` only to paths that are proved and strictly
/// shorter, or to the same motion with fewer waypoints.
pub struct Progress<'r, 'm> {
    /// What is asked.
    pub task: &'r Task<'r>,
    /// Proves.
    pub validator: &'r mut Validator<'m>,
    /// The best path so far, proved.
    pub path: Path,
    /// Its waypoints that must stay as they are, the first and the last among them.
    pub fixed: Vec<bool>,
    /// Its length.
    pub length: f64,
    /// Pairs whose half-spaces no step satisfied all at the present path.
    pub pinched: Vec<usize>,
    /// Random choices of the whole run.
    pub random: fastrand::Rng,
    /// Trials so far.
    pub iterations: u64,
    /// Ends the run.
    pub stop: &'r mut dyn FnMut() -> bool,
    publish: &'r mut dyn FnMut(Improvement),
    stage: Stage,
    /// The stage that found the path.
    pub found_by: Stage,
    /// Whether every segment is proved: the input's may not be, and then the first shorter paths
    /// may not be either.
    pub is_proved: bool,
    /// Work, length and iterations at the start of the present stage.
    since: (u64, f64, u64),
    shares: Vec<StageShare>,
}

impl<'r, 'm> Progress<'r, 'm> {
    /// Starts from a path without equal neighbours but fixed ones.
    pub fn new(
        task: &'r Task<'r>,
        path: Path,
        is_proved: bool,
        validator: &'r mut Validator<'m>,
        stop: &'r mut dyn FnMut() -> bool,
        publish: &'r mut dyn FnMut(Improvement),
    ) -> Self {
        let length = task.length(path.as_flat(), &mut vec![0.0; task.space.nv()]);
        Self {
            task,
            fixed: task.fixed.to_vec(),
            length,
            pinched: Vec::new(),
            random: fastrand::Rng::with_seed(task.seed),
            iterations: 0,
            stop,
            publish,
            stage: Stage::Input,
            found_by: Stage::Input,
            is_proved,
            since: (validator.work(), length, 0),
            shares: Vec::new(),
            validator,
            path,
        }
    }

    /// Why the run must end now, if it must.
    pub fn must_end(&mut self) -> Option<Termination> {
        if (self.stop)() {
            return Some(Termination::Stopped);
        }
        (self.validator.work() >= self.task.work_budget).then_some(Termination::WorkBudget)
    }

    /// What follows counts for `stage`.
    pub fn enter(&mut self, stage: Stage) {
        let now = (self.validator.work(), self.length, self.iterations);
        let (work, length, iterations) = self.since;
        if self.stage != Stage::Input {
            let known = self
                .shares
                .iter()
                .position(|share| share.stage == self.stage);
            let index = known.unwrap_or_else(|| {
                self.shares.push(StageShare::new(self.stage));
                self.shares.len() - 1
            });
            let share = &mut self.shares[index];
            share.work += now.0 - work;
            share.gain += length - now.1;
            share.iterations += now.2 - iterations;
        }
        self.stage = stage;
        self.since = now;
    }

    /// What each stage has done, in the order in which they first came.
    pub fn shares(&mut self) -> Vec<StageShare> {
        self.enter(Stage::Input);
        std::mem::take(&mut self.shares)
    }

    /// Whether a length is strictly shorter than the path's.
    pub fn is_shorter(&self, length: f64) -> bool {
        length < self.length * (1.0 - SHORTER)
    }

    /// Whether the path is strictly shorter than it was at this length.
    pub fn is_shorter_than(&self, length: f64) -> bool {
        self.length < length * (1.0 - SHORTER)
    }

    /// Writes all of a trial so that its numbers say how it moves; false where it cannot be taken:
    /// a rotation of it names no way, or the goal must keep its numbers and would not.
    pub fn unroll(&self, trial: &mut Path, fixed: &[bool]) -> bool {
        let has_turned = self.task.space.unroll(trial.as_flat_mut());
        if has_turned {
            self.keep_fixed(trial.as_flat_mut(), fixed, 0);
        }
        let goal_stays = !(has_turned && self.task.keep_goal);
        goal_stays && self.names_its_way(trial.as_flat())
    }

    /// The same for `rows` in the place of the waypoints `range`; where what follows moves by whole
    /// turns, `tail` gets it, from the last of them on, else nothing.
    pub fn unroll_part(&self, range: &Range<usize>, rows: &mut [f64], tail: &mut Vec<f64>) -> bool {
        tail.clear();
        if self.task.space.unroll(rows) {
            self.turn_tail(range.end - 1, rows, tail);
        }
        (tail.is_empty() || !self.task.keep_goal) && self.names_its_way(rows)
    }

    /// `tail` ← the waypoints from `first` on, as many whole turns on as the last of `rows` is from
    /// the first of them.
    fn turn_tail(&self, first: usize, rows: &mut [f64], tail: &mut Vec<f64>) {
        let nq = self.path.nq();
        let at = self.path.waypoint(first);
        let last = rows.len() - nq;
        for q in self.task.space.circles() {
            let turns = turns_between(at[q], rows[last + q]);
            if turns == 0 {
                continue;
            }
            if tail.is_empty() {
                tail.extend_from_slice(&self.path.as_flat()[first * nq..]);
            }
            tail.iter_mut()
                .skip(q)
                .step_by(nq)
                .for_each(|number| *number += turns as f64 * TAU);
        }
        if !tail.is_empty() {
            let known = self.fixed[..first].iter().filter(|fixed| **fixed).count();
            self.keep_fixed(tail, &self.fixed[first..], known);
            rows[last..].copy_from_slice(&tail[..nq]);
        }
    }

    /// Gives the angles of fixed waypoints the caller's numbers and whole turns, exactly; `first`
    /// fixed ones come before.
    fn keep_fixed(&self, rows: &mut [f64], fixed: &[bool], first: usize) {
        let nq = self.path.nq();
        let fixed_rows = rows
            .chunks_exact_mut(nq)
            .zip(fixed)
            .filter(|(_, fixed)| **fixed)
            .map(|(row, _)| row);
        for (row, given) in fixed_rows.zip(self.task.fixed_rows.chunks_exact(nq).skip(first)) {
            for q in self.task.space.circles() {
                row[q] = given[q] + turns_between(given[q], row[q]) as f64 * TAU;
            }
        }
    }

    fn names_its_way(&self, rows: &[f64]) -> bool {
        let nq = self.path.nq();
        let mut segments = rows.chunks_exact(nq).zip(rows.chunks_exact(nq).skip(1));
        segments.all(|(from, to)| self.task.space.half_turn(from, to).is_none())
    }

    /// Proves consecutive segments of rows laid end to end.
    pub fn prove(&mut self, rows: &[f64]) -> SegmentsVerdict {
        let nq = self.path.nq();
        let pairs = rows.chunks_exact(nq).zip(rows.chunks_exact(nq).skip(1));
        self.validator
            .segments(pairs.map(|(from, to)| [from, to]), self.stop)
    }

    /// Puts `rows`, which are proved, in the place of the waypoints `range`, whose ends they
    /// repeat; and `tail`, from the last of them on, in the place of what follows, unless it is
    /// empty.
    pub fn replace(&mut self, range: Range<usize>, rows: &[f64], tail: &[f64]) {
        let count = rows.len() / self.path.nq();
        if !tail.is_empty() {
            self.path.splice(range.end - 1..self.path.len(), tail);
        }
        self.fixed.splice(
            range.start + 1..range.end - 1,
            std::iter::repeat_n(false, count - 2),
        );
        self.path.splice(range, rows);
    }

    /// Takes another path with the same waypoints fixed; it is proved and strictly shorter.
    pub fn take(&mut self, path: &mut Path, length: f64) {
        std::mem::swap(&mut self.path, path);
        self.length = length;
        self.publish();
    }

    /// Takes another path with other fixed waypoints; it is proved and strictly shorter.
    pub fn adopt(&mut self, path: &Path, fixed: &[bool], length: f64) {
        self.path.clone_from(path);
        self.fixed.clear();
        self.fixed.extend_from_slice(fixed);
        self.length = length;
        self.publish();
    }

    /// Tells of the path, which has become shorter, if all of it is proved.
    pub fn publish(&mut self) {
        if !self.is_proved {
            // Each optimizer proves what it changes; what it left of the input may still not be
            // provable.
            self.is_proved =
                self.validator.segments(self.path.segments(), self.stop) == SegmentsVerdict::Proved;
        }
        if self.is_proved {
            self.found_by = self.stage;
            let path = &self.path;
            let length = self.length;
            let iterations = self.iterations;
            let stage = self.stage;
            let work = self.validator.work();
            (self.publish)(Improvement {
                path,
                length,
                iterations,
                work,
                stage,
            });
        }
    }
}
