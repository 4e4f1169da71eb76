//! `taut time`: give a path times near the least that the motors allow, proved as they are written, in this
//! process.

mod arguments;
mod told;
mod verdict;
mod written;

use std::time::Instant;

use taut::collision::CollisionModel;
use taut::constraint::{self, ConstraintError, ConstraintsFile};
use taut::robot::RobotModel;
use taut::timing::{self, Outcome, Settings, Timed, TimingError};
use taut::validation::timed::{self as proof, Claims};
use taut::validation::{HitReason, Scratch, Validator};

pub(super) use arguments::Arguments;

use super::error::CliError;
use super::export::save;
use super::format::{Format, print_line};
use super::load::{self, Loaded};
use super::report;
use told::Answer;
use verdict::{Nearest, Reached, Shown, Verdict};

/// Times a path.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    let mut reader = load::reader(&arguments.source);
    let mut loaded = load::load_holding(
        &mut reader,
        &arguments.path,
        &arguments.source,
        false,
        &arguments.held,
    )?;
    let held = super::check::held(&loaded, &arguments.held)?;
    loaded.constraints = started(&loaded, &held)?;
    let motors = &arguments.motors;
    let settings = settings(arguments, &loaded)?;
    let model = loaded.model()?;
    if let Some(why) = model.uncheckable() {
        return Err(CliError::Choice(why));
    }
    let start = Instant::now();
    let mut stages = Vec::new();
    let (verdict, time_s) = timed(
        arguments,
        &loaded,
        (&model, &held),
        &settings,
        start,
        &mut stages,
    )?;
    let answer = Answer {
        loaded: &loaded,
        verdict: &verdict,
        stages: &stages,
        limits: &settings.limits,
        ignores_scaling: motors.file()?.has_scaling,
        time_s,
    };
    if let (Some(file), Verdict::Timed(shown)) = (&arguments.out, &verdict) {
        written::write(file, &loaded, &shown.timed)?;
    }
    if let (Some(file), Verdict::Timed(shown)) = (&arguments.write_certificate, &verdict)
        && let Some(certificate) = &shown.certificate
    {
        save(file, report::certificate(certificate).as_bytes())?;
    }
    answer.warn();
    print_line(&match arguments.format {
        Format::Json => answer.json(),
        Format::Table => answer.line(),
    })?;
    Ok(verdict.code().exit_code())
}

/// What the path must keep, with directions as they are where it starts.
fn started(loaded: &Loaded, held: &[f64]) -> Result<ConstraintsFile, CliError> {
    let asked = loaded.constraints.clone();
    asked
        .started(&loaded.robot, &loaded.scene, loaded.path.waypoint(0), held)
        .map_err(no_choice)
}

fn no_choice(error: ConstraintError) -> CliError {
    CliError::Choice(error.to_string())
}

fn settings(arguments: &Arguments, loaded: &Loaded) -> Result<Settings, CliError> {
    let start_velocity = start_velocity(arguments, loaded)?;
    let starts = |column: usize| {
        let given = start_velocity.as_ref();
        given.is_some_and(|velocities| velocities[column] != 0.0)
    };
    let moves = |column| timing::moves(&loaded.path, column) || starts(column);
    let limits = arguments.motors.limits(&loaded.robot, moves)?;
    Ok(Settings {
        strict: arguments.strict,
        seed: arguments.seed,
        fixed_waypoints: arguments.fix.clone().unwrap_or_default(),
        controller: arguments.controller,
        start_velocity,
        ..Settings::new(limits.at_speed(arguments.speed))
    })
}

/// Of each column, where one is given.
fn start_velocity(arguments: &Arguments, loaded: &Loaded) -> Result<Option<Vec<f64>>, CliError> {
    if arguments.start_velocity.is_empty() {
        return Ok(None);
    }
    let variables = loaded.robot.variables();
    let mut velocities = vec![0.0; variables.len()];
    for (name, value) in &arguments.start_velocity {
        let column = variables
            .iter()
            .position(|variable| variable.name == *name);
        velocities[column.ok_or_else(|| no_column(loaded, name))?] = *value;
    }
    Ok(Some(velocities))
}

