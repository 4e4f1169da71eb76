//! The connection to the daemon.

use std::time::Duration;

use taut_ipc::client::retry;
use taut_ipc::control::{ControlReply, ControlRequest};
use taut_ipc::{Client, ClientError, Instance};

use super::error::CliError;
use crate::daemon::DaemonError;

/// How long a control message may take: large meshes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(600);

/// How long a command goes on after its daemon died, or had no room for it: a supervised one is
/// back long before.
pub(super) const RECOVERY: Duration = Duration::from_secs(5);

/// Which daemon.
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
    pub(super) fn connect(&self) -> Result<Client, CliError> {
        Ok(Client::connect(&self.instance()?)?)
    }
}

/// Sends a control message, to the next daemon if the first dies; a refusal is an error here.
pub(super) fn control(client: &Client, message: &ControlRequest) -> Result<ControlReply, CliError> {
    answered(retry(RECOVERY, || client.control(message, PATIENCE))?)
}

/// Sends a control message to the daemon that is there.
pub(super) fn control_once(
    client: &Client,
    message: &ControlRequest,
) -> Result<ControlReply, CliError> {
    answered(client.control(message, PATIENCE)?)
}

fn answered(reply: ControlReply) -> Result<ControlReply, CliError> {
    match reply {
        ControlReply::Refused(refusal) => Err(refusal.into()),
        reply => Ok(reply),
    }
}

/// A reply of another kind than the message asks for: daemon and command of different releases.
pub(super) fn unexpected(reply: &ControlReply) -> CliError {
    let text = format!("the daemon answers {reply:?}; use client and daemon of the same release");
    CliError::Usage(text)
}

/// Whether the daemon went away.
pub(super) fn is_lost(error: &CliError) -> bool {
    matches!(
        error,
        CliError::Client(ClientError::DaemonLost { .. } | ClientError::NoAnswer)
    )
}

impl From<taut_ipc::InstanceError> for CliError {
    fn from(error: taut_ipc::InstanceError) -> Self {
        Self::Daemon(DaemonError::Instance(error))
    }
}
