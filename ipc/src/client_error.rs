//! Why a client's call failed.

use crate::control::ControlError;
use crate::instance::InstanceError;
use crate::limits::ACTIVE_REQUESTS_PER_CLIENT;
use crate::wire::{Code, WireError};
use std::time::Duration;

/// What a client sees of a daemon that is not there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Loss {
    /// It has no lock file.
    #[error("it was never started, or its files were removed")]
    NeverStarted,
    /// Nobody holds its lock.
    #[error("it is not running")]
    NotRunning,
    /// It has not announced itself yet.
    #[error("it is still starting")]
    Starting,
    /// It ended while it was waited for.
    #[error("it went away")]
    WentAway,
    /// Another start of it is there than the one that was waited for.
    #[error("it was restarted")]
    Restarted,
    /// The daemon that a feed came from is not there any more.
    #[error("it went away, and with it what was subscribed")]
    Unsubscribed,
    /// Somebody removed the files by which its clients find it.
    #[error("files of the instance, there or in /dev/shm, were removed")]
    Removed,
}

impl Loss {
    /// The next step.
    pub fn advice(self) -> &'static str {
        match self {
            Self::NeverStarted => {
                "start it (`taut serve`) unless it runs, which starts anew within a second; sending again is safe"
            }
            Self::NotRunning | Self::WentAway => {
                "start it (`taut serve`) and send again, that is safe"
            }
            Self::Starting | Self::Restarted => "send again, that is safe",
            Self::Unsubscribed => "subscribe again",
            Self::Removed => {
                "a daemon that runs notices and starts anew with the same robots and scenes: send again in a second, that is safe"
            }
        }
    }
}

/// Why a client's call failed. What the daemon answered, refusals included, is never one of these.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// No daemon, or it went away.
    #[error("no daemon serves {root}: {loss}; {}", loss.advice())]
    DaemonLost {
        /// The instance's root.
        root: String,
        /// What was seen.
        loss: Loss,
    },
    /// The instance cannot be used.
    #[error(transparent)]
    Instance(#[from] InstanceError),
    /// The daemon serves as many clients as it can.
    #[error(
        "the daemon serves as many clients as it can; close one, or give it more open files (`taut doctor`)"
    )]
    TooManyClients,
    /// This client has as many requests in flight as it may.
    #[error("{ACTIVE_REQUESTS_PER_CLIENT} requests are in flight; finish or drop one")]
    TooManyRequests,
    /// The daemon has not taken this client's earlier requests yet.
    #[error("the daemon has not taken this client's earlier requests yet; send again later")]
    Overloaded,
    /// Too little shared memory is left.
    #[error(
        "no room in /dev/shm for {0} bytes beside the reserve; remove files there or enlarge it"
    )]
    NoMemory(usize),
    /// Nothing came in time; the request still runs.
    #[error("no response within {0:?}; wait again, or drop the request to cancel it")]
    Timeout(Duration),
    /// The caller did not want to wait any longer.
    #[error("given up while waiting for the daemon's reply")]
    GivenUp,
    /// The daemon ended the stream without a final response.
    #[error("the daemon ended the request without a final response")]
    NoAnswer,
    /// What was to be sent, or what came back, breaks the wire's rules.
    #[error(transparent)]
    Wire(#[from] WireError),
    /// A control message cannot be written or read.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// A service or port cannot be opened; daemon and client may be of different releases.
    #[error("cannot open {what}: {reason}; use client and daemon of the same release")]
    Setup {
        /// The service or port.
        what: &'static str,
        /// What iceoryx2 said.
        reason: String,
    },
    /// A port stopped working.
    #[error("{what} failed: {reason}")]
    Transport {
        /// The port.
        what: &'static str,
        /// What iceoryx2 said.
        reason: String,
    },
}

impl ClientError {
    /// The code for the command line's exit and for other languages.
    pub fn code(&self) -> Code {
        match self {
            Self::DaemonLost { .. } | Self::Setup { .. } | Self::Instance(_) => Code::DaemonLost,
            Self::Transport { .. } => Code::DaemonLost,
            Self::TooManyClients | Self::Overloaded => Code::Overloaded,
            Self::TooManyRequests => Code::Quota,
            Self::NoMemory(_) => Code::ResourceExhausted,
            Self::Timeout(_) => Code::TimedOut,
            Self::GivenUp => Code::Preempted,
            Self::NoAnswer => Code::Crash,
            Self::Wire(error) => error.code(),
            Self::Control(ControlError::TooLarge | ControlError::BodyTooLarge(_)) => {
                Code::ResourceExhausted
            }
            Self::Control(ControlError::Malformed(_)) => Code::MalformedRequest,
        }
    }

    #[cfg(feature = "iceoryx2")]
    pub(crate) fn setup(what: &'static str, error: impl std::fmt::Display) -> Self {
        Self::Setup {
            what,
            reason: error.to_string(),
        }
    }

    pub(crate) fn transport(what: &'static str, error: impl std::fmt::Display) -> Self {
        Self::Transport {
            what,
            reason: error.to_string(),
        }
    }
}
