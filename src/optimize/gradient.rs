//! The gradient-based method of Campana, Lamiraux and Laumond (*A gradient-based path optimization
//! method for motion planning*, Advanced Robotics, 2016): start reading here.
//!
//! The path is an elastic string ([`Cost`]). Its quadratic model gives a step towards the shortest
//! path under the rows found so far; the rows keep bodies that were seen to collide from
//! approaching ([`CollisionRow`]). The loop tries a cautious part of the step. Where that collides
//! it adds *one* row and tries the whole step to the new minimum; where the whole step collides, it
//! is cautious again.
//!
//! Nothing is believed: a path is accepted only when every segment that changed is proved and it is
//! strictly shorter, so the answer is never worse than the input.

use super::cost::Cost;
use super::limits::{Limits, Model};
use super::outcome::{Stage, Termination};
use super::progress::{Progress, Tried};
use super::quadratic_step::QuadraticStep;
use super::rows::{CollisionRow, Row};
use crate::path::Path;
use crate::validation::{Hit, SegmentVerdict};
use std::ops::ControlFlow;

/// α of a cautious trial: the part of the step that is tried while its rows are not yet known.
const CAUTIOUS_PART: f64 = 0.2;

/// ε: a trial that moves the path by less than this part of its length is the last.
const SMALL_STEP: f64 = 1e-3;

/// A valid trial that is not shorter is halved so many times.
const HALVINGS: u32 = 5;

/// Places between the free and the colliding configuration that are tried for an independent row.
const BISECTIONS: u32 = 5;

/// Iterations, each one validated trial.
const ITERATIONS: u64 = 5000;

/// How much of the step a trial takes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stride {
    /// A part of it: the rows may be far from complete.
    Cautious {
        /// α.
        part: f64,
        /// How many times it was halved.
        halved: u32,
    },
    /// All of it, to the minimum of the model under the newest rows.
    Full,
}

impl Stride {
    const FIRST: Self = Self::Cautious {
        part: CAUTIOUS_PART,
        halved: 0,
    };

    /// α.
    fn part(self) -> f64 {
        match self {
            Self::Cautious { part, .. } => part,
            Self::Full => 1.0,
        }
    }

    fn halved(self) -> Option<Self> {
        let halved = self.times_halved();
        (halved < HALVINGS).then_some(Self::Cautious {
            part: self.part() / 2.0,
            halved: halved + 1,
        })
    }

    fn times_halved(self) -> u32 {
        match self {
            Self::Cautious { halved, .. } => halved,
            Self::Full => 0,
        }
    }
}

/// Pulls the path taut; returns why that ended.
pub fn optimize(progress: &mut Progress) -> Termination {
    progress.enter(Stage::Gradient);
    let mut descent = Descent::new(progress);
    let mut stride = Stride::FIRST;
    for _ in 0..ITERATIONS {
        match descent.iterate(stride) {
            ControlFlow::Continue(next) => stride = next,
            ControlFlow::Break(termination) => return termination,
        }
    }
    Termination::IterationLimit
}

/// On with a stride; where there is none left, nothing more is gained.
fn continue_with(stride: Option<Stride>) -> ControlFlow<Termination, Stride> {
    match stride {
        Some(stride) => ControlFlow::Continue(stride),
        None => ControlFlow::Break(Termination::Converged),
    }
}

/// A collision seen between the path and a trial.
struct Colliding {
    segment: usize,
    ratio: f64,
    hit: Hit,
    /// Where it is.
    q: Vec<f64>,
}

