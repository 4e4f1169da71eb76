//! What is checked of the steps of a request's path: that each says how it moves, and that none
//! goes so far that no proof of it ends.

use super::request_error::{FARTHEST_MOTION, RequestError};
use crate::path::Path;
use crate::robot::configuration::{FARTHEST_ANGLE_RAD, LONGEST_STEP_RAD, turns_between};
use crate::robot::{Component, ConfigurationSpace, RobotModel, Variable};

/// Checks that every angle and every rotation says how it moves.
pub(super) fn check_turns(
    robot: &RobotModel,
    space: &ConfigurationSpace,
    path: &Path,
) -> Result<(), RequestError> {
    check_angles(robot, space, path)?;
    let mut components = space.components().iter();
    match components.any(|component| matches!(component, Component::Rotation { .. })) {
        true => check_rotations(robot, space, path),
        false => Ok(()),
    }
}

/// Checks that no angle is so far out that its turns are lost.
fn check_angles(
    robot: &RobotModel,
    space: &ConfigurationSpace,
    path: &Path,
) -> Result<(), RequestError> {
    for (waypoint, row) in path.waypoints().enumerate() {
        if let Some(q) = space
            .circles()
            .find(|&q| row[q].abs() > FARTHEST_ANGLE_RAD)
        {
            let variable = robot.variables()[q].name.clone();
            return Err(RequestError::FarAngle {
                waypoint,
                variable,
                value: row[q],
            });
        }
    }
    Ok(())
}

/// Checks that no rotation turns by half a turn, to which two ways lead.
fn check_rotations(
    robot: &RobotModel,
    space: &ConfigurationSpace,
    path: &Path,
) -> Result<(), RequestError> {
    let mut segments = path.segments().enumerate();
    let half_turn =
        segments.find_map(|(segment, [from, to])| Some((segment, space.half_turn(from, to)?)));
    match half_turn {
        Some((segment, q)) => Err(RequestError::HalfTurn {
            waypoint: segment + 1,
            variable: robot.variables()[q].name.clone(),
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
    let lines = space
        .components()
        .iter()
        .filter_map(|component| match *component {
            Component::Line { q, .. } => Some(q),
            // A step is at most half a turn.
            Component::Circle { .. } | Component::Rotation { .. } => None,
        });
    for q in lines {
        let variable = &robot.variables()[q];
        if !is_confined(variable, path.len()) {
            check_line(variable, path, q)?;
        }
    }
    Ok(())
}

/// Whether a variable cannot move too far between its limits in so many steps.
fn is_confined(variable: &Variable, steps: usize) -> bool {
    (variable.hard_upper - variable.hard_lower + 1.0) * (steps as f64) < FARTHEST_MOTION
}

fn check_line(variable: &Variable, path: &Path, q: usize) -> Result<(), RequestError> {
    let mut moved = 0.0;
    for (segment, [from, to]) in path.segments().enumerate() {
        moved += (to[q] - from[q]).abs();
        if moved > FARTHEST_MOTION {
            let waypoint = segment + 1;
            let variable = variable.name.clone();
            return Err(RequestError::FarMotion {
                waypoint,
                variable,
                moved,
            });
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
    let goal = path.waypoint(path.len() - 1);
    let end = unrolled.waypoint(path.len() - 1);
    match space
        .circles()
        .find(|&q| turns_between(goal[q], end[q]) != 0)
    {
        Some(q) => Err(moved_goal(
            &robot.variables()[q],
            path,
            q,
            turns_between(goal[q], end[q]),
        )),
        None => Ok(()),
    }
}

/// What is said of a goal whose number would move by whole turns.
fn moved_goal(variable: &Variable, path: &Path, q: usize, turns: i64) -> RequestError {
    let is_long = |[from, to]: [&[f64]; 2]| (to[q] - from[q]).abs() > LONGEST_STEP_RAD;
    let long = path.segments().position(is_long);
    let segment = long.expect("a number moves only after a long step");
    RequestError::KeepGoal {
        waypoint: segment + 1,
        variable: variable.name.clone(),
        before: path.waypoint(segment)[q],
        value: path.waypoint(segment + 1)[q],
        turns,
    }
}
