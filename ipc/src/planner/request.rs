//! What a planner asks for, by name.

use super::{Columns, PlannerError};
use crate::control::RobotDescription;
use crate::limits::{MAX_PATH_NUMBERS, MAX_VARIABLES, MAX_WAYPOINTS};
use crate::time::deadline_after;
use crate::wire::{Code, Mode, NO_GROUP, RequestBody, RequestFlags, RequestHeader, label_id};
use std::time::Duration;

/// What is asked about a path. [`Request::new`] has what a request means that says nothing more.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// Label of the robot.
    pub robot: String,
    /// Label of the scene; `None` = nothing around the robot.
    pub scene: Option<String>,
    /// Version of the scene; 0 = the newest.
    pub scene_version: u64,
    /// Names of the path's columns; empty = all of the robot's, in its order. Joints without one
    /// stand still, at 0 where [`Self::held`] does not say.
    pub columns: Vec<String>,
    /// Where joints stand that are no columns, by variable name (rad or m).
    pub held: Vec<(String, f64)>,
    /// Optimizer.
    pub mode: Mode,
    /// Time that it may take, from when it is sent.
    pub deadline: Option<Duration>,
    /// Counted work, the same on every machine; 0 = the default.
    pub work_budget: u64,
    /// Seed of every random choice.
    pub seed: u64,
    /// Clearance to prove, in metres; `None` = the daemon's default.
    pub clearance_m: Option<f64>,
    /// Refuse a path that keeps less, instead of lowering the floors of the pairs that come closer.
    pub strict: bool,
    /// Columns of continuous joints are real numbers, not angles on the circle.
    pub unwrapped: bool,
    /// The goal's numbers stay to the last bit; a path whose angles do not lead there by their
    /// numbers is refused.
    pub keep_goal: bool,
    /// Look for what is nearest along the answer.
    pub contacts: bool,
    /// Mode check only: tell again when a change of the scene makes the path unsafe or safe, until
    /// it is dropped.
    pub watch: bool,
    /// Weights of the metric, one per velocity coordinate; empty = reach weights.
    pub metric: Vec<f64>,
    /// Weights of single joints, by name, instead of those.
    pub joint_weights: Vec<(String, f64)>,
    /// Waypoints that stay bit-equal, from 0; the ends always do.
    pub fixed_waypoints: Vec<usize>,
    /// Only this group's joints may leave their motion.
    pub group: Option<String>,
    /// Higher is served first.
    pub priority: u32,
}

impl Request {
    /// A request to shorten a path of this robot in this scene.
    pub fn new(robot: &str, scene: Option<&str>) -> Self {
        Self {
            robot: robot.to_owned(),
            scene: scene.map(str::to_owned),
            scene_version: 0,
            columns: Vec::new(),
            held: Vec::new(),
            mode: Mode::Hybrid,
            deadline: None,
            work_budget: 0,
            seed: 0,
            clearance_m: None,
            strict: false,
            unwrapped: false,
            keep_goal: false,
            contacts: true,
            watch: false,
            metric: Vec::new(),
            joint_weights: Vec::new(),
            fixed_waypoints: Vec::new(),
            group: None,
            priority: 0,
        }
    }

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
        let flag = |is_set: bool, flag: u32| if is_set { flag } else { 0 };
        let clearance_m = match self.clearance_m {
            None => 0.0,
            Some(metres) if metres.is_finite() && metres > 0.0 => metres,
            Some(metres) => {
                let message = format!("a clearance of {metres} m; valid: more than 0");
                return Err(PlannerError::invalid(Code::MalformedRequest, message));
            }
        };
        Ok(RequestHeader {
            robot_id: robot.robot_id,
            layout_hash: robot.layout_hash,
            scene_id: label_id(scene),
            scene_version: self.scene_version,
            mode: self.mode.into(),
            flags: flag(self.strict, RequestFlags::STRICT)
                | flag(self.unwrapped, RequestFlags::UNWRAPPED)
                | flag(self.keep_goal, RequestFlags::KEEP_GOAL)
                | flag(!self.contacts, RequestFlags::WITHOUT_CONTACTS)
                | flag(self.watch, RequestFlags::WATCH),
            priority: self.priority,
            seed: self.seed,
            deadline_ns: self.deadline.map_or(0, deadline_after),
            work_budget: self.work_budget,
            clearance_m,
            group: NO_GROUP,
            ..RequestHeader::default()
        })
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
        let mut weights = if self.metric.is_empty() {
            robot.weights.clone()
        } else {
            self.metric.clone()
        };
        for (name, weight) in &self.joint_weights {
            let is_meant = |column: &str| {
                column
                    .strip_prefix(name.as_str())
                    .is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
            };
            let mut found = false;
            for variable in robot
                .variables
                .iter()
                .filter(|variable| is_meant(&variable.name))
            {
                found = true;
                let first = variable.coordinate as usize;
                let end = first + variable.coordinates as usize;
                if let Some(own) = weights.get_mut(first..end) {
                    own.fill(*weight);
                }
            }
            if !found {
                let valid = robot
                    .variables
                    .iter()
                    .map(|variable| variable.name.as_str());
                return Err(PlannerError::unknown(
                    "joint of the robot",
                    name,
                    valid,
                    Code::MalformedRequest,
                ));
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
                    "waypoint {waypoint} is to stay; the path has waypoints 0 to {}",
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
            let Some(group) = robot.groups.iter().find(|group| group.name == *name) else {
                let valid = robot.groups.iter().map(|group| group.name.as_str());
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
    fn held_values(&self, robot: &RobotDescription) -> Result<Vec<f64>, PlannerError> {
        let mut values = robot.held_values.clone();
        let mut is_given = false;
        for (name, value) in &self.held {
            if let Some(index) = robot.held_variables.iter().position(|held| held == name) {
                values[index] = *value;
                is_given = true;
                continue;
            }
            let is_missing_column = robot
                .variables
                .iter()
                .any(|variable| variable.name == *name)
                && !self.columns.is_empty()
                && !self.columns.contains(name);
            if !is_missing_column {
                let columns = robot.variables.iter().map(|variable| &variable.name);
                let missing =
                    columns.filter(|name| !self.columns.is_empty() && !self.columns.contains(name));
                let valid = robot
                    .held_variables
                    .iter()
                    .chain(missing)
                    .map(String::as_str);
                return Err(PlannerError::unknown(
                    "joint without a column",
                    name,
                    valid,
                    Code::MalformedRequest,
                ));
            }
        }
        Ok(if is_given { values } else { Vec::new() })
    }
}

/// Optional sections in the robot's order.
pub(super) struct Sections {
    weights: Vec<f64>,
    fixed: Vec<u8>,
    moving: Vec<u8>,
    held: Vec<f64>,
}

impl Sections {
    pub(super) fn body(&self) -> RequestBody<'_> {
        RequestBody {
            weights: &self.weights,
            fixed_waypoints: &self.fixed,
            group_mask: &self.moving,
            held_values: &self.held,
        }
    }
}
