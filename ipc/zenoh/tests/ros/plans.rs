//! Requests about paths.

use crate::cell::{Cell, of, path, request, services};
use taut_ipc::wire::Code;
use taut_ros::cdr::{decode, encode};
use taut_ros::messages::geometry_msgs::Vector3;
use taut_ros::messages::moveit_msgs::{
    AttachedCollisionObject, CartesianTrajectory, Constraints, GetMotionPlan, GetMotionPlanRequest,
    GetMotionPlanResponse, JointConstraint, MotionPlanRequest, MotionPlanResponse,
    PositionConstraint,
};

fn code(response: &MotionPlanResponse) -> Code {
    Code::try_from(response.error_code.val).unwrap()
}

fn said(response: &MotionPlanResponse) -> &str {
    assert_eq!(response.error_code.source, "taut");
    &response.error_code.message
}

/// The two lengths that a message tells.
fn lengths(message: &str) -> (f64, f64) {
    let part = message
        .split("; ")
        .find_map(|part| part.strip_prefix("length "));
    let (after, before) = part.unwrap().split_once(" of ").unwrap();
    (after.parse().unwrap(), before.parse().unwrap())
}

#[test]
fn a_path_is_shortened_and_proved() {
    for problem in ["corner", "arm_shelf"] {
        let Some(cell) = Cell::of(problem) else {
            return;
        };
        let mut asked = request(problem);
        asked.planner_id = "hybrid".to_owned();
        let answer = cell.shorten(&asked);
        let text = said(&answer).to_owned();
        assert_eq!(code(&answer), Code::Success, "{text}");
        let (after, before) = lengths(&text);
        assert!(after < 0.9 * before, "{text}");
        for word in ["proved: clearance ≥", " × ", "without --timing", problem] {
            assert!(text.contains(word), "{word}: {text}");
        }
        assert!(answer.planning_time > 0.0);
        let shorter = answer.trajectory.joint_trajectory;
        let given = path(&mut asked).clone();
        assert_eq!(shorter.joint_names, given.joint_names);
        assert_eq!(shorter.points.first(), given.points.first());
        assert_eq!(shorter.points.last(), given.points.last());
        let start = answer.trajectory_start.joint_state;
        assert_eq!(start.position, given.points[0].positions);
        let (verdict, text) = cell.verdict(&of(shorter));
        assert_eq!(verdict, 1, "{text}");
        assert!((lengths(&text).1 - after).abs() < 1e-5, "{text}");
    }
}

#[test]
fn tokens_tell_of_the_services() {
    let Some(cell) = Cell::of("corner") else {
        return;
    };
    let tokens = services(&cell.node).join("\n");
    for (name, kind) in [
        ("%taut%shorten", "moveit_msgs::srv::dds_::GetMotionPlan_"),
        ("%taut%check", "moveit_msgs::srv::dds_::GetMotionPlan_"),
        (
            "%taut%apply_planning_scene",
            "moveit_msgs::srv::dds_::ApplyPlanningScene_",
        ),
    ] {
        let part = format!("/SS/%/%/taut/{name}/{kind}/RIHS01_");
        assert!(tokens.contains(&part), "{part}: {tokens}");
    }
}

#[test]
fn times_are_there_where_they_are_asked_for() {
    let with_times = |options: &mut taut_zenoh::ros::Options| {
        options.timing = "acceleration=2/s".to_owned();
    };
    let Some(cell) = Cell::with("arm_shelf", with_times) else {
        return;
    };
    let answer = cell.shorten(&request("arm_shelf"));
    assert_eq!(code(&answer), Code::Success, "{}", said(&answer));
    let points = &answer.trajectory.joint_trajectory.points;
    let last = &points.last().unwrap();
    assert!(last.time_from_start.sec > 0 || last.time_from_start.nanosec > 0);
    assert_eq!(last.velocities.len(), 7);
    assert!(said(&answer).contains("s, proved as it is written"));
    let mut moving = request("arm_shelf");
    path(&mut moving).points[0].velocities = vec![0.1; 7];
    assert_eq!(code(&cell.shorten(&moving)), Code::InvalidTiming);
    let mut moving = request("arm_shelf");
    moving.start_state.joint_state.velocity = vec![0.1];
    assert_eq!(code(&cell.shorten(&moving)), Code::InvalidTiming);
}

/// What of a request is not used, the code, and the words that the answer has.
type Unused = (fn(&mut MotionPlanRequest), Code, &'static [&'static str]);

