//! Timing: from a proved path to a trajectory that can be executed, proved as it is written, and near the
//! least time that the motors allow.
//!
//! First the robot stops at every waypoint. Then corners are rounded by parabolas as wide as can be proved
//! ([`blend`]), and gone along as fast as the limits allow ([`along`], [`pace`]). Then parts are replaced by
//! faster ramps ([`mod@shortcut`]), which may leave the path as far as can be proved, until the least time that
//! the motors need ([`bound`]) is reached or nothing helps any more. Nothing is taken that is not faster, and
//! nothing is published that is not proved as it is written, in whole nanoseconds, between its points too.
//! A trajectory has a state wherever an acceleration changes: a controller's cubics between them are what
//! was planned. Jerk has no limits here.

pub mod along;
pub mod blend;
pub mod bound;
pub mod controller;
mod error;
mod keeper;
pub mod limits;
pub mod pace;
pub mod ramp;
mod rounded;
mod settings;
pub mod shortcut;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
mod timed;
pub mod trajectory;

pub use bound::Bound;
pub use controller::{Controller, TimedPoint};
pub use error::TimingError;
pub use limits::{ColumnLimits, Limits, Range, Usage, Use};
pub use settings::{Fixed, Settings};
pub use timed::{Outcome, Stage, Timed};
pub use trajectory::{State, TimedState, Trajectory};

use crate::path::Path;
use crate::robot::RobotModel;
use crate::validation::Validator;
use crate::validation::timed::{self as proof, TimedVerdict};
use blend::Corners;
use keeper::Keeper;
use ramp::Phasing;
use shortcut::{Until, shortcut};

/// Times a path: each trajectory that is faster than all before it is published as soon as it is proved,
/// the last is returned. Floors that the stops need lowered stay lowered, unless that is forbidden.
///
/// The validator's space must take columns as they stand, as controllers do.
///
/// # Errors
/// Limits that leave a column no way to move, quaternions that turn, a path that is not proved.
pub fn run(
    robot: &RobotModel,
    validator: &mut Validator,
    path: &Path,
    settings: &Settings,
    stop: &mut dyn FnMut() -> bool,
    publish: &mut dyn FnMut(&Timed),
) -> Result<Outcome, TimingError> {
    check(robot, path, &settings.limits)?;
    supported(settings)?;
    let corners = Corners::new(path, &settings.limits);
    if corners.rows().len() < 2 {
        return Ok(Outcome::Timed(standing(path, settings)));
    }
    let ends = [path.waypoint(0), path.waypoint(path.len() - 1)];
    let velocities = vec![0.0; path.nq()];
    let bound = Bound::between(ends, &velocities, &settings.limits);
    let stops = stops(&corners, &settings.limits)?;
    let curve = trajectory::curve(robot, stops.states())?;
    let proof = match proof::prove(validator, &curve, settings.strict, stop) {
        TimedVerdict::Proved(proof) => proof,
        TimedVerdict::Refused(hit) => return Err(TimingError::Refused(Box::new(hit))),
        TimedVerdict::Stopped => return Ok(Outcome::Stopped),
    };
    let best = Timed {
        usage: settings.limits.usage_by_column(&curve),
        points: stops
            .states()
            .iter()
            .map(TimedPoint::of_state)
            .collect(),
        controller: settings.controller,
        proof: Some(proof),
        stage: Stage::Stops,
        bound,
    };
    publish(&best);
    let mut faster = Faster {
        keeper: Keeper::new(robot, validator, &settings.limits, &curve),
        trajectory: stops,
        best,
        publish,
    };
    // What is found by the time of a stop counts.
    let _finished = faster.run(&corners, settings, stop);
    Ok(Outcome::Timed(faster.best))
}

/// Refuses what is not there yet.
fn supported(settings: &Settings) -> Result<(), TimingError> {
    let is_asked = [
        (settings.start_velocity.is_some(), "a start velocity"),
        (settings.fixed_waypoints != Fixed::Ends, "fixed waypoints"),
        (
            settings.controller != Controller::Cubic,
            "another controller than cubic",
        ),
    ];
    match is_asked.into_iter().find(|(asked, _)| *asked) {
        Some((_, what)) => Err(TimingError::Unsupported(what)),
        None => Ok(()),
    }
}

