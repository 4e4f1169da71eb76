//! Which daemon.

use std::time::{Duration, Instant};

use taut_ipc::client::Loss;
use taut_ipc::planner::{Planner, PlannerError};
use taut_ipc::{ClientError, Instance};

use super::error::CliError;

/// How long a daemon that starts is waited for, also one that starts anew.
const PATIENCE: Duration = Duration::from_secs(3);
/// Pause between two looks at it.
const PAUSE: Duration = Duration::from_millis(20);

/// The choice on the command line.
#[derive(clap::Args)]
pub(super) struct InstanceChoice {
    /// Instance of the daemon: NAME, or NAME:/ROOT; the default is TAUT_INSTANCE
    #[arg(long, value_name = "NAME")]
    pub instance: Option<String>,
}

impl InstanceChoice {
    /// The instance: the option, else the environment, else the default.
    pub(super) fn instance(&self) -> Result<Instance, CliError> {
        let instance = match &self.instance {
            Some(text) => Instance::parse(text),
            None => Instance::from_environment(),
        };
        instance.map_err(|error| CliError::Usage(error.to_string()))
    }

    /// A connection; a daemon that is about to be there is waited for.
    pub(super) fn connect(&self) -> Result<Planner, CliError> {
        let instance = self.instance()?;
        let end = Instant::now() + PATIENCE;
        loop {
            match Planner::connect(&instance) {
                Err(error) if is_on_its_way(&error) && Instant::now() < end => {
                    std::thread::sleep(PAUSE);
                }
                connected => return Ok(connected?),
            }
        }
    }
}

/// Whether a daemon is there that starts, or starts anew.
fn is_on_its_way(error: &PlannerError) -> bool {
    matches!(
        error,
        PlannerError::Client(ClientError::DaemonLost {
            loss: Loss::Starting | Loss::Removed,
            ..
        })
    )
}
