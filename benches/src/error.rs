//! Why a measurement has no result, and the exit code that says so: the same codes as `taut`'s.

use std::io::{self, ErrorKind};

use taut::collision::CollisionModelError;
use taut::files::FileError;
use taut::optimize::RequestError;
use taut_ipc::control::Refusal;
use taut_ipc::own_daemon::OwnDaemonError;
use taut_ipc::planner::PlannerError;
use taut_ipc::wire::Code;
use taut_ipc::{ClientError, InstanceError};

/// Exit code of a command line that cannot be read.
pub(crate) const USAGE: u8 = 64;
/// Exit code where a problem could not be read or run.
pub(crate) const BAD_DATA: u8 = 65;
const UNREADABLE: u8 = 66;
const NOT_STARTED: u8 = 67;
const PANICKED: u8 = 70;
/// What shells say of a program that Ctrl-C ended.
const INTERRUPTED: u8 = 130;

/// Why a measurement has no result.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Error {
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
    /// A path that no trajectory comes of.
    #[error("{name}: {reason}")]
    NoTime {
        /// What was being timed.
        name: String,
        /// What is wrong.
        reason: String,
    },
    /// A list of problems that cannot be read.
    #[error(
        "{file}: line {line}: {text:?} is no problem of a list; give SET/NAME, then nothing, given or spheres"
    )]
    List {
        /// Its file.
        file: String,
        /// From 1.
        line: usize,
        /// What stands there.
        text: String,
    },
    /// A defect of the optimizer.
    #[error("{name}: the optimizer panicked: {text}")]
    Panic {
        /// What was being run.
        name: String,
        /// What it said.
        text: String,
    },
    /// An earlier report that cannot be compared with.
    #[error("{file}: {reason}; give what `taut bench FOLDER --format json` wrote")]
    Before {
        /// Its file.
        file: String,
        /// What is wrong.
        reason: String,
    },
    /// The program that serves is not installed.
    #[error(
        "no program taut beside this one or on PATH; build it with `cargo build --release` or install it with `cargo install --path .`"
    )]
    NoTaut,
    /// A daemon of the measurement's own.
    #[error(transparent)]
    OwnDaemon(#[from] OwnDaemonError),
    /// Which daemon.
    #[error(transparent)]
    Instance(#[from] InstanceError),
    /// The connection to the daemon.
    #[error(transparent)]
    Client(#[from] ClientError),
    /// The same, by name.
    #[error(transparent)]
    Planner(#[from] PlannerError),
    /// The daemon's refusal.
    #[error("{}: {message}", code.name())]
    Refused {
        /// Why.
        code: Code,
        /// In words.
        message: String,
    },
    /// A client process ended, or says why it cannot go on.
    #[error(
        "client process {number}: {reason}; run it again with fewer --clients or a longer --duration"
    )]
    Process {
        /// Which one.
        number: usize,
        /// What it said, or what was seen.
        reason: String,
    },
    /// A client process does not answer.
    #[error("client process {0} does not answer; the daemon or the machine hangs")]
    Silent(usize),
    /// The daemon under test is gone.
    #[error("the daemon ended during the test; its log: {0}")]
    DaemonGone(String),
    /// Bare iceoryx2, which is measured beside the daemon.
    #[error("bare iceoryx2: {0}; is there room in /dev/shm and in the folder for temporary files?")]
    Bare(String),
    /// The system.
    #[error("{what}: {source}")]
    System {
        /// What was asked for.
        what: &'static str,
        /// What it says.
        source: io::Error,
    },
    /// Output that cannot be written.
    #[error("{file}: {source}")]
    Output {
        /// File, or standard output.
        file: String,
        /// What the system says.
        source: io::Error,
    },
    /// Ctrl-C, or a signal that asks to end.
    #[error("interrupted; daemon and clients are stopped")]
    Interrupted,
}

impl From<Refusal> for Error {
    fn from(refusal: Refusal) -> Self {
        Self::Refused {
            // A code of a newer daemon is a code all the same; the message says what it means.
            code: Code::try_from(refusal.code).unwrap_or(Code::MalformedRequest),
            message: refusal.message,
        }
    }
}

impl Error {
    /// The exit code.
    pub(crate) fn exit_code(&self) -> u8 {
        match self {
            Self::Usage(_) => USAGE,
            Self::File(FileError::Unreadable { .. }) | Self::Output { .. } => UNREADABLE,
            Self::File(_)
            | Self::Model { .. }
            | Self::Request { .. }
            | Self::NoTime { .. }
            | Self::List { .. }
            | Self::Before { .. } => BAD_DATA,
            Self::Panic { .. } => PANICKED,
            Self::NoTaut | Self::System { .. } => NOT_STARTED,
            Self::Interrupted => INTERRUPTED,
            of_the_daemon => of_the_daemon.daemon_code(),
        }
    }

    fn daemon_code(&self) -> u8 {
        match self {
            Self::OwnDaemon(error) => error.exit_code(),
            Self::Client(error) => error.code().exit_code(),
            Self::Refused { code, .. } => code.exit_code(),
            _ => Code::DaemonLost.exit_code(),
        }
    }

    /// Prints the error in one line and gives the exit code. A reader that has seen enough, such as
    /// `head`, gets no message.
    pub(crate) fn report(&self) -> u8 {
        let closed =
            matches!(self, Self::Output { source, .. } if source.kind() == ErrorKind::BrokenPipe);
        if !closed {
            eprintln!("taut-bench: {self}");
        }
        self.exit_code()
    }
}
