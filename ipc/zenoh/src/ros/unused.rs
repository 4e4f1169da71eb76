//! What a request may say that taut does not use: refused by name, never dropped.

use super::refusal::Refusal;
use taut_ipc::wire::Code;
use taut_ros::messages::moveit_msgs::{Constraints, MotionPlanRequest};

/// The pipeline that is meant where one is named.
const PIPELINE: &str = "taut";

/// A part of the request, whether something is in it, and what to do.
struct Part {
    name: &'static str,
    is_said: bool,
    code: Code,
    advice: &'static str,
}

/// Refuses a request that says what would be left out.
///
/// # Errors
/// The names of all that is not used, and what to do; the first one's code.
pub(super) fn check(request: &MotionPlanRequest) -> Result<(), Refusal> {
    let mut said = parts(request);
    said.retain(|part| part.is_said);
    let Some(first) = said.first() else {
        return Ok(());
    };
    let texts: Vec<String> = said
        .iter()
        .map(|part| format!("{}: {}", part.name, part.advice))
        .collect();
    let message = format!(
        "the request has what taut does not use: {}",
        texts.join("; ")
    );
    Err(Refusal::new(first.code, message))
}

fn parts(request: &MotionPlanRequest) -> Vec<Part> {
    let mut parts = Vec::from(of_state(request));
    parts.extend(of_constraints(request));
    parts.extend(of_times(request));
    let workspace = &request.workspace_parameters;
    parts.push(Part {
        name: "workspace_parameters",
        is_said: workspace.min_corner != workspace.max_corner,
        code: Code::MalformedRequest,
        advice: "leave both corners at 0; where the robot may go, its joints' limits say",
    });
    parts.push(Part {
        name: "pipeline_id",
        is_said: !["", PIPELINE].contains(&request.pipeline_id.as_str()),
        code: Code::MalformedRequest,
        advice: "leave it empty or say taut",
    });
    parts.push(Part {
        name: "num_planning_attempts",
        is_said: !(0..=1).contains(&request.num_planning_attempts),
        code: Code::MalformedRequest,
        advice: "0 or 1, since equal requests have equal answers",
    });
    parts
}

fn of_state(request: &MotionPlanRequest) -> [Part; 2] {
    let state = &request.start_state;
    [
        Part {
            name: "start_state.multi_dof_joint_state",
            is_said: !state
                .multi_dof_joint_state
                .joint_names
                .is_empty(),
            code: Code::InvalidRobotState,
            advice: "give a joint of several values as columns of the path, such as base/x",
        },
        Part {
            name: "start_state.attached_collision_objects",
            is_said: !state.attached_collision_objects.is_empty(),
            code: Code::InvalidObjectName,
            advice: "what links carry is the scene's; attach it by /taut/apply_planning_scene",
        },
    ]
}

fn of_constraints(request: &MotionPlanRequest) -> [Part; 2] {
    let goals = &request.goal_constraints;
    [
        Part {
            name: "trajectory_constraints",
            is_said: !request
                .trajectory_constraints
                .constraints
                .is_empty(),
            code: Code::InvalidConstraint,
            advice: "give path_constraints, which hold all the way",
        },
        Part {
            name: "goal_constraints other than joint_constraints",
            is_said: goals.iter().any(has_more_than_joints),
            code: Code::InvalidConstraint,
            advice: "the path's end is the goal and stays; leave them out, or give joint_constraints",
        },
    ]
}

fn has_more_than_joints(goal: &Constraints) -> bool {
    !(goal.position_constraints.is_empty()
        && goal.orientation_constraints.is_empty()
        && goal.visibility_constraints.is_empty())
}

fn of_times(request: &MotionPlanRequest) -> [Part; 3] {
    let is_scaled = |factor: f64| factor != 0.0 && factor != 1.0;
    let scaling = |name, factor| Part {
        name,
        is_said: is_scaled(factor),
        code: Code::InvalidTiming,
        advice: "0 or 1; how fast a trajectory is, `taut-zenoh ros --timing` says",
    };
    [
        scaling(
            "max_velocity_scaling_factor",
            request.max_velocity_scaling_factor,
        ),
        scaling(
            "max_acceleration_scaling_factor",
            request.max_acceleration_scaling_factor,
        ),
        Part {
            name: "max_cartesian_speed",
            is_said: request.max_cartesian_speed != 0.0
                || !request.cartesian_speed_limited_link.is_empty(),
            code: Code::InvalidTiming,
            advice: "leave it and cartesian_speed_limited_link out; links have no speed limits here",
        },
    ]
}
