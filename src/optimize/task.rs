//! What every optimizer is given: a proved input and the rules it keeps.

use std::ops::Range;

use super::cost;
use super::outcome::Stage;
use crate::collision::CollisionModel;
use crate::constraint::Held;
use crate::path::{Metric, Path};
use crate::robot::{Component, ConfigurationSpace};

/// A path is shorter only by more than this part of the other's length: rounding is no progress.
pub const SHORTER: f64 = 1e-9;

/// One optimization problem. The input path is already proved at the validator's floors.
pub struct Task<'a> {
    /// Robot and scene.
    pub model: &'a CollisionModel,
    /// The space of the request (circles, or lines where the path is unwrapped).
    pub space: &'a ConfigurationSpace,
    /// The metric of the request.
    pub metric: &'a Metric,
    /// Values of the held variables.
    pub held: &'a [f64],
    /// What the path must keep besides clearances, with the tolerances that the input set.
    pub constraints: Vec<Held>,
    /// Waypoints that must stay as they are, the first and the last among them.
    pub fixed: &'a [bool],
    /// The caller's numbers of those waypoints, laid end to end.
    pub fixed_rows: &'a [f64],
    /// Velocity coordinates that may move.
    pub moving: &'a [bool],
    /// The goal's numbers stay: a path that ends whole turns away is none.
    pub keep_goal: bool,
    /// Seed of every random choice.
    pub seed: u64,
    /// The validator's count of work at which to end.
    pub work_budget: u64,
}

impl Task<'_> {
    /// Length of a path given as flat rows; `velocity` is scratch of nv numbers.
    pub fn length(&self, rows: &[f64], velocity: &mut [f64]) -> f64 {
        cost::length(self.space, self.metric, rows, velocity)
    }

    /// `to` ← `from ⊕ part · step`; fixed waypoints and components that may not move keep their
    /// bits.
    pub fn displace(&self, from: &Path, fixed: &[bool], step: &[f64], part: f64, to: &mut Path) {
        let steps = step.chunks_exact(self.space.nv());
        for (i, (is_fixed, step)) in fixed.iter().zip(steps).enumerate() {
            let before = from.waypoint(i);
            let after = to.waypoint_mut(i);
            if *is_fixed {
                // A trial before may have moved it by whole turns.
                after.copy_from_slice(before);
            } else {
                self.space.integrate(before, step, part, after);
                self.keep_still(before, after);
            }
        }
    }

    /// Gives what may not move its bits back.
    fn keep_still(&self, before: &[f64], after: &mut [f64]) {
        for columns in self.still_columns() {
            after[columns.clone()].copy_from_slice(&before[columns]);
        }
    }

    /// Columns of what may not move.
    fn still_columns(&self) -> impl Iterator<Item = Range<usize>> {
        let components = self.space.components().iter();
        components
            .filter(|component| !self.may_move(component))
            .map(columns)
    }

    /// Whether a factor of the space may move: all of its coordinates.
    pub fn may_move(&self, component: &Component) -> bool {
        self.moving[coordinates(component)]
            .iter()
            .all(|moves| *moves)
    }
}

/// A shorter path that was just proved.
#[derive(Clone, Copy, Debug)]
pub struct Improvement<'a> {
    /// The path.
    pub path: &'a Path,
    /// Its length in the request's metric.
    pub length: f64,
    /// Iterations so far.
    pub iterations: u64,
    /// Pairs examined so far.
    pub work: u64,
    /// The stage that found it.
    pub stage: Stage,
}

/// Columns of a factor of the space.
pub fn columns(component: &Component) -> Range<usize> {
    match *component {
        Component::Line { q, .. } | Component::Circle { q, .. } => q..q + 1,
        Component::Rotation { q, .. } => q..q + 4,
    }
}

/// Velocity coordinates of a factor of the space.
fn coordinates(component: &Component) -> Range<usize> {
    match *component {
        Component::Line { v, .. } | Component::Circle { v, .. } => v..v + 1,
        Component::Rotation { v, .. } => v..v + 3,
    }
}
