//! A job's times: a trajectory along the path that came of it.

use super::job::Job;
use crate::collision::CollisionModel;
use crate::constraint;
use crate::optimize::{Outcome, PathHold};
use crate::path::Path;
use crate::robot::configuration::turns_between;
use crate::robot::{ConfigurationSpace, RobotModel};
use crate::timing::{self, Fixed, Timed};
use crate::translate::{TimedPath, Times, Timing};
use crate::validation::timed as proof;
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
            publish(&Times::Timed(Box::new(timed_path(
                timed, &settings, *first_s,
            ))));
        },
    );
    match told {
        Ok(timing::Outcome::Stopped) => Times::NotReached(NOT_REACHED.to_owned()),
        Err(error) => Times::Refused(format!("the path is proved, its times are not: {error}")),
        Ok(timing::Outcome::Timed(timed)) => {
            let first_s = found.unwrap_or(timed.duration_s());
            let nearest = match job.settings.contacts {
                true => nearest(&mut validator, &timed, robot, stop),
                false => None,
            };
            Times::Timed(Box::new(TimedPath {
                lowered: lowered(&timed, &validator),
                nearest,
                work: validator.work(),
                ..timed_path(&timed, &settings, first_s)
            }))
            .that_fits()
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

/// What is known of a trajectory as soon as it is proved.
fn timed_path(timed: &Timed, settings: &timing::Settings, stops_s: f64) -> TimedPath {
    TimedPath {
        timed: timed.clone(),
        limits: settings.limits.clone(),
        lowered: Vec::new(),
        nearest: None,
        stops_s,
        work: 0,
    }
}

fn lowered(timed: &Timed, validator: &Validator) -> Vec<LoweredFloor> {
    let proof = timed.proof.iter();
    let floors = proof.flat_map(|proof| &proof.lowered);
    floors
        .map(|&(requirement, floor)| LoweredFloor {
            requirement: validator.named(requirement),
            floor,
        })
        .collect()
}

/// Where a trajectory comes nearest to anything, if that is found.
fn nearest(
    validator: &mut Validator,
    timed: &Timed,
    robot: &RobotModel,
    stop: &mut dyn FnMut() -> bool,
) -> Option<PathHold> {
    let curve = timed.curve(robot).ok()?;
    let near = proof::nearest(validator, &curve, stop)?.smallest?;
    Some(PathHold {
        segment: near.segment,
        t: near.t,
        requirement: validator.named(near.requirement),
        amount: near.measure.amount,
        points: near.measure.points,
        normal: near.measure.normal,
    })
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
