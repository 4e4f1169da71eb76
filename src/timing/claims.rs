//! What a certificate claims of a trajectory.

use super::controller::TimedPoint;
use super::limits::{ColumnLimits, Limits};
use super::timed::Timed;
use crate::robot::RobotModel;
use crate::validation::timed::{Claims, Point, certificate};
use crate::validation::{Certificate, LimitClaim, Validator};

impl Timed {
    /// The proof in short; `None` of one that stands still.
    pub fn certificate(&self, validator: &Validator, claims: Claims) -> Option<Certificate> {
        let proof = self.proof.as_ref()?;
        let points: Vec<Point> = self
            .points
            .iter()
            .map(TimedPoint::point)
            .collect();
        Some(certificate(validator, &points, proof, claims))
    }
}

impl Limits {
    /// What is claimed of a curve that keeps them: of each of the robot's variables that has limits.
    pub fn claims(&self, robot: &RobotModel) -> Vec<LimitClaim> {
        let variables = robot.variables().iter().zip(self.columns());
        variables
            .filter(|(_, limits)| limits.velocity.is_usable() && limits.acceleration.is_usable())
            .map(|(variable, limits)| claim(&variable.name, limits))
            .collect()
    }
}

fn claim(variable: &str, limits: &ColumnLimits) -> LimitClaim {
    let [velocity, acceleration] =
        [limits.velocity, limits.acceleration].map(|range| [range.least, range.most]);
    LimitClaim {
        variable: variable.to_owned(),
        velocity,
        acceleration,
    }
}
