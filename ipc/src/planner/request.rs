//! What a request says by name, in the order of a robot's variables.

use super::options::Request;
use super::{Columns, PlannerError};
use crate::control::{RobotDescription, VariableDescription};
use crate::limits::{MAX_PATH_NUMBERS, MAX_TEXT, MAX_VARIABLES, MAX_WAYPOINTS};
use crate::wire::{Code, NO_GROUP, RequestBody, RequestHeader, label_id};
use std::ops::Range;

impl Request {
    /// Which of the robot's variables the path's columns are.
    ///
    /// # Errors
    /// A name that is none.
    pub fn columns_of(&self, robot: &RobotDescription) -> Result<Columns, PlannerError> {
        Columns::new(&robot.variables, &self.columns, &self.held)
    }

    /// Waypoints of a path of so many numbers.
    ///
    /// # Errors
    /// Numbers that make no rows, none, or too many.
    pub(super) fn waypoints(&self, columns: &Columns, numbers: usize) -> Result<u32, PlannerError> {
        let width = columns.width();
        let robot_width = columns.robot_width();
        if numbers == 0 || !numbers.is_multiple_of(width) {
            let message = format!(
                "the path has {numbers} numbers, no whole rows of {width}; give a row per waypoint"
            );
            return Err(PlannerError::invalid(Code::InvalidRobotState, message));
        }
        let rows = numbers / width;
        if rows > MAX_WAYPOINTS
            || robot_width > MAX_VARIABLES
            || rows * robot_width > MAX_PATH_NUMBERS
        {
            let message = format!(
                "a path of {rows} waypoints x {robot_width} variables; at most {MAX_WAYPOINTS} waypoints and {MAX_PATH_NUMBERS} numbers: split it or drop waypoints"
            );
            return Err(PlannerError::invalid(Code::ResourceExhausted, message));
        }
        Ok(rows as u32)
    }

    /// Header of the request.
    pub(super) fn header(
        &self,
        robot: &RobotDescription,
        scene: &str,
    ) -> Result<RequestHeader, PlannerError> {
        let mut header = RequestHeader {
            robot_id: robot.robot_id,
            robot_hash: self.robot_hash,
            layout_hash: robot.layout_hash,
            scene_id: label_id(scene),
            scene_hash: self.scene_hash,
            group: NO_GROUP,
            ..RequestHeader::default()
        };
        self.enter(&mut header)?;
        Ok(header)
    }

    /// Optional sections of the request.
    pub(super) fn sections(
        &self,
        robot: &RobotDescription,
        columns: &Columns,
        waypoints: u32,
    ) -> Result<Sections, PlannerError> {
        Ok(Sections {
            weights: self.weights(robot)?,
            fixed: self.fixed(waypoints as usize)?,
            moving: self.moving(robot, columns)?,
            held: self.held_values(robot)?,
            constraints: text("constraints", &self.constraints)?,
            timing: text("timing", &self.timing)?,
        })
    }

    /// Weights of the metric; empty for the robot's own.
    ///
    /// # Errors
    /// A joint that the robot does not have.
    pub fn weights(&self, robot: &RobotDescription) -> Result<Vec<f64>, PlannerError> {
        if self.joint_weights.is_empty() {
            return Ok(self.metric.clone());
        }
        let mut weights = match self.metric.as_slice() {
            [] => robot.weights.clone(),
            given => given.to_vec(),
        };
        for (name, weight) in &self.joint_weights {
            for coordinates in coordinates_of(robot, name)? {
                if let Some(own) = weights.get_mut(coordinates) {
                    own.fill(*weight);
                }
            }
        }
        Ok(weights)
    }

    fn fixed(&self, waypoints: usize) -> Result<Vec<u8>, PlannerError> {
        if self.fixed_waypoints.is_empty() {
            return Ok(Vec::new());
        }
        let mut fixed = vec![0; waypoints];
        for &waypoint in &self.fixed_waypoints {
            let Some(stays) = fixed.get_mut(waypoint) else {
                let message = format!(
                    "the request names waypoint {waypoint} to stay; the path has waypoints 0 to {}",
                    waypoints - 1
                );
                return Err(PlannerError::invalid(Code::MalformedRequest, message));
            };
            *stays = 1;
        }
        Ok(fixed)
    }

