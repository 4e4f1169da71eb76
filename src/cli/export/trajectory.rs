//! The trajectory of an answer, as ROS's JointTrajectory and as a motion.

use std::fmt::Write;

use serde_json::json;
use taut::files::ResultFile;
use taut::files::result::ResultTrajectory;
use taut::robot::RobotModel;
use taut::validation::timed::{Curve, Point};

/// Nanoseconds of a second.
const NS: i64 = 1_000_000_000;

/// The trajectory of an answer that has one.
pub(super) fn of(result: &ResultFile) -> Option<&ResultTrajectory> {
    result.times.as_ref()?.trajectory.as_deref()
}

/// ROS's JointTrajectory, as it is proved.
pub(super) fn yaml(result: &ResultFile, trajectory: &ResultTrajectory) -> String {
    let mut text = format!(
        "# {:.4} s. Proved as it stands, for controllers that go from point to point by {}.\n\
         joint_names: {}\npoints:\n",
        trajectory.duration_s,
        ways(trajectory),
        json!(result.variables)
    );
    for (point, ns) in trajectory.times_ns.iter().enumerate() {
        let _ = write!(
            text,
            "  - positions: {}",
            json!(trajectory.positions[point])
        );
        for (name, rows) in [
            ("velocities", &trajectory.velocities),
            ("accelerations", &trajectory.accelerations),
        ] {
            if let Some(row) = rows.get(point) {
                let _ = write!(text, "\n    {name}: {}", json!(row));
            }
        }
        let _ = writeln!(
            text,
            "\n    time_from_start: {{sec: {}, nanosec: {}}}",
            ns / NS,
            ns % NS
        );
    }
    text
}

/// What a controller must do between two points.
fn ways(trajectory: &ResultTrajectory) -> &'static str {
    match trajectory.controller.as_str() {
        "cubic" => {
            "cubics, as ros2_control's\n# joint_trajectory_controller does where points have positions and velocities"
        }
        "quintic" => {
            "quintics, as ros2_control's\n# joint_trajectory_controller does where points have accelerations too"
        }
        _ => "straight lines",
    }
}

/// What the controller makes of the points, columns in the robot's order; `None` of one that stands still.
pub(super) fn curve(
    trajectory: &ResultTrajectory,
    robot: &RobotModel,
    columns: &[usize],
) -> Option<Curve> {
    let row = |rows: &[Vec<f64>], point: usize| {
        let row = rows.get(point);
        row.map_or_else(Vec::new, |row| {
            columns
                .iter()
                .map(|&column| row[column])
                .collect()
        })
    };
    let times = trajectory.times_ns.iter().enumerate();
    let points: Vec<Point> = times
        .map(|(point, ns)| Point {
            time_s: *ns as f64 / NS as f64,
            positions: row(&trajectory.positions, point),
            velocities: row(&trajectory.velocities, point),
            accelerations: row(&trajectory.accelerations, point),
        })
        .collect();
    Curve::new(robot, &points).ok()
}

/// Where the robot is at a time (s).
pub(super) fn at(curve: &Curve, columns: usize, time_s: f64) -> Vec<f64> {
    let segments = 0..curve.segments();
    let segment = segments
        .rev()
        .find(|segment| curve.time(*segment) <= time_s)
        .unwrap_or_default();
    let after = (time_s - curve.time(segment)).clamp(0.0, curve.duration(segment));
    (0..columns)
        .map(|column| curve.column(segment, column).at(after))
        .collect()
}
