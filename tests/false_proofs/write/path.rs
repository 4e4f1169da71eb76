//! Paths as CSV, JSON, YAML trajectories, and as a request with a constraint.

use serde_json::json;

use crate::make::path::Constraint;
use crate::robot::Robot;

/// A path's text, and the ending of its file's name.
pub fn path(robot: &Robot, rows: &[Vec<f64>], whim: usize) -> (String, &'static str) {
    let names: Vec<String> = robot
        .columns
        .iter()
        .map(|column| robot.name_of(*column))
        .collect();
    match whim % 4 {
        0 => {
            let points = rows.iter().map(
                |row| json!({ "positions": row, "time_from_start": { "sec": 0, "nanosec": 0 } }),
            );
            (
                json!({ "joint_names": names, "points": points.collect::<Vec<_>>() }).to_string(),
                "yaml",
            )
        }
        1 => (
            json!({ "variables": names, "path": rows }).to_string(),
            "json",
        ),
        _ => {
            let line = |row: &Vec<f64>| {
                row.iter()
                    .map(f64::to_string)
                    .collect::<Vec<_>>()
                    .join(",")
                    + "\n"
            };
            (
                names.join(",") + "\n" + &rows.iter().map(line).collect::<String>(),
                "csv",
            )
        }
    }
}

/// A motion plan request as YAML: from the first row to the last, and a column that must stay where
/// it starts.
pub fn request(robot: &Robot, rows: &[Vec<f64>], kept: Constraint) -> String {
    let names: Vec<String> = robot
        .columns
        .iter()
        .map(|column| robot.name_of(*column))
        .collect();
    let from = &rows[0];
    let to = &rows[rows.len() - 1];
    let constraint = |q: usize, at: f64, tolerance: f64| json!({ "joint_name": names[q], "position": at, "tolerance_above": tolerance, "tolerance_below": tolerance, "weight": 1.0 });
    let goal: Vec<_> = (0..names.len())
        .map(|q| constraint(q, to[q], 1e-3))
        .collect();
    json!({
        "start_state": { "joint_state": { "name": names, "position": from } },
        "goal_constraints": [{ "joint_constraints": goal }],
        "path_constraints": { "name": "kept", "joint_constraints": [constraint(kept.column, from[kept.column], kept.tolerance)] },
        "group_name": "all",
    })
    .to_string()
}
