//! Why a demo has no table.

use std::io;
use std::path::PathBuf;

use taut_ipc::wire::Code;
use taut_ipc::{ClientError, InstanceError};

/// Why a demo has no table.
#[derive(Debug, thiserror::Error)]
pub(in crate::cli) enum DemoError {
    /// No folder for the daemon.
    #[error("no folder for the demo's daemon: {0}; set TMPDIR to a short path that can be written")]
    NoFolder(String),
    /// A process cannot be started.
    #[error("{program}: {source}")]
    Start {
        /// This program.
        program: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The daemon ended, or does not come up.
    #[error("the demo's daemon {what}; it says: {log}")]
    Daemon {
        /// What it did.
        what: String,
        /// The end of its log.
        log: String,
    },
    /// The daemon cannot be reached.
    #[error(transparent)]
    Client(#[from] ClientError),
    /// The instance.
    #[error(transparent)]
    Instance(#[from] InstanceError),
    /// Ctrl-C, or a signal that asks to end.
    #[error("interrupted; daemon and planners are stopped")]
    Interrupted,
}

impl DemoError {
    /// The exit code.
    pub(in crate::cli) fn exit_code(&self) -> u8 {
        match self {
            Self::NoFolder(_) => 66,
            Self::Start { .. } => 67,
            Self::Daemon { .. } | Self::Instance(_) => Code::DaemonLost.exit_code(),
            Self::Client(error) => error.code().exit_code(),
            // What shells say of a program that Ctrl-C ended.
            Self::Interrupted => 130,
        }
    }
}
