//! From an outcome to the sections of a response.

use std::sync::Arc;

use crate::collision::shared_names;
use crate::optimize::{Improvement, Outcome, RefusalPlace, Termination};
use crate::path::Path;
use crate::store::Snapshot;
use crate::validation::{Certificate, HitReason};
use crate::warning::{self, Warning};
use taut_ipc::control::Refusal;
use taut_ipc::wire::{
    self, CertificateHead, CertificateSegment, Code, HoldRecord, KeptRecord, LoweredFloorRecord,
    RefusalReason, RefusalRecord, RequirementRecord, ResponseBody, ResponseFlags, ResponseHeader,
    StageRecord, Status, TurnedColumn, WarningRecord,
};

use super::number;
use super::records::{self, Names};
use super::times::{self, Times};

/// A response, put together by a worker and sent by the daemon.
#[derive(Clone, Default)]
pub struct Reply {
    /// Its header; ids, lengths and sections are filled in when it is sent.
    pub header: ResponseHeader,
    /// Shared with those who keep answers.
    sections: Arc<Sections>,
}

#[derive(Default)]
struct Sections {
    path: Vec<f64>,
    certificate: Vec<CertificateSegment>,
    head: Option<CertificateHead>,
    lowered: Vec<LoweredFloorRecord>,
    holds: Vec<HoldRecord>,
    stages: Vec<StageRecord>,
    reach: Vec<f64>,
    pinched: Vec<RequirementRecord>,
    keeps: Vec<KeptRecord>,
    constraints: String,
    constraint_claims: Vec<f64>,
    trajectory: times::Sections,
    turned: Vec<TurnedColumn>,
    refusal: Option<RefusalRecord>,
    warnings: Vec<WarningRecord>,
    names: String,
    message: String,
}

impl Reply {
    fn new(header: ResponseHeader, sections: Sections) -> Self {
        Self {
            header,
            sections: Arc::new(sections),
        }
    }

    /// The sections.
    pub fn body(&self) -> ResponseBody<'_> {
        let sections = &*self.sections;
        ResponseBody {
            path: &sections.path,
            certificate: &sections.certificate,
            lowered_floors: &sections.lowered,
            holds: &sections.holds,
            stages: &sections.stages,
            reach: &sections.reach,
            pinched: &sections.pinched,
            keeps: &sections.keeps,
            constraints: &sections.constraints,
            constraint_claims: &sections.constraint_claims,
            trajectory: sections.trajectory.body(),
            turned_columns: &sections.turned,
            refusal: sections.refusal.as_ref(),
            certificate_head: sections.head.as_ref(),
            warnings: &sections.warnings,
            names: &sections.names,
            message: &sections.message,
        }
    }

    /// The line for people.
    pub fn message(&self) -> &str {
        &self.sections.message
    }
}

/// Why the work on a request ends before it is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopCause {
    /// The deadline came.
    Deadline,
    /// The client went away.
    Cancelled,
    /// The client wants the best so far.
    FinishedEarly,
    /// The daemon ends.
    Shutdown,
}

/// The code of an outcome that ended by itself or for this reason, with the times that it was asked for.
pub fn code_of(outcome: &Outcome, times: Option<&Times>, cause: Option<StopCause>) -> Code {
    let is_untimed = times.is_some_and(|times| times.missing().is_some());
    match &outcome.refusal {
        _ if outcome.proved && is_untimed => Code::Untimed,
        _ if outcome.proved => Code::Success,
        Some(hit) if hit.reason == HitReason::Collision => code_of_collision(hit.place),
        Some(hit) if hit.reason == HitReason::Outside => code_of_violation(hit.place),
        None if outcome.uncheckable.is_some() => Code::Uncertified,
        // Nor is it known of an input that is not provable whether the optimizer would have found a
        // path that is.
        _ if outcome.termination == Termination::Stopped => code_of_stop(cause),
        _ => Code::Uncertified,
    }
}

fn code_of_collision(place: RefusalPlace) -> Code {
    match place {
        RefusalPlace::Start => Code::StartStateInCollision,
        RefusalPlace::Goal => Code::GoalInCollision,
        RefusalPlace::Between => Code::InvalidMotionPlan,
    }
}

fn code_of_violation(place: RefusalPlace) -> Code {
    match place {
        RefusalPlace::Start => Code::StartStateViolatesPathConstraints,
        RefusalPlace::Goal => Code::GoalViolatesPathConstraints,
        RefusalPlace::Between => Code::InvalidMotionPlan,
    }
}

fn code_of_stop(cause: Option<StopCause>) -> Code {
    match cause {
        None | Some(StopCause::Deadline) => Code::TimedOut,
        Some(_) => Code::Preempted,
    }
}

