//! Why a load test has no result.

use std::io;

use taut_ipc::wire::Code;

/// Why a load test has no result.
#[derive(Debug, thiserror::Error)]
pub(in crate::cli) enum LoadError {
    /// A client process ended, or says why it cannot go on.
    #[error(
        "client process {number}: {reason}; run it again with fewer --clients or a longer --duration"
    )]
    Client {
        /// Which one.
        number: usize,
        /// What it said, or what was seen.
        reason: String,
    },
    /// A client process does not answer.
    #[error("client process {0} does not answer; the daemon or the machine hangs")]
    Silent(usize),
    /// The daemon of the test is gone.
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
    /// Ctrl-C, or a signal that asks to end.
    #[error("interrupted; daemon and clients are stopped")]
    Interrupted,
}

impl LoadError {
    /// The exit code.
    pub(in crate::cli) fn exit_code(&self) -> u8 {
        match self {
            Self::Client { .. } | Self::Silent(_) | Self::DaemonGone(_) | Self::Bare(_) => {
                Code::DaemonLost.exit_code()
            }
            Self::System { .. } => 67,
            Self::Interrupted => 130,
        }
    }
}
