//! One run in this process, timed.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use taut::collision::CollisionModel;
use taut::optimize::{self, Improvement, Outcome, RequestError, Settings, Workspace};

use super::curve::Curve;
use super::loaded::Loaded;
use crate::clock::thread_cpu;
use crate::error::Error;

/// An outcome and what it cost, loading left out.
pub(super) struct Timed {
    /// The outcome.
    pub outcome: Outcome,
    /// CPU time of the thread that computed it (s).
    pub cpu_s: f64,
    /// Time on the clock (s).
    pub time_s: f64,
    /// Its lengths over time.
    pub curve: Curve,
}

/// Runs a request until its end or the deadline.
///
/// # Errors
/// A request that cannot be computed, or a panic, which is a defect of the core.
pub(super) fn run(
    loaded: &Loaded,
    model: &CollisionModel,
    settings: &Settings,
    deadline: Option<Duration>,
    workspace: &mut Workspace,
) -> Result<Timed, Error> {
    let mut curve = Curve::new(f64::NAN);
    let cpu = thread_cpu();
    let start = Instant::now();
    let mut stop = || deadline.is_some_and(|deadline| start.elapsed() >= deadline);
    let mut publish =
        |better: Improvement| curve.push(start.elapsed().as_secs_f64(), better.length);
    let result = catch_unwind(AssertUnwindSafe(|| {
        optimize::run(
            model,
            &loaded.path,
            settings,
            workspace,
            &mut stop,
            &mut publish,
        )
    }));
    let cpu_s = thread_cpu() - cpu;
    let time_s = start.elapsed().as_secs_f64();
    let outcome = ended(&loaded.name, result)?;
    curve.close(outcome.length_before, outcome.length_after, time_s);
    Ok(Timed {
        outcome,
        cpu_s,
        time_s,
        curve,
    })
}

type Ended = Result<Result<Outcome, RequestError>, Box<dyn Any + Send>>;

fn ended(name: &str, result: Ended) -> Result<Outcome, Error> {
    let name = name.to_owned();
    match result {
        Ok(Ok(outcome)) => Ok(outcome),
        Ok(Err(source)) => Err(Error::Request { name, source }),
        Err(panic) => Err(Error::Panic {
            name,
            text: said(&*panic),
        }),
    }
}

fn said(panic: &(dyn Any + Send)) -> String {
    let owned = panic
        .downcast_ref::<String>()
        .map(String::as_str);
    owned
        .or_else(|| panic.downcast_ref::<&str>().copied())
        .unwrap_or("no message")
        .to_owned()
}
