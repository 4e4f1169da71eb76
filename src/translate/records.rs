//! From an outcome to the records of a response's sections.

use std::collections::HashMap;

use super::number;
use crate::optimize::{
    self, ColumnTurns, KeptConstraint, NearestHolds, Outcome, PathHold, Refusal as Hit,
};
use crate::path::Path;
use crate::robot::RobotModel;
use crate::validation::{Certificate, HitReason, LoweredFloor, NamedRequirement, SegmentClaim};
use crate::warning::Warning;
use taut_ipc::limits::{MAX_RECORDS, MAX_STAGES, MAX_TEXT, MAX_WARNINGS, MAX_WARNINGS_TEXT};
use taut_ipc::wire::{
    CertificateHead, CertificateSegment, HoldRecord, KeptRecord, LoweredFloorRecord, RefusalReason,
    RefusalRecord, RequirementRecord, StageRecord, TextSpan, TurnedColumn, WarningKind,
    WarningRecord,
};

/// Collects names, each once, as far as the section holds them.
#[derive(Default)]
pub(super) struct Names {
    /// The section.
    pub text: String,
    known: HashMap<String, TextSpan>,
}

impl Names {
    /// Where the name lies; `None` once the section is full.
    fn span(&mut self, name: &str) -> Option<TextSpan> {
        self.known
            .get(name)
            .copied()
            .or_else(|| self.enter(name))
    }

    fn enter(&mut self, name: &str) -> Option<TextSpan> {
        if self.text.len() + name.len() > MAX_TEXT {
            return None;
        }
        let span = TextSpan::push(&mut self.text, name);
        self.known.insert(name.to_owned(), span);
        Some(span)
    }

    /// A requirement by its names; `None` once the section is full.
    fn requirement(&mut self, requirement: &NamedRequirement) -> Option<RequirementRecord> {
        let mut names = [TextSpan::default(); 2];
        for (span, name) in names.iter_mut().zip(&requirement.names) {
            *span = self.span(name)?;
        }
        Some(RequirementRecord {
            kind: number::wire_kind(requirement.kind).into(),
            unit: number::wire_unit(requirement.unit).into(),
            names,
        })
    }
}

/// Most bytes of one warning.
const WARNING_MAX: usize = 4096;

/// Warnings as far as the section holds them, the last telling how many it does not.
pub(super) fn warnings(warnings: &[Warning], names: &mut Names) -> Vec<WarningRecord> {
    let mut records = Vec::with_capacity(warnings.len());
    for (index, warning) in warnings.iter().enumerate() {
        let text = &warning.text()[..warning.text().floor_char_boundary(WARNING_MAX)];
        let is_full =
            names.text.len() + text.len() > MAX_WARNINGS_TEXT || index + 1 == MAX_WARNINGS;
        if is_full && index + 1 < warnings.len() {
            let rest = left_out(warnings.len() - index);
            records.push(record_of(WarningKind::Uncovered, &rest, names));
            break;
        }
        records.push(record_of(kind_of(warning), text, names));
    }
    records
}

fn left_out(count: usize) -> String {
    format!("{count} warnings more than an answer holds; see `taut describe`")
}

fn kind_of(warning: &Warning) -> WarningKind {
    match warning.is_uncovered() {
        true => WarningKind::Uncovered,
        false => WarningKind::Cosmetic,
    }
}

fn record_of(kind: WarningKind, text: &str, names: &mut Names) -> WarningRecord {
    WarningRecord {
        kind: kind.into(),
        reserved: 0,
        text: TextSpan::push(&mut names.text, text),
    }
}

/// The same reason on the wire.
pub(super) fn reason(reason: HitReason) -> RefusalReason {
    match reason {
        HitReason::Collision => RefusalReason::Collision,
        HitReason::TooClose => RefusalReason::TooClose,
        HitReason::Uncertified => RefusalReason::Uncertified,
        HitReason::Outside => RefusalReason::Outside,
    }
}

/// Where and why the input is refused.
pub(super) fn refusal(hit: &Hit, names: &mut Names) -> RefusalRecord {
    let requirement = names.requirement(&hit.requirement);
    let proved_segments = hit.proved_prefix.floor();
    RefusalRecord {
        requirement: requirement.unwrap_or_default(),
        segment: hit.segment as u32,
        proved_segments: proved_segments as u32,
        t: hit.t,
        proved_t: hit.proved_prefix - proved_segments,
        amount: hit.amount,
        allowed: hit.allowed,
        points: hit.points.map(|point| point.to_array()),
        normal: hit.normal.to_array(),
    }
}

