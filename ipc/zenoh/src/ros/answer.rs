//! From a daemon's answer to a `MotionPlanResponse`.

use super::ask::Asked;
use super::refusal::Refusal;
use taut_ipc::planner::{Best, PlannerError, Trajectory};
use taut_ipc::wire::{HoldRecord, RequirementKind, ResponseView, WireError};
use taut_ros::messages::builtin_interfaces::Duration;
use taut_ros::messages::moveit_msgs::{MotionPlanResponse, MoveItErrorCodes, RobotState};
use taut_ros::messages::trajectory_msgs::{JointTrajectory, JointTrajectoryPoint};

/// Who says it.
const SOURCE: &str = "taut";
const NS: i64 = 1_000_000_000;

/// A no.
pub(super) fn refused(refusal: &Refusal) -> MotionPlanResponse {
    MotionPlanResponse {
        error_code: said(refusal.code.into(), std::slice::from_ref(&refusal.message)),
        ..MotionPlanResponse::default()
    }
}

/// A proved path, with times where it has them.
///
/// # Errors
/// [`WireError`] only if the daemon changed the answer after sending.
pub(super) fn planned(asked: &Asked, best: &Best) -> Result<MotionPlanResponse, Refusal> {
    let trajectory = best.trajectory().map_err(PlannerError::from)?;
    let texts = texts(asked, best, trajectory.as_ref()).map_err(PlannerError::from)?;
    let names = &asked.request.columns;
    let points = match &trajectory {
        Some(trajectory) => timed(trajectory),
        None => untimed(&best.rows(), names.len()),
    };
    let mut response = MotionPlanResponse {
        group_name: asked.request.group.clone().unwrap_or_default(),
        error_code: said(best.code().into(), &texts),
        ..MotionPlanResponse::default()
    };
    response.trajectory_start = start(names, &points);
    response.trajectory.joint_trajectory = JointTrajectory {
        joint_names: names.clone(),
        points,
        ..JointTrajectory::default()
    };
    Ok(response)
}

fn said(val: i32, texts: &[String]) -> MoveItErrorCodes {
    MoveItErrorCodes {
        val,
        message: texts.join("; "),
        source: SOURCE.to_owned(),
    }
}

fn start(names: &[String], points: &[JointTrajectoryPoint]) -> RobotState {
    // Of the other joints it says nothing.
    let mut state = RobotState {
        is_diff: true,
        ..RobotState::default()
    };
    if let Some(first) = points.first() {
        state.joint_state.name = names.to_vec();
        state.joint_state.position = first.positions.clone();
    }
    state
}

fn untimed(rows: &[f64], width: usize) -> Vec<JointTrajectoryPoint> {
    let rows = rows.chunks_exact(width.max(1));
    rows.map(|row| JointTrajectoryPoint {
        positions: row.to_vec(),
        ..JointTrajectoryPoint::default()
    })
    .collect()
}

fn timed(trajectory: &Trajectory) -> Vec<JointTrajectoryPoint> {
    let row = |table: &[f64], point: usize| {
        let mut rows = table.chunks_exact(trajectory.columns.max(1));
        rows.nth(point).unwrap_or_default().to_vec()
    };
    let times = trajectory.times_ns.iter().enumerate();
    times
        .map(|(point, ns)| JointTrajectoryPoint {
            positions: row(&trajectory.positions, point),
            velocities: row(&trajectory.velocities, point),
            accelerations: row(&trajectory.accelerations, point),
            effort: Vec::new(),
            time_from_start: duration(*ns),
        })
        .collect()
}

fn duration(ns: i64) -> Duration {
    Duration {
        sec: i32::try_from(ns.div_euclid(NS)).unwrap_or(i32::MAX),
        nanosec: ns.rem_euclid(NS) as u32,
    }
}

/// What a person should know, first what is proved.
fn texts(
    asked: &Asked,
    best: &Best,
    trajectory: Option<&Trajectory>,
) -> Result<Vec<String>, WireError> {
    let view = best.view()?;
    let header = best.header();
    let mut texts = vec![proved(&view)?];
    texts.push(format!(
        "length {:.6} of {:.6}",
        header.length_after, header.length_before
    ));
    texts.push(times(asked, best, trajectory));
    let scene = asked
        .request
        .scene
        .as_deref()
        .unwrap_or_default();
    texts.push(format!("scene {scene} version {}", header.scene_version));
    for floor in view.lowered_floors {
        let names = floor.requirement.names(view.names)?.join(" × ");
        texts.push(format!("lowered to {} for {names}", floor.floor));
    }
    let warnings = best.warnings()?;
    texts.extend(
        warnings
            .into_iter()
            .filter(|warning| warning.is_uncovered)
            .map(|warning| warning.text),
    );
    texts.extend(asked.notes.clone());
    Ok(texts)
}

fn proved(view: &ResponseView<'_>) -> Result<String, WireError> {
    let clearance = view.header.clearance_m;
    if clearance.is_infinite() {
        return Ok("proved: nothing is near".to_owned());
    }
    let clearance = format!("proved: clearance ≥ {:.4} mm", clearance * 1e3);
    let is_clearance =
        |hold: &&HoldRecord| hold.requirement.kind == u32::from(RequirementKind::Clearance);
    Ok(match view.holds.iter().find(is_clearance) {
        None => clearance,
        Some(hold) => format!(
            "{clearance}, least at segment {} (from 0), t = {:.3}: {}, distance {:.4} mm",
            hold.segment,
            hold.t,
            hold.requirement.names(view.names)?.join(" × "),
            hold.amount * 1e3
        ),
    })
}

fn times(asked: &Asked, best: &Best, trajectory: Option<&Trajectory>) -> String {
    match (trajectory, best.timed()) {
        (Some(trajectory), _) => format!(
            "{:.3} s, proved as it is written, at least {:.3} s",
            trajectory.duration_s(),
            trajectory.bound_s
        ),
        (None, Err(error)) if !asked.request.timing.is_empty() => format!("no times: {error}"),
        // Nodes cannot ask for them; who serves them can.
        (None, _) => "no times: `taut-zenoh ros` was started without --timing".to_owned(),
    }
}
