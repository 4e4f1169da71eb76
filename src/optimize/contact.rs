//! The gradient with contact half-spaces: the string is pulled taut around what holds it.
//!
//! The model is the paper's ([`gradient`](super::gradient)) with three changes.
//! * The stiffness of each segment is that of the *present* path, λ = 1/length. Then the cost's
//!   gradient is the length's, and the cost bounds the length from above: a step that lowers it
//!   shortens the path, and the loop ends at a shortest one, not at a path whose segments keep
//!   their ratio.
//! * The rows are half-spaces `j p ≥ 2δ − d` from true closest points
//!   ([`half_space`](super::half_space)), made anew at each accepted path (`Holds`) and released
//!   where they do not push ([`ActiveSet`]).
//! * A trial that is refused adds a half-space and another is tried, at first of half the step,
//!   then of all of it; after some refusals in a row less of the step is tried, no more than at
//!   which the pair was seen apart.
//!
//! Once nothing more is gained, segments that are pushed on their inside get a waypoint there, and
//! it goes on.

use super::active_set::{ActiveSet, Unsolved};
use super::cost::{Cost, rest_lengths, segment_lengths};
use super::holds::{HeldModel, Holds, Ray};
use super::limits::Limits;
use super::outcome::{Stage, Termination};
use super::progress::{Progress, Tried};
use super::shortcut;
use crate::path::Path;
use crate::validation::{Requirement, SegmentRefusal};
use std::ops::ControlFlow;

/// A segment shorter than this part of the path is no stiffer: neighbours that meet do not lock
/// each other.
const SHORTEST_SEGMENT: f64 = 1e-3;

/// Trials from one path.
const TRIALS: u32 = 24;

/// Part of the step that is tried first, while the half-spaces are not known yet.
const FIRST_PART: f64 = 0.5;

/// By how much more of the next step is tried than of one that was accepted: from half of it to all
/// of it in two trials, so that a path in the open is nearly straight before the first dear
/// refusal.
const GROWTH: f64 = 1.7;

/// The smallest part of a step that is tried.
const SMALLEST_PART: f64 = 0.02;

/// Trials refused in a row before less of the step is tried.
const PATIENCE: u32 = 4;

/// A step that shortens the path by less than this part is small.
const SMALL_GAIN: f64 = 2e-4;

/// Without this gain since the last, new waypoints are not worth their cost.
const WORTH_REFINING: f64 = 1e-3;

/// No segment shorter than this part of the path is split: micro-segments break the timing of a
/// path.
const SHORTEST_SPLIT: f64 = 0.04;

/// Pulls the path taut; returns why that ended.
pub fn optimize(progress: &mut Progress) -> Termination {
    if let Some(termination) = thin_out(progress) {
        return termination;
    }
    progress.enter(Stage::Contact);
    let mut descent = Descent::new(progress);
    loop {
        let before = descent.progress.best.length();
        if let Some(termination) = descent.converge() {
            return termination;
        }
        let has_gained = descent.progress.best.length() < before * (1.0 - WORTH_REFINING);
        if !(has_gained && descent.refine()) {
            return Termination::Converged;
        }
    }
}

/// Leaves out what a path that follows constraints can do without: they hold it everywhere, so that each
/// waypoint costs rows, and it gets new ones where it must bend. Says why the run must end, if it must.
fn thin_out(progress: &mut Progress) -> Option<Termination> {
    match progress.task.constraints.is_empty() {
        true => None,
        false => shortcut::leave_out_needless(progress),
    }
}

/// What came of the trials from one path.
enum Pulled {
    /// A shorter path, by this part of the length.
    By(f64),
    /// None was found.
    Nothing,
    Ended(Termination),
}

/// The path x₀, the trial x₁ = x₀ ⊕ αp, and the model that p comes from.
struct Descent<'s, 'r, 'm> {
    progress: &'s mut Progress<'r, 'm>,
    /// x₀: the best path, perhaps with waypoints more.
    path: Path,
    fixed: Vec<bool>,
    holds: Holds<'r>,
    cost: Cost<'r>,
    set: ActiveSet,
    limits: Limits,
    /// α of the next first trial.
    part: f64,
    /// x₁.
    trial: Path,
    gradient: Vec<f64>,
    /// p: one row of nv numbers for each waypoint.
    step: Vec<f64>,
    velocity: Vec<f64>,
}

