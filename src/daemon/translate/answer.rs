//! From an outcome to the sections of a response.

use std::collections::HashMap;

use sha2::{Digest, Sha256};
use taut::optimize::{self, Improvement, Outcome, Refusal as Hit, RefusalPlace, Termination};
use taut::path::Path;
use taut::store::Snapshot;
use taut::validation::{Certificate, HitReason};
use taut_ipc::control::Refusal;
use taut_ipc::limits::{MAX_RECORDS, MAX_TEXT};
use taut_ipc::wire::{
    self, CertificateHead, CertificateSegment, Code, LoweredPair, RefusalReason, RefusalRecord, ResponseBody,
    ResponseFlags, ResponseHeader, Stage, Status, TextSpan,
};

use crate::daemon::job::{Job, StopCause};

/// A response, put together by a worker and sent by the I/O thread.
#[derive(Default)]
pub(in crate::daemon) struct Reply {
    /// Its header; ids, lengths and sections are filled in when it is sent.
    pub header: ResponseHeader,
    path: Vec<f64>,
    certificate: Vec<CertificateSegment>,
    head: Option<CertificateHead>,
    lowered: Vec<LoweredPair>,
    refusal: Option<RefusalRecord>,
    names: String,
    message: String,
}

impl Reply {
    /// The sections.
    pub(in crate::daemon) fn body(&self) -> ResponseBody<'_> {
        ResponseBody {
            path: &self.path,
            certificate: &self.certificate,
            lowered_pairs: &self.lowered,
            refusal: self.refusal.as_ref(),
            certificate_head: self.head.as_ref(),
            names: &self.names,
            message: &self.message,
            ..ResponseBody::default()
        }
    }
}

/// The code of an outcome that ended by itself or for this reason.
pub fn code_of(outcome: &Outcome, cause: Option<StopCause>) -> Code {
    match &outcome.refusal {
        _ if outcome.proved => Code::Success,
        Some(hit) if hit.reason == HitReason::Collision => match hit.place {
            RefusalPlace::Start => Code::StartStateInCollision,
            RefusalPlace::Goal => Code::GoalInCollision,
            RefusalPlace::Between => Code::InvalidMotionPlan,
        },
        None if outcome.termination == Termination::Stopped => match cause {
            None | Some(StopCause::Deadline) => Code::TimedOut,
            Some(_) => Code::Preempted,
        },
        _ => Code::Uncertified,
    }
}

fn termination(outcome: &Outcome, cause: Option<StopCause>) -> wire::Termination {
    match outcome.termination {
        Termination::Done if outcome.refusal.is_some() => wire::Termination::Refused,
        Termination::Done => wire::Termination::Checked,
        Termination::Converged => wire::Termination::Converged,
        Termination::IterationLimit => wire::Termination::IterationLimit,
        Termination::WorkBudget => wire::Termination::WorkBudget,
        Termination::Stopped => match cause {
            None | Some(StopCause::Deadline) => wire::Termination::Deadline,
            Some(StopCause::FinishedEarly) => wire::Termination::FinishedEarly,
            Some(StopCause::Cancelled | StopCause::Shutdown) => wire::Termination::Cancelled,
        },
    }
}

