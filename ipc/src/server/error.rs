//! Why a server cannot be created or go on.

use crate::instance::InstanceError;
use crate::wire::Code;

/// Why the server cannot be created or go on.
#[derive(Debug, thiserror::Error)]
pub enum ServerError {
    /// Another daemon serves this instance.
    #[error(
        "another daemon serves instance `{name}` at {root}; stop it or choose another instance with TAUT_INSTANCE=name:/root"
    )]
    AlreadyRunning {
        /// The instance's name.
        name: String,
        /// Its root.
        root: String,
    },
    /// Somebody removed files of the instance while they were made.
    #[error(
        "the files of the instance at {root} or in /dev/shm are removed as soon as they are made; find out by whom, or choose another root"
    )]
    Removed {
        /// Its root.
        root: String,
    },
    /// The instance cannot be used.
    #[error(transparent)]
    Instance(#[from] InstanceError),
    /// Too little shared memory is left.
    #[error("/dev/shm is full but for its reserve; remove files there or enlarge it")]
    NoMemory,
    /// A service or port could not be made; clients of another release may still be connected.
    #[error("cannot set up {what}: {reason}; stop clients of other releases and try again")]
    Setup {
        /// The service or port.
        what: &'static str,
        /// What iceoryx2 said.
        reason: String,
    },
    /// A port stopped working.
    #[error("{what} failed: {reason}")]
    Port {
        /// The port.
        what: &'static str,
        /// What iceoryx2 said.
        reason: String,
    },
}

impl ServerError {
    /// The code for the command line's exit.
    pub fn code(&self) -> Code {
        match self {
            Self::NoMemory => Code::ResourceExhausted,
            _ => Code::DaemonLost,
        }
    }
}
