//! What comes of a trajectory.

use std::time::Instant;

use taut::collision::CollisionModel;
use taut::constraint::{self, Constraint, ConstraintError, ConstraintsFile};
use taut::optimize::{LIMIT_TOLERANCE, Settings};
use taut::robot::{Kinematics, RobotModel};
use taut::timing::{Limits, Usage, Use};
use taut::validation::timed::{
    self, Claims, Curve, Outside, Point, TimedHit, TimedProof, TimedVerdict,
};
use taut::validation::{
    Certificate, HitReason, LoweredFloor, Measure, NamedRequirement, Scratch, Validator,
};
use taut::warning::Warning;
use taut_ipc::planner::Request;

use crate::cli::error::CliError;
use crate::cli::load::Loaded;
use taut_ipc::wire::Code;

/// What came of a trajectory.
#[expect(clippy::large_enum_variant, reason = "a command makes one of them")]
pub(super) enum Verdict {
    Proved(Proof),
    Refused(Refusal),
    Outside {
        outside: Outside,
        variable: String,
        limits: [f64; 2],
    },
    /// Faster, or with a greater acceleration, than a limit allows.
    Beyond(Beyond),
    TimedOut,
    NoGeometry(String),
}

/// Where a limit is exceeded.
pub(super) struct Beyond {
    /// Velocity or acceleration.
    pub what: &'static str,
    pub variable: String,
    pub used: Use,
    /// The point before it, from 0.
    pub point: usize,
}

/// What a proof says.
pub(super) struct Proof {
    /// Distance that every pair keeps (m); `None` where nothing is near.
    pub clearance_m: Option<f64>,
    pub lowered: Vec<LoweredFloor>,
    pub intervals: u64,
    pub certificate: Certificate,
}