fn stage(stage: optimize::Stage) -> Stage {
    match stage {
        optimize::Stage::Input => Stage::Input,
        optimize::Stage::Shortcut => Stage::Shortcut,
        optimize::Stage::PartialShortcut => Stage::PartialShortcut,
        optimize::Stage::Gradient => Stage::Gradient,
        optimize::Stage::Contact => Stage::Contact,
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

/// Header of an improvement. Its clearance and floor come with the final response.
pub(in crate::daemon) fn progress(job: &Job, improvement: &Improvement, lengths: [f64; 3]) -> ResponseHeader {
    let [length_before, length_after, lower_bound] = lengths;
    ResponseHeader {
        status: Status::Progress.into(),
        code: Code::Success.into(),
        termination: wire::Termination::Running.into(),
        flags: ResponseFlags::PROVED,
        stage: stage(improvement.stage).into(),
        length_before,
        length_after,
        lower_bound,
        iterations: improvement.iterations,
        work: improvement.work,
        ..header(&job.snapshot, improvement.path)
    }
}

/// The final response of a job that was computed.
pub(in crate::daemon) fn answered(job: &Job, outcome: &Outcome, cause: Option<StopCause>) -> Reply {
    let mut names = Names::default();
    let refusal = outcome.refusal.as_ref().map(|hit| refusal_record(hit, outcome, &mut names));
    let reason = outcome.refusal.as_ref().map_or(RefusalReason::None, |hit| reason(hit.reason));
    let certificate = outcome.certificate.as_ref();
    let header = ResponseHeader {
        status: Status::Final.into(),
        code: code_of(outcome, cause).into(),
        termination: termination(outcome, cause).into(),
        refusal_reason: reason.into(),
        flags: if outcome.proved { ResponseFlags::PROVED } else { 0 },
        stage: stage(outcome.stage).into(),
        length_before: outcome.length_before,
        length_after: outcome.length_after,
        lower_bound: outcome.lower_bound,
        clearance_m: certificate.map_or(0.0, |certificate| certificate.clearance_m().unwrap_or(f64::INFINITY)),
        floor_m: outcome.floor_m,
        iterations: outcome.iterations,
        work: outcome.work,
        ..header(&job.snapshot, &outcome.path)
    };
    Reply {
        header,
        path: outcome.path.as_flat().to_vec(),
        certificate: certificate.map(segments).unwrap_or_default(),
        head: certificate.map(|certificate| head(certificate, &outcome.path)),
        lowered: lowered(outcome, &mut names),
        refusal,
        names: names.text,
        message: message(outcome),
    }
}

/// The final response of a job whose deadline passed while it waited: the input, nothing computed, lengths 0.
pub(in crate::daemon) fn expired(job: &Job) -> Reply {
    untouched(job, Code::TimedOut, wire::Termination::Deadline, "the deadline passed while the request waited")
}

/// The final response of a job that a stopping daemon, or a client that wants an answer now, took from the queue.
pub(in crate::daemon) fn preempted(job: &Job, cause: StopCause) -> Reply {
    let termination = match cause {
        StopCause::FinishedEarly => wire::Termination::FinishedEarly,
        _ => wire::Termination::Cancelled,
    };
    untouched(job, Code::Preempted, termination, "ended before it was begun")
}

fn untouched(job: &Job, code: Code, termination: wire::Termination, message: &str) -> Reply {
    let header = ResponseHeader {
        status: Status::Final.into(),
        code: code.into(),
        termination: termination.into(),
        ..header(&job.snapshot, &job.path)
    };
    let (path, message) = (job.path.as_flat().to_vec(), message.to_owned());
    Reply { header, path, message, ..Reply::default() }
}

/// The final response that only says why not.
pub(in crate::daemon) fn refused(refusal: Refusal) -> Reply {
    let header = ResponseHeader {
        status: Status::Final.into(),
        code: refusal.code,
        retry_after_ms: refusal.retry_after_ms,
        termination: wire::Termination::Refused.into(),
        ..ResponseHeader::default()
    };
    Reply { header, message: refusal.message, ..Reply::default() }
}

/// Collects names of bodies, each once, as far as the section holds them.
#[derive(Default)]
struct Names {
    text: String,
    known: HashMap<String, TextSpan>,
}

impl Names {
    /// Where the name lies; `None` once the section is full.
    fn span(&mut self, name: &str) -> Option<TextSpan> {
        if let Some(span) = self.known.get(name) {
            return Some(*span);
        }
        if self.text.len() + name.len() > MAX_TEXT {
            return None;
        }
        let span = TextSpan::push(&mut self.text, name);
        self.known.insert(name.to_owned(), span);
        Some(span)
    }
}

fn reason(reason: HitReason) -> RefusalReason {
    match reason {
        HitReason::Collision => RefusalReason::Collision,
        HitReason::TooClose => RefusalReason::TooClose,
        HitReason::Uncertified => RefusalReason::Uncertified,
    }
}

fn refusal_record(hit: &Hit, outcome: &Outcome, names: &mut Names) -> RefusalRecord {
    let [body_a, body_b] = hit.bodies.each_ref().map(|name| names.span(name).unwrap_or_default());
    let floor = outcome.floors_lowered.iter().find(|lowered| lowered.bodies == hit.bodies);
    let proved_segments = hit.proved_prefix.floor();
    RefusalRecord {
        body_a,
        body_b,
        segment: hit.segment as u32,
        proved_segments: proved_segments as u32,
        t: hit.t,
        proved_t: hit.proved_prefix - proved_segments,
        depth_m: hit.depth_m,
        floor_m: floor.map_or(outcome.clearance_m, |lowered| lowered.floor_m),
        point_a: hit.points[0].to_array(),
        point_b: hit.points[1].to_array(),
        normal: hit.normal.to_array(),
    }
}

fn lowered(outcome: &Outcome, names: &mut Names) -> Vec<LoweredPair> {
    let record = |floor: &taut::optimize::LoweredFloor| {
        let [a, b] = &floor.bodies;
        Some(LoweredPair { body_a: names.span(a)?, body_b: names.span(b)?, floor_m: floor.floor_m })
    };
    outcome.floors_lowered.iter().map_while(record).take(MAX_RECORDS).collect()
}

fn segments(certificate: &Certificate) -> Vec<CertificateSegment> {
    let record = |claim: &taut::validation::SegmentClaim| CertificateSegment {
        clearance_m: claim.clearance_m.unwrap_or(f64::INFINITY),
        intervals: claim.intervals,
        reserved: 0,
    };
    certificate.segments.iter().map(record).collect()
}

fn head(certificate: &Certificate, path: &Path) -> CertificateHead {
    CertificateHead {
        path_hash: path_hash(path.as_flat()),
        checker_version: certificate.checker_version,
        segments: certificate.segments.len() as u32,
        clearance_m: certificate.clearance_m,
        intervals: certificate.segments.iter().map(|claim| u64::from(claim.intervals)).sum(),
    }
}

/// SHA-256 of a path's bits, as the wire has it: four little-endian numbers.
pub(super) fn path_hash(path: &[f64]) -> [u64; 4] {
    let mut hasher = Sha256::new();
    for value in path {
        hasher.update(value.to_bits().to_le_bytes());
    }
    let digest = hasher.finalize();
    let mut numbers = [0; 4];
    for (number, bytes) in numbers.iter_mut().zip(digest.chunks_exact(8)) {
        *number = bytes.iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte));
    }
    numbers
}

/// How a warning starts in the message, which otherwise holds the hint of a refusal.
pub(super) const WARNING: &str = "warning: ";

fn message(outcome: &Outcome) -> String {
    let mut lines: Vec<String> = outcome.warnings.iter().map(|warning| format!("{WARNING}{warning}")).collect();
    lines.extend(outcome.refusal.iter().map(|hit| hit.hint.clone()).filter(|hint| !hint.is_empty()));
    lines.join("\n")
}
