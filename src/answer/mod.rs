//! One job's answer, from nothing but the job and when it is told to end: a worker of the daemon,
//! a replay and a program without a daemon compute it by this function, to the same bits.

mod job;
mod times;

pub use job::Job;

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

use taut_ipc::control::Refusal;
use taut_ipc::wire::Code;

use crate::optimize::{self, Improvement, Outcome, Workspace};
use crate::translate::{self, Reply, StopCause, Times};
use crate::warning::Warning;

/// What is told of limits that come with factors.
const SCALING: &str = "the scaling factors in the file of limits are of MoveIt's requests and do not count here; use speed";

/// What of a job is computed: its times come after its path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// A shorter path.
    Path,
    /// A trajectory along it.
    Times,
}

/// What is found on the way.
pub enum Found<'a> {
    /// A shorter proved path.
    Path(Improvement<'a>),
    /// A faster proved trajectory along the path that is going to be the answer's, as its client is told.
    Times(&'a Reply),
}

/// When and why each part of a job was told to end. Its answer depends on nothing else besides the job.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stops {
    /// The search for a shorter path.
    pub path: Option<Stopped>,
    /// That for a faster trajectory.
    pub times: Option<Stopped>,
}

/// When and why a part of a job was told to end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stopped {
    /// How often the core had asked by then in this part, that time included.
    pub asked: u64,
    /// Why.
    pub cause: StopCause,
}

/// What came of a job.
pub struct Answered {
    /// What its client is told.
    pub reply: Reply,
    /// When it was told to end before it was done.
    pub stops: Stops,
    /// What the core made of it, and its code, where it came to that.
    pub outcome: Option<(Outcome, Code)>,
    /// Whether the core panicked on it.
    pub panicked: bool,
}

/// Computes a job. `stop` is asked often in each part, until it gives a cause; `publish` gets each shorter
/// proved path, then each faster trajectory. A panic costs only this job, and the workspace that it left half changed.
pub fn answer(
    job: Job,
    workspace: &mut Workspace,
    stop: &mut dyn FnMut(Part) -> Option<StopCause>,
    publish: &mut dyn FnMut(Found),
) -> Answered {
    let mut stops = Stops::default();
    let work = || compute(job, workspace, &mut stops, stop, publish);
    let result = catch_unwind(AssertUnwindSafe(work));
    match result {
        Ok(Ok((outcome, times))) => Answered::of(job, outcome, times, stops),
        Ok(Err(refusal)) => Answered::refused(refusal, stops),
        Err(panic) => {
            *workspace = Workspace::default();
            Answered {
                panicked: true,
                ..Answered::refused(crash(&*panic), stops)
            }
        }
    }
}

fn compute(
    job: Job,
    workspace: &mut Workspace,
    stops: &mut Stops,
    stop: &mut dyn FnMut(Part) -> Option<StopCause>,
    publish: &mut dyn FnMut(Found),
) -> Result<(Outcome, Option<Times>), Refusal> {
    let model = job.snapshot.model.get();
    let model = model.map_err(|error| translate::model_refusal(error, &job.snapshot.robot))?;
    let mut asked = 0;
    let outcome = optimize::run(
        model,
        job.path,
        job.settings,
        workspace,
        &mut || ask(&mut || stop(Part::Path), &mut asked, &mut stops.path),
        &mut |improvement| publish(Found::Path(improvement)),
    );
    let mut outcome = outcome.map_err(|error| translate::request_refusal(&error))?;
    let Some(timing) = job.timing else {
        return Ok((outcome, None));
    };
    if timing.ignores_scaling {
        outcome
            .warnings
            .push(Warning::uncovered(SCALING));
    }
    if stops
        .path
        .is_some_and(|stopped| stopped.cause != StopCause::Deadline)
    {
        // It is to end, and not only its search for a shorter path.
        stops.times = stops.path;
    }
    let mut asked = 0;
    let times = times::times(
        job,
        timing,
        model,
        &outcome,
        &mut || ask(&mut || stop(Part::Times), &mut asked, &mut stops.times),
        &mut |times| {
            let told = translate::timed(job.snapshot, &outcome, times);
            publish(Found::Times(&told));
        },
    );
    Ok((outcome, Some(times)))
}

/// When a job that asks for times ends to look for a shorter path, between its begin and its deadline
/// (0 = none): its times have as long.
pub fn end_of_path_ns(begun_ns: u64, deadline_ns: u64) -> u64 {
    match deadline_ns {
        0 => 0,
        _ => begun_ns + deadline_ns.saturating_sub(begun_ns) / 2,
    }
}

/// Asks whether to stop, until it is so, and counts how often.
fn ask(
    stop: &mut dyn FnMut() -> Option<StopCause>,
    asked: &mut u64,
    stopped: &mut Option<Stopped>,
) -> bool {
    if stopped.is_none() {
        *asked += 1;
        let asked = *asked;
        *stopped = stop().map(|cause| Stopped { asked, cause });
    }
    stopped.is_some()
}

impl Answered {
    fn of(job: Job, outcome: Outcome, times: Option<Times>, stops: Stops) -> Self {
        let stopped = stops.path.or(stops.times);
        let cause = stopped.map(|stopped| stopped.cause);
        let times = times.as_ref();
        let code = translate::code_of(&outcome, times, cause);
        Self {
            reply: translate::answered(job.snapshot, &outcome, times, cause),
            stops,
            outcome: Some((outcome, code)),
            panicked: false,
        }
    }

    fn refused(refusal: Refusal, stops: Stops) -> Self {
        Self {
            reply: translate::refused(refusal),
            stops,
            outcome: None,
            panicked: false,
        }
    }
}

fn crash(panic: &(dyn Any + Send)) -> Refusal {
    let text = panic
        .downcast_ref::<String>()
        .map(String::as_str);
    let text = text
        .or_else(|| panic.downcast_ref::<&str>().copied())
        .unwrap_or("no message");
    let message = format!("the worker panicked: {text}; report this with the request as a defect");
    Refusal::new(Code::Crash, message)
}
