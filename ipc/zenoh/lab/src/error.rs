//! Why a measurement has no result, and the exit code that says so: the same codes as `taut`'s.

use taut_ipc::own_daemon::OwnDaemonError;
use taut_ipc::planner::PlannerError;
use taut_ipc::{ClientError, InstanceError};

/// Exit code of a command line that cannot be read.
pub(crate) const USAGE: u8 = 64;
const NOT_STARTED: u8 = 67;
const GONE: u8 = 69;

/// Why a measurement has no result.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Error {
    /// No namespace, device or address.
    #[error("{what}: {reason}; hosts take root, iproute2 and /dev/net/tun")]
    Network {
        /// What was made.
        what: String,
        /// What the system says.
        reason: String,
    },
    /// A program that is measured is not there.
    #[error("no program {name} beside this one, in ${variable} or on PATH; {build}")]
    NoProgram {
        /// Its name.
        name: &'static str,
        /// The variable that may name its file.
        variable: &'static str,
        /// How to build it.
        build: &'static str,
    },
    /// A process does not do what it is started for.
    #[error("{what}: {reason}")]
    Process {
        /// Which.
        what: String,
        /// What it did or said.
        reason: String,
    },
    /// Something of the system.
    #[error("{what}: {source}")]
    System {
        /// What was done.
        what: &'static str,
        /// What it says.
        source: std::io::Error,
    },
    /// Zenoh.
    #[error("zenoh: {0}")]
    Zenoh(String),
    /// The instance.
    #[error(transparent)]
    Instance(#[from] InstanceError),
    /// A folder or program.
    #[error(transparent)]
    Start(#[from] OwnDaemonError),
    /// The daemon.
    #[error(transparent)]
    Client(#[from] ClientError),
    /// The daemon, by names.
    #[error(transparent)]
    Planner(#[from] PlannerError),
}

impl Error {
    /// Whether it is this machine that cannot have hosts.
    pub(crate) fn is_of_the_machine(&self) -> bool {
        matches!(self, Self::Network { .. })
    }

    /// Exit code of a command that ends with it.
    pub(crate) fn exit_code(&self) -> u8 {
        match self {
            Self::Network { .. } | Self::NoProgram { .. } | Self::System { .. } => NOT_STARTED,
            Self::Start(error) => error.exit_code(),
            _ => GONE,
        }
    }
}
