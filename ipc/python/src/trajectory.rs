//! The trajectory of an answer, for `taut._timing`.

use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use taut_ipc::control::RobotDescription;
use taut_ipc::planner::{Request, Trajectory};

/// Names of a request's columns.
pub fn names(request: &Request, robot: &RobotDescription) -> Vec<String> {
    let variables = robot.variables.iter();
    match request.columns.is_empty() {
        true => variables
            .map(|variable| variable.name.clone())
            .collect(),
        false => request.columns.clone(),
    }
}

/// What `trajectory_of` takes.
pub fn dict<'py>(
    py: Python<'py>,
    trajectory: &Trajectory,
    names: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    let decides = trajectory
        .decides
        .and_then(|column| names.get(column).cloned());
    dict.set_item("times_ns", PyArray1::from_slice(py, &trajectory.times_ns))?;
    dict.set_item("positions", table(py, trajectory, &trajectory.positions)?)?;
    dict.set_item("velocities", table(py, trajectory, &trajectory.velocities)?)?;
    dict.set_item(
        "accelerations",
        table(py, trajectory, &trajectory.accelerations)?,
    )?;
    dict.set_item("controller", trajectory.controller.name())?;
    let rate = Some(trajectory.rate_hz).filter(|rate_hz| *rate_hz > 0.0);
    dict.set_item("rate", rate)?;
    dict.set_item("duration", trajectory.duration_s())?;
    dict.set_item("bound", trajectory.bound_s)?;
    dict.set_item("gap", trajectory.gap())?;
    dict.set_item("decides", decides)?;
    dict.set_item("stops", trajectory.stops_s)?;
    dict.set_item("stage", trajectory.stage.name())?;
    dict.set_item("clearance", trajectory.clearance_m)?;
    dict.set_item("motors", motors(trajectory))?;
    dict.set_item("nearest", nearest(py, trajectory)?)?;
    dict.set_item("joint_names", names)?;
    Ok(dict)
}

/// An array with a row for each point; `None` where the controller goes without.
fn table<'py>(
    py: Python<'py>,
    trajectory: &Trajectory,
    numbers: &[f64],
) -> PyResult<Option<Bound<'py, PyAny>>> {
    if numbers.is_empty() {
        return Ok(None);
    }
    let shape = [trajectory.points(), trajectory.columns];
    let array = PyArray1::from_slice(py, numbers).reshape(shape)?;
    Ok(Some(array.into_any()))
}

type Motor = ((f64, f64), (f64, f64), f64, f64, f64, f64);

fn motors(trajectory: &Trajectory) -> Vec<Motor> {
    let own = trajectory.limits.iter().zip(&trajectory.used);
    own.map(|(limits, used)| {
        (
            (limits[0], limits[1]),
            (limits[2], limits[3]),
            used.velocity,
            used.velocity_time_s,
            used.acceleration,
            used.acceleration_time_s,
        )
    })
    .collect()
}

fn nearest<'py>(py: Python<'py>, trajectory: &Trajectory) -> PyResult<Option<Bound<'py, PyTuple>>> {
    let Some(nearest) = &trajectory.nearest else {
        return Ok(None);
    };
    let points = nearest.points.map(|[x, y, z]| (x, y, z));
    let names = PyTuple::new(py, &nearest.names)?;
    let points = PyTuple::new(py, points)?;
    (nearest.time_s, names, nearest.distance_m, points)
        .into_pyobject(py)
        .map(Some)
}
