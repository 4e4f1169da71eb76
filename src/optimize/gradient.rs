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
        let halved = if let Self::Cautious { halved, .. } = self {
            halved
        } else {
            0
        };
        (halved < HALVINGS).then_some(Self::Cautious {
            part: self.part() / 2.0,
            halved: halved + 1,
        })
    }
}

/// Pulls the path taut; returns why that ended.
pub fn optimize(progress: &mut Progress) -> Termination {
    progress.enter(Stage::Gradient);
    let mut descent = Descent::new(progress);
    let mut stride = Stride::FIRST;
    for _ in 0..ITERATIONS {
        if let Some(termination) = descent.progress.must_end() {
            return termination;
        }
        descent.progress.iterations += 1;
        if descent.update_step().is_none() {
            return Termination::Stopped;
        }
        if descent.step_norm == 0.0 {
            return Termination::Converged;
        }
        let is_last =
            stride.part() * descent.step_norm < SMALL_STEP * descent.progress.best.length();
        descent.move_trial(stride.part());
        match descent.try_trial() {
            Tried::Stopped => return Termination::Stopped,
            Tried::Taken => {
                // After a whole step there is nothing left under these rows, but where the space is
                // curved.
                if is_last || (stride == Stride::Full && descent.is_at_minimum()) {
                    return Termination::Converged;
                }
                stride = Stride::FIRST;
            }
            Tried::NotShorter => match stride.halved() {
                Some(halved) => stride = halved,
                None => return Termination::Converged,
            },
            Tried::Refused(refusal) if stride != Stride::Full => {
                match descent.add_row(refusal.segment) {
                    Some(true) => stride = Stride::Full,
                    Some(false) => return Termination::Converged,
                    None => return Termination::Stopped,
                }
            }
            // Too far from the path for its rows to mean anything: no row, the same step.
            Tried::Refused(_) => stride = Stride::FIRST,
        }
    }
    Termination::IterationLimit
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
            collision_row: CollisionRow::new(task.model, task.space, task.held),
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
        let rows = self.progress.best.path().as_flat();
        self.cost
            .gradient(rows, &mut self.velocity, &mut self.gradient);
        let quadratic = &mut self.quadratic;
        let count = self.collision_rows;
        self.largest_part = self.limits.solve(
            quadratic,
            count,
            Model {
                cost: &self.cost,
                path: rows,
                gradient: &self.gradient,
            },
            &mut self.step,
            self.progress.stop,
        )?;
        let squares = self
            .step
            .chunks_exact(self.velocity.len())
            .map(|p| self.progress.task.metric.norm(p).powi(2));
        self.step_norm = self.largest_part * squares.sum::<f64>().sqrt();
        self.outdated = false;
        Some(())
    }

    /// Whether the model promises no more than a small step.
    fn is_at_minimum(&mut self) -> bool {
        self.update_step().is_some() && self.step_norm < SMALL_STEP * self.progress.best.length()
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
        let from = self.trial.waypoint(segment);
        let to = self.trial.waypoint(segment + 1);
        let mut hit = match self
            .progress
            .validator
            .first_hit(from, to, self.progress.stop)
        {
            SegmentVerdict::Refused(hit) => hit,
            SegmentVerdict::Proved(_) => return Some(false),
            SegmentVerdict::Stopped => return None,
        };
        let ratio = hit.t;
        let mut q_coll = self.between(&self.trial, segment, ratio);
        let q_free = self.between(self.progress.best.path(), segment, ratio);
        let mut q_clear = q_free.clone();
        self.quadratic.truncate(self.collision_rows);
        for _ in 0..=BISECTIONS {
            if self.append(segment, ratio, &hit, &q_coll, &q_free) {
                self.outdated = true;
                return Some(true);
            }
            let middle = self.interpolate(&q_clear, &q_coll, 0.5);
            match self
                .progress
                .validator
                .segment(&middle, &middle, self.progress.stop)
            {
                SegmentVerdict::Refused(nearer) => (hit, q_coll) = (nearer, middle),
                SegmentVerdict::Proved(_) => q_clear = middle,
                SegmentVerdict::Stopped => return None,
            }
        }
        Some(false)
    }

    fn append(
        &mut self,
        segment: usize,
        ratio: f64,
        hit: &Hit,
        q_coll: &[f64],
        q_free: &[f64],
    ) -> bool {
        let Some(jacobian) = self.collision_row.at(hit, q_coll, q_free) else {
            return false;
        };
        let independent = self.quadratic.append(
            &self.cost,
            Row {
                segment,
                ratio,
                jacobian,
                right_hand_side: 0.0,
            },
        );
        self.collision_rows += usize::from(independent);
        independent
    }

    /// The configuration at a ratio of a segment.
    fn between(&self, path: &Path, segment: usize, ratio: f64) -> Vec<f64> {
        self.interpolate(path.waypoint(segment), path.waypoint(segment + 1), ratio)
    }

    fn interpolate(&self, from: &[f64], to: &[f64], ratio: f64) -> Vec<f64> {
        self.progress.task.space.between(from, to, ratio)
    }
}
