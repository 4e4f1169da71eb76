//! Where a request says that the path starts and ends, beside the path itself.

use super::refusal::Refusal;
use std::f64::consts::TAU;
use taut_ipc::control::RobotDescription;
use taut_ipc::wire::Code;
use taut_ros::messages::moveit_msgs::{Constraints, JointConstraint};
use taut_ros::messages::sensor_msgs::JointState;
use taut_ros::messages::trajectory_msgs::{JointTrajectory, JointTrajectoryPoint};

/// By how much a start state may differ from the path's first point (rad or m): as much as limits may be
/// exceeded.
const SAME: f64 = 1e-4;

/// What a start state says of joints that are no columns of the path.
#[derive(Debug, Default)]
pub(super) struct Start {
    pub held: Vec<(String, f64)>,
    pub notes: Vec<String>,
}

/// Reads a start state: joints of the path have to stand where it starts, others are held there.
///
/// # Errors
/// [`Code::InvalidRobotState`]: it differs from the path's start, or has other names than positions.
pub(super) fn read(
    state: &JointState,
    trajectory: &JointTrajectory,
    robot: &RobotDescription,
) -> Result<Start, Refusal> {
    if state.name.len() != state.position.len() {
        let message = format!(
            "start_state.joint_state has {} names and {} positions",
            state.name.len(),
            state.position.len()
        );
        return Err(Refusal::new(Code::InvalidRobotState, message));
    }
    let first = trajectory.points.first();
    let mut start = Start::default();
    let mut unknown = Vec::new();
    for (name, value) in state.name.iter().zip(&state.position) {
        match at(name, trajectory, first) {
            Some(own) => check_same(name, *value, own, robot)?,
            None if is_known(name, robot) => start.held.push((name.clone(), *value)),
            None => unknown.push(name.as_str()),
        }
    }
    if !unknown.is_empty() {
        let names = unknown.join(", ");
        let note = format!(
            "start_state says where {names} is, which changes nothing: no joint of the robot's that moves by itself"
        );
        start.notes.push(note);
    }
    Ok(start)
}

/// What of a start state's motion changes nothing.
///
/// # Errors
/// It moves, and times are asked for.
pub(super) fn moving(state: &JointState, is_timed: bool) -> Result<Option<String>, Refusal> {
    let is_said = |list: &[f64]| list.iter().any(|number| *number != 0.0);
    if is_timed && is_said(&state.velocity) {
        let message = "start_state.joint_state has velocities; trajectories start at rest here: leave them out";
        return Err(Refusal::new(Code::InvalidTiming, message));
    }
    let is_said = is_said(&state.velocity) || is_said(&state.effort);
    Ok(is_said.then(|| "velocities and efforts of start_state change nothing".to_owned()))
}

/// Refuses a path that ends elsewhere than at one of the goals.
///
/// # Errors
/// [`Code::GoalViolatesPathConstraints`]; [`Code::InvalidConstraint`] for a joint that is no column.
pub(super) fn check_goals(
    goals: &[Constraints],
    trajectory: &JointTrajectory,
    robot: &RobotDescription,
) -> Result<(), Refusal> {
    let mut missed = None;
    for goal in goals {
        match first_missed(goal, trajectory, robot)? {
            None => return Ok(()),
            Some(text) => missed = missed.or(Some(text)),
        }
    }
    match missed {
        None => Ok(()),
        Some(text) => Err(Refusal::new(
            Code::GoalViolatesPathConstraints,
            format!("the path does not end at a goal of goal_constraints: {text}"),
        )),
    }
}

fn first_missed(
    goal: &Constraints,
    trajectory: &JointTrajectory,
    robot: &RobotDescription,
) -> Result<Option<String>, Refusal> {
    let last = trajectory.points.last();
    for JointConstraint {
        joint_name,
        position,
        tolerance_above,
        tolerance_below,
        ..
    } in &goal.joint_constraints
    {
        let Some(own) = at(joint_name, trajectory, last) else {
            let message = format!("goal_constraints name {joint_name:?}, no column of the path");
            return Err(Refusal::new(Code::InvalidConstraint, message));
        };
        let off = difference(joint_name, own, *position, robot);
        let is_kept = (-tolerance_below..=*tolerance_above).contains(&off);
        if !is_kept {
            return Ok(Some(format!(
                "{joint_name} is {own} there, the goal {position}"
            )));
        }
    }
    Ok(None)
}

/// Where a column of the path is at a point.
fn at(
    name: &str,
    trajectory: &JointTrajectory,
    point: Option<&JointTrajectoryPoint>,
) -> Option<f64> {
    let column = trajectory
        .joint_names
        .iter()
        .position(|column| column == name)?;
    point?.positions.get(column).copied()
}

fn check_same(name: &str, value: f64, own: f64, robot: &RobotDescription) -> Result<(), Refusal> {
    let off = difference(name, value, own, robot);
    if off.abs() <= SAME {
        return Ok(());
    }
    let message = format!(
        "start_state has {name} at {value}, the path starts at {own}; give the path from where the robot is, or leave the joint out"
    );
    Err(Refusal::new(Code::InvalidRobotState, message))
}

/// By how much a value is above another, of continuous joints the short way around.
fn difference(name: &str, value: f64, from: f64, robot: &RobotDescription) -> f64 {
    let off = value - from;
    let is_continuous = robot
        .variables
        .iter()
        .any(|variable| variable.name == name && variable.continuous);
    match is_continuous {
        true => off - TAU * (off / TAU).round(),
        false => off,
    }
}

fn is_known(name: &str, robot: &RobotDescription) -> bool {
    let mut free = robot
        .variables
        .iter()
        .map(|variable| &variable.name);
    free.any(|known| known == name)
        || robot
            .held_variables
            .iter()
            .any(|known| known == name)
}
