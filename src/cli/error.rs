//! Why a command ended without an answer, and the exit code that says so.

use std::io::ErrorKind;

use taut::collision::CollisionModelError;
use taut::files::FileError;
use taut::optimize::RequestError;

/// Exit code of a command line that cannot be read.
pub(super) const USAGE: u8 = 64;
const BAD_DATA: u8 = 65;
const UNREADABLE: u8 = 66;
const PANICKED: u8 = 70;

/// Why a command has no answer.
#[derive(Debug, thiserror::Error)]
pub(super) enum CliError {
    /// Arguments that do not go together.
    #[error("{0}")]
    Usage(String),
    /// A file.
    #[error(transparent)]
    File(#[from] FileError),
    /// A robot and a scene that do not go together.
    #[error("{name}: {source}")]
    Model {
        /// What was being read.
        name: String,
        /// What is wrong.
        source: Box<CollisionModelError>,
    },
    /// A request that cannot be computed.
    #[error("{name}: {source}")]
    Request {
        /// What was being run.
        name: String,
        /// What is wrong.
        source: RequestError,
    },
    /// A defect of this program.
    #[error("{name}: the optimizer panicked: {text}")]
    Panic {
        /// What was being run.
        name: String,
        /// What it said.
        text: String,
    },
    /// The demo's daemon and planners.
    #[error(transparent)]
    Demo(#[from] super::demo::DemoError),
    /// Output that cannot be written.
    #[error("{file}: {source}")]
    Output {
        /// File, or standard output.
        file: String,
        /// What the system says.
        source: std::io::Error,
    },
}

impl CliError {
    /// The exit code.
    pub(super) fn exit_code(&self) -> u8 {
        match self {
            Self::Usage(_) => USAGE,
            Self::File(FileError::Unreadable { .. }) | Self::Output { .. } => UNREADABLE,
            Self::File(_) | Self::Model { .. } | Self::Request { .. } => BAD_DATA,
            Self::Panic { .. } => PANICKED,
            Self::Demo(error) => error.exit_code(),
        }
    }

    /// Prints the error in one line and gives the exit code. A reader that has seen enough, such as `head`,
    /// gets no message.
    pub(super) fn report(&self) -> u8 {
        let closed = matches!(self, Self::Output { source, .. } if source.kind() == ErrorKind::BrokenPipe);
        if !closed {
            eprintln!("taut: {self}");
        }
        self.exit_code()
    }
}

/// Standard output that cannot be written.
pub(super) fn stdout(source: std::io::Error) -> CliError {
    CliError::Output { file: "standard output".to_owned(), source }
}