fn no_column(loaded: &Loaded, name: &str) -> CliError {
    let names = written::names(loaded).join(", ");
    CliError::Choice(format!(
        "--start-velocity: {name:?} is no column of the robot; valid: {names}"
    ))
}

/// What comes of a path, and how long that took (s).
fn timed(
    arguments: &Arguments,
    loaded: &Loaded,
    (model, held): (&CollisionModel, &[f64]),
    settings: &Settings,
    start: Instant,
    stages: &mut Vec<Reached>,
) -> Result<(Verdict, f64), CliError> {
    let robot: &RobotModel = &loaded.robot;
    let constraints = constraint::constraints(&loaded.constraints, robot, &loaded.scene);
    let constraints = constraints.map_err(no_choice)?;
    let space = robot.space().unwrapped();
    let mut scratch = Scratch::default();
    let validator = Validator::new(model, &space, held, arguments.clearance, &mut scratch);
    let mut validator = validator
        .with_constraints(&constraints)
        .closely();
    let deadline = arguments.deadline;
    let mut stop = || deadline.is_some_and(|deadline| start.elapsed() >= deadline);
    let mut publish = |timed: &Timed| {
        stages.push(Reached {
            timed: timed.clone(),
            after_s: start.elapsed().as_secs_f64(),
        });
    };
    let outcome = timing::run(
        robot,
        &mut validator,
        &loaded.path,
        settings,
        &mut stop,
        &mut publish,
    );
    let time_s = start.elapsed().as_secs_f64();
    let verdict = match outcome {
        Ok(Outcome::Timed(timed)) => Verdict::Timed(Shown {
            certificate: timed.certificate(&validator, claims(loaded, settings)),
            nearest: nearest(&mut validator, robot, &timed, &mut stop),
            timed,
        }),
        Ok(Outcome::Stopped) => Verdict::TimedOut,
        Err(error) => refused(&validator, error)?,
    };
    Ok((verdict, time_s))
}

/// Where a trajectory that is proved comes nearest to anything, if that is found.
fn nearest(
    validator: &mut Validator,
    robot: &RobotModel,
    timed: &Timed,
    stop: &mut dyn FnMut() -> bool,
) -> Option<Nearest> {
    let curve = timed.curve(robot).ok()?;
    let near = proof::nearest(validator, &curve, stop)?.smallest?;
    Some(Nearest {
        requirement: validator.named(near.requirement),
        amount: near.measure.amount,
        time_s: curve.time_of(near.segment, near.t),
    })
}

/// What is claimed of a trajectory besides its proof.
fn claims(loaded: &Loaded, settings: &Settings) -> Claims {
    Claims {
        constraints: loaded.constraints.clone(),
        limits: settings.limits.claims(&loaded.robot),
    }
}

/// A path that is not proved, or has no way from the velocity that it starts with.
fn refused(validator: &Validator, error: TimingError) -> Result<Verdict, CliError> {
    let found = error.hit().map(|hit| {
        let requirement = validator.named(hit.requirement);
        let amount = report::amount(&requirement, hit.measure.amount);
        let name = hit.reason.name();
        let text = match &error {
            TimingError::Refused(_) => format!("{name} with a stop at each waypoint, at"),
            other => format!("{other}: {name} at"),
        };
        (
            hit.reason,
            format!("{text} {:.4} s: {requirement}, {amount}", hit.time_s),
        )
    });
    match (found, error) {
        (Some((reason, text)), _) => Ok(Verdict::Refused(reason, text)),
        (None, TimingError::NoStart(refused)) => Ok(Verdict::Refused(
            HitReason::Uncertified,
            refused.to_string(),
        )),
        (None, standing @ TimingError::Standing(_)) => {
            Ok(Verdict::Refused(HitReason::Collision, standing.to_string()))
        }
        (None, error) => Err(CliError::Choice(error.to_string())),
    }
}
