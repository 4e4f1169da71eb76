//! Times of an answer: from a trajectory to sections.

use super::number;
use super::records::{self, Names};
use crate::optimize::PathHold;
use crate::timing::{Controller, Limits, Timed, TimedPoint};
use crate::validation::LoweredFloor;
use taut_ipc::limits::{MAX_POINTS, MAX_RECORDS, MAX_TRAJECTORY_NUMBERS};
use taut_ipc::wire::{self, HoldRecord, LoweredFloorRecord, TrajectoryRecord, TrajectorySections};

/// What became of the times that a request asks for.
#[derive(Clone, Debug, PartialEq)]
pub enum Times {
    /// A trajectory.
    Timed(Box<TimedPath>),
    /// The request ended before one was proved; in words.
    NotReached(String),
    /// None is proved, or none is possible; in words.
    Refused(String),
    /// The path is not proved.
    NoPath,
}

/// A trajectory, with what is known of it by name.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedPath {
    /// The trajectory.
    pub timed: Timed,
    /// What it was allowed.
    pub limits: Limits,
    /// What it is proved at lower floors.
    pub lowered: Vec<LoweredFloor>,
    /// Where it comes nearest to anything.
    pub nearest: Option<PathHold>,
    /// What the first one took that was proved (s).
    pub stops_s: f64,
    /// Work that it took.
    pub work: u64,
}

impl Times {
    /// The same on the wire.
    pub(super) fn status(&self) -> wire::Times {
        match self {
            Self::Timed(_) => wire::Times::Timed,
            Self::NotReached(_) => wire::Times::NotReached,
            Self::Refused(_) => wire::Times::Refused,
            Self::NoPath => wire::Times::NoPath,
        }
    }

    /// Why there is no trajectory, where the path is proved.
    pub(super) fn missing(&self) -> Option<&str> {
        match self {
            Self::NotReached(why) | Self::Refused(why) => Some(why),
            Self::Timed(_) | Self::NoPath => None,
        }
    }

    /// The trajectory; one that is too large for an answer is none.
    #[must_use]
    pub fn that_fits(self) -> Self {
        let Self::Timed(path) = &self else {
            return self;
        };
        let points = path.timed.points.len();
        let columns = path.limits.columns().len();
        if points <= MAX_POINTS && points * columns <= MAX_TRAJECTORY_NUMBERS {
            return self;
        }
        Self::Refused(format!(
            "the trajectory has {points} points of {columns} columns; an answer holds {MAX_TRAJECTORY_NUMBERS} numbers: ask for a lower rate or split the path"
        ))
    }
}

/// The sections of a trajectory.
#[derive(Default)]
pub(super) struct Sections {
    head: Option<TrajectoryRecord>,
    times_ns: Vec<i64>,
    positions: Vec<f64>,
    velocities: Vec<f64>,
    accelerations: Vec<f64>,
    limits: Vec<f64>,
    used: Vec<f64>,
    lowered: Vec<LoweredFloorRecord>,
    nearest: Option<HoldRecord>,
}

impl Sections {
    /// Those of an answer's times; none where there are none.
    pub fn of(times: Option<&Times>, names: &mut Names) -> Self {
        let Some(Times::Timed(path)) = times else {
            return Self::default();
        };
        let points = &path.timed.points;
        let table = |of: fn(&TimedPoint) -> &[f64]| {
            let is_whole = points.iter().all(|point| !of(point).is_empty());
            let rows = points.iter().filter(|_| is_whole);
            rows.flat_map(of).copied().collect()
        };
        let lowered = path.lowered.iter();
        Self {
            head: Some(head(path)),
            times_ns: points
                .iter()
                .map(|point| point.time_ns)
                .collect(),
            positions: table(|point| &point.positions),
            velocities: table(|point| &point.velocities),
            accelerations: table(|point| &point.accelerations),
            limits: limits(&path.limits),
            used: used(&path.timed),
            lowered: lowered
                .map_while(|floor| records::lowered_floor(floor, names))
                .take(MAX_RECORDS)
                .collect(),
            nearest: path
                .nearest
                .as_ref()
                .and_then(|hold| records::hold(hold, names)),
        }
    }

    /// As they are sent.
    pub fn body(&self) -> TrajectorySections<'_> {
        TrajectorySections {
            head: self.head.as_ref(),
            times_ns: &self.times_ns,
            positions: &self.positions,
            velocities: &self.velocities,
            accelerations: &self.accelerations,
            limits: &self.limits,
            used: &self.used,
            lowered_floors: &self.lowered,
            nearest: self.nearest.as_ref(),
        }
    }
}

fn head(path: &TimedPath) -> TrajectoryRecord {
    let timed = &path.timed;
    let proof = timed.proof.as_ref();
    TrajectoryRecord {
        stage: number::wire_timing_stage(timed.stage).into(),
        controller: number::wire_controller(timed.controller).into(),
        rate_hz: match timed.controller {
            Controller::Linear { rate_hz } => rate_hz,
            Controller::Cubic | Controller::Quintic => 0.0,
        },
        bound_s: timed.bound.time_s,
        stops_s: path.stops_s,
        clearance_m: proof.map_or(f64::INFINITY, |proof| proof.clearance_m()),
        work: path.work,
        intervals: proof.map_or(0, |proof| proof.intervals()),
        decides: timed.bound.column as u32,
        reserved: 0,
    }
}

fn limits(limits: &Limits) -> Vec<f64> {
    let columns = limits.columns().iter();
    columns
        .flat_map(|own| {
            [
                own.velocity.least,
                own.velocity.most,
                own.acceleration.least,
                own.acceleration.most,
            ]
        })
        .collect()
}

fn used(timed: &Timed) -> Vec<f64> {
    let columns = timed.usage.iter();
    columns
        .flat_map(|usage| {
            [
                usage.velocity.part,
                usage.velocity.time_s,
                usage.acceleration.part,
                usage.acceleration.time_s,
            ]
        })
        .collect()
}
