//! Why a command ended without an answer, and the exit code that says so.

use std::io::ErrorKind;
use std::path::Path;

use taut::collision::CollisionModelError;
use taut::files::FileError;
use taut_ipc::ClientError;
use taut_ipc::client::Loss;
use taut_ipc::control::ControlReply;
use taut_ipc::own_daemon::OwnDaemonError;
use taut_ipc::planner::PlannerError;

use crate::daemon::DaemonError;
use crate::daemon::recording::RecordingError;
use crate::daemon::supervise::SuperviseError;
use crate::daemon::translate::AnswerError;
use taut_ipc::wire::Code;

/// Exit code of a command line that cannot be read.
pub(super) const USAGE: u8 = 64;
const BAD_DATA: u8 = 65;
const UNREADABLE: u8 = 66;
const NO_PROGRAM: u8 = 67;

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
    /// A name or number of a request that does not exist.
    #[error("{0}")]
    Choice(String),
    /// What this process cannot compute, or a defect of it.
    #[error("{name}: {message}")]
    Here {
        /// What was being asked about.
        name: String,
        /// What is wrong.
        message: String,
    },
    /// A daemon of the command's own.
    #[error(transparent)]
    OwnDaemon(#[from] OwnDaemonError),
    /// Ctrl-C, or a signal that asks to end.
    #[error("interrupted; daemon and planners are stopped")]
    Interrupted,
    /// A program of taut's own that is not installed.
    #[error("no program {name} beside this one or on PATH; install it with `{install}`")]
    NoProgram {
        /// Its name.
        name: &'static str,
        /// What installs it.
        install: &'static str,
    },
    /// The daemon's refusal.
    #[error("{}: {message}{}", code.name(), next_step(*retry_after_ms))]
    Refused {
        /// Why.
        code: Code,
        /// In words.
        message: String,
        /// When to try again; 0 = never.
        retry_after_ms: u32,
    },
    /// No daemon where one is needed to compute.
    #[error("no daemon serves {root}: {loss}; start one with `taut serve`, or use --local")]
    NoDaemon {
        /// The instance's root.
        root: String,
        /// What was seen.
        loss: Loss,
    },
    /// A recorded run.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The connection to the daemon.
    #[error(transparent)]
    Client(#[from] ClientError),
    /// The daemon itself.
    #[error(transparent)]
    Daemon(#[from] DaemonError),
    /// The daemon and its supervisor.
    #[error(transparent)]
    Supervise(#[from] SuperviseError),
    /// Output that cannot be written.
    #[error("{file}: {source}")]
    Output {
        /// File, or standard output.
        file: String,
        /// What the system says.
        source: std::io::Error,
    },
}

impl From<PlannerError> for CliError {
    fn from(error: PlannerError) -> Self {
        match error {
            PlannerError::Client(error) => Self::Client(error),
            // Of a size and not of a choice: it has an exit code of its own.
            PlannerError::Invalid {
                code: code @ Code::ResourceExhausted,
                message,
            } => Self::refused(code, message),
            PlannerError::Invalid { message, .. } => Self::Choice(message),
            PlannerError::Refused(refused) => Self::Refused {
                code: refused.code,
                message: refused.message,
                retry_after_ms: refused.retry_after_ms,
            },
        }
    }
}

impl From<taut_ipc::InstanceError> for CliError {
    fn from(error: taut_ipc::InstanceError) -> Self {
        Self::Daemon(DaemonError::Instance(error))
    }
}

impl From<AnswerError> for CliError {
    fn from(error: AnswerError) -> Self {
        match error {
            AnswerError::Request(error) => error.into(),
            AnswerError::Refused {
                code,
                message,
                retry_after_ms,
            } => Self::Refused {
                code,
                message,
                retry_after_ms,
            },
            other => Self::refused(Code::Crash, other.to_string()),
        }
    }
}

fn next_step(retry_after_ms: u32) -> String {
    if retry_after_ms == 0 {
        String::new()
    } else {
        format!(" (try again in {retry_after_ms} ms)")
    }
}

impl CliError {
    /// What cannot be had, however often it is asked for.
    pub(super) fn refused(code: Code, message: String) -> Self {
        Self::Refused {
            code,
            message,
            retry_after_ms: 0,
        }
    }

    /// A file that cannot be written.
    pub(super) fn output(file: &Path) -> impl FnOnce(std::io::Error) -> Self {
        move |source| Self::Output {
            file: file.display().to_string(),
            source,
        }
    }

    /// The exit code.
    pub(super) fn exit_code(&self) -> u8 {
        match self {
            Self::Usage(_) => USAGE,
            Self::File(FileError::Unreadable { .. }) | Self::Output { .. } => UNREADABLE,
            Self::File(_) | Self::Model { .. } | Self::Choice(_) | Self::Here { .. } => BAD_DATA,
            Self::OwnDaemon(error) => error.exit_code(),
            Self::NoProgram { .. } => NO_PROGRAM,
            // What shells say of a program that Ctrl-C ended.
            Self::Interrupted => 130,
            Self::Refused { code, .. } => code.exit_code(),
            Self::NoDaemon { .. } => Code::DaemonLost.exit_code(),
            Self::Recording(error) => error.code().exit_code(),
            Self::Client(error) => error.code().exit_code(),
            Self::Daemon(error) => error.code().exit_code(),
            Self::Supervise(error) => error.code().exit_code(),
        }
    }

    /// Prints the error in one line and gives the exit code. A reader that has seen enough, such as
    /// `head`, gets no message.
    pub(super) fn report(&self) -> u8 {
        let closed =
            matches!(self, Self::Output { source, .. } if source.kind() == ErrorKind::BrokenPipe);
        if !closed {
            eprintln!("taut: {self}");
        }
        self.exit_code()
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

/// Standard output that cannot be written.
pub(super) fn stdout(source: std::io::Error) -> CliError {
    CliError::Output {
        file: "standard output".to_owned(),
        source,
    }
}