/// Checks that whatever moves has limits, and that limits are of this robot.
fn check(robot: &RobotModel, path: &Path, limits: &Limits) -> Result<(), TimingError> {
    let expected = robot.space().nq();
    let got = limits.columns().len();
    if got != expected {
        return Err(TimingError::Count { got, expected });
    }
    for (column, own) in limits.columns().iter().enumerate() {
        if !moves(path, column) {
            continue;
        }
        for (what, range) in [
            ("velocity", own.velocity),
            ("acceleration", own.acceleration),
        ] {
            if !range.is_usable() {
                return Err(TimingError::Limit {
                    column: robot.variables()[column].name.clone(),
                    what,
                    least: range.least,
                    most: range.most,
                });
            }
        }
    }
    Ok(())
}

/// Whether a path moves a column.
pub fn moves(path: &Path, column: usize) -> bool {
    let first = path.waypoint(0)[column];
    (1..path.len()).any(|waypoint| path.waypoint(waypoint)[column] != first)
}

/// What does not move needs no proof but its path's.
fn standing(path: &Path, settings: &Settings) -> Timed {
    let state = TimedState::at(0, State::resting(path.waypoint(0)));
    Timed {
        points: vec![TimedPoint::of_state(&state)],
        controller: settings.controller,
        proof: None,
        stage: Stage::Stops,
        usage: vec![Usage::default(); path.nq()],
        bound: Bound::default(),
    }
}

/// From rest to rest between all waypoints, straight.
fn stops(corners: &Corners, limits: &Limits) -> Result<Trajectory, TimingError> {
    let rows = corners.rows();
    let mut states = vec![TimedState::at(0, State::resting(&rows[0]))];
    for (waypoint, ends) in rows.windows(2).enumerate() {
        let [from, to] = [0, 1].map(|end| State::resting(&ends[end]));
        let start_ns = states[states.len() - 1].time_ns;
        let ramp = ramp::between([&from, &to], limits, Phasing::Common, start_ns, i64::MAX);
        let ramp = ramp.ok_or(TimingError::Ramp { waypoint })?;
        states.extend(ramp.into_iter().skip(1));
    }
    Ok(Trajectory::new(states))
}

/// What makes a proved trajectory faster.
struct Faster<'f, 'k, 'm> {
    keeper: Keeper<'k, 'm>,
    /// The best as it was planned.
    trajectory: Trajectory,
    best: Timed,
    publish: &'f mut dyn FnMut(&Timed),
}

impl Faster<'_, '_, '_> {
    /// `None` where stopped.
    fn run(
        &mut self,
        corners: &Corners,
        settings: &Settings,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<()> {
        let most_work = self.keeper.work() + settings.most_work;
        if let Some(rounded) = rounded::rounded(&mut self.keeper, corners.clone(), stop)? {
            self.take(rounded, Stage::Rounded, stop)?;
        }
        let until = Until {
            bound_ns: (self.best.bound.time_s * trajectory::NS) as i64,
            most_work,
        };
        let start = self.trajectory.clone();
        let shorter = shortcut(&mut self.keeper, start, settings.seed, &until, stop);
        self.take(shorter, Stage::Shortcuts, stop)
    }

    /// Takes a trajectory that is faster and proved as a whole; `None` where stopped before that is known.
    fn take(
        &mut self,
        trajectory: Trajectory,
        stage: Stage,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<()> {
        if trajectory.duration_ns() >= self.trajectory.duration_ns() {
            return Some(());
        }
        let Ok(curve) = trajectory::curve(self.keeper.robot(), trajectory.states()) else {
            return Some(());
        };
        if !self.keeper.is_within(&curve) {
            return Some(());
        }
        if let Some(proof) = self.keeper.proof(&curve, stop)? {
            self.best = Timed {
                usage: self.keeper.limits().usage_by_column(&curve),
                points: trajectory
                    .states()
                    .iter()
                    .map(TimedPoint::of_state)
                    .collect(),
                proof: Some(proof),
                stage,
                ..self.best.clone()
            };
            self.trajectory = trajectory;
            (self.publish)(&self.best);
        }
        Some(())
    }
}
