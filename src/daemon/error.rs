//! Why the daemon cannot start or go on.

use taut::files::FileError;
use taut_ipc::server::ServerError;
use taut_ipc::wire::Code;

use crate::daemon::durability::journal::JournalError;
use crate::daemon::state::StateError;

/// Why the daemon cannot start or go on.
#[derive(Debug, thiserror::Error)]
pub enum DaemonError {
    /// A robot or scene to load.
    #[error(transparent)]
    File(#[from] FileError),
    /// Robots and scenes that do not go together, or two of one label.
    #[error("{message}")]
    Model {
        /// Its code.
        code: i32,
        /// What is wrong.
        message: String,
    },
    /// The instance.
    #[error(transparent)]
    Instance(#[from] taut_ipc::InstanceError),
    /// The ports.
    #[error(transparent)]
    Server(#[from] ServerError),
    /// Where robots and scenes are kept.
    #[error(transparent)]
    State(#[from] StateError),
    /// What is kept there.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// Threads and signals.
    #[error("the system gives no {what}: {source}")]
    System {
        /// What was asked for.
        what: &'static str,
        /// What it says.
        source: std::io::Error,
    },
}

impl DaemonError {
    /// The code for the command line's exit.
    pub fn code(&self) -> Code {
        match self {
            Self::File(error) => file_code(error),
            Self::Model { code, .. } => Code::try_from(*code).unwrap_or(Code::InvalidModel),
            Self::Instance(_) => Code::DaemonLost,
            Self::Server(error) => error.code(),
            Self::State(_) => Code::UnreadableFile,
            Self::Journal(error) => error.code(),
            Self::System { .. } => Code::ResourceExhausted,
        }
    }
}

fn file_code(error: &FileError) -> Code {
    match error {
        FileError::Unreadable { .. } => Code::UnreadableFile,
        _ => Code::InvalidModel,
    }
}
