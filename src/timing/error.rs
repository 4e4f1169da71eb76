//! Why a path gets no times.

use crate::validation::timed::{CurveError, TimedHit};

/// What keeps a path from being timed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TimingError {
    /// A column that moves has no usable limit.
    #[error(
        "{column} moves, but its {what} limits are [{least}, {most}]; each must be a number, the first below 0 and the second above"
    )]
    Limit {
        /// The column's name.
        column: String,
        /// Velocity or acceleration.
        what: &'static str,
        /// The limit downwards.
        least: f64,
        /// The limit upwards.
        most: f64,
    },
    /// What is not there yet.
    #[error("{0} is not supported yet")]
    Unsupported(&'static str),
    /// Limits of another robot.
    #[error("limits of {got} columns given; the robot has {expected}")]
    Count {
        /// Columns of the limits.
        got: usize,
        /// Columns of the robot.
        expected: usize,
    },
    /// A joint of more than one value turns.
    #[error(transparent)]
    Curve(#[from] CurveError),
    /// No ramps between two waypoints are found.
    #[error("no ramp from waypoint {waypoint} to the next is found within the limits")]
    Ramp {
        /// The first of the two, from 0.
        waypoint: usize,
    },
    /// The path cannot be proved even with a stop at each waypoint.
    #[error("with a stop at each waypoint the path is not proved")]
    Refused(Box<TimedHit>),
}
