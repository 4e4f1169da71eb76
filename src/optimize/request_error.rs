//! Why a request cannot be computed as it stands.

use crate::constraint::ConstraintError;
use crate::path::MetricError;
use crate::robot::configuration::FARTHEST_ANGLE_RAD;
use crate::validation::path_proof::LEAST_FLOOR_M;

/// How far outside its limits a path may start (m or rad).
pub const LIMIT_TOLERANCE: f64 = 1e-4;
/// How far the norm of a quaternion may be from 1.
pub const QUATERNION_TOLERANCE: f64 = 1e-3;

/// How far a variable that is no angle may move in one path, all steps added up (rad or m): a
/// proof's memory and time grow with it. A path of as many waypoints as there may be, each half a
/// turn from the one before, keeps to it.
pub(super) const FARTHEST_MOTION: f64 = 1e6;

/// A request that cannot be computed as it stands.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RequestError {
    /// Wrong number of columns.
    #[error("the path has {got} columns, robot {robot:?} has {expected} variables: {variables}")]
    Columns {
        /// Columns given.
        got: usize,
        /// Columns needed.
        expected: usize,
        /// Robot.
        robot: String,
        /// Its variables.
        variables: String,
    },
    /// A number that is not one.
    #[error("waypoint {waypoint}: {variable} is {value}; it must be finite")]
    NotFinite {
        /// Waypoint, from 0.
        waypoint: usize,
        /// Variable.
        variable: String,
        /// Value.
        value: f64,
    },
    /// A quaternion of the wrong norm.
    #[error(
        "waypoint {waypoint}: the quaternion that starts at {variable} has norm {norm}; it must be 1 within {QUATERNION_TOLERANCE}"
    )]
    Quaternion {
        /// Waypoint, from 0.
        waypoint: usize,
        /// First variable of the quaternion.
        variable: String,
        /// Its norm.
        norm: f64,
    },
    /// Limits exceeded.
    #[error(
        "waypoint {waypoint}: {variable} is {value}, outside [{lower}, {upper}] by more than {LIMIT_TOLERANCE}"
    )]
    Limits {
        /// Waypoint, from 0.
        waypoint: usize,
        /// Variable.
        variable: String,
        /// Value.
        value: f64,
        /// Lower limit.
        lower: f64,
        /// Upper limit.
        upper: f64,
    },
    /// An angle with too few digits.
    #[error(
        "waypoint {waypoint}: angle {variable} is {value} rad; beyond {FARTHEST_ANGLE_RAD:e} rad whole turns are lost in \
         rounding, write it within a few turns"
    )]
    FarAngle {
        /// Waypoint, from 0.
        waypoint: usize,
        /// Variable.
        variable: String,
        /// Value.
        value: f64,
    },
    /// A motion that no proof of it ends in time.
    #[error(
        "waypoint {waypoint}: by then {variable} has moved by {moved:e}, more than {FARTHEST_MOTION:e} rad or m in one path, \
         which is not proved in any time: write angles within a few turns, or split the path"
    )]
    FarMotion {
        /// Waypoint, from 0.
        waypoint: usize,
        /// Variable.
        variable: String,
        /// Sum of its steps so far (rad or m).
        moved: f64,
    },
    /// A rotation that names no way.
    #[error(
        "waypoint {waypoint}: the quaternion that starts at {variable} is half a turn from the one before, and two ways \
         lead there; put a waypoint between that says which"
    )]
    HalfTurn {
        /// Waypoint, from 0.
        waypoint: usize,
        /// First variable of the quaternion.
        variable: String,
    },
    /// The goal's numbers would have to change.
    #[error(
        "waypoint {waypoint}: {variable} steps from {before} to {value}, more than half a turn, which means the short way \
         round; the goal's number would move by {turns:+} turns and keep_goal forbids it: write the goal that many turns \
         on, put waypoints between, or take the numbers as they stand (unwrapped)"
    )]
    KeepGoal {
        /// Waypoint after the first such step, from 0.
        waypoint: usize,
        /// Variable.
        variable: String,
        /// Value at the waypoint before.
        before: f64,
        /// Value.
        value: f64,
        /// Whole turns by which the goal's number would move.
        turns: i64,
    },
    /// Constraints.
    #[error(transparent)]
    Constraint(#[from] ConstraintError),
    /// What is asked for besides, and not proved of a path with constraints.
    #[error(
        "{what} does not go with path constraints yet: it would not keep them; ask for one of the two"
    )]
    WithConstraints {
        /// What is asked for.
        what: &'static str,
    },
    /// Weights.
    #[error(transparent)]
    Metric(#[from] MetricError),
    /// A list of the wrong length.
    #[error("{what}: {got} entries given, {expected} needed")]
    Count {
        /// Which list.
        what: &'static str,
        /// Entries given.
        got: usize,
        /// Entries needed.
        expected: usize,
    },
    /// A clearance that cannot be promised.
    #[error("clearance {0} m; it must be finite and at least {LEAST_FLOOR_M} m")]
    Clearance(f64),
}
