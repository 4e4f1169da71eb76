//! From the records of a response's sections back to an outcome.

use crate::math::Vec3;
use crate::optimize::{
    ColumnTurns, LoweredFloor, NearestBodies, PathContact, Refusal, RefusalPlace, StageShare,
};
use crate::path::Path;
use crate::validation::corridor;
use crate::validation::{Certificate, Corridor, HitReason, SegmentClaim};
use crate::warning::Warning;
use taut_ipc::control::RobotDescription;
use taut_ipc::planner::Request;
use taut_ipc::wire::{
    self, ActiveContact, Code, RefusalReason, ResponseView, Stage, StageRecord, TextSpan,
    TurnedColumn, WarningKind, WarningRecord, WireError,
};

use super::error::AnswerError;
use super::number;

fn vector([x, y, z]: [f64; 3]) -> Vec3 {
    Vec3::new(x, y, z)
}

fn names(view: &ResponseView, [a, b]: [TextSpan; 2]) -> Result<[String; 2], WireError> {
    let name = |span: TextSpan| span.of(view.names).map(str::to_owned);
    Ok([name(a)?, name(b)?])
}

/// A pair with a lowered floor.
pub(super) fn lowered(
    pair: &wire::LoweredPair,
    view: &ResponseView,
) -> Result<LoweredFloor, WireError> {
    Ok(LoweredFloor {
        bodies: names(view, [pair.body_a, pair.body_b])?,
        floor_m: pair.floor_m,
    })
}

