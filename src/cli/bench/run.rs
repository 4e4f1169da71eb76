//! One run in this process, timed.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use rustix::time::{ClockId, clock_gettime};
use taut::collision::CollisionModel;
use taut::optimize::{Improvement, Settings, Workspace};

use crate::cli::answered::Answered;
use crate::cli::error::CliError;
use crate::cli::load::Loaded;
use crate::daemon::translate::code_of;

/// Runs a request. `watch` gets the length of each improvement and the time since the start.
///
/// # Errors
/// A request that cannot be computed, or a panic, which is a defect of the core.
pub(in crate::cli) fn run(
    loaded: &Loaded,
    model: &CollisionModel,
    settings: &Settings,
    deadline: Option<Duration>,
    workspace: &mut Workspace,
    watch: &mut dyn FnMut(Duration, f64),
) -> Result<Answered, CliError> {
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
        CliError::Here {
            name: loaded.name.clone(),
            message: format!("the optimizer panicked: {text}"),
        }
    })?;
    let outcome = result.map_err(|error| CliError::Here {
        name: loaded.name.clone(),
        message: error.to_string(),
    })?;
    let code = code_of(&outcome, None);
    let cpu_s = thread_cpu() - cpu;
    let time_s = start.elapsed().as_secs_f64();
    Ok(Answered {
        outcome,
        code,
        cpu_s,
        time_s,
        corridor: None,
        request_id: None,
        lengths_over_time,
    })
}

/// CPU time of this thread so far (s).
pub(in crate::cli) fn thread_cpu() -> f64 {
    let now = clock_gettime(ClockId::ThreadCPUTime);
    now.tv_sec as f64 + now.tv_nsec as f64 * 1e-9
}
