//! A job's times: a trajectory along the path that came of it.

use super::Job;
use crate::collision::CollisionModel;
use crate::constraint;
use crate::optimize::Outcome;
use crate::path::Path;
use crate::robot::configuration::turns_between;
use crate::robot::{ConfigurationSpace, RobotModel};
use crate::timing::{self, Fixed, Timed};
use crate::translate::{TimedPath, Times, Timing};
use crate::validation::{LoweredFloor, Scratch, Validator};
use std::f64::consts::TAU;

/// What a deadline that comes too early leaves untold.
const NOT_REACHED: &str = "the path is proved and has no times yet: the request ended before a trajectory was proved; give it more time";

/// The times of a path that is the outcome of a job; `publish` gets each trajectory that is faster than
/// all before it.
pub(super) fn times(
    job: Job,
    timing: &Timing,
    model: &CollisionModel,
    outcome: &Outcome,
    stop: &mut dyn FnMut() -> bool,
    publish: &mut dyn FnMut(&Times),
) -> Times {
    if !outcome.proved {
        return Times::NoPath;
    }
    let robot = model.robot();
    let held = held(job, robot);
    let constraints =
        constraint::constraints(&job.settings.constraints, robot, &job.snapshot.scene);
    let constraints = match constraints {
        Ok(constraints) => constraints,
        Err(error) => return Times::Refused(error.to_string()),
    };
    let space = robot.space().unwrapped();
    let mut scratch = Scratch::default();
    let mut validator = Validator::new(model, &space, &held, timing.clearance_m, &mut scratch)
        .with_layers(job.settings.layers)
        .with_constraints(&constraints)
        .closely();
    let settings = timing::Settings {
        fixed_waypoints: fixed(robot.space(), job, &outcome.path),
        ..timing.settings.clone()
    };
    let mut found = None;
    let told = timing::run(
        robot,
        &mut validator,
        &outcome.path,
        &settings,
        stop,
        &mut |timed| {
            let first_s = found.get_or_insert(timed.duration_s());
            publish(&named(timed, &settings, *first_s));
        },
    );
    match told {
        Ok(timing::Outcome::Stopped) => Times::NotReached(NOT_REACHED.to_owned()),
        Err(error) => Times::Refused(format!("the path is proved, its times are not: {error}")),
        Ok(timing::Outcome::Timed(timed)) => {
            let first_s = found.unwrap_or(timed.duration_s());
            with_names(named(&timed, &settings, first_s), &validator).that_fits()
        }
    }
}

/// Where the joints stand that are no columns.
fn held(job: Job, robot: &RobotModel) -> Vec<f64> {
    let defaults = || {
        let held = robot.held().iter();
        held.map(|variable| variable.default).collect()
    };
    job.settings
        .held
        .clone()
        .unwrap_or_else(defaults)
}

fn named(timed: &Timed, settings: &timing::Settings, stops_s: f64) -> Times {
    Times::Timed(Box::new(TimedPath {
        timed: timed.clone(),
        limits: settings.limits.clone(),
        lowered: Vec::new(),
        nearest: None,
        stops_s,
        work: 0,
    }))
}

/// With what only the last of them tells.
fn with_names(times: Times, validator: &Validator) -> Times {
    let Times::Timed(mut path) = times else {
        return times;
    };
    let proof = path.timed.proof.iter();
    let floors = proof.flat_map(|proof| &proof.lowered);
    path.lowered = floors
        .map(|&(requirement, floor)| LoweredFloor {
            requirement: validator.named(requirement),
            floor,
        })
        .collect();
    path.work = validator.work();
    Times::Timed(path)
}

/// The waypoints of a path that the request wants passed: its fixed ones, in their order. Angles may be
/// whole turns away.
fn fixed(space: &ConfigurationSpace, job: Job, path: &Path) -> Fixed {
    let Some(mask) = &job.settings.fixed_waypoints else {
        return Fixed::Ends;
    };
    let given = (0..job.path.len()).filter(|waypoint| mask[*waypoint]);
    let mut next = 0;
    let rows = given.filter_map(|waypoint| {
        let row = job.path.waypoint(waypoint);
        let found = (next..path.len()).find(|at| is_same(space, row, path.waypoint(*at)))?;
        next = found;
        Some(found)
    });
    Fixed::These(rows.collect())
}

fn is_same(space: &ConfigurationSpace, given: &[f64], row: &[f64]) -> bool {
    let circles: Vec<usize> = space.circles().collect();
    let same = |column: usize| match circles.contains(&column) {
        true => {
            let turns = turns_between(given[column], row[column]) as f64;
            row[column] == given[column] + turns * TAU
        }
        false => row[column] == given[column],
    };
    (0..given.len()).all(same)
}