fn termination(outcome: &Outcome, cause: Option<StopCause>) -> wire::Termination {
    let is_refused = outcome.refusal.is_some() || outcome.uncheckable.is_some();
    match outcome.termination {
        Termination::Done if is_refused => wire::Termination::Refused,
        Termination::Done => wire::Termination::Checked,
        Termination::Converged => wire::Termination::Converged,
        Termination::IterationLimit => wire::Termination::IterationLimit,
        Termination::WorkBudget => wire::Termination::WorkBudget,
        Termination::Stopped => termination_of_stop(cause),
    }
}

fn termination_of_stop(cause: Option<StopCause>) -> wire::Termination {
    match cause {
        None | Some(StopCause::Deadline) => wire::Termination::Deadline,
        Some(StopCause::FinishedEarly) => wire::Termination::FinishedEarly,
        Some(StopCause::Cancelled | StopCause::Shutdown) => wire::Termination::Cancelled,
    }
}

/// What every response says about robot and scene.
fn header(snapshot: &Snapshot, path: &Path) -> ResponseHeader {
    ResponseHeader {
        robot_hash: snapshot.robot.hash(),
        scene_id: snapshot.scene_id,
        scene_hash: snapshot.scene_hash,
        scene_version: snapshot.scene_version,
        waypoints: path.len() as u32,
        variables: path.nq() as u32,
        ..ResponseHeader::default()
    }
}

/// Header of an improvement, of a request that asks for times or not. Its clearance and floor come with the
/// final response.
pub fn progress(
    snapshot: &Snapshot,
    improvement: &Improvement,
    lengths: [f64; 3],
    asks_times: bool,
) -> ResponseHeader {
    let [length_before, length_after, lower_bound] = lengths;
    ResponseHeader {
        status: Status::Progress.into(),
        code: Code::Success.into(),
        termination: wire::Termination::Running.into(),
        flags: ResponseFlags::PROVED,
        stage: number::wire_stage(improvement.stage).into(),
        length_before,
        length_after,
        lower_bound,
        iterations: improvement.iterations,
        work: improvement.work,
        times: match asks_times {
            true => wire::Times::NotReached.into(),
            false => wire::Times::NotAsked.into(),
        },
        ..header(snapshot, improvement.path)
    }
}

/// A response on the way: the path that is going to be the answer's, and a trajectory along it.
pub fn timed(snapshot: &Snapshot, outcome: &Outcome, times: &Times) -> Reply {
    let header = ResponseHeader {
        status: Status::Progress.into(),
        termination: wire::Termination::Running.into(),
        ..final_header(snapshot, outcome, Some(times), None)
    };
    let mut names = Names::default();
    let sections = Sections {
        trajectory: times::Sections::of(Some(times), &mut names),
        path: outcome.path.as_flat().to_vec(),
        names: names.text,
        ..Sections::default()
    };
    Reply::new(header, sections)
}

/// The final response of a job that was computed.
pub fn answered(
    snapshot: &Snapshot,
    outcome: &Outcome,
    times: Option<&Times>,
    cause: Option<StopCause>,
) -> Reply {
    Reply::new(
        final_header(snapshot, outcome, times, cause),
        sections(snapshot, outcome, times),
    )
}

fn final_header(
    snapshot: &Snapshot,
    outcome: &Outcome,
    times: Option<&Times>,
    cause: Option<StopCause>,
) -> ResponseHeader {
    let certificate = outcome.certificate.as_ref();
    let claimed = |certificate: &Certificate| {
        certificate
            .clearance_m()
            .unwrap_or(f64::INFINITY)
    };
    let nearest = outcome.nearest.as_ref();
    ResponseHeader {
        status: Status::Final.into(),
        code: code_of(outcome, times, cause).into(),
        termination: termination(outcome, cause).into(),
        refusal_reason: reason(outcome).into(),
        flags: u32::from(outcome.proved) * ResponseFlags::PROVED,
        stage: number::wire_stage(outcome.stage).into(),
        length_before: outcome.length_before,
        length_after: outcome.length_after,
        lower_bound: outcome.lower_bound,
        clearance_m: certificate.map_or(0.0, claimed),
        floor_m: outcome.floor_m,
        searched_m: nearest.map_or(0.0, |nearest| nearest.searched_m),
        iterations: outcome.iterations,
        work: outcome.work,
        pairs: outcome.pairs as u64,
        times: times
            .map_or(wire::Times::NotAsked, Times::status)
            .into(),
        ..header(snapshot, &outcome.path)
    }
}

