//! One job's answer, from nothing but the job and when it is told to end: a worker of the daemon,
//! a replay and a program without a daemon compute it by this function, to the same bits.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

use taut_ipc::control::Refusal;
use taut_ipc::wire::Code;

use crate::optimize::{self, Improvement, Outcome, Settings, Workspace};
use crate::path::Path;
use crate::store::Snapshot;
use crate::translate::{self, Reply, StopCause};

/// What is to be computed.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    /// Robot and scene.
    pub snapshot: &'a Snapshot,
    /// The path, its numbers unchecked.
    pub path: &'a Path,
    /// What is asked for.
    pub settings: &'a Settings,
}

/// When and why a job was told to end. Its answer depends on nothing else besides the job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stopped {
    /// How often the core had asked by then, that time included.
    pub asked: u64,
    /// Why.
    pub cause: StopCause,
}

/// What came of a job.
pub struct Answered {
    /// What its client is told.
    pub reply: Reply,
    /// When it was told to end before it was done.
    pub stopped: Option<Stopped>,
    /// What the core made of it, and its code, where it came to that.
    pub outcome: Option<(Outcome, Code)>,
    /// Whether the core panicked on it.
    pub panicked: bool,
}

/// Computes a job. `stop` is asked often, until it gives a cause; `publish` gets each shorter
/// proved path. A panic costs only this job, and the workspace that it left half changed.
pub fn answer(
    job: Job,
    workspace: &mut Workspace,
    stop: &mut dyn FnMut() -> Option<StopCause>,
    publish: &mut dyn FnMut(Improvement),
) -> Answered {
    let mut asking = Asking {
        stop,
        asked: 0,
        stopped: None,
    };
    let work = || compute(job, workspace, &mut asking, publish);
    let result = catch_unwind(AssertUnwindSafe(work));
    let stopped = asking.stopped;
    match result {
        Ok(Ok(outcome)) => Answered::of(job, outcome, stopped),
        Ok(Err(refusal)) => Answered::refused(refusal, stopped),
        Err(panic) => {
            *workspace = Workspace::default();
            Answered {
                panicked: true,
                ..Answered::refused(crash(&*panic), stopped)
            }
        }
    }
}

fn compute(
    job: Job,
    workspace: &mut Workspace,
    asking: &mut Asking,
    publish: &mut dyn FnMut(Improvement),
) -> Result<Outcome, Refusal> {
    let model = job.snapshot.model.get();
    let model = model.map_err(|error| translate::model_refusal(error, &job.snapshot.robot))?;
    let mut stop = || asking.ask();
    optimize::run(model, job.path, job.settings, workspace, &mut stop, publish)
        .map_err(|error| translate::request_refusal(&error))
}

/// Asks whether to stop, until it is so, and counts how often.
struct Asking<'a> {
    stop: &'a mut dyn FnMut() -> Option<StopCause>,
    asked: u64,
    stopped: Option<Stopped>,
}

impl Asking<'_> {
    fn ask(&mut self) -> bool {
        if self.stopped.is_none() {
            self.asked += 1;
            let asked = self.asked;
            self.stopped = (self.stop)().map(|cause| Stopped { asked, cause });
        }
        self.stopped.is_some()
    }
}

impl Answered {
    fn of(job: Job, outcome: Outcome, stopped: Option<Stopped>) -> Self {
        let cause = stopped.map(|stopped| stopped.cause);
        let code = translate::code_of(&outcome, cause);
        Self {
            reply: translate::answered(job.snapshot, &outcome, cause),
            stopped,
            outcome: Some((outcome, code)),
            panicked: false,
        }
    }

    fn refused(refusal: Refusal, stopped: Option<Stopped>) -> Self {
        Self {
            reply: translate::refused(refusal),
            stopped,
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
