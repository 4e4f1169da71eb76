//! The client's side: the times of a response as result files have them.

use crate::files::result::{ResultMotor, ResultNearest, ResultTimes, ResultTrajectory};
use taut_ipc::control::RobotDescription;
use taut_ipc::wire::{
    Controller, HoldRecord, ResponseView, Times, TimingStage, TrajectoryRecord, WireError,
};

use super::sections;

/// What a final response says of the times that were asked for; `None` where none were.
///
/// # Errors
/// A response that contradicts itself.
pub fn result_times(
    view: &ResponseView,
    robot: &RobotDescription,
) -> Result<Option<ResultTimes>, WireError> {
    let head = view.trajectory.head;
    let trajectory = head.map(|head| trajectory(view, head, robot));
    Ok((view.times != Times::NotAsked).then_some(ResultTimes {
        status: view.times.name().to_owned(),
        message: match view.times {
            Times::Timed | Times::NotAsked => String::new(),
            Times::NotReached | Times::Refused | Times::NoPath => view.message.to_owned(),
        },
        trajectory: trajectory.transpose()?.map(Box::new),
    }))
}

fn trajectory(
    view: &ResponseView,
    head: &TrajectoryRecord,
    robot: &RobotDescription,
) -> Result<ResultTrajectory, WireError> {
    let sections = &view.trajectory;
    let columns = (view.header.variables as usize).max(1);
    let rows = |numbers: &[f64]| {
        let rows = numbers.chunks_exact(columns);
        rows.map(<[f64]>::to_vec).collect()
    };
    let lowered = sections.lowered_floors.iter();
    let duration_s = sections
        .times_ns
        .last()
        .map_or(0.0, |ns| *ns as f64 / 1e9);
    let variable = robot.variables.get(head.decides as usize);
    Ok(ResultTrajectory {
        duration_s,
        duration_bound_s: head.bound_s,
        gap: match head.bound_s > 0.0 {
            true => duration_s / head.bound_s - 1.0,
            false => 0.0,
        },
        decides: variable.map_or_else(String::new, |variable| variable.name.clone()),
        stops_s: head.stops_s,
        stage: TimingStage::try_from(head.stage)?
            .name()
            .to_owned(),
        controller: Controller::try_from(head.controller)?
            .name()
            .to_owned(),
        rate_hz: Some(head.rate_hz).filter(|rate_hz| *rate_hz > 0.0),
        clearance_m: finite(head.clearance_m),
        floors_lowered: lowered
            .map(|floor| super::sections::lowered(floor, view))
            .collect::<Result<_, _>>()?,
        nearest: sections
            .nearest
            .map(|record| nearest(view, record))
            .transpose()?,
        work: head.work,
        motors: sections
            .limits
            .chunks_exact(4)
            .zip(sections.used.chunks_exact(4))
            .map(|(limits, used)| motor(limits, used))
            .collect(),
        times_ns: sections.times_ns.to_vec(),
        positions: rows(sections.positions),
        velocities: rows(sections.velocities),
        accelerations: rows(sections.accelerations),
    })
}

fn finite(number: f64) -> Option<f64> {
    Some(number).filter(|number| number.is_finite())
}

fn motor(limits: &[f64], used: &[f64]) -> ResultMotor {
    ResultMotor {
        velocity: [finite(limits[0]), finite(limits[1])],
        acceleration: [finite(limits[2]), finite(limits[3])],
        velocity_used: used[0],
        velocity_at_s: used[1],
        acceleration_used: used[2],
        acceleration_at_s: used[3],
    }
}

fn nearest(view: &ResponseView, record: &HoldRecord) -> Result<ResultNearest, WireError> {
    let hold = sections::hold(view, record)?;
    let time = |point: usize| {
        let ns = view.trajectory.times_ns.get(point);
        ns.map_or(0.0, |ns| *ns as f64 / 1e9)
    };
    let from_s = time(hold.segment);
    let to_s = time(hold.segment + 1).max(from_s);
    Ok(ResultNearest {
        time_s: from_s + hold.t * (to_s - from_s),
        requirement: hold.requirement,
        amount: hold.amount,
        points: hold.points.map(|point| point.to_array()),
        normal: hold.normal.to_array(),
    })
}