fn reason(outcome: &Outcome) -> RefusalReason {
    match &outcome.refusal {
        Some(hit) => records::reason(hit.reason),
        None if outcome.uncheckable.is_some() => RefusalReason::NoGeometry,
        None => RefusalReason::None,
    }
}

fn sections(snapshot: &Snapshot, outcome: &Outcome, times: Option<&Times>) -> Sections {
    let mut names = Names::default();
    // First, so that however many requirements are named there is room for them.
    let warnings = records::warnings(&told(snapshot, outcome), &mut names);
    let refusal = outcome.refusal.as_ref();
    let refusal = refusal.map(|hit| records::refusal(hit, &mut names));
    let keeps = records::keeps(outcome, &mut names);
    let lowered = records::lowered(outcome, &mut names);
    let nearest = outcome.nearest.as_ref();
    let holds = nearest.map(|nearest| records::holds(nearest, &mut names));
    let pinched = records::pinched(outcome, &mut names);
    let trajectory = times::Sections::of(times, &mut names);
    let certificate = outcome.certificate.as_ref();
    let constraints = certificate.and_then(|certificate| certificate.constraints.as_ref());
    let corridor = outcome.corridor.as_ref();
    Sections {
        path: outcome.path.as_flat().to_vec(),
        certificate: certificate
            .map(records::segments)
            .unwrap_or_default(),
        head: certificate.map(|certificate| records::head(certificate, &outcome.path)),
        lowered,
        holds: holds.unwrap_or_default(),
        stages: records::stages(outcome),
        reach: corridor.map_or_else(Vec::new, |corridor| corridor.reach.clone()),
        pinched,
        keeps,
        constraints: constraints.map_or_else(String::new, |claims| claims.asked.text()),
        constraint_claims: constraints.map_or_else(Vec::new, |claims| claims.left.concat()),
        trajectory,
        turned: records::turned(outcome, &snapshot.robot),
        refusal,
        warnings,
        names: names.text,
        message: message(outcome, times),
    }
}

/// The final response of a job whose deadline passed while it waited: the input, nothing computed,
/// lengths 0.
pub fn expired(snapshot: &Snapshot, path: &Path) -> Reply {
    untouched(
        snapshot,
        path,
        Code::TimedOut,
        wire::Termination::Deadline,
        "the deadline passed while the request waited",
    )
}

/// The final response of a job that a stopping daemon, or a client that wants an answer now, took
/// from the queue.
pub fn preempted(snapshot: &Snapshot, path: &Path, cause: StopCause) -> Reply {
    let termination = match cause {
        StopCause::FinishedEarly => wire::Termination::FinishedEarly,
        _ => wire::Termination::Cancelled,
    };
    untouched(
        snapshot,
        path,
        Code::Preempted,
        termination,
        "ended before it was begun",
    )
}

fn untouched(
    snapshot: &Snapshot,
    path: &Path,
    code: Code,
    termination: wire::Termination,
    message: &str,
) -> Reply {
    let header = ResponseHeader {
        status: Status::Final.into(),
        code: code.into(),
        termination: termination.into(),
        ..header(snapshot, path)
    };
    Reply::new(
        header,
        Sections {
            path: path.as_flat().to_vec(),
            message: message.to_owned(),
            ..Sections::default()
        },
    )
}

/// The final response that only says why not.
pub fn refused(refusal: Refusal) -> Reply {
    let header = ResponseHeader {
        status: Status::Final.into(),
        code: refusal.code,
        retry_after_ms: refusal.retry_after_ms,
        termination: wire::Termination::Refused.into(),
        ..ResponseHeader::default()
    };
    let sections = Sections {
        message: refusal.message,
        ..Sections::default()
    };
    Reply::new(header, sections)
}

/// What a person should know of robot, scene and request.
fn told(snapshot: &Snapshot, outcome: &Outcome) -> Vec<Warning> {
    let robot = snapshot.robot.warnings().iter();
    let scene = snapshot.scene.warnings();
    let shared = shared_names(&snapshot.robot, &snapshot.scene);
    warning::told(
        robot
            .chain(scene)
            .chain(&shared)
            .chain(&outcome.warnings),
    )
}

/// The hint of a refusal, or why nothing can be proved, or why there are no times.
fn message(outcome: &Outcome, times: Option<&Times>) -> String {
    let hint = outcome
        .refusal
        .as_ref()
        .map(|hit| hit.hint.clone());
    let missing = times.and_then(Times::missing);
    hint.or_else(|| outcome.uncheckable.clone())
        .or_else(|| missing.map(str::to_owned))
        .unwrap_or_default()
}
