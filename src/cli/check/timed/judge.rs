//! What comes of a trajectory.

use std::time::Instant;

use taut::collision::CollisionModel;
use taut::optimize::{LIMIT_TOLERANCE, Settings};
use taut::robot::{Kinematics, RobotModel};
use taut::validation::timed::{self, Curve, Outside, TimedHit, TimedProof, TimedVerdict};
use taut::validation::{
    HitReason, LoweredFloor, Measure, NamedRequirement, Requirement, Scratch, Validator,
};
use taut::warning::Warning;
use taut_ipc::planner::Request;

use crate::cli::error::CliError;
use crate::cli::load::Loaded;
use taut_ipc::wire::Code;

/// What came of a trajectory.
pub(super) enum Verdict {
    Proved(TimedProof),
    Refused(Refusal),
    Outside {
        outside: Outside,
        variable: String,
        limits: [f64; 2],
    },
    TimedOut,
    NoGeometry(String),
}

/// Where a trajectory is refused.
pub(super) struct Refusal {
    pub reason: HitReason,
    /// The point before it, from 0.
    pub point: usize,
    /// When it is first so (s).
    pub time_s: f64,
    /// What is not kept.
    pub requirement: NamedRequirement,
    /// When it was measured (s), and how much was kept then.
    pub seen_s: f64,
    pub measure: Measure,
}

impl Refusal {
    fn of(hit: &TimedHit, model: &CollisionModel) -> Self {
        Self {
            reason: hit.reason,
            point: hit.point,
            time_s: hit.time_s,
            requirement: hit.requirement.named(model, &[]),
            seen_s: hit.seen_s,
            measure: hit.measure,
        }
    }

    /// Bodies collide wherever the robot goes.
    fn at_start(curve: &Curve, bodies: [String; 2], measure: Measure) -> Self {
        let time_s = curve.time(0);
        Self {
            reason: HitReason::Collision,
            point: 0,
            time_s,
            requirement: NamedRequirement::clearance(bodies),
            seen_s: time_s,
            measure,
        }
    }
}

/// A verdict and what it rests on.
pub(super) struct Judged {
    /// What came of it.
    pub verdict: Verdict,
    /// Pairs of bodies that were checked.
    pub pairs: usize,
    /// What the verdict does not cover.
    pub warnings: Vec<Warning>,
}

/// Judges the curve of a trajectory.
///
/// # Errors
/// A robot and a scene that do not go together, a joint that is none.
pub(super) fn judge(
    loaded: &Loaded,
    curve: &Curve,
    request: &Request,
    start: Instant,
) -> Result<Judged, CliError> {
    let model = loaded.model()?;
    let mut warnings = model.uncovered();
    warnings.extend(late_start(curve));
    let held = held(loaded, &request.held)?;
    let verdict = match outside(loaded, curve, &mut warnings) {
        Some(outside) => outside,
        None => standing(loaded, &model, curve, &held)
            .unwrap_or_else(|| moving(loaded, &model, curve, &held, request, start)),
    };
    Ok(Judged {
        verdict,
        pairs: model.checked_pairs(),
        warnings,
    })
}

fn late_start(curve: &Curve) -> Option<Warning> {
    let start_s = curve.time(0);
    (start_s > 0.0).then(|| {
        Warning::uncovered(format!(
            "the first point is at {start_s} s: how the robot gets there is not part of the trajectory, nor of this proof"
        ))
    })
}

/// Where the curve leaves the limits, unless by so little that a warning says it.
fn outside(loaded: &Loaded, curve: &Curve, warnings: &mut Vec<Warning>) -> Option<Verdict> {
    let robot = &loaded.robot;
    let Some(outside) = curve.outside(robot) else {
        let soft_limits = curve.outside_soft(robot);
        warnings.extend(soft_limits.map(|outside| soft(loaded, &outside)));
        return None;
    };
    let variable = &robot.variables()[outside.column];
    if outside.by <= LIMIT_TOLERANCE {
        warnings.push(hardly_outside(&variable.name, &outside));
        return None;
    }
    Some(Verdict::Outside {
        variable: variable.name.clone(),
        limits: [variable.hard_lower, variable.hard_upper],
        outside,
    })
}

fn hardly_outside(name: &str, outside: &Outside) -> Warning {
    Warning::uncovered(format!(
        "{name} leaves its limits by {:.1e} at {:.4} s",
        outside.by, outside.time_s
    ))
}

fn soft(loaded: &Loaded, outside: &Outside) -> Warning {
    let name = &loaded.robot.variables()[outside.column].name;
    Warning::uncovered(format!(
        "{name} leaves its soft limits by {:.2e} at {:.4} s",
        outside.by, outside.time_s
    ))
}

