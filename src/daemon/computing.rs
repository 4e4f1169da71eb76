//! A job's answer, from nothing but the job and when it is told to end: what a worker computes
//! once, a replay computes again to the same bits.

use std::panic::{AssertUnwindSafe, catch_unwind};

use taut::optimize::{self, Improvement, Outcome, Workspace};
use taut_ipc::control::Refusal;
use taut_ipc::wire::Code;

use super::job::{Job, StopCause, Stopped};
use super::translate::{self, Reply};

/// What came of a job.
pub(super) struct Computed {
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
pub(super) fn compute(
    job: &Job,
    workspace: &mut Workspace,
    stop: &mut dyn FnMut() -> Option<StopCause>,
    publish: &mut dyn FnMut(Improvement),
) -> Computed {
    let mut asked = 0;
    let mut stopped = None;
    let mut ask = || {
        if stopped.is_none() {
            asked += 1;
            stopped = stop().map(|cause| Stopped { asked, cause });
        }
        stopped.is_some()
    };
    let model = match catch_unwind(AssertUnwindSafe(|| job.snapshot.model.get())) {
        Ok(Ok(model)) => model,
        Ok(Err(error)) => {
            let reply = translate::refused(translate::model_refusal(error, &job.snapshot.robot));
            return Computed {
                reply,
                stopped: None,
                outcome: None,
                panicked: false,
            };
        }
        Err(panic) => {
            return Computed {
                reply: crash(&*panic),
                stopped: None,
                outcome: None,
                panicked: true,
            };
        }
    };
    let run = || {
        optimize::run(
            model,
            &job.path,
            &job.settings,
            workspace,
            &mut ask,
            publish,
        )
    };
    match catch_unwind(AssertUnwindSafe(run)) {
        Ok(Ok(outcome)) => {
            let cause = stopped.map(|stopped| stopped.cause);
            let reply = translate::answered(&job.snapshot, &outcome, cause);
            let code = translate::code_of(&outcome, cause);
            Computed {
                reply,
                stopped,
                outcome: Some((outcome, code)),
                panicked: false,
            }
        }
        Ok(Err(error)) => {
            let reply = translate::refused(translate::request_refusal(&error));
            Computed {
                reply,
                stopped,
                outcome: None,
                panicked: false,
            }
        }
        Err(panic) => {
            *workspace = Workspace::default();
            Computed {
                reply: crash(&*panic),
                stopped,
                outcome: None,
                panicked: true,
            }
        }
    }
}

fn crash(panic: &(dyn std::any::Any + Send)) -> Reply {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text
        .or_else(|| panic.downcast_ref::<&str>().copied())
        .unwrap_or("no message");
    let message = format!("the worker panicked: {text}; report this with the request as a defect");
    translate::refused(Refusal::new(Code::Crash, message))
}
