//! Where a request is computed: by the daemon, or in this process. Nothing else knows which.

use std::sync::Arc;

use taut::local::LocalService;
use taut_ipc::ClientError;
use taut_ipc::planner::{Planner, PlannerError};

use super::error::CliError;
use super::instance::InstanceChoice;
use super::load::Loaded;

/// The choice on the command line.
#[derive(clap::Args)]
pub(super) struct Choice {
    /// Work in this process, without a daemon
    #[arg(long, conflicts_with = "instance")]
    local: bool,
    #[command(flatten)]
    instance: InstanceChoice,
}

/// A place.
pub(super) enum Place {
    /// This process.
    Here,
    /// The daemon.
    Daemon(Planner),
}

impl Place {
    /// Goes there.
    ///
    /// # Errors
    /// Where there is no daemon.
    pub(super) fn open(choice: &Choice) -> Result<Self, CliError> {
        if choice.local {
            return Ok(Self::Here);
        }
        let planner = choice
            .instance
            .connect()
            .map_err(without_daemon)?;
        Ok(Self::Daemon(planner))
    }

    /// Who has robots and scenes that were loaded before, and watches paths.
    pub(super) fn daemon(&self) -> Option<&Planner> {
        match self {
            Self::Here => None,
            Self::Daemon(planner) => Some(planner),
        }
    }

    /// Who answers requests about what was read; where that is this process, it has robot and scene
    /// under these labels already, and nothing of another file.
    ///
    /// # Errors
    /// A robot and a scene that do not go together.
    pub(super) fn planner(
        &self,
        loaded: &Loaded,
        robot: &str,
        scene: &str,
    ) -> Result<Planner, CliError> {
        match self {
            Self::Daemon(planner) => Ok(planner.clone()),
            Self::Here => in_process(loaded, robot, scene),
        }
    }

    /// A refusal as this place tells it: this process says what it is about, the daemon its code.
    pub(super) fn refusal(&self, name: &str, error: PlannerError) -> CliError {
        match (self, error) {
            (Self::Here, PlannerError::Refused(refused)) => CliError::Here {
                name: name.to_owned(),
                message: refused.message,
            },
            (_, error) => error.into(),
        }
    }

    /// The id under which `taut why` knows a request.
    pub(super) fn known_id(&self, request_id: u64) -> Option<u64> {
        self.daemon().map(|_| request_id)
    }
}

/// The error of who found no daemon where a daemon is not the only way.
fn without_daemon(error: CliError) -> CliError {
    match error {
        CliError::Client(ClientError::DaemonLost { root, loss }) => {
            CliError::NoDaemon { root, loss }
        }
        error => error,
    }
}

fn in_process(loaded: &Loaded, robot: &str, scene: &str) -> Result<Planner, CliError> {
    let service = Arc::new(LocalService::default());
    service
        .insert((robot, &loaded.robot), (scene, &loaded.scene))
        .map_err(|refusal| CliError::Here {
            name: loaded.name.clone(),
            message: refusal.message,
        })?;
    Ok(Planner::in_process(service))
}
