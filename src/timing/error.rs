//! Why a path gets no times.

use super::controller::NoController;
use super::trajectory::{NS, TimedState};
use crate::robot::RobotModel;
use crate::validation::timed::{Curve, CurveError, TimedHit};

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
    /// Limits or velocities of another robot.
    #[error("{what} of {got} columns given; the robot has {expected}")]
    Count {
        /// What they are.
        what: &'static str,
        /// Columns given.
        got: usize,
        /// Columns of the robot.
        expected: usize,
    },
    /// A start velocity that no motor may have.
    #[error("the start velocity of {column} is {value}; its limits are [{least}, {most}]")]
    StartVelocity {
        /// The column's name.
        column: String,
        /// Its velocity (m/s or rad/s).
        value: f64,
        /// The limit downwards.
        least: f64,
        /// The limit upwards.
        most: f64,
    },
    /// A fixed waypoint that is none.
    #[error("waypoint {waypoint} is to be fixed; the path has waypoints 0 to {last}")]
    Fixed {
        /// The number given.
        waypoint: usize,
        /// The last one there is.
        last: usize,
    },
    /// Bodies that no joint moves are in each other, wherever the robot goes.
    #[error("{} overlaps {} where no joint moves them: nothing that moves is proved", .0[0], .0[1])]
    Standing([String; 2]),
    /// A controller that cannot be.
    #[error(transparent)]
    Controller(#[from] NoController),
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
    /// No way from the start velocity is proved.
    #[error(transparent)]
    NoStart(Box<NoStart>),
}

impl TimingError {
    /// What is not kept, and when.
    pub fn hit(&self) -> Option<&TimedHit> {
        match self {
            Self::Refused(hit) => Some(hit),
            Self::NoStart(refused) => refused.hit.as_ref(),
            _ => None,
        }
    }
}

/// What was tried from a start velocity, and what is in the way of the simplest: straight on to rest.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "no trajectory from the start velocity is proved: {tried} ways were tried; straight on it rests after {stop_s:.4} s, {column} {way:+.4} from the start{outside}"
)]
pub struct NoStart {
    /// Ways that were tried.
    pub tried: usize,
    /// How long it takes to come to rest (s).
    pub stop_s: f64,
    /// The column that goes farthest until then.
    pub column: String,
    /// How far that is (m or rad).
    pub way: f64,
    /// Whose limits it leaves until then, in words that follow the others; empty where it does not.
    pub outside: String,
    /// What is not kept until then, and when; `None` where that is proved, but not the way on.
    pub hit: Option<TimedHit>,
}

impl NoStart {
    /// Of a way from one state to rest.
    pub fn new(robot: &RobotModel, [from, rest]: [&TimedState; 2], tried: usize) -> Self {
        let columns = from
            .state
            .positions
            .iter()
            .zip(&rest.state.positions);
        let ways = columns.map(|(from, to)| to - from).enumerate();
        let (column, way) = ways
            .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
            .unwrap_or_default();
        Self {
            tried,
            stop_s: (rest.time_ns - from.time_ns) as f64 / NS,
            column: robot.variables()[column].name.clone(),
            way,
            outside: String::new(),
            hit: None,
        }
    }

    /// Says whose limits a curve leaves, if any.
    pub fn leaves_limits(&mut self, robot: &RobotModel, curve: &Curve) {
        if let Some(outside) = curve.outside(robot) {
            let name = &robot.variables()[outside.column].name;
            self.outside = format!(
                ", outside of the limits of {name} by {:.4} at {:.4} s",
                outside.by, outside.time_s
            );
        }
    }
}
