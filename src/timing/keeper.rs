//! What every part of a trajectory must keep: the limits of its columns, and whatever a validator proves.

use super::limits::{Limits, Usage};
use super::pace::BEYOND;
use super::trajectory::{TimedState, curve};
use crate::robot::RobotModel;
use crate::validation::Validator;
use crate::validation::timed::{self, Curve, TimedProof};

/// Whoever is asked whether states may be executed.
pub struct Keeper<'k, 'm> {
    robot: &'k RobotModel,
    validator: &'k mut Validator<'m>,
    limits: &'k Limits,
    /// How far the path itself is outside of its hard and its soft limits (m or rad).
    outside: [f64; 2],
    /// Proofs that were asked for.
    pub proofs: u32,
}

impl<'k, 'm> Keeper<'k, 'm> {
    /// Of a path that this curve follows: nothing may be farther outside than it.
    pub fn new(
        robot: &'k RobotModel,
        validator: &'k mut Validator<'m>,
        limits: &'k Limits,
        path: &Curve,
    ) -> Self {
        Self {
            outside: outside(robot, path),
            robot,
            validator,
            limits,
            proofs: 0,
        }
    }

    /// The robot.
    pub fn robot(&self) -> &'k RobotModel {
        self.robot
    }

    /// Its limits.
    pub fn limits(&self) -> &'k Limits {
        self.limits
    }

    /// Tests that the validator has made: what work is counted in.
    pub fn work(&self) -> u64 {
        self.validator.work()
    }

    /// Whether states may be executed as they are written; `None` where stopped.
    pub fn keeps(&mut self, states: &[TimedState], stop: &mut dyn FnMut() -> bool) -> Option<bool> {
        let Ok(curve) = curve(self.robot, states) else {
            return Some(false);
        };
        if !self.is_within(&curve) {
            return Some(false);
        }
        self.proves(&curve, stop)
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
        self.proofs += 1;
        timed::proof(self.validator, curve, stop)
    }

    /// Whether a curve keeps the limits of positions, velocities and accelerations.
    pub fn is_within(&self, curve: &Curve) -> bool {
        let Usage {
            velocity,
            acceleration,
        } = self.limits.usage(curve);
        let is_slow = velocity.part <= 1.0 + BEYOND && acceleration.part <= 1.0 + BEYOND;
        is_slow && self.is_inside(curve)
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