    /// A byte per variable that may move; none where all may.
    fn moving(&self, robot: &RobotDescription, columns: &Columns) -> Result<Vec<u8>, PlannerError> {
        let mut moving = columns.given();
        if let Some(name) = &self.group {
            let Some(group) = robot
                .groups
                .iter()
                .find(|group| group.name == *name)
            else {
                let valid = robot
                    .groups
                    .iter()
                    .map(|group| group.name.as_str());
                return Err(PlannerError::unknown(
                    "group of the robot",
                    name,
                    valid,
                    Code::InvalidGroupName,
                ));
            };
            for (variable, moves) in (0..).zip(&mut moving) {
                *moves &= u8::from(group.variables.contains(&variable));
            }
        }
        Ok(if moving.iter().all(|moves| *moves == 1) {
            Vec::new()
        } else {
            moving
        })
    }

    /// Values of the robot's held joints; none where all have their own.
    ///
    /// # Errors
    /// A joint that has a column, or that the robot does not have.
    pub fn held_values(&self, robot: &RobotDescription) -> Result<Vec<f64>, PlannerError> {
        let mut values = robot.held_values.clone();
        let mut is_given = false;
        for (name, value) in &self.held {
            match robot
                .held_variables
                .iter()
                .position(|held| held == name)
            {
                Some(index) => {
                    values[index] = *value;
                    is_given = true;
                }
                None => self.check_missing(robot, name)?,
            }
        }
        Ok(if is_given { values } else { Vec::new() })
    }

    /// Whether a variable of the robot has no column.
    fn is_missing(&self, name: &str) -> bool {
        !self.columns.is_empty() && self.columns.iter().all(|column| column != name)
    }

    /// Checks that a value is for a variable that has no column.
    fn check_missing(&self, robot: &RobotDescription, name: &str) -> Result<(), PlannerError> {
        let variables = || {
            robot
                .variables
                .iter()
                .map(|variable| variable.name.as_str())
        };
        let is_variable = variables().any(|variable| variable == name);
        if is_variable && self.is_missing(name) {
            return Ok(());
        }
        let kind = match is_variable {
            true => "joint without a column (it is a column of the path)",
            false => "joint without a column",
        };
        let held = robot.held_variables.iter().map(String::as_str);
        let valid = held.chain(variables().filter(|name| self.is_missing(name)));
        Err(PlannerError::unknown(
            kind,
            name,
            valid,
            Code::MalformedRequest,
        ))
    }
}

/// A text that fits the wire.
fn text(what: &str, text: &str) -> Result<String, PlannerError> {
    let bytes = text.len();
    if bytes > MAX_TEXT {
        let message = format!("{what} of {bytes} bytes; at most {MAX_TEXT}: ask for fewer");
        return Err(PlannerError::invalid(Code::ResourceExhausted, message));
    }
    Ok(text.to_owned())
}

/// The velocity coordinates of a joint, or of one of its variables.
fn coordinates_of(robot: &RobotDescription, name: &str) -> Result<Vec<Range<usize>>, PlannerError> {
    let is_meant = |column: &str| {
        column
            .strip_prefix(name)
            .is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
    };
    let meant = robot
        .variables
        .iter()
        .filter(|variable| is_meant(&variable.name));
    let coordinates: Vec<Range<usize>> = meant.map(coordinates).collect();
    if coordinates.is_empty() {
        let valid = robot
            .variables
            .iter()
            .map(|variable| variable.name.as_str());
        let kind = "joint of the robot";
        return Err(PlannerError::unknown(
            kind,
            name,
            valid,
            Code::MalformedRequest,
        ));
    }
    Ok(coordinates)
}

fn coordinates(variable: &VariableDescription) -> Range<usize> {
    let first = variable.coordinate as usize;
    first..first + variable.coordinates as usize
}

/// Optional sections in the robot's order.
pub(super) struct Sections {
    weights: Vec<f64>,
    fixed: Vec<u8>,
    moving: Vec<u8>,
    held: Vec<f64>,
    constraints: String,
    timing: String,
}

impl Sections {
    pub(super) fn body(&self) -> RequestBody<'_> {
        RequestBody {
            weights: &self.weights,
            fixed_waypoints: &self.fixed,
            group_mask: &self.moving,
            held_values: &self.held,
            constraints: &self.constraints,
            timing: &self.timing,
        }
    }
}
