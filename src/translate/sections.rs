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

fn names(view: &ResponseView, spans: [TextSpan; 2]) -> Result<[String; 2], WireError> {
    let [a, b] = spans;
    Ok([a.of(view.names)?.to_owned(), b.of(view.names)?.to_owned()])
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
    let reason = match RefusalReason::try_from(view.header.refusal_reason)? {
        RefusalReason::None | RefusalReason::NoGeometry => return Ok(None),
        RefusalReason::Collision => HitReason::Collision,
        RefusalReason::TooClose => HitReason::TooClose,
        RefusalReason::Uncertified => HitReason::Uncertified,
    };
    let place = match view.code {
        Code::StartStateInCollision => RefusalPlace::Start,
        Code::GoalInCollision => RefusalPlace::Goal,
        _ => RefusalPlace::Between,
    };
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
    let claim = |segment: &wire::CertificateSegment| SegmentClaim {
        clearance_m: Some(segment.clearance_m).filter(|clearance| clearance.is_finite()),
        intervals: segment.intervals,
    };
    let named = |floor: &LoweredFloor| {
        (
            floor.bodies[0].clone(),
            floor.bodies[1].clone(),
            floor.floor_m,
        )
    };
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

/// The corridor; `None` where it was not asked for.
pub(super) fn corridor(view: &ResponseView, certificate: &Certificate) -> Option<Corridor> {
    let reach = view.reach.to_vec();
    let slack_m = corridor::slack_m(certificate);
    (!reach.is_empty()).then(|| Corridor {
        floor_m: certificate.floor_m(),
        reach,
        slack_m,
    })
}

/// What is nearest along the path; `None` where it was not looked for.
pub(super) fn nearest(view: &ResponseView) -> Result<Option<NearestBodies>, WireError> {
    let searched_m = view.header.searched_m;
    if searched_m == 0.0 {
        return Ok(None);
    }
    let contact = |record: &ActiveContact| -> Result<PathContact, WireError> {
        Ok(PathContact {
            segment: record.segment as usize,
            t: record.t,
            bodies: names(view, [record.body_a, record.body_b])?,
            distance_m: record.distance_m,
            points: [vector(record.point_a), vector(record.point_b)],
            normal: vector(record.normal),
        })
    };
    let smallest = view.active_contacts.first().map(contact).transpose()?;
    let contacts = view
        .active_contacts
        .iter()
        .skip(1)
        .map(contact)
        .collect::<Result<_, _>>()?;
    Ok(Some(NearestBodies {
        searched_m,
        smallest,
        contacts,
    }))
}

/// What a person should know beside the verdict. Each stands for itself: who sent it has counted
/// the others like it.
pub(super) fn warnings(view: &ResponseView) -> Result<Vec<Warning>, WireError> {
    let warning = |record: &WarningRecord| -> Result<Warning, WireError> {
        let text = record.text.of(view.names)?;
        Ok(match WarningKind::try_from(record.kind)? {
            WarningKind::Uncovered => Warning::uncovered(text),
            WarningKind::Cosmetic => Warning::cosmetic(text, text),
        })
    };
    view.warnings.iter().map(warning).collect()
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
    let column = |record: &TurnedColumn| match robot.variables.get(record.column as usize) {
        Some(variable) => Ok(ColumnTurns {
            variable: variable.name.clone(),
            turns: record.turns.into(),
        }),
        None => Err(WireError::UnknownValue {
            field: "column",
            value: record.column.into(),
        }),
    };
    view.turned_columns.iter().map(column).collect()
}

/// What each stage did.
pub(super) fn stages(view: &ResponseView) -> Result<Vec<StageShare>, WireError> {
    let share = |record: &StageRecord| {
        let stage = number::stage(Stage::try_from(record.stage)?);
        Ok(StageShare {
            stage,
            gain: record.gain,
            work: record.work,
            iterations: record.iterations,
        })
    };
    view.stages.iter().map(share).collect()
}
