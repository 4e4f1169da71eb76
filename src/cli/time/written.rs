//! A trajectory as ROS's JointTrajectory.

use std::fmt::Write;
use std::path::Path;

use serde_json::{Value, json};
use taut::timing::{Controller, Timed, TimedPoint};

use crate::cli::error::CliError;
use crate::cli::export::{Form, save};
use crate::cli::load::Loaded;

/// Nanoseconds of a second.
const NS: i64 = 1_000_000_000;

/// Writes a trajectory in the form that the file's ending says.
///
/// # Errors
/// Another ending, a file that cannot be written.
pub(super) fn write(file: &Path, loaded: &Loaded, timed: &Timed) -> Result<(), CliError> {
    let text = match Form::of(file)? {
        Form::Yaml => yaml(loaded, timed),
        Form::Json => format!("{}\n", message(loaded, timed)),
        Form::Csv | Form::Mcap => {
            let file = file.display();
            let text = format!("-o {file}: a trajectory is written as .yaml or .json");
            return Err(CliError::Usage(text));
        }
    };
    save(file, text.as_bytes())
}

/// Of the columns.
pub(super) fn names(loaded: &Loaded) -> Vec<&str> {
    let variables = loaded.robot.variables().iter();
    variables
        .map(|variable| variable.name.as_str())
        .collect()
}

/// The message, as JSON.
pub(super) fn message(loaded: &Loaded, timed: &Timed) -> Value {
    let points = timed.points.iter();
    json!({ "joint_names": names(loaded), "points": points.map(point).collect::<Vec<_>>() })
}

fn point(point: &TimedPoint) -> Value {
    let mut written = json!({
        "positions": point.positions,
        "time_from_start": { "sec": point.time_ns / NS, "nanosec": point.time_ns % NS },
    });
    for (what, list) in said(point) {
        written[what] = json!(list);
    }
    written
}

/// What a point says besides its positions: a controller that is told more, or less, goes another way.
fn said(point: &TimedPoint) -> impl Iterator<Item = (&'static str, &Vec<f64>)> {
    let all = [
        ("velocities", &point.velocities),
        ("accelerations", &point.accelerations),
    ];
    all.into_iter()
        .filter(|(_, list)| !list.is_empty())
}

/// The same with what is proved of it.
fn yaml(loaded: &Loaded, timed: &Timed) -> String {
    let goes = match timed.controller {
        Controller::Cubic => {
            "by cubics, as ros2_control's\n# joint_trajectory_controller does where points have velocities"
        }
        Controller::Quintic => {
            "by quintics, as ros2_control's\n# joint_trajectory_controller does where points have accelerations"
        }
        Controller::Linear { .. } => "straight",
    };
    let mut text = format!(
        "# {:.4} s. Proved as it stands, for controllers that go from point to point {goes}.\n",
        timed.duration_s()
    );
    let _ = writeln!(text, "joint_names: {}\npoints:", json!(names(loaded)));
    for point in &timed.points {
        let _ = writeln!(text, "  - positions: {}", json!(point.positions));
        for (what, list) in said(point) {
            let _ = writeln!(text, "    {what}: {}", json!(list));
        }
        let [sec, nanosec] = [point.time_ns / NS, point.time_ns % NS];
        let _ = writeln!(
            text,
            "    time_from_start: {{sec: {sec}, nanosec: {nanosec}}}"
        );
    }
    text
}
