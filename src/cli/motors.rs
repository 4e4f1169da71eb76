//! What motors allow, as flags.

use std::path::PathBuf;

use taut::files::{Acceleration, LimitsFile};
use taut::robot::RobotModel;
use taut::timing::Limits;

use super::error::CliError;

/// Where limits of velocity and acceleration come from.
#[derive(clap::Args)]
pub(super) struct Motors {
    /// Limits of joints: MoveIt's joint_limits.yaml; what it does not say of velocities, the URDF does
    #[arg(long, value_name = "FILE")]
    pub limits: Option<PathBuf>,
    /// Greatest acceleration of joints of which --limits says none: 2/s is twice the velocity limit per
    /// second, 1.5 so many rad/s² or m/s²
    #[arg(long, value_name = "TIMES/s|SIZE", value_parser = str::parse::<Acceleration>)]
    pub acceleration: Option<Acceleration>,
}

impl Motors {
    /// The limits of the columns that move.
    ///
    /// # Errors
    /// A file that cannot be read, a column without a limit.
    pub(super) fn limits(
        &self,
        robot: &RobotModel,
        moves: impl Fn(usize) -> bool,
    ) -> Result<Limits, CliError> {
        let file = self.file()?;
        file.limits(robot, moves, self.acceleration)
            .map_err(CliError::Choice)
    }

    /// What the file says; nothing where there is none.
    pub(super) fn file(&self) -> Result<LimitsFile, CliError> {
        match &self.limits {
            Some(file) => Ok(LimitsFile::read(file)?),
            None => Ok(LimitsFile::default()),
        }
    }
}
