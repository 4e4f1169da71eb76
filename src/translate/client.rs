//! The client's side: from settings to a request, and from a response back to an outcome.

use crate::optimize::{LoweredFloor, Mode, Outcome, Settings, Termination};
use crate::path::Path;
use taut_ipc::control::RobotDescription;
use taut_ipc::wire::{self, Code, NO_GROUP, RequestFlags, RequestHeader, ResponseView, WireError};

use super::sections;

/// Why a response cannot be taken.
#[derive(Debug, thiserror::Error)]
pub enum AnswerError {
    /// It breaks the wire's rules.
    #[error("the daemon's response cannot be read: {0}")]
    Wire(#[from] WireError),
    /// The daemon refused the request.
    #[error("{message}")]
    Refused {
        /// Why.
        code: Code,
        /// In words.
        message: String,
        /// When to try again; 0 = never.
        retry_after_ms: u32,
    },
    /// The path is another one than the certificate is about.
    #[error("the daemon's certificate is about another path than it sent; report this as a defect")]
    OtherPath,
}

/// Header of a request with these settings; ids, hashes and deadline are the caller's.
pub fn request_header(settings: &Settings) -> RequestHeader {
    let mode = match settings.mode {
        Mode::Check => wire::Mode::Check,
        Mode::Gradient => wire::Mode::Gradient,
        Mode::RandomShortcut => wire::Mode::RandomShortcut,
        Mode::PartialShortcut => wire::Mode::PartialShortcut,
        Mode::Contact => wire::Mode::Contact,
        Mode::Hybrid => wire::Mode::Hybrid,
    };
    let strict = if settings.strict {
        RequestFlags::STRICT
    } else {
        0
    };
    let unwrapped = if settings.unwrapped {
        RequestFlags::UNWRAPPED
    } else {
        0
    };
    let keep_goal = if settings.keep_goal {
        RequestFlags::KEEP_GOAL
    } else {
        0
    };
    let without_contacts = if settings.contacts {
        0
    } else {
        RequestFlags::WITHOUT_CONTACTS
    };
    let corridor = if settings.corridor {
        RequestFlags::CORRIDOR
    } else {
        0
    };
    RequestHeader {
        mode: mode.into(),
        flags: strict | unwrapped | keep_goal | without_contacts | corridor,
        group: NO_GROUP,
        seed: settings.seed,
        work_budget: settings.work_budget,
        clearance_m: settings.clearance_m,
        ..RequestHeader::default()
    }
}

/// The outcome that a final response about a path of `robot` tells of. `weights` are those of the
/// request's metric.
///
/// # Errors
/// A refusal, or a response that contradicts itself.
pub fn outcome(
    view: &ResponseView,
    settings: &Settings,
    robot: &RobotDescription,
    weights: &[f64],
) -> Result<(Outcome, Code), AnswerError> {
    let header = &view.header;
    let Some(path) = Path::from_rows((header.variables as usize).max(1), view.path.to_vec()) else {
        let message = view.message.to_owned();
        let retry_after_ms = header.retry_after_ms;
        return Err(AnswerError::Refused {
            code: view.code,
            message,
            retry_after_ms,
        });
    };
    let lowered: Vec<LoweredFloor> = view
        .lowered_pairs
        .iter()
        .map(|pair| sections::lowered(pair, view))
        .collect::<Result<_, _>>()?;
    let turned = sections::turned(view, robot)?;
    let certificate = sections::certificate(view, settings, &path, &lowered)?;
    let corridor = certificate
        .as_ref()
        .and_then(|certificate| sections::corridor(view, certificate));
    let outcome = Outcome {
        path,
        proved: view.is_proved(),
        uncheckable: sections::uncheckable(view)?,
        pairs: header.pairs as usize,
        refusal: sections::refusal(view, view.message.to_owned())?,
        length_before: header.length_before,
        length_after: header.length_after,
        lower_bound: header.lower_bound,
        weights: weights.to_vec(),
        clearance_m: settings.clearance_m,
        floor_m: header.floor_m,
        floors_lowered: lowered,
        turned,
        pinched: sections::pinched(view)?,
        nearest: sections::nearest(view)?,
        iterations: header.iterations,
        work: header.work,
        stage: sections::stage(view.stage),
        stages: sections::stages(view)?,
        termination: termination(view.termination),
        warnings: sections::warnings(view)?,
        corridor,
        certificate,
    };
    Ok((outcome, view.code))
}

fn termination(termination: wire::Termination) -> Termination {
    use wire::Termination as Wire;
    match termination {
        Wire::Checked | Wire::Refused => Termination::Done,
        Wire::Converged => Termination::Converged,
        Wire::WorkBudget => Termination::WorkBudget,
        Wire::IterationLimit => Termination::IterationLimit,
        Wire::Running | Wire::Deadline | Wire::Cancelled | Wire::FinishedEarly => {
            Termination::Stopped
        }
    }
}
