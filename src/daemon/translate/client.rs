//! The client's side: from settings to a request, and from a response back to an outcome.

use taut::math::Vec3;
use taut::optimize::{LoweredFloor, Mode, Outcome, Refusal, RefusalPlace, Settings, Termination};
use taut::path::Path;
use taut::validation::{Certificate, HitReason, SegmentClaim};
use taut_ipc::wire::{
    self, Code, NO_GROUP, RefusalReason, RequestFlags, RequestHeader, ResponseView, TextSpan, WireError,
};

use super::answer::{WARNING, path_hash};

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
    };
    let strict = if settings.strict { RequestFlags::STRICT } else { 0 };
    let unwrapped = if settings.unwrapped { RequestFlags::UNWRAPPED } else { 0 };
    RequestHeader {
        mode: mode.into(),
        flags: strict | unwrapped,
        group: NO_GROUP,
        seed: settings.seed,
        work_budget: settings.work_budget,
        clearance_m: settings.clearance_m,
        ..RequestHeader::default()
    }
}

/// The outcome that a final response tells of. `weights` are those of the request's metric.
///
/// # Errors
/// A refusal, or a response that contradicts itself.
pub fn outcome(view: &ResponseView, settings: &Settings, weights: &[f64]) -> Result<(Outcome, Code), AnswerError> {
    let header = &view.header;
    let Some(path) = Path::from_rows((header.variables as usize).max(1), view.path.to_vec()) else {
        let (message, retry_after_ms) = (view.message.to_owned(), header.retry_after_ms);
        return Err(AnswerError::Refused { code: view.code, message, retry_after_ms });
    };
    let mut warnings: Vec<String> = view.message.lines().map(str::to_owned).collect();
    let hint: Vec<String> = warnings.extract_if(.., |line| !line.starts_with(WARNING)).collect();
    let lowered: Vec<LoweredFloor> =
        view.lowered_pairs.iter().map(|pair| lowered(pair, view)).collect::<Result<_, _>>()?;
    let certificate = certificate(view, settings, &path, &lowered)?;
    let outcome = Outcome {
        path,
        proved: view.is_proved(),
        refusal: refusal(view, hint.join("\n"))?,
        length_before: header.length_before,
        length_after: header.length_after,
        lower_bound: header.lower_bound,
        weights: weights.to_vec(),
        clearance_m: settings.clearance_m,
        floor_m: header.floor_m,
        floors_lowered: lowered,
        iterations: header.iterations,
        work: header.work,
        termination: termination(view.termination),
        warnings: warnings.iter().map(|line| line[WARNING.len()..].to_owned()).collect(),
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
        Wire::Running | Wire::Deadline | Wire::Cancelled | Wire::FinishedEarly => Termination::Stopped,
    }
}

fn names(view: &ResponseView, spans: [TextSpan; 2]) -> Result<[String; 2], WireError> {
    let [a, b] = spans;
    Ok([a.of(view.names)?.to_owned(), b.of(view.names)?.to_owned()])
}

fn lowered(pair: &wire::LoweredPair, view: &ResponseView) -> Result<LoweredFloor, WireError> {
    Ok(LoweredFloor { bodies: names(view, [pair.body_a, pair.body_b])?, floor_m: pair.floor_m })
}

fn refusal(view: &ResponseView, hint: String) -> Result<Option<Refusal>, WireError> {
    let Some(record) = view.refusal else { return Ok(None) };
    let reason = match RefusalReason::try_from(view.header.refusal_reason)? {
        RefusalReason::None => return Ok(None),
        RefusalReason::Collision => HitReason::Collision,
        RefusalReason::TooClose => HitReason::TooClose,
        RefusalReason::Uncertified => HitReason::Uncertified,
    };
    let place = match view.code {
        Code::StartStateInCollision => RefusalPlace::Start,
        Code::GoalInCollision => RefusalPlace::Goal,
        _ => RefusalPlace::Between,
    };
    let vector = |[x, y, z]: [f64; 3]| Vec3::new(x, y, z);
    Ok(Some(Refusal {
        reason,
        place,
        segment: record.segment as usize,
        t: record.t,
        bodies: names(view, [record.body_a, record.body_b])?,
        points: [vector(record.point_a), vector(record.point_b)],
        normal: vector(record.normal),
        depth_m: record.depth_m,
        proved_prefix: f64::from(record.proved_segments) + record.proved_t,
        hint,
    }))
}

/// The certificate, after comparing its hash with the path that came.
fn certificate(
    view: &ResponseView,
    settings: &Settings,
    path: &Path,
    lowered: &[LoweredFloor],
) -> Result<Option<Certificate>, AnswerError> {
    let Some(head) = view.certificate_head else { return Ok(None) };
    if head.path_hash != path_hash(path.as_flat()) {
        return Err(AnswerError::OtherPath);
    }
    let claim = |segment: &wire::CertificateSegment| SegmentClaim {
        clearance_m: Some(segment.clearance_m).filter(|clearance| clearance.is_finite()),
        intervals: segment.intervals,
    };
    let named = |floor: &LoweredFloor| (floor.bodies[0].clone(), floor.bodies[1].clone(), floor.floor_m);
    let certificate = Certificate {
        checker_version: head.checker_version,
        path_hash: path.hash(),
        robot_hash: view.header.robot_hash,
        scene_hash: view.header.scene_hash,
        clearance_m: head.clearance_m,
        lowered: lowered.iter().map(named).collect(),
        unwrapped: settings.unwrapped,
        held: settings.held.clone(),
        segments: view.certificate.iter().map(claim).collect(),
        digest: None,
    };
    Ok(Some(certificate.sealed()))
}