const UNUSED: &[Unused] = &[
    (
        |request| request.workspace_parameters.max_corner = corner(),
        Code::MalformedRequest,
        &["workspace_parameters"],
    ),
    (
        |request| {
            request
                .start_state
                .multi_dof_joint_state
                .joint_names = vec!["base".into()]
        },
        Code::InvalidRobotState,
        &["start_state.multi_dof_joint_state"],
    ),
    (
        |request| {
            let attached = AttachedCollisionObject::default();
            request.start_state.attached_collision_objects = vec![attached];
        },
        Code::InvalidObjectName,
        &[
            "start_state.attached_collision_objects",
            "/taut/apply_planning_scene",
        ],
    ),
    (
        |request| request.trajectory_constraints.constraints = vec![Constraints::default()],
        Code::InvalidConstraint,
        &["trajectory_constraints"],
    ),
    (
        |request| {
            request.goal_constraints = vec![Constraints {
                position_constraints: vec![PositionConstraint::default()],
                ..Constraints::default()
            }];
        },
        Code::InvalidConstraint,
        &["goal_constraints other than joint_constraints"],
    ),
    (
        |request| request.pipeline_id = "ompl".into(),
        Code::MalformedRequest,
        &["pipeline_id"],
    ),
    (
        |request| request.planner_id = "RRTConnect".into(),
        Code::MalformedRequest,
        &["RRTConnect", "hybrid"],
    ),
    (
        |request| request.num_planning_attempts = 4,
        Code::MalformedRequest,
        &["num_planning_attempts"],
    ),
    (
        |request| request.max_velocity_scaling_factor = 0.5,
        Code::InvalidTiming,
        &["max_velocity_scaling_factor", "--timing"],
    ),
    (
        |request| {
            request.max_acceleration_scaling_factor = 0.1;
            request.max_cartesian_speed = 0.3;
        },
        Code::InvalidTiming,
        &["max_acceleration_scaling_factor", "max_cartesian_speed"],
    ),
    (
        |request| request.cartesian_speed_limited_link = "hand".into(),
        Code::InvalidTiming,
        &["cartesian_speed_limited_link"],
    ),
    (
        |request| request.allowed_planning_time = -1.0,
        Code::MalformedRequest,
        &["allowed_planning_time"],
    ),
    (
        |request| request.reference_trajectories.clear(),
        Code::MalformedRequest,
        &["reference_trajectories has 0 trajectories"],
    ),
    (
        |request| {
            let cartesian = CartesianTrajectory::default();
            request.reference_trajectories[0].cartesian_trajectory = vec![cartesian];
        },
        Code::MalformedRequest,
        &["cartesian_trajectory"],
    ),
    (
        |request| path(request).joint_names.clear(),
        Code::MalformedRequest,
        &["no joint_names"],
    ),
    (
        |request| path(request).points[1].positions.truncate(2),
        Code::InvalidRobotState,
        &["point 1", "has 2 positions"],
    ),
    (
        |request| path(request).joint_names[0] = "elbow".into(),
        Code::InvalidRobotState,
        &["elbow", "theta"],
    ),
    (
        |request| request.group_name = "leg".into(),
        Code::InvalidGroupName,
        &["leg"],
    ),
    (
        |request| request.start_state.joint_state.name = vec!["x".into()],
        Code::InvalidRobotState,
        &["1 names and 0 positions"],
    ),
    (
        |request| starts(request, "x", -2.9),
        Code::InvalidRobotState,
        &["start_state has x at -2.9, the path starts at -3"],
    ),
    (
        |request| ends(request, "y", -2.5),
        Code::GoalViolatesPathConstraints,
        &["y is -3 there, the goal -2.5"],
    ),
    (
        |request| ends(request, "wrist", 0.0),
        Code::InvalidConstraint,
        &["wrist"],
    ),
    (
        |request| keeps(request, "theta", 0.0, 0.5),
        Code::GoalViolatesPathConstraints,
        &["theta", "outside by"],
    ),
    (
        |request| keeps(request, "wrist", 0.0, 0.5),
        Code::InvalidConstraint,
        &["wrist"],
    ),
];

fn corner() -> Vector3 {
    Vector3 {
        x: 1.0,
        ..Vector3::default()
    }
}

fn starts(request: &mut MotionPlanRequest, joint: &str, value: f64) {
    request.start_state.joint_state.name = vec![joint.to_owned()];
    request.start_state.joint_state.position = vec![value];
}

fn within(joint: &str, position: f64, tolerance: f64) -> Constraints {
    Constraints {
        joint_constraints: vec![JointConstraint {
            joint_name: joint.to_owned(),
            position,
            tolerance_above: tolerance,
            tolerance_below: tolerance,
            weight: 1.0,
        }],
        ..Constraints::default()
    }
}

fn ends(request: &mut MotionPlanRequest, joint: &str, value: f64) {
    request.goal_constraints = vec![within(joint, value, 1e-3)];
}

fn keeps(request: &mut MotionPlanRequest, joint: &str, value: f64, tolerance: f64) {
    request.path_constraints = within(joint, value, tolerance);
}

