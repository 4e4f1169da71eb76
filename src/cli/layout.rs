//! Names and order of a robot's joints, whether it was read here or by the daemon.

use std::ops::Range;

use taut::robot::{Component, RobotModel};
use taut_ipc::control::RobotDescription;

use super::error::CliError;

/// A velocity coordinate.
pub(super) struct Coordinate {
    /// The variable it belongs to; for the three of a rotation, each of the quaternion's first
    /// three.
    pub variable: String,
    is_angle: bool,
    is_rotation: bool,
}

impl Coordinate {
    /// What it is in results: `line`, `circle`, or one of the three of a `rotation` vector.
    pub(super) fn kind(&self, unwrapped: bool) -> &'static str {
        match self {
            Self {
                is_rotation: true, ..
            } => "rotation",
            Self { is_angle: true, .. } if !unwrapped => "circle",
            _ => "line",
        }
    }
}

/// The velocity coordinates of a robot.
pub(super) fn coordinates_of_model(robot: &RobotModel) -> Vec<Coordinate> {
    let name = |q: usize| robot.variables()[q].name.clone();
    let own = |component: &Component| match *component {
        Component::Line { q, .. } => vec![Coordinate {
            variable: name(q),
            is_angle: false,
            is_rotation: false,
        }],
        Component::Circle { q, .. } => vec![Coordinate {
            variable: name(q),
            is_angle: true,
            is_rotation: false,
        }],
        Component::Rotation { q, .. } => (q..q + 3)
            .map(|q| Coordinate {
                variable: name(q),
                is_angle: false,
                is_rotation: true,
            })
            .collect(),
    };
    robot.space().components().iter().flat_map(own).collect()
}

/// The same of a robot as the daemon describes it.
pub(super) fn coordinates_of_description(robot: &RobotDescription) -> Vec<Coordinate> {
    let mut coordinates: Vec<Coordinate> = Vec::new();
    for variable in &robot.variables {
        // The fourth variable of a quaternion has none of its own.
        if coordinates.len() < (variable.coordinate + variable.coordinates) as usize {
            let is_angle = variable.continuous;
            let is_rotation = variable.coordinates == 3;
            coordinates.push(Coordinate {
                variable: variable.name.clone(),
                is_angle,
                is_rotation,
            });
        }
    }
    coordinates
}

/// What the names of a request stand for.
pub(super) struct Layout {
    /// Columns of a path, each with its velocity coordinates; the four of a quaternion share three.
    columns: Vec<(String, Range<usize>)>,
    /// Variables of the joints that are no columns, and where these stand by default.
    pub held: Vec<(String, f64)>,
    /// Groups, each with the velocity coordinates that it moves.
    groups: Vec<(String, Vec<bool>)>,
    /// Default weights, one per velocity coordinate.
    pub weights: Vec<f64>,
}

impl Layout {
    /// That of a robot with these default weights.
    pub(super) fn of_model(robot: &RobotModel, weights: Vec<f64>) -> Self {
        let mut columns: Vec<_> = robot
            .variables()
            .iter()
            .map(|variable| (variable.name.clone(), Range::default()))
            .collect();
        for component in robot.space().components() {
            match *component {
                Component::Line { q, v } | Component::Circle { q, v } => columns[q].1 = v..v + 1,
                Component::Rotation { q, v } => columns[q..q + 4]
                    .iter_mut()
                    .for_each(|column| column.1 = v..v + 3),
            }
        }
        let held = robot
            .held()
            .iter()
            .map(|variable| (variable.name.clone(), variable.default))
            .collect();
        Self {
            columns,
            held,
            groups: robot.groups().to_vec(),
            weights,
        }
    }

    /// That of a robot as the daemon describes it.
    pub(super) fn of_description(robot: &RobotDescription) -> Self {
        let column = |variable: &taut_ipc::control::VariableDescription| {
            let first = variable.coordinate as usize;
            (
                variable.name.clone(),
                first..first + variable.coordinates as usize,
            )
        };
        let columns: Vec<_> = robot.variables.iter().map(column).collect();
        let group = |group: &taut_ipc::control::GroupDescription| {
            let mut moving = vec![false; robot.nv as usize];
            for &variable in &group.variables {
                moving[columns[variable as usize].1.clone()].fill(true);
            }
            (group.name.clone(), moving)
        };
        let groups = robot.groups.iter().map(group).collect();
        let held = robot
            .held_variables
            .iter()
            .cloned()
            .zip(robot.held_values.iter().copied())
            .collect();
        Self {
            columns,
            held,
            groups,
            weights: robot.weights.clone(),
        }
    }

    /// The velocity coordinates that a group moves.
    ///
    /// # Errors
    /// An unknown name, with the valid ones.
    pub(super) fn group(&self, name: &str) -> Result<&[bool], CliError> {
        let known = self.groups.iter().map(|(name, _)| name.as_str());
        let group = self.groups.iter().find(|(group, _)| group == name);
        group
            .map(|(_, moving)| moving.as_slice())
            .ok_or_else(|| unknown("--group", "group", name, known))
    }

    /// The velocity coordinates of a joint, or of one of its variables.
    ///
    /// # Errors
    /// An unknown name, with the valid ones.
    pub(super) fn coordinates_of(&self, name: &str) -> Result<Vec<usize>, CliError> {
        let is_meant = |column: &str| {
            column
                .strip_prefix(name)
                .is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
        };
        let meant = self.columns.iter().filter(|(column, _)| is_meant(column));
        let coordinates: Vec<usize> = meant
            .flat_map(|(_, coordinates)| coordinates.clone())
            .collect();
        if coordinates.is_empty() {
            let known = self.columns.iter().map(|(column, _)| column.as_str());
            return Err(unknown("--joint-weight", "joint", name, known));
        }
        Ok(coordinates)
    }

    /// Number of a variable that is no column.
    ///
    /// # Errors
    /// An unknown name, with the valid ones.
    pub(super) fn held_index(&self, name: &str) -> Result<usize, CliError> {
        let known = || self.held.iter().map(|(name, _)| name.as_str());
        known().position(|held| held == name).ok_or_else(|| {
            let is_column = self.columns.iter().any(|(column, _)| column == name);
            let kind = if is_column {
                "held joint (it is a column of the path)"
            } else {
                "held joint"
            };
            unknown("--hold", kind, name, known())
        })
    }

    /// A mask of velocity coordinates as one of columns.
    pub(super) fn columns_of(&self, coordinates: &[bool]) -> Vec<u8> {
        self.columns
            .iter()
            .map(|(_, own)| u8::from(coordinates[own.start]))
            .collect()
    }
}

fn unknown<'a>(
    option: &str,
    kind: &str,
    name: &str,
    known: impl Iterator<Item = &'a str>,
) -> CliError {
    let known: Vec<&str> = known.collect();
    let known = if known.is_empty() {
        "none".to_owned()
    } else {
        known.join(", ")
    };
    CliError::Choice(format!(
        "{option}: {name:?} is no {kind} of the robot; valid: {known}"
    ))
}
