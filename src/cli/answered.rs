//! An answer, and what it cost.

use taut::files::result::{ResultCorridor, ResultTimes};
use taut::optimize::Outcome;

use taut_ipc::wire::Code;

/// An outcome and what it cost, loading left out.
pub(super) struct Answered {
    /// The outcome.
    pub outcome: Outcome,
    /// What it amounts to.
    pub code: Code,
    /// The trajectory, as files say it, or what became of it; `None` where none was asked for.
    pub times: Option<ResultTimes>,
    /// How far what is executed may stray from its path, as files say it; `None` where it was not
    /// asked for, or is not known.
    pub corridor: Option<ResultCorridor>,
    /// Age (s) of the oldest frame among those that the scene is seen by, when the answer was sent;
    /// `None` where no sensor sees it.
    pub world_age_s: Option<f64>,
    /// Time that it was computed (s).
    pub cpu_s: f64,
    /// Time on the clock (s).
    pub time_s: f64,
    /// Id of the request that the daemon answered.
    pub request_id: Option<u64>,
    /// When each proved improvement was seen (s since the start), and its length.
    pub lengths_over_time: Vec<(f64, f64)>,
}