impl Proof {
    fn of(subject: &Subject, validator: &Validator, proof: &TimedProof) -> Self {
        let certificate = subject.certificate(validator, proof);
        Self {
            clearance_m: Some(proof.clearance_m()).filter(|metres| metres.is_finite()),
            lowered: certificate.lowered.clone(),
            intervals: proof.intervals(),
            certificate,
        }
    }
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
    fn of(validator: &Validator, hit: &TimedHit) -> Self {
        Self {
            reason: hit.reason,
            point: hit.point,
            time_s: hit.time_s,
            requirement: validator.named(hit.requirement),
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

/// A trajectory and what it must keep.
pub(super) struct Subject<'a> {
    robot: &'a RobotModel,
    model: CollisionModel,
    points: &'a [Point],
    curve: &'a Curve,
    held: Vec<f64>,
    asked: ConstraintsFile,
    constraints: Vec<Constraint>,
    limits: Option<Limits>,
    request: &'a Request,
}

impl<'a> Subject<'a> {
    /// # Errors
    /// A robot and a scene that do not go together, a joint that is none, constraints of what is not
    /// there.
    pub(super) fn new(
        loaded: &'a Loaded,
        (points, curve): (&'a [Point], &'a Curve),
        request: &'a Request,
        constraints: ConstraintsFile,
        limits: Option<Limits>,
    ) -> Result<Self, CliError> {
        let robot = &loaded.robot;
        let scene = &loaded.scene;
        let held = held(loaded, &request.held)?;
        let no_choice = |error: ConstraintError| CliError::Choice(error.to_string());
        let asked = constraints
            .started(robot, scene, &curve.at(0, 0.0), &held)
            .map_err(no_choice)?;
        Ok(Self {
            robot,
            model: loaded.model()?,
            points,
            curve,
            held,
            constraints: constraint::constraints(&asked, robot, scene).map_err(no_choice)?,
            asked,
            limits,
            request,
        })
    }

    fn certificate(&self, validator: &Validator, proof: &TimedProof) -> Certificate {
        let limits = self.limits.as_ref();
        let claims = Claims {
            constraints: self.asked.clone(),
            limits: limits.map_or_else(Vec::new, |limits| limits.claims(self.robot)),
        };
        timed::certificate(validator, self.points, proof, claims)
    }
}

/// Judges the curve of a trajectory.
pub(super) fn judge(subject: &Subject, start: Instant) -> Judged {
    let mut warnings = subject.model.uncovered();
    warnings.extend(late_start(subject.curve));
    let verdict = outside(subject.robot, subject.curve, &mut warnings)
        .or_else(|| beyond(subject))
        .or_else(|| standing(subject))
        .unwrap_or_else(|| moving(subject, start));
    Judged {
        verdict,
        pairs: subject.model.checked_pairs(),
        warnings,
    }
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
fn outside(robot: &RobotModel, curve: &Curve, warnings: &mut Vec<Warning>) -> Option<Verdict> {
    let Some(outside) = curve.outside(robot) else {
        let soft_limits = curve.outside_soft(robot);
        warnings.extend(soft_limits.map(|outside| soft(robot, &outside)));
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

/// Where limits of velocity or acceleration are exceeded most, by more than rounding.
fn beyond(subject: &Subject) -> Option<Verdict> {
    const ROUNDING: f64 = 1e-6;
    let columns = subject
        .limits
        .as_ref()?
        .usage_by_column(subject.curve);
    let usage = columns
        .into_iter()
        .fold(Usage::default(), Usage::most);
    let uses = [
        ("velocity", usage.velocity),
        ("acceleration", usage.acceleration),
    ];
    let (what, used) = uses
        .into_iter()
        .find(|(_, used)| used.part > 1.0 + ROUNDING)?;
    let points = 0..subject.curve.segments();
    Some(Verdict::Beyond(Beyond {
        what,
        variable: subject.robot.variables()[used.column]
            .name
            .clone(),
        point: points
            .rev()
            .find(|point| subject.curve.time(*point) <= used.time_s)
            .unwrap_or(0),
        used,
    }))
}

fn hardly_outside(name: &str, outside: &Outside) -> Warning {
    Warning::uncovered(format!(
        "{name} leaves its limits by {:.1e} at {:.4} s",
        outside.by, outside.time_s
    ))
}

fn soft(robot: &RobotModel, outside: &Outside) -> Warning {
    let name = &robot.variables()[outside.column].name;
    Warning::uncovered(format!(
        "{name} leaves its soft limits by {:.2e} at {:.4} s",
        outside.by, outside.time_s
    ))
}

/// The bodies that collide wherever the robot goes.
fn standing(subject: &Subject) -> Option<Verdict> {
    let mut kinematics = Kinematics::default();
    kinematics.update(subject.robot, &subject.curve.at(0, 0.0), &subject.held);
    let (bodies, contact) = subject.model.static_contact(&kinematics)?;
    let refusal = Refusal::at_start(subject.curve, bodies, contact.into());
    Some(Verdict::Refused(refusal))
}

fn moving(subject: &Subject, start: Instant) -> Verdict {
    let Subject { model, request, .. } = subject;
    let space = subject.robot.space().unwrapped();
    let mut scratch = Scratch::default();
    let clearance_m = request
        .clearance_m
        .unwrap_or(Settings::DEFAULT_CLEARANCE_M);
    let validator = Validator::new(model, &space, &subject.held, clearance_m, &mut scratch);
    let mut validator = validator
        .with_constraints(&subject.constraints)
        .closely();
    let deadline = request.deadline;
    let mut stop = || deadline.is_some_and(|deadline| start.elapsed() >= deadline);
    let found = timed::prove(&mut validator, subject.curve, request.strict, &mut stop);
    let is_collision =
        matches!(&found, TimedVerdict::Refused(hit) if hit.reason == HitReason::Collision);
    match (model.uncheckable().filter(|_| !is_collision), found) {
        (Some(why), _) => Verdict::NoGeometry(why),
        (None, TimedVerdict::Proved(proof)) => {
            Verdict::Proved(Proof::of(subject, &validator, &proof))
        }
        (None, TimedVerdict::Refused(hit)) => Verdict::Refused(Refusal::of(&validator, &hit)),
        (None, TimedVerdict::Stopped) => Verdict::TimedOut,
    }
}

/// Where each held joint stands.
pub(in crate::cli) fn held(loaded: &Loaded, given: &[(String, f64)]) -> Result<Vec<f64>, CliError> {
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
        Verdict::Outside { .. } | Verdict::Beyond(_) => (Code::Uncertified, Some("LIMIT")),
        Verdict::TimedOut => (Code::TimedOut, None),
        Verdict::NoGeometry(_) => (Code::Uncertified, Some("UNCERTIFIED")),
        Verdict::Refused(refusal) => {
            let (code, reason) = code_of_hit(refusal.reason);
            (code, Some(reason))
        }
    }
}

pub(in crate::cli) fn code_of_hit(reason: HitReason) -> (Code, &'static str) {
    match reason {
        HitReason::Collision => (Code::InvalidMotionPlan, "COLLISION"),
        HitReason::Outside => (Code::InvalidMotionPlan, "OUTSIDE"),
        HitReason::TooClose => (Code::Uncertified, "TOO_CLOSE"),
        HitReason::Uncertified => (Code::Uncertified, "UNCERTIFIED"),
    }
}