/// Where and why the input is refused.
pub(super) fn refusal(view: &ResponseView, hint: String) -> Result<Option<Refusal>, WireError> {
    let Some(record) = view.refusal else {
        return Ok(None);
    };
    let Some(reason) = reason(view)? else {
        return Ok(None);
    };
    Ok(Some(Refusal {
        reason,
        place: place(view.code),
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

/// Why the motion is refused; `None` where it is not the motion that is.
fn reason(view: &ResponseView) -> Result<Option<HitReason>, WireError> {
    Ok(match RefusalReason::try_from(view.header.refusal_reason)? {
        RefusalReason::None | RefusalReason::NoGeometry => None,
        RefusalReason::Collision => Some(HitReason::Collision),
        RefusalReason::TooClose => Some(HitReason::TooClose),
        RefusalReason::Uncertified => Some(HitReason::Uncertified),
    })
}

fn place(code: Code) -> RefusalPlace {
    match code {
        Code::StartStateInCollision => RefusalPlace::Start,
        Code::GoalInCollision => RefusalPlace::Goal,
        _ => RefusalPlace::Between,
    }
}

/// The certificate, after comparing its hash with the path that came.
pub(super) fn certificate(
    view: &ResponseView,
    request: &Request,
    robot: &RobotDescription,
    path: &Path,
    lowered: &[LoweredFloor],
) -> Result<Option<Certificate>, AnswerError> {
    let Some(head) = view.certificate_head else {
        return Ok(None);
    };
    if head.path_hash != path.digest() {
        return Err(AnswerError::OtherPath);
    }
    let held = request.held_values(robot)?;
    let certificate = Certificate {
        checker_version: head.checker_version,
        path_hash: path.hash(),
        robot_hash: view.header.robot_hash,
        scene_hash: view.header.scene_hash,
        clearance_m: head.clearance_m,
        lowered: lowered.iter().map(named).collect(),
        unwrapped: request.unwrapped,
        held: (!held.is_empty()).then_some(held),
        segments: view.certificate.iter().map(claim).collect(),
        digest: None,
    };
    Ok(Some(certificate.sealed()))
}

fn claim(segment: &wire::CertificateSegment) -> SegmentClaim {
    SegmentClaim {
        clearance_m: Some(segment.clearance_m).filter(|clearance| clearance.is_finite()),
        intervals: segment.intervals,
    }
}

/// A lowered floor as certificates have it.
fn named(floor: &LoweredFloor) -> (String, String, f64) {
    let [a, b] = floor.bodies.clone();
    (a, b, floor.floor_m)
}

/// The corridor; `None` where it was not asked for.
pub(super) fn corridor(view: &ResponseView, certificate: &Certificate) -> Option<Corridor> {
    (!view.reach.is_empty()).then(|| Corridor {
        floor_m: certificate.floor_m(),
        reach: view.reach.to_vec(),
        slack_m: corridor::slack_m(certificate),
    })
}

/// What is nearest along the path; `None` where it was not looked for.
pub(super) fn nearest(view: &ResponseView) -> Result<Option<NearestBodies>, WireError> {
    let searched_m = view.header.searched_m;
    if searched_m == 0.0 {
        return Ok(None);
    }
    let mut contacts = view
        .active_contacts
        .iter()
        .map(|record| contact(view, record));
    Ok(Some(NearestBodies {
        searched_m,
        smallest: contacts.next().transpose()?,
        contacts: contacts.collect::<Result<_, _>>()?,
    }))
}

fn contact(view: &ResponseView, record: &ActiveContact) -> Result<PathContact, WireError> {
    Ok(PathContact {
        segment: record.segment as usize,
        t: record.t,
        bodies: names(view, [record.body_a, record.body_b])?,
        distance_m: record.distance_m,
        points: [vector(record.point_a), vector(record.point_b)],
        normal: vector(record.normal),
    })
}

/// What a person should know beside the verdict. Each stands for itself: who sent it has counted
/// the others like it.
pub(super) fn warnings(view: &ResponseView) -> Result<Vec<Warning>, WireError> {
    let records = view.warnings.iter();
    records
        .map(|record| warning(view, record))
        .collect()
}

fn warning(view: &ResponseView, record: &WarningRecord) -> Result<Warning, WireError> {
    let text = record.text.of(view.names)?;
    Ok(match WarningKind::try_from(record.kind)? {
        WarningKind::Uncovered => Warning::uncovered(text),
        WarningKind::Cosmetic => Warning::cosmetic(text, text),
    })
}

/// Why nothing can be proved of the robot.
pub(super) fn uncheckable(view: &ResponseView) -> Result<Option<String>, WireError> {
    let is_without =
        RefusalReason::try_from(view.header.refusal_reason)? == RefusalReason::NoGeometry;
    Ok(is_without.then(|| view.message.to_owned()))
}

/// Pairs between which the path is pinched.
pub(super) fn pinched(view: &ResponseView) -> Result<Vec<[String; 2]>, WireError> {
    view.pinched_pairs
        .iter()
        .map(|pair| names(view, [pair.body_a, pair.body_b]))
        .collect()
}

/// Angle columns whose numbers are not the given ones.
pub(super) fn turned(
    view: &ResponseView,
    robot: &RobotDescription,
) -> Result<Vec<ColumnTurns>, WireError> {
    let records = view.turned_columns.iter();
    records
        .map(|record| column_turns(record, robot))
        .collect()
}

fn column_turns(record: &TurnedColumn, robot: &RobotDescription) -> Result<ColumnTurns, WireError> {
    let variable = robot.variables.get(record.column as usize);
    let variable = variable.ok_or(WireError::UnknownValue {
        field: "column",
        value: record.column.into(),
    })?;
    Ok(ColumnTurns {
        variable: variable.name.clone(),
        turns: record.turns.into(),
    })
}

/// What each stage did.
pub(super) fn stages(view: &ResponseView) -> Result<Vec<StageShare>, WireError> {
    view.stages.iter().map(share).collect()
}

fn share(record: &StageRecord) -> Result<StageShare, WireError> {
    Ok(StageShare {
        stage: number::stage(Stage::try_from(record.stage)?),
        gain: record.gain,
        work: record.work,
        iterations: record.iterations,
    })
}
