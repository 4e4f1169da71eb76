//! What every optimizer is given: a proved input and the rules it keeps.

use crate::collision::CollisionModel;
use crate::path::{Metric, Path};
use crate::robot::ConfigurationSpace;

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
    /// Waypoints that must stay as they are, the first and the last among them.
    pub fixed: &'a [bool],
    /// Velocity coordinates that may move.
    pub moving: &'a [bool],
    /// Seed of every random choice.
    pub seed: u64,
    /// Most work to spend, in the validator's unit.
    pub work_budget: u64,
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
}
