//! Why a response cannot be taken.

use crate::constraint::ConstraintError;
use taut_ipc::planner::PlannerError;
use taut_ipc::wire::{Code, WireError};

/// Why a response cannot be taken.
#[derive(Debug, thiserror::Error)]
pub enum AnswerError {
    /// It breaks the wire's rules.
    #[error("the daemon's response cannot be read: {0}")]
    Wire(#[from] WireError),
    /// The daemon refused the request.
    #[error("{message}")]
    Refused {
        /// Why.
        code: Code,
        /// In words.
        message: String,
        /// When to try again; 0 = never.
        retry_after_ms: u32,
    },
    /// What it says of constraints is no text of theirs.
    #[error("the daemon's certificate cannot be read: {0}")]
    Constraints(#[from] ConstraintError),
    /// The request names what the robot does not have.
    #[error(transparent)]
    Request(#[from] PlannerError),
    /// The path is another one than the certificate is about.
    #[error("the daemon's certificate is about another path than it sent; report this as a defect")]
    OtherPath,
}