/// The bodies that collide wherever the robot goes.
fn standing(
    loaded: &Loaded,
    model: &CollisionModel,
    curve: &Curve,
    held: &[f64],
) -> Option<Verdict> {
    let mut kinematics = Kinematics::default();
    kinematics.update(&loaded.robot, &curve.at(0, 0.0), held);
    let (bodies, contact) = model.static_contact(&kinematics)?;
    let refusal = Refusal::at_start(curve, bodies, contact.into());
    Some(Verdict::Refused(refusal))
}

fn moving(
    loaded: &Loaded,
    model: &CollisionModel,
    curve: &Curve,
    held: &[f64],
    request: &Request,
    start: Instant,
) -> Verdict {
    let space = loaded.robot.space().unwrapped();
    let mut scratch = Scratch::default();
    let clearance_m = request
        .clearance_m
        .unwrap_or(Settings::DEFAULT_CLEARANCE_M);
    let mut validator = Validator::new(model, &space, held, clearance_m, &mut scratch);
    let deadline = request.deadline;
    let mut stop = || deadline.is_some_and(|deadline| start.elapsed() >= deadline);
    let found = timed::prove(&mut validator, curve, request.strict, &mut stop);
    let is_collision =
        matches!(&found, TimedVerdict::Refused(hit) if hit.reason == HitReason::Collision);
    match (model.uncheckable().filter(|_| !is_collision), found) {
        (Some(why), _) => Verdict::NoGeometry(why),
        (None, TimedVerdict::Proved(proof)) => Verdict::Proved(proof),
        (None, TimedVerdict::Refused(hit)) => Verdict::Refused(Refusal::of(&hit, model)),
        (None, TimedVerdict::Stopped) => Verdict::TimedOut,
    }
}

/// Where each held joint stands.
fn held(loaded: &Loaded, given: &[(String, f64)]) -> Result<Vec<f64>, CliError> {
    let joints = loaded.robot.held();
    let mut held: Vec<f64> = joints
        .iter()
        .map(|joint| joint.default)
        .collect();
    for (name, value) in given {
        let index = joints
            .iter()
            .position(|joint| joint.name == *name);
        held[index.ok_or_else(|| no_held_joint(&loaded.robot, name))?] = *value;
    }
    Ok(held)
}

fn no_held_joint(robot: &RobotModel, name: &str) -> CliError {
    let mut variables = robot.variables().iter();
    let column = match variables.any(|variable| variable.name == name) {
        true => " (it is a column of the path)",
        false => "",
    };
    CliError::Choice(format!(
        "{name:?} is no joint without a column{column}; valid: {}",
        held_names(robot)
    ))
}

fn held_names(robot: &RobotModel) -> String {
    let names: Vec<&str> = robot
        .held()
        .iter()
        .map(|held| held.name.as_str())
        .collect();
    match names.is_empty() {
        true => "none".to_owned(),
        false => names.join(", "),
    }
}

/// What a verdict amounts to, and why.
pub(super) fn code(verdict: &Verdict) -> (Code, Option<&'static str>) {
    match verdict {
        Verdict::Proved(_) => (Code::Success, None),
        Verdict::Outside { .. } => (Code::Uncertified, Some("LIMIT")),
        Verdict::TimedOut => (Code::TimedOut, None),
        Verdict::NoGeometry(_) => (Code::Uncertified, Some("UNCERTIFIED")),
        Verdict::Refused(refusal) => {
            let (code, reason) = code_of_hit(refusal.reason);
            (code, Some(reason))
        }
    }
}

fn code_of_hit(reason: HitReason) -> (Code, &'static str) {
    match reason {
        HitReason::Collision => (Code::InvalidMotionPlan, "COLLISION"),
        HitReason::Outside => (Code::InvalidMotionPlan, "OUTSIDE"),
        HitReason::TooClose => (Code::Uncertified, "TOO_CLOSE"),
        HitReason::Uncertified => (Code::Uncertified, "UNCERTIFIED"),
    }
}

/// Requirements with a lowered floor, by name.
pub(super) fn lowered(loaded: &Loaded, proof: &TimedProof) -> Result<Vec<LoweredFloor>, CliError> {
    if proof.lowered.is_empty() {
        return Ok(Vec::new());
    }
    let model = loaded.model()?;
    let floors = proof.lowered.iter();
    Ok(floors
        .map(|floor| named(&model, *floor))
        .collect())
}

fn named(model: &CollisionModel, (requirement, floor): (Requirement, f64)) -> LoweredFloor {
    LoweredFloor {
        requirement: requirement.named(model, &[]),
        floor,
    }
}
