//! Limits as a certificate claims them.

use super::limits::{ColumnLimits, Limits};
use crate::robot::RobotModel;
use crate::validation::LimitClaim;

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