/// The path x₀, the trial x₁ = x₀ ⊕ αp, and the model that p comes from.
struct Descent<'s, 'r, 'm> {
    /// x₀, proved, and its length.
    progress: &'s mut Progress<'r, 'm>,
    fixed: Vec<bool>,
    cost: Cost<'r>,
    quadratic: QuadraticStep,
    collision_rows: usize,
    limits: Limits,
    collision_row: CollisionRow<'r>,
    /// x₁.
    trial: Path,
    /// Whether x₁ can be taken as it is written.
    trial_counts: bool,
    gradient: Vec<f64>,
    /// p: one row of nv numbers for each waypoint.
    step: Vec<f64>,
    /// ‖W p‖ over all waypoints; 0 where it moves nothing.
    step_norm: f64,
    /// The largest part of p that keeps the joint limits; nearly always 1.
    largest_part: f64,
    /// p does not belong to the present path and rows.
    outdated: bool,
    velocity: Vec<f64>,
}

impl<'s, 'r, 'm> Descent<'s, 'r, 'm> {
    fn new(progress: &'s mut Progress<'r, 'm>) -> Self {
        let task = progress.task;
        let path = progress.best.path();
        let fixed = progress.best.fixed().to_vec();
        let cost = Cost::new(task.space, task.metric, path.as_flat(), &fixed, task.moving);
        let size = path.len() * task.space.nv();
        Self {
            quadratic: QuadraticStep::new(&cost),
            cost,
            collision_rows: 0,
            limits: Limits::new(task, &fixed),
            collision_row: CollisionRow::new(task.model, task.space, task.held, &task.constraints),
            trial: path.clone(),
            trial_counts: true,
            gradient: vec![0.0; size],
            step: vec![0.0; size],
            step_norm: 0.0,
            largest_part: 1.0,
            outdated: true,
            velocity: vec![0.0; task.space.nv()],
            fixed,
            progress,
        }
    }

    /// p ← the minimum of the quadratic model under the rows and the limits, where they changed;
    /// `None` where stopped.
    fn update_step(&mut self) -> Option<()> {
        if !self.outdated {
            return Some(());
        }
        self.solve()?;
        let coordinates = self.step.chunks_exact(self.velocity.len());
        let squares = coordinates.map(|p| self.progress.task.metric.norm(p).powi(2));
        self.step_norm = self.largest_part * squares.sum::<f64>().sqrt();
        self.outdated = false;
        Some(())
    }

    fn solve(&mut self) -> Option<()> {
        let path = self.progress.best.path().as_flat();
        self.cost
            .gradient(path, &mut self.velocity, &mut self.gradient);
        let model = Model {
            cost: &self.cost,
            path,
            gradient: &self.gradient,
        };
        self.largest_part = self.limits.solve(
            &mut self.quadratic,
            self.collision_rows,
            model,
            &mut self.step,
            self.progress.stop,
        )?;
        Some(())
    }

    /// One trial; the stride of the next, or why there is none.
    fn iterate(&mut self, stride: Stride) -> ControlFlow<Termination, Stride> {
        if let Some(termination) = self.progress.must_end() {
            return ControlFlow::Break(termination);
        }
        self.progress.iterations += 1;
        if self.update_step().is_none() {
            return ControlFlow::Break(Termination::Stopped);
        }
        if self.step_norm == 0.0 {
            return ControlFlow::Break(Termination::Converged);
        }
        self.step_along(stride)
    }

    /// Tries the part of p that the stride tells.
    fn step_along(&mut self, stride: Stride) -> ControlFlow<Termination, Stride> {
        let is_last = self.is_small(stride.part() * self.step_norm);
        self.move_trial(stride.part());
        match self.try_trial() {
            Tried::Stopped => ControlFlow::Break(Termination::Stopped),
            // After a whole step there is nothing left under these rows, but where the space is curved.
            Tried::Taken if is_last || (stride == Stride::Full && self.is_at_minimum()) => {
                ControlFlow::Break(Termination::Converged)
            }
            Tried::Taken => ControlFlow::Continue(Stride::FIRST),
            Tried::NotShorter => continue_with(stride.halved()),
            // Too far from the path for its rows to mean anything: no row, the same step.
            Tried::Refused(_) if stride == Stride::Full => ControlFlow::Continue(Stride::FIRST),
            Tried::Refused(refusal) => match self.add_row(refusal.segment) {
                Some(found) => continue_with(found.then_some(Stride::Full)),
                None => ControlFlow::Break(Termination::Stopped),
            },
        }
    }

