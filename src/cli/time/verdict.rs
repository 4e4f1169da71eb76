//! What came of a path, stage by stage.

use taut::timing::Timed;
use taut::validation::{HitReason, LoweredFloor};
use taut_ipc::wire::Code;

use crate::cli::check;

/// What came of a path.
pub(super) enum Verdict {
    Timed(Timed, Vec<LoweredFloor>),
    /// With a stop at each waypoint it is not proved: why, and where.
    Refused(HitReason, String),
    TimedOut,
}

/// A stage of an answer, and when it was there.
pub(super) struct Reached {
    pub(super) timed: Timed,
    pub(super) after_s: f64,
}

impl Verdict {
    /// The code that says so.
    pub(super) fn code(&self) -> Code {
        match self {
            Self::Timed(..) => Code::Success,
            Self::TimedOut => Code::TimedOut,
            Self::Refused(reason, _) => check::code_of_hit(*reason).0,
        }
    }
}
