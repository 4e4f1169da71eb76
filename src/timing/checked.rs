//! What is checked of a request before anything is computed.

use super::error::TimingError;
use super::limits::ColumnLimits;
use super::settings::{Fixed, Settings};
use crate::path::Path;
use crate::robot::{Component, Kinematics, RobotModel};
use crate::validation::Validator;
use crate::validation::timed::CurveError;

/// Checks that a request is of this robot and path, and that whatever moves has limits.
pub fn check(robot: &RobotModel, path: &Path, settings: &Settings) -> Result<(), TimingError> {
    settings.controller.usable()?;
    check_fixed(&settings.fixed_waypoints, path.len() - 1)?;
    let limits = settings.limits.columns();
    check_count(robot, "limits", limits.len())?;
    let at_rest = vec![0.0; limits.len()];
    let start = settings
        .start_velocity
        .as_ref()
        .unwrap_or(&at_rest);
    check_count(robot, "start velocities", start.len())?;
    check_turns(robot, start)?;
    for (column, own) in limits.iter().enumerate() {
        let name = &robot.variables()[column].name;
        if start[column] != 0.0 || moves(path, column) {
            check_usable(name, own)?;
        }
        check_start(name, own, start[column])?;
    }
    Ok(())
}

/// Checks that nothing collides that no joint moves: a proof of what moves does not see it.
pub fn check_standing(validator: &Validator, path: &Path) -> Result<(), TimingError> {
    let model = validator.model();
    let mut kinematics = Kinematics::default();
    kinematics.update(model.robot(), path.waypoint(0), validator.held());
    match model.static_contact(&kinematics) {
        Some((bodies, _)) => Err(TimingError::Standing(bodies)),
        None => Ok(()),
    }
}

fn check_fixed(fixed: &Fixed, last: usize) -> Result<(), TimingError> {
    let Fixed::These(list) = fixed else {
        return Ok(());
    };
    match list.iter().find(|waypoint| **waypoint > last) {
        Some(&waypoint) => Err(TimingError::Fixed { waypoint, last }),
        None => Ok(()),
    }
}

fn check_count(robot: &RobotModel, what: &'static str, got: usize) -> Result<(), TimingError> {
    let expected = robot.space().nq();
    match got == expected {
        true => Ok(()),
        false => Err(TimingError::Count {
            what,
            got,
            expected,
        }),
    }
}

/// No quaternion begins to turn.
fn check_turns(robot: &RobotModel, start: &[f64]) -> Result<(), TimingError> {
    let components = robot.space().components().iter();
    let mut turning = components.filter_map(|component| match *component {
        Component::Rotation { q, .. } if start[q..q + 4] != [0.0; 4] => Some(q),
        _ => None,
    });
    turning.next().map_or(Ok(()), |q| {
        let variable = robot.variables()[q].name.clone();
        Err(CurveError::Rotation { point: 0, variable }.into())
    })
}

fn check_usable(name: &str, own: &ColumnLimits) -> Result<(), TimingError> {
    let all = [
        ("velocity", own.velocity),
        ("acceleration", own.acceleration),
    ];
    let unusable = all
        .into_iter()
        .find(|(_, range)| !range.is_usable());
    unusable.map_or(Ok(()), |(what, range)| {
        Err(TimingError::Limit {
            column: name.to_owned(),
            what,
            least: range.least,
            most: range.most,
        })
    })
}

fn check_start(name: &str, own: &ColumnLimits, value: f64) -> Result<(), TimingError> {
    // No number is within limits, and no part of them.
    match own.velocity.part(value) <= 1.0 {
        true => Ok(()),
        false => Err(TimingError::StartVelocity {
            column: name.to_owned(),
            value,
            least: own.velocity.least,
            most: own.velocity.most,
        }),
    }
}

/// Whether a path moves a column.
pub fn moves(path: &Path, column: usize) -> bool {
    let first = path.waypoint(0)[column];
    (1..path.len()).any(|waypoint| path.waypoint(waypoint)[column] != first)
}
