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
mod begun;
pub mod blend;
pub mod bound;
mod checked;
mod claims;
pub mod controller;
mod error;
mod keeper;
pub mod limits;
pub mod pace;
pub mod ramp;
mod rounded;
#[cfg(test)]
mod scenarios;
mod settings;
pub mod shortcut;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
mod through;
mod timed;
pub mod trajectory;

pub use bound::Bound;
pub use checked::moves;
pub use controller::{Controller, TimedPoint};
pub use error::{NoStart, TimingError};
pub use limits::{ColumnLimits, Limits, Range, Usage, Use};
pub use settings::{Fixed, Settings};
pub use timed::{Outcome, Stage, Timed};
pub use trajectory::{State, TimedState, Trajectory};

use crate::path::Path;
use crate::robot::RobotModel;
use crate::validation::Validator;
use crate::validation::timed::{self as proof, TimedProof, TimedVerdict};
use begun::{Begun, Stopping};
use blend::{Corners, distinct};
use keeper::{Keeper, Written};
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
    checked::check(robot, path, settings)?;
    checked::check_standing(validator, path)?;
    let limits = &settings.limits;
    let corners = Corners::new(distinct(path, &settings.fixed_waypoints, limits), limits);
    let start = State {
        velocities: velocities(path, settings),
        ..State::resting(path.waypoint(0))
    };
    let goal = path.waypoint(path.len() - 1);
    let mut timing = Timing {
        keeper: Keeper::new(robot, validator, limits, settings.controller),
        bound: Bound::between(&start, goal, limits),
        settings,
        stop,
    };
    let stands = corners.rows().len() == 1 && start.rests();
    let Some((begun, first)) = timing.stopping(corners, start)? else {
        return Ok(Outcome::Stopped);
    };
    Ok(Outcome::Timed(match stands {
        true => timing.standing(first),
        false => timing.fastest(&begun, first, publish),
    }))
}

/// Of each column when the trajectory begins.
fn velocities(path: &Path, settings: &Settings) -> Vec<f64> {
    let given = settings.start_velocity.clone();
    given.unwrap_or_else(|| vec![0.0; path.nq()])
}

/// A path that gets its times.
struct Timing<'t, 'k, 'm> {
    keeper: Keeper<'k, 'm>,
    settings: &'t Settings,
    bound: Bound,
    stop: &'t mut dyn FnMut() -> bool,
}

/// A trajectory as it is planned and as it is written, with its proof.
struct Found {
    trajectory: Trajectory,
    written: Written,
    proof: TimedProof,
}

impl Timing<'_, '_, '_> {
    /// One point, at a place that is proved.
    fn standing(&self, mut found: Found) -> Timed {
        found.written.points.truncate(1);
        Timed {
            proof: None,
            ..self.timed(&found, Stage::Stops)
        }
    }

    /// A trajectory that stops at every waypoint; `None` where stopped.
    fn stopping(
        &mut self,
        corners: Corners,
        start: State,
    ) -> Result<Option<(Begun, Found)>, TimingError> {
        let manner = self.keeper.manner();
        let rests = Begun::at_rest(corners.clone());
        let Stopping { begun, trajectory } = rests.stopping(&self.keeper.motors(), &manner)?;
        // Whatever is beside the path lowers floors, and what is in its way refuses it.
        let Some(found) = self.prove(trajectory.lasting(self.keeper.motors().tick_ns))? else {
            return Ok(None);
        };
        self.keeper.stay_inside(&found.written.curve);
        if start.rests() {
            return Ok(Some((begun, found)));
        }
        let Some(moving) = begun::moving(&mut self.keeper, &corners, start, self.stop) else {
            return Ok(None);
        };
        let Stopping { begun, trajectory } = moving?;
        let found = self.proved(trajectory);
        Ok(found.flatten().map(|found| (begun, found)))
    }

    /// The proof of a path's first trajectory, with floors lowered where that is allowed.
    fn prove(&mut self, trajectory: Trajectory) -> Result<Option<Found>, TimingError> {
        let written = self
            .keeper
            .written(&trajectory, trajectory.whole())?;
        let strict = self.settings.strict;
        match proof::prove(self.keeper.validator(), &written.curve, strict, self.stop) {
            TimedVerdict::Proved(proof) => Ok(Some(Found {
                trajectory,
                written,
                proof,
            })),
            TimedVerdict::Refused(hit) => Err(TimingError::Refused(Box::new(hit))),
            TimedVerdict::Stopped => Ok(None),
        }
    }

    /// The fastest trajectory that is found, and publishes each that is faster than all before it.
    fn fastest(&mut self, begun: &Begun, first: Found, publish: &mut dyn FnMut(&Timed)) -> Timed {
        let best = self.timed(&first, Stage::Stops);
        publish(&best);
        let mut faster = Faster {
            planned: first.trajectory,
            timing: self,
            best,
            publish,
        };
        // What is found by the time of a stop counts.
        let _finished = faster.run(begun);
        faster.best
    }

    /// A trajectory that is within limits and proved as a whole; `None` where stopped before that is known.
    fn proved(&mut self, trajectory: Trajectory) -> Option<Option<Found>> {
        let written = self
            .keeper
            .written(&trajectory, trajectory.whole());
        let Some(written) = written
            .ok()
            .filter(|written| self.keeper.is_within(&written.curve))
        else {
            return Some(None);
        };
        let proof = self.keeper.proof(&written.curve, self.stop)?;
        Some(proof.map(|proof| Found {
            trajectory,
            written,
            proof,
        }))
    }

    /// What is known of a trajectory.
    fn timed(&self, found: &Found, stage: Stage) -> Timed {
        Timed {
            usage: self
                .settings
                .limits
                .usage_by_column(&found.written.curve),
            points: found.written.points.clone(),
            controller: self.settings.controller,
            proof: Some(found.proof.clone()),
            stage,
            bound: self.bound,
        }
    }
}

/// What makes a proved trajectory faster.
struct Faster<'f, 't, 'k, 'm> {
    timing: &'f mut Timing<'t, 'k, 'm>,
    /// The best as it is planned.
    planned: Trajectory,
    best: Timed,
    publish: &'f mut dyn FnMut(&Timed),
}

impl Faster<'_, '_, '_, '_> {
    /// `None` where stopped.
    fn run(&mut self, begun: &Begun) -> Option<()> {
        let Timing {
            keeper,
            settings,
            bound,
            stop,
        } = &mut *self.timing;
        let until = Until {
            bound_ns: (bound.time_s * trajectory::NS) as i64 + 2 * keeper.manner().ends_ns,
            most_work: keeper.work() + settings.most_work,
        };
        let seed = settings.seed;
        if let Some(rounded) = rounded::rounded(keeper, begun, stop)? {
            self.take(rounded, Stage::Rounded)?;
        }
        let Timing { keeper, stop, .. } = &mut *self.timing;
        let shorter = shortcut(keeper, self.planned.clone(), seed, &until, stop);
        self.take(shorter, Stage::Shortcuts)
    }

    /// Takes a trajectory that is faster and proved; `None` where stopped before that is known.
    fn take(&mut self, trajectory: Trajectory, stage: Stage) -> Option<()> {
        if trajectory.duration_ns() >= self.planned.duration_ns() {
            return Some(());
        }
        let Some(found) = self.timing.proved(trajectory)? else {
            return Some(());
        };
        let timed = self.timing.timed(&found, stage);
        self.planned = found.trajectory;
        if timed.duration_ns() < self.best.duration_ns() {
            self.best = timed;
            (self.publish)(&self.best);
        }
        Some(())
    }
}
