//! From a `MotionPlanRequest` to a planner's request, with all that it says.

use super::options::Options;
use super::refusal::Refusal;
use super::{start, unused};
use serde_json::json;
use std::time::Duration;
use taut_ipc::control::RobotDescription;
use taut_ipc::planner::Request;
use taut_ipc::wire::{Code, Mode};
use taut_ros::messages::builtin_interfaces;
use taut_ros::messages::moveit_msgs::{Constraints, GenericTrajectory, MotionPlanRequest};
use taut_ros::messages::trajectory_msgs::{JointTrajectory, JointTrajectoryPoint};

/// What a service does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Shorten,
    Check,
}

impl Kind {
    /// The name under which it is called.
    pub fn service(self) -> &'static str {
        match self {
            Self::Shorten => "/taut/shorten",
            Self::Check => "/taut/check",
        }
    }

    /// The optimizer that `planner_id` names.
    fn mode(self, planner_id: &str) -> Result<Mode, Refusal> {
        let is_valid = |mode: &Mode| self == Self::Shorten || *mode == Mode::Check;
        let usual = match self {
            Self::Shorten => Mode::Hybrid,
            Self::Check => Mode::Check,
        };
        let named = match planner_id {
            "" => Some(usual),
            name => Mode::named(name).filter(is_valid),
        };
        named.ok_or_else(|| {
            let modes = Mode::ALL.iter().map(|(mode, _)| *mode);
            let valid: Vec<&str> = modes.filter(is_valid).map(Mode::name).collect();
            let message = format!(
                "planner_id {planner_id:?} is no mode of {}; valid: {}, or none for {}",
                self.service(),
                valid.join(", "),
                usual.name()
            );
            Refusal::new(Code::MalformedRequest, message)
        })
    }
}

/// A request, with what an answer has to say beside it.
#[derive(Debug)]
pub(super) struct Asked {
    pub request: Request,
    /// Row by row.
    pub path: Vec<f64>,
    /// What was said and changes nothing.
    pub notes: Vec<String>,
}

/// What a message asks for.
///
/// # Errors
/// What would be left out, and what makes no sense, by name.
pub(super) fn asked(
    message: &MotionPlanRequest,
    kind: Kind,
    options: &Options,
    robot: &RobotDescription,
) -> Result<Asked, Refusal> {
    unused::check(message)?;
    let trajectory = trajectory(&message.reference_trajectories)?;
    let path = path(trajectory)?;
    start::check_goals(&message.goal_constraints, trajectory, robot)?;
    let start = start::read(&message.start_state.joint_state, trajectory, robot)?;
    let is_timed = !options.timing.is_empty();
    let mut notes = start.notes;
    notes.extend(moving(trajectory, is_timed)?);
    let state = &message.start_state.joint_state;
    notes.extend(start::moving(state, is_timed)?);
    let request = Request {
        deadline: deadline(message.allowed_planning_time)?,
        mode: kind.mode(&message.planner_id)?,
        group: (!message.group_name.is_empty()).then(|| message.group_name.clone()),
        columns: trajectory.joint_names.clone(),
        held: start.held,
        constraints: constraints(&message.path_constraints),
        timing: options.timing.clone(),
        ..Request::new(&options.robot, Some(&options.scene))
    };
    Ok(Asked {
        request,
        path,
        notes,
    })
}

/// The one path of a request.
fn trajectory(given: &[GenericTrajectory]) -> Result<&JointTrajectory, Refusal> {
    let refused = |what: String| {
        let message = format!(
            "reference_trajectories has {what}; give the path as one, with one joint_trajectory"
        );
        Err(Refusal::new(Code::MalformedRequest, message))
    };
    let [given] = given else {
        return refused(format!("{} trajectories", given.len()));
    };
    if !given.cartesian_trajectory.is_empty() {
        return refused("a cartesian_trajectory".to_owned());
    }
    match given.joint_trajectory.as_slice() {
        [one] if !one.joint_names.is_empty() => Ok(one),
        [_] => refused("no joint_names".to_owned()),
        several => refused(format!("{} joint_trajectories", several.len())),
    }
}

fn path(trajectory: &JointTrajectory) -> Result<Vec<f64>, Refusal> {
    let width = trajectory.joint_names.len();
    let wrong = trajectory
        .points
        .iter()
        .position(|point| point.positions.len() != width);
    if let Some(point) = wrong {
        let message = format!(
            "point {point} (from 0) of the path has {} positions; joint_names has {width}",
            trajectory.points[point].positions.len()
        );
        return Err(Refusal::new(Code::InvalidRobotState, message));
    }
    let rows = trajectory.points.iter();
    Ok(rows
        .flat_map(|point| point.positions.iter().copied())
        .collect())
}

/// What of a path's own times is not kept.
///
/// # Errors
/// It starts moving, and times are asked for: they would start at rest.
fn moving(trajectory: &JointTrajectory, is_timed: bool) -> Result<Option<String>, Refusal> {
    let points = &trajectory.points;
    let starts_moving = points
        .first()
        .is_some_and(|point| point.velocities.iter().any(|v| *v != 0.0));
    if is_timed && starts_moving {
        let message = "the path's first point has velocities; trajectories start at rest here: leave them out";
        return Err(Refusal::new(Code::InvalidTiming, message));
    }
    Ok(points.iter().any(has_times).then(|| {
        "times, velocities, accelerations and efforts of the path given are not kept".into()
    }))
}

fn has_times(point: &JointTrajectoryPoint) -> bool {
    let lists = [&point.velocities, &point.accelerations, &point.effort];
    point.time_from_start != builtin_interfaces::Duration::default()
        || lists.iter().any(|list| !list.is_empty())
}

/// None where it is 0, as in a message that says nothing.
fn deadline(seconds: f64) -> Result<Option<Duration>, Refusal> {
    let time = Duration::try_from_secs_f64(seconds).map_err(|error| {
        let message = format!("allowed_planning_time is {seconds} s: {error}; 0 is no limit");
        Refusal::new(Code::MalformedRequest, message)
    })?;
    Ok((!time.is_zero()).then_some(time))
}

/// The text of the request's option, MoveIt's own message; empty where it asks for nothing.
fn constraints(asked: &Constraints) -> String {
    let is_empty = asked.joint_constraints.is_empty()
        && asked.position_constraints.is_empty()
        && asked.orientation_constraints.is_empty()
        && asked.visibility_constraints.is_empty();
    match is_empty {
        true => String::new(),
        false => json!(asked).to_string(),
    }
}
