//! From the records of a response's sections back to an outcome.

use crate::constraint::ConstraintsFile;
use crate::math::Vec3;
use crate::optimize::{
    ColumnTurns, KeptConstraint, NearestHolds, PathHold, Refusal, RefusalPlace, StageShare,
};
use crate::path::Path;
use crate::validation::corridor;
use crate::validation::{
    Certificate, ConstraintClaims, Corridor, HitReason, LoweredFloor, NamedRequirement,
    SegmentClaim,
};
use crate::warning::Warning;
use taut_ipc::control::RobotDescription;
use taut_ipc::planner::Request;
use taut_ipc::wire::{
    self, Code, HoldRecord, RefusalReason, RequirementKind, RequirementRecord, ResponseView, Stage,
    StageRecord, TurnedColumn, Unit, WarningKind, WarningRecord, WireError,
};

use super::error::AnswerError;
use super::number;

fn vector([x, y, z]: [f64; 3]) -> Vec3 {
    Vec3::new(x, y, z)
}

/// What a path must keep.
fn requirement(
    record: &RequirementRecord,
    view: &ResponseView,
) -> Result<NamedRequirement, WireError> {
    Ok(NamedRequirement {
        kind: number::kind(RequirementKind::try_from(record.kind)?),
        unit: number::unit(Unit::try_from(record.unit)?),
        names: record.names(view.names)?,
    })
}

/// A requirement with a lowered floor.
pub(super) fn lowered(
    record: &wire::LoweredFloorRecord,
    view: &ResponseView,
) -> Result<LoweredFloor, WireError> {
    Ok(LoweredFloor {
        requirement: requirement(&record.requirement, view)?,
        floor: record.floor,
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
        requirement: requirement(&record.requirement, view)?,
        amount: record.amount,
        allowed: record.allowed,
        points: record.points.map(vector),
        normal: vector(record.normal),
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
        RefusalReason::Outside => Some(HitReason::Outside),
    })
}

fn place(code: Code) -> RefusalPlace {
    match code {
        Code::StartStateInCollision | Code::StartStateViolatesPathConstraints => {
            RefusalPlace::Start
        }
        Code::GoalInCollision | Code::GoalViolatesPathConstraints => RefusalPlace::Goal,
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
    let segments = view.certificate.len();
    let certificate = Certificate {
        checker_version: head.checker_version,
        path_hash: path.hash(),
        robot_hash: view.header.robot_hash,
        scene_hash: view.header.scene_hash,
        clearance_m: head.clearance_m,
        lowered: lowered.to_vec(),
        unwrapped: request.unwrapped,
        held: (!held.is_empty()).then_some(held),
        constraints: constraints(view, segments)?,
        timed: None,
        segments: view.certificate.iter().map(claim).collect(),
        digest: None,
    };
    Ok(Some(certificate.sealed()))
}

/// What the certificate claims of constraints, on each of so many segments.
fn constraints(
    view: &ResponseView,
    segments: usize,
) -> Result<Option<ConstraintClaims>, AnswerError> {
    if view.constraints.is_empty() {
        return Ok(None);
    }
    let claims = view.constraint_claims;
    let count = claims.len() / segments.max(1);
    if count == 0 || count * segments != claims.len() {
        return Err(AnswerError::Wire(WireError::SectionCount {
            section: "constraint_claims",
            found: claims.len(),
            expected: count.max(1) * segments,
        }));
    }
    Ok(Some(ConstraintClaims {
        asked: ConstraintsFile::parse(view.constraints)?,
        left: claims
            .chunks(count)
            .map(<[f64]>::to_vec)
            .collect(),
    }))
}

fn claim(segment: &wire::CertificateSegment) -> SegmentClaim {
    SegmentClaim {
        clearance_m: Some(segment.clearance_m).filter(|clearance| clearance.is_finite()),
        intervals: segment.intervals,
    }
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
pub(super) fn nearest(view: &ResponseView) -> Result<Option<NearestHolds>, WireError> {
    let searched_m = view.header.searched_m;
    if searched_m == 0.0 {
        return Ok(None);
    }
    let (smallest, holds) = smallest_and_holds(view)?;
    Ok(Some(NearestHolds {
        searched_m,
        smallest: smallest
            .map(|record| hold(view, record))
            .transpose()?,
        holds: holds
            .iter()
            .map(|record| hold(view, record))
            .collect::<Result<_, _>>()?,
    }))
}

type SmallestAndHolds<'a> = (Option<&'a HoldRecord>, &'a [HoldRecord]);

/// The place of the smallest clearance, where there is one, and what holds the path.
fn smallest_and_holds<'a>(view: &ResponseView<'a>) -> Result<SmallestAndHolds<'a>, WireError> {
    let Some((first, others)) = view.holds.split_first() else {
        return Ok((None, &[]));
    };
    Ok(match RequirementKind::try_from(first.requirement.kind)? {
        RequirementKind::Clearance => (Some(first), others),
        // Where a clearance holds the path, the smallest stands before it.
        RequirementKind::Orientation | RequirementKind::Position | RequirementKind::Joint => {
            (None, view.holds)
        }
    })
}

/// What the path keeps of each constraint.
pub(super) fn keeps(view: &ResponseView) -> Result<Vec<KeptConstraint>, WireError> {
    let records = view.keeps.iter();
    records
        .map(|record| {
            Ok(KeptConstraint {
                tightest: hold(view, &record.tightest)?,
                left: record.left,
                asked: Some(record.asked).filter(|asked| *asked > 0.0),
            })
        })
        .collect()
}

pub(super) fn hold(view: &ResponseView, record: &HoldRecord) -> Result<PathHold, WireError> {
    Ok(PathHold {
        segment: record.segment as usize,
        t: record.t,
        requirement: requirement(&record.requirement, view)?,
        amount: record.amount,
        points: record.points.map(vector),
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

/// What pinches the path.
pub(super) fn pinched(view: &ResponseView) -> Result<Vec<NamedRequirement>, WireError> {
    let pinched = view.pinched.iter();
    pinched
        .map(|record| requirement(record, view))
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
