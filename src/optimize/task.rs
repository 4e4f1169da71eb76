//! What an optimizer is asked to do, and what it may do with the world.

use super::cost;
use crate::collision::CollisionModel;
use crate::path::{Metric, Path};
use crate::robot::{Component, ConfigurationSpace, RobotModel};

/// Everything an optimizer needs of a request; the input path is already proved.
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// Robot and scene.
    pub model: &'a CollisionModel,
    /// The robot.
    pub robot: &'a RobotModel,
    /// Its space; circles may be unwrapped.
    pub space: &'a ConfigurationSpace,
    /// What lengths are measured in.
    pub metric: &'a Metric,
    /// Values of the held variables.
    pub held: &'a [f64],
    /// Waypoints that stay bit-equal, one entry a waypoint; first and last are true.
    pub fixed: &'a [bool],
    /// Coordinates that may move, one entry a velocity coordinate.
    pub moving: &'a [bool],
    /// Seed of every random choice.
    pub seed: u64,
    /// Most work of the validator to spend; `u64::MAX` is no limit.
    pub work_budget: u64,
}

/// Asked often; the optimizer ends soon after it says true.
pub type Stop<'a> = dyn FnMut() -> bool + 'a;

/// Told each better proved path, its length and the iterations so far.
pub type Publish<'a> = dyn FnMut(&Path, f64, u64) + 'a;

/// A path is shorter only by more than this part of the other's length: rounding is no progress.
pub const SHORTER: f64 = 1e-9;

impl Task<'_> {
    /// Length of a path given as flat rows; `velocity` is scratch of nv numbers.
    pub fn length(&self, rows: &[f64], velocity: &mut [f64]) -> f64 {
        cost::length(self.space, self.metric, rows, velocity)
    }

    /// Whether a factor of the space may move: all of its coordinates.
    pub fn may_move(&self, component: &Component) -> bool {
        match *component {
            Component::Line { v, .. } | Component::Circle { v, .. } => self.moving[v],
            Component::Rotation { v, .. } => self.moving[v..v + 3].iter().all(|moves| *moves),
        }
    }
}
