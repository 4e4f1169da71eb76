//! A robot where its joints are told by name.

use super::{Kinematics, RobotModel};

/// Why named values are no place of a robot.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StandError {
    /// A name that the robot does not have.
    #[error("{name:?} is no variable of the robot; valid: {valid}")]
    Unknown {
        /// The name.
        name: String,
        /// Its variables.
        valid: String,
    },
    /// A value that is none.
    #[error("{name:?} = {value}; it must be finite")]
    NotFinite {
        /// The variable.
        name: String,
        /// Its value.
        value: f64,
    },
    /// Two values of one variable.
    #[error("{0:?} has two values; give one")]
    Twice(String),
    /// Variables without a value.
    #[error("no value of {0}: where the robot is depends on every joint")]
    Missing(String),
}

/// The robot where its variables are at these values (m or rad), each by its name once; a joint that
/// is held may be left out, it is then at its default.
///
/// # Errors
/// A name that is none, twice the same one, a value that is not finite, a variable without one.
pub fn stand(robot: &RobotModel, values: &[(String, f64)]) -> Result<Kinematics, StandError> {
    check(robot, values)?;
    let value = |name: &str| {
        let given = values.iter().find(|(given, _)| given == name);
        given.map(|(_, value)| *value)
    };
    let missing: Vec<&str> = names(robot)
        .filter(|name| value(name).is_none())
        .collect();
    if !missing.is_empty() {
        return Err(StandError::Missing(missing.join(", ")));
    }
    let q: Vec<f64> = names(robot).filter_map(value).collect();
    let held = robot.held().iter();
    let held: Vec<f64> = held
        .map(|held| value(&held.name).unwrap_or(held.default))
        .collect();
    let mut kinematics = Kinematics::default();
    kinematics.update(robot, &q, &held);
    Ok(kinematics)
}

fn check(robot: &RobotModel, values: &[(String, f64)]) -> Result<(), StandError> {
    let held = || {
        robot
            .held()
            .iter()
            .map(|held| held.name.as_str())
    };
    for (index, (name, value)) in values.iter().enumerate() {
        if !names(robot)
            .chain(held())
            .any(|known| known == name)
        {
            return Err(StandError::Unknown {
                name: name.clone(),
                valid: names(robot).collect::<Vec<_>>().join(", "),
            });
        }
        if !value.is_finite() {
            let name = name.clone();
            return Err(StandError::NotFinite {
                name,
                value: *value,
            });
        }
        if values[..index]
            .iter()
            .any(|(before, _)| before == name)
        {
            return Err(StandError::Twice(name.clone()));
        }
    }
    Ok(())
}

fn names(robot: &RobotModel) -> impl Iterator<Item = &str> {
    robot
        .variables()
        .iter()
        .map(|variable| variable.name.as_str())
}
