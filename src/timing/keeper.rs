//! What every part of a trajectory must keep, as it is written: the limits of its columns, and whatever a
//! validator proves.

use super::controller::{Controller, Manner, TimedPoint};
use super::limits::Limits;
use super::pace::BEYOND;
use super::ramp::Motors;
use super::trajectory::{Trajectory, Window};
use crate::robot::RobotModel;
use crate::validation::Validator;
use crate::validation::timed::{self, Curve, CurveError, Point, TimedProof};

/// Ramps of columns have phases of so many nanoseconds at least.
const TICK_NS: i64 = 100_000;

/// A trajectory as it is written, and what a controller makes of that.
#[derive(Clone, Debug)]
pub struct Written {
    /// The points.
    pub points: Vec<TimedPoint>,
    /// The curve through them.
    pub curve: Curve,
}

/// Whoever is asked whether a trajectory may be executed.
pub struct Keeper<'k, 'm> {
    robot: &'k RobotModel,
    validator: &'k mut Validator<'m>,
    limits: &'k Limits,
    controller: Controller,
    /// How far the path itself is outside of its hard and its soft limits (m or rad).
    outside: [f64; 2],
}

impl<'k, 'm> Keeper<'k, 'm> {
    /// Of trajectories for a controller.
    pub fn new(
        robot: &'k RobotModel,
        validator: &'k mut Validator<'m>,
        limits: &'k Limits,
        controller: Controller,
    ) -> Self {
        Self {
            outside: [f64::INFINITY; 2],
            robot,
            validator,
            limits,
            controller,
        }
    }

    /// From now on nothing may be farther outside of the limits than this is.
    pub fn stay_inside(&mut self, path: &Curve) {
        self.outside = outside(self.robot, path);
    }

    /// The robot.
    pub fn robot(&self) -> &'k RobotModel {
        self.robot
    }

    /// Whoever proves.
    pub fn validator(&mut self) -> &mut Validator<'m> {
        self.validator
    }

    /// The limits of its columns.
    pub fn limits(&self) -> &'k Limits {
        self.limits
    }

    /// What trajectories must be for the controller.
    pub fn manner(&self) -> Manner {
        self.controller.manner()
    }

    /// What goes along their ramps.
    pub fn motors(&self) -> Motors<'k> {
        Motors {
            limits: self.limits,
            tick_ns: self.manner().grain_ns.max(TICK_NS),
        }
    }

    /// Tests that the validator has made: what work is counted in.
    pub fn work(&self) -> u64 {
        self.validator.work()
    }

    /// A part of a trajectory as it is written.
    ///
    /// # Errors
    /// Times that do not grow, a quaternion that moves.
    pub fn written(&self, trajectory: &Trajectory, window: Window) -> Result<Written, CurveError> {
        let points = self.controller.points(trajectory, window);
        let at: Vec<Point> = points.iter().map(TimedPoint::point).collect();
        let curve = Curve::new(self.robot, &at)?;
        Ok(Written { points, curve })
    }

    /// Whether a part of a trajectory may be executed as it is written; `None` where stopped.
    pub fn keeps(
        &mut self,
        trajectory: &Trajectory,
        window: Window,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<bool> {
        match self.written(trajectory, window) {
            Ok(written) if self.is_within(&written.curve) => self.proves(&written.curve, stop),
            _ => Some(false),
        }
    }

    /// Whether a curve is proved, however fast it is.
    pub fn proves(&mut self, curve: &Curve, stop: &mut dyn FnMut() -> bool) -> Option<bool> {
        Some(self.proof(curve, stop)?.is_some())
    }

    /// Its proof, if it is proved; `None` where stopped.
    pub fn proof(
        &mut self,
        curve: &Curve,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Option<TimedProof>> {
        timed::proof(self.validator, curve, stop)
    }

    /// Whether a curve keeps the limits of positions, velocities and accelerations.
    pub fn is_within(&self, curve: &Curve) -> bool {
        let usage = self.limits.usage(curve);
        let most = usage.velocity.part.max(usage.acceleration.part);
        most <= 1.0 + BEYOND && self.is_inside(curve)
    }

    /// Whether it is no farther outside than the path is.
    fn is_inside(&self, curve: &Curve) -> bool {
        let outside = outside(self.robot, curve);
        outside[0] <= self.outside[0] && outside[1] <= self.outside[1]
    }
}

/// How far a curve is outside of hard and soft limits.
fn outside(robot: &RobotModel, curve: &Curve) -> [f64; 2] {
    [curve.outside(robot), curve.outside_soft(robot)]
        .map(|outside| outside.map_or(0.0, |outside| outside.by))
}
