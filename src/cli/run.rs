//! One run in this process, timed.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use rustix::time::{ClockId, clock_gettime};
use taut::collision::CollisionModel;
use taut::optimize::{Improvement, Outcome, Settings, Workspace};

use super::code::{self, Code};
use super::error::CliError;
use super::load::Loaded;

/// An outcome and what it cost, loading left out.
pub(super) struct Timed {
    /// The outcome.
    pub outcome: Outcome,
    /// What it amounts to.
    pub code: Code,
    /// CPU time of the thread that computed it (s).
    pub cpu_s: f64,
    /// Time on the clock (s).
    pub time_s: f64,
    /// Id of the request that the daemon answered.
    pub request_id: Option<u64>,
    /// When each proved improvement was seen (s since the start), and its length.
    pub lengths_over_time: Vec<(f64, f64)>,
}

/// Runs a request. `watch` gets the length of each improvement and the time since the start.
///
/// # Errors
/// A request that cannot be computed, or a panic, which is a defect of the core.
pub(super) fn run(
    loaded: &Loaded,
    model: &CollisionModel,
    settings: &Settings,
    deadline: Option<Duration>,
    workspace: &mut Workspace,
    watch: &mut dyn FnMut(Duration, f64),
) -> Result<Timed, CliError> {
    let cpu = thread_cpu();
    let start = Instant::now();
    let mut stop = || deadline.is_some_and(|deadline| start.elapsed() >= deadline);
    let mut lengths_over_time = Vec::new();
    let mut publish = |improvement: Improvement| {
        let time = start.elapsed();
        lengths_over_time.push((time.as_secs_f64(), improvement.length));
        watch(time, improvement.length);
    };
    let run = || {
        taut::optimize::run(
            model,
            &loaded.path,
            settings,
            workspace,
            &mut stop,
            &mut publish,
        )
    };
    let result = catch_unwind(AssertUnwindSafe(run)).map_err(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text
            .or_else(|| panic.downcast_ref::<&str>().copied())
            .unwrap_or("no message")
            .to_owned();
        CliError::Panic {
            name: loaded.name.clone(),
            text,
        }
    })?;
    let outcome = result.map_err(|source| CliError::Request {
        name: loaded.name.clone(),
        source,
    })?;
    let code = code::of(&outcome);
    let cpu_s = thread_cpu() - cpu;
    let time_s = start.elapsed().as_secs_f64();
    Ok(Timed {
        outcome,
        code,
        cpu_s,
        time_s,
        request_id: None,
        lengths_over_time,
    })
}

/// CPU time of this thread so far (s).
pub(super) fn thread_cpu() -> f64 {
    let now = clock_gettime(ClockId::ThreadCPUTime);
    now.tv_sec as f64 + now.tv_nsec as f64 * 1e-9
}
