//! A trajectory as ROS's JointTrajectory.

use std::fmt::Write;
use std::path::Path;

use serde_json::{Value, json};
use taut::timing::{Timed, TimedPoint};

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

fn names(loaded: &Loaded) -> Vec<&str> {
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

fn point(state: &TimedPoint) -> Value {
    json!({
        "positions": state.positions,
        "velocities": state.velocities,
        "time_from_start": { "sec": state.time_ns / NS, "nanosec": state.time_ns % NS },
    })
}

/// The same with what is proved of it. There are no accelerations: a controller that had them would go
/// another way between the points.
fn yaml(loaded: &Loaded, timed: &Timed) -> String {
    let mut text = format!(
        "# {:.4} s. Proved as it stands, for controllers that go from point to point by cubics, as ros2_control's\n\
         # joint_trajectory_controller does where points have positions and velocities.\n",
        timed.duration_s()
    );
    let _ = writeln!(text, "joint_names: {}\npoints:", json!(names(loaded)));
    for state in &timed.points {
        let _ = writeln!(
            text,
            "  - positions: {}\n    velocities: {}\n    time_from_start: {{sec: {}, nanosec: {}}}",
            json!(state.positions),
            json!(state.velocities),
            state.time_ns / NS,
            state.time_ns % NS
        );
    }
    text
}
