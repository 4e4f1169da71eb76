//! Why a demo has no table.

use crate::cli::own_daemon::OwnDaemonError;

/// Why a demo has no table.
#[derive(Debug, thiserror::Error)]
pub(in crate::cli) enum DemoError {
    /// The demo's daemon and planners.
    #[error(transparent)]
    Own(#[from] OwnDaemonError),
    /// Ctrl-C, or a signal that asks to end.
    #[error("interrupted; daemon and planners are stopped")]
    Interrupted,
}

impl DemoError {
    /// The exit code.
    pub(in crate::cli) fn exit_code(&self) -> u8 {
        match self {
            Self::Own(error) => error.exit_code(),
            // What shells say of a program that Ctrl-C ended.
            Self::Interrupted => 130,
        }
    }
}
