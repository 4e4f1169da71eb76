//! `taut time`: give a path times near the least that the motors allow, proved as they are written, in this
//! process.

mod arguments;
mod told;
mod verdict;
mod written;

use std::time::Instant;

use taut::constraint;
use taut::robot::RobotModel;
use taut::timing::{self, Outcome, Settings, Timed, TimingError};
use taut::validation::timed::TimedHit;
use taut::validation::{LoweredFloor, Scratch, Validator};

pub(super) use arguments::Arguments;

use super::error::CliError;
use super::format::{Format, print_line};
use super::load::{self, Loaded};
use told::Answer;
use verdict::{Reached, Verdict};

/// Times a path.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    let mut reader = load::reader(&arguments.source);
    let loaded = load::load_holding(
        &mut reader,
        &arguments.path,
        &arguments.source,
        false,
        &arguments.held,
    )?;
    let motors = &arguments.motors;
    let settings = settings(arguments, &loaded)?;
    let model = loaded.model()?;
    if let Some(why) = model.uncheckable() {
        return Err(CliError::Choice(why));
    }
    let start = Instant::now();
    let mut stages = Vec::new();
    let verdict = timed(arguments, &loaded, &model, &settings, start, &mut stages)?;
    let answer = Answer {
        loaded: &loaded,
        verdict: &verdict,
        stages: &stages,
        limits: &settings.limits,
        ignores_scaling: motors.file()?.has_scaling,
        time_s: start.elapsed().as_secs_f64(),
    };
    if let (Some(file), Verdict::Timed(timed, _)) = (&arguments.out, &verdict) {
        written::write(file, &loaded, timed)?;
    }
    answer.warn();
    print_line(&match arguments.format {
        Format::Json => answer.json(),
        Format::Table => answer.line(),
    })?;
    Ok(verdict.code().exit_code())
}

fn settings(arguments: &Arguments, loaded: &Loaded) -> Result<Settings, CliError> {
    let moves = |column| timing::moves(&loaded.path, column);
    let limits = arguments.motors.limits(&loaded.robot, moves)?;
    Ok(Settings {
        strict: arguments.strict,
        seed: arguments.seed,
        ..Settings::new(limits.at_speed(arguments.speed))
    })
}

fn timed(
    arguments: &Arguments,
    loaded: &Loaded,
    model: &taut::collision::CollisionModel,
    settings: &Settings,
    start: Instant,
    stages: &mut Vec<Reached>,
) -> Result<Verdict, CliError> {
    let robot: &RobotModel = &loaded.robot;
    let held = super::check::held(loaded, &arguments.held)?;
    let constraints = constraint::constraints(&loaded.constraints, robot, &loaded.scene);
    let constraints = constraints.map_err(|error| CliError::Choice(error.to_string()))?;
    let space = robot.space().unwrapped();
    let mut scratch = Scratch::default();
    let validator = Validator::new(model, &space, &held, arguments.clearance, &mut scratch);
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
    match outcome {
        Ok(Outcome::Timed(timed)) => {
            let lowered = lowered(&validator, &timed);
            Ok(Verdict::Timed(timed, lowered))
        }
        Ok(Outcome::Stopped) => Ok(Verdict::TimedOut),
        Err(TimingError::Refused(hit)) => {
            Ok(Verdict::Refused(hit.reason, refused(&validator, &hit)))
        }
        Err(error) => Err(CliError::Choice(error.to_string())),
    }
}

fn lowered(validator: &Validator, timed: &Timed) -> Vec<LoweredFloor> {
    let proof = timed.proof.iter();
    let floors = proof.flat_map(|proof| &proof.lowered);
    floors
        .map(|&(requirement, floor)| LoweredFloor {
            requirement: validator.named(requirement),
            floor,
        })
        .collect()
}

fn refused(validator: &Validator, hit: &TimedHit) -> String {
    let requirement = validator.named(hit.requirement);
    let amount = super::report::amount(&requirement, hit.measure.amount);
    format!(
        "{} with a stop at each waypoint, at {:.4} s: {requirement}, {amount}",
        hit.reason.name(),
        hit.time_s
    )
}