/// Requirements with a lowered floor.
pub(super) fn lowered(outcome: &Outcome, names: &mut Names) -> Vec<LoweredFloorRecord> {
    let floors = outcome.floors_lowered.iter();
    floors
        .map_while(|floor| lowered_floor(floor, names))
        .take(MAX_RECORDS)
        .collect()
}

pub(super) fn lowered_floor(
    lowered: &LoweredFloor,
    names: &mut Names,
) -> Option<LoweredFloorRecord> {
    Some(LoweredFloorRecord {
        requirement: names.requirement(&lowered.requirement)?,
        floor: lowered.floor,
    })
}

/// What the certificate claims of each segment.
pub(super) fn segments(certificate: &Certificate) -> Vec<CertificateSegment> {
    certificate
        .segments
        .iter()
        .map(segment)
        .collect()
}

fn segment(claim: &SegmentClaim) -> CertificateSegment {
    CertificateSegment {
        clearance_m: claim.clearance_m.unwrap_or(f64::INFINITY),
        intervals: claim.intervals,
        reserved: 0,
    }
}

/// What it is about.
pub(super) fn head(certificate: &Certificate, path: &Path) -> CertificateHead {
    let claims = certificate.segments.iter();
    CertificateHead {
        path_hash: path.digest(),
        checker_version: certificate.checker_version,
        segments: certificate.segments.len() as u32,
        clearance_m: certificate.clearance_m,
        intervals: claims
            .map(|claim| u64::from(claim.intervals))
            .sum(),
    }
}

/// The place of the smallest clearance, then what holds the path, as far as the section holds it.
pub(super) fn holds(nearest: &NearestHolds, names: &mut Names) -> Vec<HoldRecord> {
    nearest
        .smallest
        .iter()
        .chain(&nearest.holds)
        .map_while(|at| hold(at, names))
        .take(MAX_RECORDS)
        .collect()
}

pub(super) fn hold(hold: &PathHold, names: &mut Names) -> Option<HoldRecord> {
    Some(HoldRecord {
        requirement: names.requirement(&hold.requirement)?,
        segment: hold.segment as u32,
        reserved: 0,
        t: hold.t,
        amount: hold.amount,
        points: hold.points.map(|point| point.to_array()),
        normal: hold.normal.to_array(),
    })
}

/// What the path keeps of each constraint.
pub(super) fn keeps(outcome: &Outcome, names: &mut Names) -> Vec<KeptRecord> {
    let keeps = outcome.keeps.iter();
    keeps
        .map_while(|kept| self::kept(kept, names))
        .take(MAX_RECORDS)
        .collect()
}

fn kept(kept: &KeptConstraint, names: &mut Names) -> Option<KeptRecord> {
    Some(KeptRecord {
        tightest: hold(&kept.tightest, names)?,
        left: kept.left,
        asked: kept.asked.unwrap_or(0.0),
    })
}

/// What pinches the path.
pub(super) fn pinched(outcome: &Outcome, names: &mut Names) -> Vec<RequirementRecord> {
    let pinched = outcome.pinched.iter();
    pinched
        .map_while(|requirement| names.requirement(requirement))
        .take(MAX_RECORDS)
        .collect()
}

/// Angle columns whose numbers are not the given ones.
pub(super) fn turned(outcome: &Outcome, robot: &RobotModel) -> Vec<TurnedColumn> {
    let columns = outcome.turned.iter();
    columns
        .filter_map(|turned| turned_column(turned, robot))
        .collect()
}

fn turned_column(turned: &ColumnTurns, robot: &RobotModel) -> Option<TurnedColumn> {
    let mut variables = robot.variables().iter();
    let column = variables.position(|variable| variable.name == turned.variable)?;
    Some(TurnedColumn {
        column: column as u32,
        turns: turned.turns as i32,
    })
}

/// What each stage did.
pub(super) fn stages(outcome: &Outcome) -> Vec<StageRecord> {
    outcome
        .stages
        .iter()
        .map(stage)
        .take(MAX_STAGES)
        .collect()
}

fn stage(share: &optimize::StageShare) -> StageRecord {
    StageRecord {
        stage: number::wire_stage(share.stage).into(),
        reserved: 0,
        gain: share.gain,
        work: share.work,
        iterations: share.iterations,
    }
}
