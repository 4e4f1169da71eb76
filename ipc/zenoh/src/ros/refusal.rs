//! Why a request of a node is not answered with a path.

use std::fmt;
use taut_ipc::planner::PlannerError;
use taut_ipc::wire::Code;

/// A no, as `moveit_msgs/MoveItErrorCodes` says it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Refusal {
    pub code: Code,
    pub message: String,
}

impl Refusal {
    pub fn new(code: Code, message: impl Into<String>) -> Self {
        Self {
            code,
            message: message.into(),
        }
    }

    /// The same, with what else is to be known.
    pub fn with(mut self, note: Option<String>) -> Self {
        if let Some(note) = note {
            self.message = format!("{}; {note}", self.message);
        }
        self
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.code, self.message)
    }
}

impl From<PlannerError> for Refusal {
    fn from(error: PlannerError) -> Self {
        let refusal = Self::new(error.code(), error.to_string());
        match error.retry_after_ms() {
            0 => refusal,
            after => refusal.with(Some(format!("ask again after {after} ms"))),
        }
    }
}