impl<'s, 'r, 'm> Descent<'s, 'r, 'm> {
    fn new(progress: &'s mut Progress<'r, 'm>) -> Self {
        let task = progress.task;
        let path = progress.best.path().clone();
        let fixed = progress.best.fixed().to_vec();
        let size = path.len() * task.space.nv();
        Self {
            holds: Holds::new(task),
            cost: Cost::new(task.space, task.metric, path.as_flat(), &fixed, task.moving),
            set: ActiveSet::new(task.space.nv()),
            limits: Limits::new(task, &fixed),
            part: FIRST_PART,
            trial: path.clone(),
            gradient: vec![0.0; size],
            step: vec![0.0; size],
            velocity: vec![0.0; task.space.nv()],
            path,
            fixed,
            progress,
        }
    }

    /// Pulls until nothing is gained any more; says why the run must end, if it must.
    fn converge(&mut self) -> Option<Termination> {
        let mut small = 0;
        while small < 2 {
            match self.pull() {
                Pulled::Ended(termination) => return Some(termination),
                Pulled::By(gain) if gain >= SMALL_GAIN => small = 0,
                Pulled::By(_) => small += 1,
                Pulled::Nothing => small += 2,
            }
        }
        None
    }

    /// Tries steps from x₀ until one is shorter and proved.
    fn pull(&mut self) -> Pulled {
        self.linearise();
        if self.update_step().is_none() {
            return Pulled::Ended(Termination::Stopped);
        }
        let mut part = self.part;
        for trial in 1..=TRIALS {
            match self.attempt(trial, part) {
                ControlFlow::Continue(next) => part = next,
                ControlFlow::Break(pulled) => return pulled,
            }
        }
        self.give_up()
    }

    /// Tries a part of the step; the part to try next, or what came of it.
    fn attempt(&mut self, trial: u32, part: f64) -> ControlFlow<Pulled, f64> {
        if let Some(termination) = self.progress.must_end() {
            return ControlFlow::Break(Pulled::Ended(termination));
        }
        self.progress.iterations += 1;
        if self.move_trial(part) {
            self.prove_trial(trial, part)
        } else if part < SMALLEST_PART {
            ControlFlow::Break(self.give_up())
        } else {
            // The model bounds the length from above, to first order: less of the step is shorter.
            ControlFlow::Continue(0.5 * part)
        }
    }

    fn prove_trial(&mut self, trial: u32, part: f64) -> ControlFlow<Pulled, f64> {
        match self.try_trial() {
            (Tried::Stopped, _) => ControlFlow::Break(Pulled::Ended(Termination::Stopped)),
            (Tried::Taken, gain) => {
                self.part = (GROWTH * part).min(1.0);
                ControlFlow::Break(Pulled::By(gain))
            }
            (Tried::NotShorter, _) => unreachable!("a trial is seen to be shorter"),
            (Tried::Refused(refusal), _) => self.hold_back(&refusal, trial, part),
        }
    }

    /// Learns from a refusal, and turns the step or takes less of it.
    fn hold_back(
        &mut self,
        refusal: &SegmentRefusal,
        trial: u32,
        part: f64,
    ) -> ControlFlow<Pulled, f64> {
        let apart = self.learn(refusal, part);
        if trial.is_multiple_of(PATIENCE) {
            // Just short of the touch; but a look that was bad must neither stop the descent nor keep it
            // where it is.
            return ControlFlow::Continue((0.95 * apart).clamp(0.25 * part, 0.9 * part));
        }
        match self.update_step() {
            Some(()) => ControlFlow::Continue(part),
            None => ControlFlow::Break(Pulled::Ended(Termination::Stopped)),
        }
    }

    fn give_up(&mut self) -> Pulled {
        self.part = (0.5 * self.part).max(SMALLEST_PART);
        Pulled::Nothing
    }

    /// The model at x₀: cost, gradient, and the half-spaces of what is known to hold the path.
    fn linearise(&mut self) {
        self.soften();
        let rows = self.path.as_flat();
        self.cost
            .gradient(rows, &mut self.velocity, &mut self.gradient);
        self.set.begin(&self.cost, &self.gradient);
        self.limits.release();
        self.progress.pinched.clear();
        let mut model = HeldModel {
            floors: self.progress.validator.floors(),
            cost: &self.cost,
            set: &mut self.set,
        };
        self.holds.linearise(&self.path, &mut model);
    }

    /// λ ← 1/length of the present segments.
    fn soften(&mut self) {
        let task = self.progress.task;
        let lengths = rest_lengths(
            task.space,
            task.metric,
            self.path.as_flat(),
            SHORTEST_SEGMENT,
        );
        self.cost =
            Cost::of_rest_lengths(task.space, task.metric, &lengths, &self.fixed, task.moving);
    }

    /// p ← the minimum of the model under half-spaces and limits; `None` where stopped.
    fn update_step(&mut self) -> Option<()> {
        loop {
            self.solve()?;
            self.set.step(&self.cost, &mut self.step);
            // Limits come in lazily: most never hold the path, and a row for each would cost more than
            // solving again.
            if !self.push_left_limits()? {
                return Some(());
            }
        }
    }

