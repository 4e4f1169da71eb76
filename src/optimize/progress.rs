//! A run of optimizers on one task: what they better the best path with, and whom to tell of it.

use std::ops::Range;

use super::best::{Best, Change};
use super::outcome::{Stage, StageShare, Termination};
use super::task::{Improvement, SHORTER, Task};
use crate::path::Path;
use crate::validation::{Proved, Requirement, RowsVerdict, SegmentRefusal, Validator};

/// What came of a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tried {
    /// It is proved and taken.
    Taken,
    /// It is proved, but not what it was tried for.
    NotShorter,
    /// One of its segments is refused.
    Refused(SegmentRefusal),
    /// `stop` said so.
    Stopped,
}

/// One run on one task.
pub struct Progress<'r, 'm> {
    /// What is asked.
    pub task: &'r Task<'r>,
    /// Proves.
    pub validator: &'r mut Validator<'m>,
    /// The best path so far.
    pub best: Best<'r>,
    /// Requirements whose half-spaces no step satisfied all at the present path.
    pub pinched: Vec<Requirement>,
    /// Random choices of the whole run.
    pub random: fastrand::Rng,
    /// Trials so far.
    pub iterations: u64,
    /// Ends the run.
    pub stop: &'r mut dyn FnMut() -> bool,
    publish: &'r mut dyn FnMut(Improvement),
    stage: Stage,
    found_by: Stage,
    /// Work, length and iterations at the start of the present stage.
    since: (u64, f64, u64),
    shares: Vec<StageShare>,
}

impl<'r, 'm> Progress<'r, 'm> {
    /// Starts from a path without equal neighbours but fixed ones.
    pub fn new(
        best: Best<'r>,
        validator: &'r mut Validator<'m>,
        stop: &'r mut dyn FnMut() -> bool,
        publish: &'r mut dyn FnMut(Improvement),
    ) -> Self {
        let task = best.task();
        Self {
            task,
            pinched: Vec::new(),
            random: fastrand::Rng::with_seed(task.seed),
            iterations: 0,
            stop,
            publish,
            stage: Stage::Input,
            found_by: Stage::Input,
            since: (validator.work(), best.length(), 0),
            shares: Vec::new(),
            validator,
            best,
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
        let now = (self.validator.work(), self.best.length(), self.iterations);
        let (work, length, iterations) = self.since;
        if self.stage != Stage::Input {
            let share = self.share();
            share.work += now.0 - work;
            share.gain += length - now.1;
            share.iterations += now.2 - iterations;
        }
        self.stage = stage;
        self.since = now;
    }

    /// The share of the present stage.
    fn share(&mut self) -> &mut StageShare {
        let index = self.share_index();
        &mut self.shares[index]
    }

    /// Where the share of the present stage is; it is added where there is none.
    fn share_index(&mut self) -> usize {
        let stage = self.stage;
        let known = self
            .shares
            .iter()
            .position(|share| share.stage == stage);
        known.unwrap_or_else(|| {
            self.shares.push(StageShare::new(stage));
            self.shares.len() - 1
        })
    }

    /// What each stage has done, in the order in which they first came.
    pub fn shares(&mut self) -> Vec<StageShare> {
        self.enter(Stage::Input);
        std::mem::take(&mut self.shares)
    }

    /// The stage that found the path.
    pub fn found_by(&self) -> Stage {
        self.found_by
    }

    /// Whether the path is strictly shorter than it was at this length.
    pub fn is_shorter_than(&self, length: f64) -> bool {
        self.best.length() < length * (1.0 - SHORTER)
    }

    /// Proves a whole path with these waypoints fixed, and takes and publishes it if it is strictly
    /// shorter.
    pub fn try_path(&mut self, path: &Path, fixed: &[bool]) -> Tried {
        match self.prove(path.as_flat()) {
            Err(tried) => return tried,
            Ok(proved) if self.best.take(&proved, fixed) => {}
            Ok(_) => return Tried::NotShorter,
        }
        self.publish();
        Tried::Taken
    }

    /// Proves `rows` and, unless it is empty, `tail`, and takes them as [`Best::replace`] does.
    pub fn try_part(
        &mut self,
        range: &Range<usize>,
        rows: &[f64],
        tail: &[f64],
        change: Change,
    ) -> Tried {
        let proved = self
            .prove(rows)
            .and_then(|rows| Ok((rows, self.prove_tail(tail)?)));
        match proved {
            Err(tried) => tried,
            Ok((rows, tail))
                if self
                    .best
                    .replace(range, &rows, tail.as_ref(), change) =>
            {
                Tried::Taken
            }
            Ok(_) => Tried::NotShorter,
        }
    }

    /// What is proved of rows, or what came of them.
    fn prove<'p>(&mut self, rows: &'p [f64]) -> Result<Proved<'p>, Tried> {
        match self.validator.prove(rows, self.stop) {
            RowsVerdict::Proved(proved) => Ok(proved),
            RowsVerdict::Refused(refusal) => Err(Tried::Refused(refusal)),
            RowsVerdict::Stopped => Err(Tried::Stopped),
        }
    }

    /// The same of rows of which there may be none.
    fn prove_tail<'p>(&mut self, tail: &'p [f64]) -> Result<Option<Proved<'p>>, Tried> {
        match tail {
            [] => Ok(None),
            tail => self.prove(tail).map(Some),
        }
    }

    /// Asks for a proof of what has none; says whether all of the path is proved then.
    pub fn prove_rest(&mut self) -> bool {
        self.best.prove_rest(self.validator, self.stop)
    }

    /// Tells of the path, which has become shorter, if all of it is proved: each optimizer proves
    /// what it changes, and what it left of an input that is not proved may still not be provable.
    pub fn publish(&mut self) {
        if self.prove_rest() {
            self.found_by = self.stage;
            (self.publish)(Improvement {
                path: self.best.path(),
                length: self.best.length(),
                iterations: self.iterations,
                work: self.validator.work(),
                stage: self.stage,
            });
        }
    }
}
