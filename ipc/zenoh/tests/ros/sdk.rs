//! A client that nobody here wrote: zenoh-ros2-sdk, from PyPI, calls the services.

use crate::cell::{Cell, of, project};
use crate::venv::{python, run, write_definitions};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;
use taut_ros::messages::moveit_msgs::{
    GetMotionPlan, GetMotionPlanRequest, GetMotionPlanResponse, PlanningScene,
};
use taut_ros::messages::trajectory_msgs::{JointTrajectory, JointTrajectoryPoint};
use taut_ros::{definition, definitions, message_hash, service_hash};

/// What the SDK needs: it would fetch what is missing from the net, and computes other hashes.
fn write_messages(folder: &Path) {
    write_definitions(folder, definitions::<GetMotionPlanRequest>());
    write_definitions(folder, definitions::<GetMotionPlanResponse>());
    write_definitions(folder, definitions::<PlanningScene>());
    let service = format!(
        "{}---\n{}",
        definition::<GetMotionPlanRequest>(),
        definition::<GetMotionPlanResponse>()
    );
    fs::write(folder.join("moveit_msgs/srv/GetMotionPlan.srv"), service).unwrap();
}

/// Runs the client; gives what it prints, a line of JSON for each thing that it did.
fn ran(python: &Path, cell: &Cell, problem: &str) -> Vec<Value> {
    let messages = tempfile::tempdir().unwrap();
    write_messages(messages.path());
    let printed = run(Command::new(python)
        .arg(project().join("ipc/zenoh/tests/ros/sdk.py"))
        .arg(messages.path())
        .arg(cell.endpoint.rsplit(':').next().unwrap())
        .arg(service_hash::<GetMotionPlan>())
        .arg(message_hash::<PlanningScene>())
        .arg(project().join(format!("config/problems/{problem}.json")))
        // The SDK keeps what it fetches in the home.
        .env("HOME", messages.path()));
    printed
        .unwrap_or_else(|error| panic!("{error}"))
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

fn shorter(line: &Value) -> JointTrajectory {
    let rows: Vec<Vec<f64>> = serde_json::from_value(line["points"].clone()).unwrap();
    JointTrajectory {
        joint_names: serde_json::from_value(line["names"].clone()).unwrap(),
        points: rows
            .into_iter()
            .map(|positions| JointTrajectoryPoint {
                positions,
                ..JointTrajectoryPoint::default()
            })
            .collect(),
        ..JointTrajectory::default()
    }
}

/// The sum of a path's steps.
fn length(path: &[Value]) -> f64 {
    let row = |row: &Value| -> Vec<f64> { serde_json::from_value(row.clone()).unwrap() };
    let step = |pair: &[Value]| {
        let (from, to) = (row(&pair[0]), row(&pair[1]));
        let squares = from
            .iter()
            .zip(&to)
            .map(|(a, b)| (a - b).powi(2));
        squares.sum::<f64>().sqrt()
    };
    path.windows(2).map(step).sum()
}

/// Codes and texts of what the client asked: a shorter path that taut's own check then proves; then a
/// PlanningScene that it publishes stands in the way, and goes.
#[test]
fn the_sdk_gets_shorter_paths_and_changes_the_verdict() {
    let Some(python) = python() else {
        return;
    };
    for problem in ["corner", "arm_shelf", "arm_window", "slalom"] {
        let Some(cell) = Cell::with(problem, |options| options.follows = true) else {
            return;
        };
        let lines = ran(&python, &cell, problem);
        let codes: Vec<i64> = lines
            .iter()
            .map(|line| line["code"].as_i64().unwrap())
            .collect();
        assert_eq!(codes[0], 1, "{problem}: {lines:?}");
        let (given, points) = (&lines[0]["given"], &lines[0]["points"]);
        let [before, after] = [given, points].map(|path| length(path.as_array().unwrap()));
        println!("{problem}: {before:.3} → {after:.3}, {}", lines[0]["ms"]);
        assert!(after < 0.95 * before, "{problem}: {before} → {after}");
        assert_eq!(codes[1..], [-10, 1], "{problem}: {lines:?}");
        let text = lines[1]["message"].as_str().unwrap();
        assert!(text.contains("everywhere"), "{text}");
        let (verdict, text) = cell.verdict(&of(shorter(&lines[0])));
        assert_eq!(verdict, 1, "{problem}: {text}");
    }
}