    fn push_left_limits(&mut self) -> Option<bool> {
        let rows = self.path.as_flat();
        let stop = &mut *self.progress.stop;
        self.limits
            .push_left(&mut self.set, &self.cost, rows, &self.step, stop)
    }

    /// The multipliers under the half-spaces; those that no step satisfies give way.
    fn solve(&mut self) -> Option<()> {
        loop {
            match self.set.solve(self.progress.stop) {
                Ok(()) => return Some(()),
                Err(Unsolved::Stopped) => return None,
                Err(Unsolved::Infeasible { row }) => {
                    let pinched = self.holds.give_way(row, &mut self.set);
                    self.progress.pinched.extend(pinched);
                }
            }
        }
    }

    /// x₁ ← x₀ ⊕ αp; says whether it can be taken and is shorter.
    fn move_trial(&mut self, part: f64) -> bool {
        let task = self.progress.task;
        let best = &self.progress.best;
        let part = part.min(
            self.limits
                .largest_part(self.path.as_flat(), &self.step),
        );
        task.displace(&self.path, &self.fixed, &self.step, part, &mut self.trial);
        self.limits.settle(&self.path, &mut self.trial);
        best.unroll(&mut self.trial, &self.fixed)
            && best.is_longer_than(task.length(self.trial.as_flat(), &mut self.velocity))
    }

    /// Adds half-spaces for what was refused of the trial; returns the part of p at which all of that
    /// was seen kept.
    fn learn(&mut self, refusal: &SegmentRefusal, part: f64) -> f64 {
        let refusals = self.refusals_like(refusal);
        let ray = Ray {
            path: &self.path,
            step: &self.step,
            part,
        };
        let mut model = HeldModel {
            floors: self.progress.validator.floors(),
            cost: &self.cost,
            set: &mut self.set,
        };
        let learn = |refusal| self.holds.learn(refusal, ray, &mut model);
        refusals.iter().map(learn).fold(part, f64::min)
    }

    /// What refuses the trial as this does: all constraints that it violates, on whatever segment, for a
    /// look is cheap; else only this.
    fn refusals_like(&mut self, refusal: &SegmentRefusal) -> Vec<SegmentRefusal> {
        match refusal.requirement {
            Requirement::Clearance(_) => vec![*refusal],
            Requirement::Constraint(_) => self
                .progress
                .validator
                .violations(self.trial.as_flat()),
        }
    }

    /// Proves x₁; where that is taken, x₀ ← x₁. Also returns by which part of the length it is
    /// shorter.
    fn try_trial(&mut self) -> (Tried, f64) {
        let before = self.progress.best.length();
        let tried = self.progress.try_path(&self.trial, &self.fixed);
        if tried == Tried::Taken {
            self.step_forward();
        }
        (tried, 1.0 - self.progress.best.length() / before)
    }

    /// x₀ ← x₁.
    fn step_forward(&mut self) {
        self.holds.note_pushes(&self.set);
        std::mem::swap(&mut self.path, &mut self.trial);
    }

    /// Gives each segment that is pushed on its inside a waypoint there, so that the path can bend;
    /// false where none is, or only short ones are.
    fn refine(&mut self) -> bool {
        let waypoints = self.path.len();
        self.split_where_pushed();
        self.resize();
        self.path.len() > waypoints
    }

    fn split_where_pushed(&mut self) {
        let task = self.progress.task;
        let lengths = segment_lengths(task.space, task.metric, self.path.as_flat());
        // From the last segment to the first, so that the numbers of those to come stay.
        for (segment, ratio) in self.holds.pushed_inside() {
            if lengths[segment] > SHORTEST_SPLIT * self.progress.best.length() {
                self.split(segment, ratio);
            }
        }
    }

    /// Gives a segment a waypoint at a ratio.
    fn split(&mut self, segment: usize, ratio: f64) {
        let from = self.path.waypoint(segment);
        let to = self.path.waypoint(segment + 1);
        let middle = self
            .progress
            .task
            .space
            .between(from, to, ratio);
        self.path
            .splice(segment + 1..segment + 1, &middle);
        self.fixed.insert(segment + 1, false);
        self.holds.split(segment, ratio);
    }

    /// Fits the scratch to the waypoints that there are.
    fn resize(&mut self) {
        let task = self.progress.task;
        let size = self.path.len() * task.space.nv();
        self.trial.clone_from(&self.path);
        self.gradient.resize(size, 0.0);
        self.step.resize(size, 0.0);
        self.limits = Limits::new(task, &self.fixed);
    }
}