#[test]
fn what_is_not_used_is_refused_by_name() {
    let Some(cell) = Cell::of("corner") else {
        return;
    };
    for (number, (change, expected, words)) in UNUSED.iter().enumerate() {
        let mut asked = request("corner");
        change(&mut asked);
        let answer = cell.shorten(&asked);
        let text = said(&answer);
        assert_eq!(code(&answer), *expected, "{number}: {text}");
        for word in *words {
            assert!(text.contains(word), "{word:?}: {text}");
        }
        assert!(
            answer
                .trajectory
                .joint_trajectory
                .points
                .is_empty()
        );
    }
    let mut optimizer = request("corner");
    optimizer.planner_id = "hybrid".to_owned();
    assert_eq!(code(&cell.check(&optimizer)), Code::MalformedRequest);
}

#[test]
fn what_is_used_is_honoured() {
    let Some(cell) = Cell::of("corner") else {
        return;
    };
    let mut asked = request("corner");
    asked.pipeline_id = "taut".to_owned();
    asked.max_velocity_scaling_factor = 1.0;
    starts(&mut asked, "theta", 0.2 + std::f64::consts::TAU);
    // The first goal is missed, the second is kept.
    asked.goal_constraints = vec![within("y", 0.0, 0.1), within("y", -3.0, 1e-9)];
    keeps(&mut asked, "theta", 0.0, 2.5);
    let answer = cell.shorten(&asked);
    assert_eq!(code(&answer), Code::Success, "{}", said(&answer));
    starts(&mut asked, "mimic_finger", 0.0);
    path(&mut asked).points[1].time_from_start.sec = 1;
    asked.start_state.joint_state.effort = vec![3.0];
    let answer = cell.check(&asked);
    for word in [
        "where mimic_finger is",
        "times, velocities, accelerations and efforts of the path given are not kept",
        "velocities and efforts of start_state change nothing",
    ] {
        assert!(said(&answer).contains(word), "{word}: {}", said(&answer));
    }
    asked.allowed_planning_time = 1e-9;
    assert_eq!(code(&cell.check(&asked)), Code::TimedOut);
}

/// A joint without a column stands where the start state says.
#[test]
fn joints_that_are_no_columns_are_held_where_they_start() {
    let Some(cell) = Cell::of("corner") else {
        return;
    };
    let mut asked = request("corner");
    let only = path(&mut asked);
    only.joint_names = vec!["x".into()];
    only.points.truncate(2);
    for (point, x) in only.points.iter_mut().zip([-3.0, -2.9]) {
        point.positions = vec![x];
    }
    asked.start_state.joint_state.name = vec!["y".into(), "theta".into()];
    for (y, expected) in [
        (0.1, Code::Success),
        // In the inner wall.
        (-2.0, Code::StartStateInCollision),
    ] {
        asked.start_state.joint_state.position = vec![y, 0.2];
        let answer = cell.check(&asked);
        assert_eq!(code(&answer), expected, "{}", said(&answer));
    }
}

#[test]
fn bytes_that_are_no_request_are_answered_so() {
    let Some(cell) = Cell::of("corner") else {
        return;
    };
    let request = GetMotionPlanRequest {
        motion_plan_request: request("corner"),
    };
    let whole = encode(&request).unwrap();
    for bytes in [
        whole[..whole.len() / 2].to_vec(),
        vec![],
        [&[9, 9], &whole[2..]].concat(),
    ] {
        let reply = cell
            .node
            .call_raw::<GetMotionPlan>("/taut/shorten", bytes);
        let reply: GetMotionPlanResponse = decode(&reply).unwrap();
        let answer = reply.motion_plan_response;
        assert_eq!(code(&answer), Code::MalformedRequest, "{}", said(&answer));
    }
}

/// Whatever comes is answered, and the service serves on.
#[test]
fn mutated_requests_are_answered() {
    let Some(cell) = Cell::of("corner") else {
        return;
    };
    let messages = std::env::var("TAUT_MESSAGES");
    let messages: usize = messages.map_or(300, |text| text.parse().unwrap());
    let request = GetMotionPlanRequest {
        motion_plan_request: request("corner"),
    };
    let whole = encode(&request).unwrap();
    let mut noise = 1_u64;
    let mut below = |end: usize| {
        noise = noise
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (noise >> 33) as usize % end
    };
    let mut succeeded = 0;
    for _ in 0..messages {
        let mut bytes = whole.clone();
        for _ in 0..=below(3) {
            let at = below(bytes.len());
            bytes[at] = below(256) as u8;
        }
        let reply = cell
            .node
            .call_raw::<GetMotionPlan>("/taut/check", bytes);
        let reply: GetMotionPlanResponse = decode(&reply).unwrap();
        succeeded += usize::from(code(&reply.motion_plan_response) == Code::Success);
    }
    println!("{succeeded} of {messages} prove a path");
    assert!(0 < succeeded && succeeded < messages, "{succeeded}");
    assert_eq!(cell.verdict(&request.motion_plan_request).0, 1);
}
