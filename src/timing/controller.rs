//! What is written for a controller, so that the curve it makes of the points is the one that is proved.

use super::trajectory::{NS, TimedState};
use crate::validation::timed::Point;

/// How a controller goes from a point to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Controller {
    /// By cubics: points have positions and velocities.
    #[default]
    Cubic,
    /// By quintics: points have accelerations too, and these do not jump.
    Quintic,
    /// Straight, at a rate: points have positions only, and follow each other evenly. Velocities and
    /// accelerations are differences of positions at that rate.
    Linear {
        /// Points a second (Hz).
        rate_hz: f64,
    },
}

impl Controller {
    /// Name in results and options.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Cubic => "cubic",
            Self::Quintic => "quintic",
            Self::Linear { .. } => "linear",
        }
    }
}

/// A point as it is written.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedPoint {
    /// From the trajectory's start (ns).
    pub time_ns: i64,
    /// m or rad.
    pub positions: Vec<f64>,
    /// Per second; empty where the controller is to go straight.
    pub velocities: Vec<f64>,
    /// Per second squared; empty where the controller is not to go by quintics.
    pub accelerations: Vec<f64>,
}

impl TimedPoint {
    /// A state, without accelerations.
    pub fn of_state(known: &TimedState) -> Self {
        Self {
            time_ns: known.time_ns,
            positions: known.state.positions.clone(),
            velocities: known.state.velocities.clone(),
            accelerations: Vec::new(),
        }
    }

    /// The same with its time in seconds.
    pub fn point(&self) -> Point {
        Point {
            time_s: self.time_ns as f64 / NS,
            positions: self.positions.clone(),
            velocities: self.velocities.clone(),
            accelerations: self.accelerations.clone(),
        }
    }
}
