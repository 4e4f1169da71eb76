//! What is checked of the steps of a request's path: that each says how it moves, and that none
//! goes so far that no proof of it ends.

use super::input::RequestError;
use crate::path::Path;
use crate::robot::configuration::{FARTHEST_ANGLE_RAD, LONGEST_STEP_RAD, turns_between};
use crate::robot::{Component, ConfigurationSpace, RobotModel, Variable};

/// How far a variable that is no angle may move in one path, all steps added up (rad or m): a
/// proof's memory and time grow with it. A path of as many waypoints as there may be, each half a
/// turn from the one before, keeps to it.
pub(super) const FARTHEST_MOTION: f64 = 1e6;

/// Checks that every angle and every rotation says how it moves.
pub(super) fn check_turns(
    robot: &RobotModel,
    space: &ConfigurationSpace,
    path: &Path,
) -> Result<(), RequestError> {
    let name = |column: usize| robot.variables()[column].name.clone();
    for (waypoint, row) in path.waypoints().enumerate() {
        if let Some(q) = space.circles().find(|&q| row[q].abs() > FARTHEST_ANGLE_RAD) {
            return Err(RequestError::FarAngle {
                waypoint,
                variable: name(q),
                value: row[q],
            });
        }
    }
    if !space
        .components()
        .iter()
        .any(|component| matches!(component, Component::Rotation { .. }))
    {
        return Ok(());
    }
    match path
        .segments()
        .enumerate()
        .find_map(|(segment, [from, to])| Some((segment, space.half_turn(from, to)?)))
    {
        Some((segment, q)) => Err(RequestError::HalfTurn {
            waypoint: segment + 1,
            variable: name(q),
        }),
        None => Ok(()),
    }
}

/// Checks that no line goes so far that nothing proves it.
pub(super) fn check_motion(
    robot: &RobotModel,
    space: &ConfigurationSpace,
    path: &Path,
) -> Result<(), RequestError> {
    for component in space.components() {
        let q = match *component {
            Component::Line { q, .. } => q,
            // A step is at most half a turn.
            Component::Circle { .. } | Component::Rotation { .. } => continue,
        };
        // Between its limits it cannot.
        let Variable {
            hard_lower,
            hard_upper,
            ..
        } = robot.variables()[q];
        if (hard_upper - hard_lower + 1.0) * (path.len() as f64) < FARTHEST_MOTION {
            continue;
        }
        let mut moved = 0.0;
        for (segment, [from, to]) in path.segments().enumerate() {
            moved += (to[q] - from[q]).abs();
            if moved > FARTHEST_MOTION {
                let variable = robot.variables()[q].name.clone();
                return Err(RequestError::FarMotion {
                    waypoint: segment + 1,
                    variable,
                    moved,
                });
            }
        }
    }
    Ok(())
}

/// Checks that unrolling left the goal's numbers as they are.
pub(super) fn keeps_goal(
    robot: &RobotModel,
    space: &ConfigurationSpace,
    path: &Path,
    unrolled: &Path,
) -> Result<(), RequestError> {
    let goal = path.len() - 1;
    let moved =
        |q: &usize| turns_between(path.waypoint(goal)[*q], unrolled.waypoint(goal)[*q]) != 0;
    let Some(q) = space.circles().find(moved) else {
        return Ok(());
    };
    let is_long = |[from, to]: [&[f64]; 2]| (to[q] - from[q]).abs() > LONGEST_STEP_RAD;
    let segment = path
        .segments()
        .position(is_long)
        .expect("a number moves only after a long step");
    Err(RequestError::KeepGoal {
        waypoint: segment + 1,
        variable: robot.variables()[q].name.clone(),
        before: path.waypoint(segment)[q],
        value: path.waypoint(segment + 1)[q],
        turns: turns_between(path.waypoint(goal)[q], unrolled.waypoint(goal)[q]),
    })
}
