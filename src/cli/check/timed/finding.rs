//! What was found, as JSON.

use serde::Serialize;
use taut::validation::{Certificate, LoweredFloor, NamedRequirement};

use super::judge::Verdict;

/// What was found, as JSON has it. Distances are in metres, times in seconds on the trajectory's
/// clock.
#[derive(Default, Serialize)]
pub(super) struct Finding<'a> {
    pub name: &'a str,
    pub timed: bool,
    pub proved: bool,
    pub code: i32,
    pub code_name: &'static str,
    pub points: usize,
    pub duration_s: f64,
    pub clearance_m: Option<f64>,
    pub floors_lowered: Vec<LoweredFloor>,
    pub intervals: u64,
    /// `COLLISION`, `TOO_CLOSE`, `OUTSIDE`, `UNCERTIFIED` or `LIMIT`.
    pub reason: Option<&'static str>,
    /// The point before the place, from 0.
    pub point: Option<usize>,
    pub at_s: Option<f64>,
    /// What is not kept.
    #[serde(flatten)]
    pub requirement: Option<NamedRequirement>,
    /// How much of it is kept, in its unit: of a clearance the distance, below 0 no more than the
    /// penetration depth.
    pub amount: Option<f64>,
    pub seen_s: Option<f64>,
    /// Why nothing can be proved of this robot.
    pub uncheckable: Option<String>,
    /// Pairs of bodies that were checked.
    pub pairs: usize,
    pub warnings: Vec<String>,
    pub uncovered: Vec<String>,
    pub variable: Option<String>,
    pub value: Option<f64>,
    /// `velocity` or `acceleration`, where such a limit is exceeded.
    pub limit: Option<&'static str>,
    /// How many times that limit.
    pub part: Option<f64>,
    pub time_s: f64,
    pub certificate: Option<&'a Certificate>,
}

/// What of a verdict a finding holds.
pub(super) fn found(verdict: &Verdict) -> Finding<'_> {
    match verdict {
        Verdict::Proved(proof) => Finding {
            proved: true,
            clearance_m: proof.clearance_m,
            floors_lowered: proof.lowered.clone(),
            intervals: proof.intervals,
            certificate: Some(&proof.certificate),
            ..Finding::default()
        },
        Verdict::Refused(refusal) => Finding {
            point: Some(refusal.point),
            at_s: Some(refusal.time_s),
            requirement: Some(refusal.requirement.clone()),
            amount: Some(refusal.measure.amount),
            seen_s: Some(refusal.seen_s),
            ..Finding::default()
        },
        Verdict::Outside {
            outside, variable, ..
        } => Finding {
            point: Some(outside.point),
            at_s: Some(outside.time_s),
            variable: Some(variable.clone()),
            value: Some(outside.value),
            ..Finding::default()
        },
        Verdict::Beyond(beyond) => Finding {
            point: Some(beyond.point),
            at_s: Some(beyond.used.time_s),
            variable: Some(beyond.variable.clone()),
            limit: Some(beyond.what),
            part: Some(beyond.used.part),
            ..Finding::default()
        },
        Verdict::TimedOut => Finding::default(),
        Verdict::NoGeometry(why) => Finding {
            uncheckable: Some(why.clone()),
            ..Finding::default()
        },
    }
}
