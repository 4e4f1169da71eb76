//! What came of a path, stage by stage.

use serde::Serialize;
use taut::timing::Timed;
use taut::validation::{Certificate, HitReason, LoweredFloor, NamedRequirement};
use taut_ipc::wire::Code;

use crate::cli::check;

/// What came of a path.
#[expect(clippy::large_enum_variant, reason = "a command makes one of them")]
pub(super) enum Verdict {
    Timed(Shown),
    /// It is not proved: why, and where.
    Refused(HitReason, String),
    TimedOut,
}

/// A trajectory with what is told of it.
pub(super) struct Shown {
    pub(super) timed: Timed,
    /// The proof in short; `None` of one that stands still.
    pub(super) certificate: Option<Certificate>,
    /// Where it comes nearest to anything, if that is found.
    pub(super) nearest: Option<Nearest>,
}

impl Shown {
    /// Floors that had to be lowered.
    pub(super) fn lowered(&self) -> &[LoweredFloor] {
        let certificate = self.certificate.as_ref();
        certificate.map_or(&[], |certificate| &certificate.lowered)
    }
}

/// Where a trajectory comes nearest to anything, and when.
#[derive(Serialize)]
pub(super) struct Nearest {
    #[serde(flatten)]
    pub(super) requirement: NamedRequirement,
    /// What is kept there, in the unit of what must be.
    pub(super) amount: f64,
    /// On the trajectory's clock (s).
    pub(super) time_s: f64,
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
            Self::Timed(_) => Code::Success,
            Self::TimedOut => Code::TimedOut,
            Self::Refused(reason, _) => check::code_of_hit(*reason).0,
        }
    }
}
