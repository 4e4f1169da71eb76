//! What came of a path, stage by stage.

use taut::timing::Timed;
use taut::validation::{Certificate, HitReason, LoweredFloor};
use taut_ipc::wire::Code;

use crate::cli::check;

/// What came of a path.
pub(super) enum Verdict {
    /// `None` of one that stands still: there is no proof to certify.
    Timed(Timed, Option<Certificate>),
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
    /// What is proved, in short.
    pub(super) fn certificate(&self) -> Option<&Certificate> {
        match self {
            Self::Timed(_, certificate) => certificate.as_ref(),
            Self::Refused(..) | Self::TimedOut => None,
        }
    }

    /// The floors that had to be lowered.
    pub(super) fn lowered(&self) -> &[LoweredFloor] {
        self.certificate()
            .map_or(&[], |certificate| &certificate.lowered)
    }

    /// The code that says so.
    pub(super) fn code(&self) -> Code {
        match self {
            Self::Timed(..) => Code::Success,
            Self::TimedOut => Code::TimedOut,
            Self::Refused(reason, _) => check::code_of_hit(*reason).0,
        }
    }
}
