//! Which daemon.

use taut_ipc::Instance;
use taut_ipc::planner::Planner;

use super::error::CliError;

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

    /// A connection.
    pub(super) fn connect(&self) -> Result<Planner, CliError> {
        Ok(Planner::connect(&self.instance()?)?)
    }
}
