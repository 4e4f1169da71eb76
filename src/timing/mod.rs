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
mod claims;
mod error;
mod keeper;
pub mod limits;
pub mod pace;
pub mod ramp;
mod rounded;
pub mod shortcut;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
pub mod trajectory;

pub use error::TimingError;
pub use limits::{ColumnLimits, Limits, Range, Usage, Use};
pub use trajectory::{State, TimedState, Trajectory};

use crate::path::Path;
use crate::robot::RobotModel;
use crate::validation::timed::{self, Claims, TimedProof, TimedVerdict};
use crate::validation::{Certificate, Validator};
use blend::Corners;
use keeper::Keeper;
use ramp::Phasing;
use shortcut::{Until, shortcut};

/// What a trajectory is asked to be.
#[derive(Clone, Debug)]
pub struct Settings {
    /// What the motors allow.
    pub limits: Limits,
    /// Whether no floor may be lowered.
    pub strict: bool,
    /// Of the random choices.
    pub seed: u64,
    /// Work, in a validator's tests of bodies, after which no more is looked for.
    pub most_work: u64,
}

impl Settings {
    /// Work that is enough for most paths.
    pub const DEFAULT_WORK: u64 = 3_000_000;
}

/// What a trajectory comes of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// It stops at every waypoint.
    Stops,
    /// It rounds corners.
    Rounded,
    /// Parts of it are shortcuts in time.
    Shortcuts,
}

impl Stage {
    /// Name in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stops => "stops",
            Self::Rounded => "rounded",
            Self::Shortcuts => "shortcuts",
        }
    }
}

/// A trajectory with its proof.
#[derive(Clone, Debug, PartialEq)]
pub struct Timed {
    /// As it is written.
    pub trajectory: Trajectory,
    /// That it keeps every requirement at every instant; `None` of one that stands still.
    pub proof: Option<TimedProof>,
    /// What it comes of.
    pub stage: Stage,
    /// What it uses of the limits.
    pub usage: Usage,
    /// The least time that the motors need (s).
    pub bound_s: f64,
}

impl Timed {
    /// The proof in short; `None` of one that stands still.
    pub fn certificate(&self, validator: &Validator, claims: Claims) -> Option<Certificate> {
        let proof = self.proof.as_ref()?;
        let points = self.trajectory.points();
        Some(timed::certificate(validator, &points, proof, claims))
    }
}

/// What came of a path.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// The fastest trajectory that was found.
    Timed(Timed),
    /// `stop` said so before there was any.
    Stopped,
}

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
    let corners = Corners::new(path, &settings.limits);
    if corners.rows().len() < 2 {
        return Ok(Outcome::Timed(standing(path)));
    }
    let bound_s = bound::least_s(
        path.waypoint(0),
        path.waypoint(path.len() - 1),
        &settings.limits,
    );
    let stops = stops(&corners, &settings.limits)?;
    let curve = trajectory::curve(robot, stops.states())?;
    let proof = match timed::prove(validator, &curve, settings.strict, stop) {
        TimedVerdict::Proved(proof) => proof,
        TimedVerdict::Refused(hit) => return Err(TimingError::Refused(Box::new(hit))),
        TimedVerdict::Stopped => return Ok(Outcome::Stopped),
    };
    let best = Timed {
        usage: settings.limits.usage(&curve),
        trajectory: stops,
        proof: Some(proof),
        stage: Stage::Stops,
        bound_s,
    };
    publish(&best);
    let mut faster = Faster {
        keeper: Keeper::new(robot, validator, &settings.limits, &curve),
        best,
        publish,
    };
    // What is found by the time of a stop counts.
    let _finished = faster.run(&corners, settings, stop);
    Ok(Outcome::Timed(faster.best))
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
fn standing(path: &Path) -> Timed {
    Timed {
        trajectory: Trajectory::new(vec![TimedState::at(0, State::resting(path.waypoint(0)))]),
        proof: None,
        stage: Stage::Stops,
        usage: Usage::default(),
        bound_s: 0.0,
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
            bound_ns: (self.best.bound_s * trajectory::NS) as i64,
            most_work,
        };
        let start = self.best.trajectory.clone();
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
        if trajectory.duration_ns() >= self.best.trajectory.duration_ns() {
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
                usage: self.keeper.limits().usage(&curve),
                trajectory,
                proof: Some(proof),
                stage,
                bound_s: self.best.bound_s,
            };
            (self.publish)(&self.best);
        }
        Some(())
    }
}
