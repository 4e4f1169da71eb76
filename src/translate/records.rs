//! From an outcome to the records of a response's sections.

use std::collections::HashMap;

use super::number;
use crate::optimize::{
    self, ColumnTurns, LoweredFloor, NearestBodies, Outcome, PathContact, Refusal as Hit,
};
use crate::path::Path;
use crate::robot::RobotModel;
use crate::validation::{Certificate, HitReason, SegmentClaim};
use crate::warning::Warning;
use taut_ipc::limits::{MAX_RECORDS, MAX_STAGES, MAX_TEXT, MAX_WARNINGS, MAX_WARNINGS_TEXT};
use taut_ipc::wire::{
    ActiveContact, CertificateHead, CertificateSegment, LoweredPair, PinchedPair, RefusalReason,
    RefusalRecord, StageRecord, TextSpan, TurnedColumn, WarningKind, WarningRecord,
};

/// Collects names of bodies, each once, as far as the section holds them.
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

    /// Where the names of two bodies lie.
    fn pair(&mut self, [a, b]: &[String; 2]) -> Option<[TextSpan; 2]> {
        Some([self.span(a)?, self.span(b)?])
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
    }
}

/// Where and why the input is refused.
pub(super) fn refusal(hit: &Hit, outcome: &Outcome, names: &mut Names) -> RefusalRecord {
    let [body_a, body_b] = hit
        .bodies
        .each_ref()
        .map(|name| names.span(name).unwrap_or_default());
    let proved_segments = hit.proved_prefix.floor();
    RefusalRecord {
        body_a,
        body_b,
        segment: hit.segment as u32,
        proved_segments: proved_segments as u32,
        t: hit.t,
        proved_t: hit.proved_prefix - proved_segments,
        depth_m: hit.depth_m,
        floor_m: floor_of(&hit.bodies, outcome),
        point_a: hit.points[0].to_array(),
        point_b: hit.points[1].to_array(),
        normal: hit.normal.to_array(),
    }
}

/// The distance that a pair has to keep.
fn floor_of(bodies: &[String; 2], outcome: &Outcome) -> f64 {
    let mut lowered = outcome.floors_lowered.iter();
    lowered
        .find(|lowered| lowered.bodies == *bodies)
        .map_or(outcome.clearance_m, |lowered| lowered.floor_m)
}

/// Pairs with a lowered floor.
pub(super) fn lowered(outcome: &Outcome, names: &mut Names) -> Vec<LoweredPair> {
    let floors = outcome.floors_lowered.iter();
    floors
        .map_while(|floor| lowered_pair(floor, names))
        .take(MAX_RECORDS)
        .collect()
}

fn lowered_pair(floor: &LoweredFloor, names: &mut Names) -> Option<LoweredPair> {
    let [body_a, body_b] = names.pair(&floor.bodies)?;
    Some(LoweredPair {
        body_a,
        body_b,
        floor_m: floor.floor_m,
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
pub(super) fn contacts(nearest: &NearestBodies, names: &mut Names) -> Vec<ActiveContact> {
    nearest
        .smallest
        .iter()
        .chain(&nearest.contacts)
        .map_while(|at| contact(at, names))
        .take(MAX_RECORDS)
        .collect()
}

fn contact(contact: &PathContact, names: &mut Names) -> Option<ActiveContact> {
    let [body_a, body_b] = names.pair(&contact.bodies)?;
    Some(ActiveContact {
        body_a,
        body_b,
        segment: contact.segment as u32,
        reserved: 0,
        t: contact.t,
        distance_m: contact.distance_m,
        point_a: contact.points[0].to_array(),
        point_b: contact.points[1].to_array(),
        normal: contact.normal.to_array(),
    })
}

/// Pairs between which the path is pinched.
pub(super) fn pinched(outcome: &Outcome, names: &mut Names) -> Vec<PinchedPair> {
    let pairs = outcome.pinched.iter();
    pairs
        .map_while(|bodies| names.pair(bodies))
        .map(|[body_a, body_b]| PinchedPair { body_a, body_b })
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