    fn is_small(&self, distance: f64) -> bool {
        distance < SMALL_STEP * self.progress.best.length()
    }

    /// Whether the model promises no more than a small step.
    fn is_at_minimum(&mut self) -> bool {
        self.update_step().is_some() && self.is_small(self.step_norm)
    }

    /// x₁ ← x₀ ⊕ αp; what may not move keeps its bits.
    fn move_trial(&mut self, part: f64) {
        let Progress { task, best, .. } = &*self.progress;
        let part = part.min(self.largest_part);
        task.displace(best.path(), &self.fixed, &self.step, part, &mut self.trial);
        self.limits.settle(best.path(), &mut self.trial);
        self.trial_counts = best.unroll(&mut self.trial, &self.fixed);
    }

    /// Proves the trial and takes it, if it is shorter; what did not move is known.
    fn try_trial(&mut self) -> Tried {
        if !self.trial_counts {
            return Tried::NotShorter;
        }
        let tried = self.progress.try_path(&self.trial, &self.fixed);
        self.outdated |= tried == Tried::Taken;
        tried
    }

    /// Adds one row for the first collision of a refused segment: false where no independent one is
    /// found, `None` where stopped.
    ///
    /// Where the row depends on those there are, another is looked for between the free and the
    /// colliding configuration, by bisection.
    fn add_row(&mut self, segment: usize) -> Option<bool> {
        let hit = match self.first_hit(segment) {
            SegmentVerdict::Refused(hit) => hit,
            SegmentVerdict::Proved(_) => return Some(false),
            SegmentVerdict::Stopped => return None,
        };
        let mut seen = Colliding {
            segment,
            q: self.between(&self.trial, segment, hit.t),
            ratio: hit.t,
            hit,
        };
        let q_free = self.between(self.progress.best.path(), segment, seen.ratio);
        let mut q_clear = q_free.clone();
        self.quadratic.truncate(self.collision_rows);
        for _ in 0..=BISECTIONS {
            if self.append(&seen, &q_free) {
                self.outdated = true;
                return Some(true);
            }
            self.bisect(&mut seen, &mut q_clear)?;
        }
        Some(false)
    }

    fn first_hit(&mut self, segment: usize) -> SegmentVerdict {
        let from = self.trial.waypoint(segment);
        let to = self.trial.waypoint(segment + 1);
        self.progress
            .validator
            .first_hit(from, to, self.progress.stop)
    }

    /// Halves the way from a configuration that is clear to one that collides; `None` where stopped.
    fn bisect(&mut self, seen: &mut Colliding, q_clear: &mut Vec<f64>) -> Option<()> {
        let Progress {
            task,
            validator,
            stop,
            ..
        } = &mut *self.progress;
        let middle = task.space.between(q_clear, &seen.q, 0.5);
        match validator.segment(&middle, &middle, *stop) {
            SegmentVerdict::Refused(nearer) => {
                seen.hit = nearer;
                seen.q = middle;
            }
            SegmentVerdict::Proved(_) => *q_clear = middle,
            SegmentVerdict::Stopped => return None,
        }
        Some(())
    }

    /// Adds the row of a collision; false where it depends on those there are.
    fn append(&mut self, seen: &Colliding, q_free: &[f64]) -> bool {
        let Some(jacobian) = self
            .collision_row
            .at(&seen.hit, &seen.q, q_free)
        else {
            return false;
        };
        let row = Row {
            segment: seen.segment,
            ratio: seen.ratio,
            jacobian,
            right_hand_side: 0.0,
        };
        let independent = self.quadratic.append(&self.cost, row);
        self.collision_rows += usize::from(independent);
        independent
    }

    /// The configuration at a ratio of a segment.
    fn between(&self, path: &Path, segment: usize, ratio: f64) -> Vec<f64> {
        let space = self.progress.task.space;
        space.between(path.waypoint(segment), path.waypoint(segment + 1), ratio)
    }
}
