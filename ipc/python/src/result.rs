//! Answers as result files.

use pyo3::prelude::*;
use std::path::Path as FilePath;
use taut::constraint::ConstraintsFile;
use taut::files::ResultFile;
use taut::files::result::{ResultSubject, RobotSource, SceneSource};
use taut::translate;
use taut_ipc::control::RobotDescription;
use taut_ipc::planner::{Best, EMPTY_SCENE, PlannerError, Request};
use taut_ipc::wire::Code;

use super::about::About;
use super::errors;

/// What an answer says, with its own path in the robot's columns.
fn result(
    about: &About,
    best: &Best,
    time_s: f64,
) -> PyResult<(ResultFile, std::sync::Arc<RobotDescription>)> {
    let request = &about.request;
    let robot = about
        .planner
        .get()?
        .robot(&request.robot)
        .map_err(|error| errors::of(&error))?;
    let view = best
        .view()
        .map_err(|error| errors::of(&PlannerError::from(error)))?;
    let (outcome, code) = translate::outcome(&view, request, &robot)
        .map_err(|error| errors::raise(Code::MalformedRequest, &error.to_string()))?;
    let warnings = best
        .warnings()
        .map_err(|error| errors::of(&PlannerError::from(error)))?;
    let corridor = outcome.corridor.as_ref();
    let corridor =
        corridor.map(|corridor| translate::result_corridor(corridor, &robot, request.unwrapped));
    let result = ResultFile {
        name: request.robot.clone(),
        mode: request.mode.name().to_owned(),
        geometry: "loaded".to_owned(),
        code: code.into(),
        code_name: code.name().to_owned(),
        metric: metric(request).to_owned(),
        request_id: Some(format!("{:016x}", view.header.request_id)),
        cpu_s: view.header.compute_ns as f64 * 1e-9,
        time_s,
        variables: robot
            .variables
            .iter()
            .map(|variable| variable.name.clone())
            .collect(),
        warnings: warnings
            .iter()
            .map(|warning| warning.text.clone())
            .collect(),
        uncovered: warnings
            .iter()
            .filter(|warning| warning.is_uncovered)
            .map(|warning| warning.text.clone())
            .collect(),
        corridor,
        times: translate::result_times(&view, &robot)
            .map_err(|error| errors::of(&PlannerError::from(error)))?,
        // What was answered to could be read.
        path_constraints: ConstraintsFile::parse(&request.constraints)
            .map_err(|error| errors::invalid(error.to_string()))?,
        ..ResultFile::of(&outcome)
    };
    Ok((result, robot))
}

fn metric(request: &Request) -> &'static str {
    if request.metric.is_empty() {
        "metres of reach"
    } else {
        "the given weights"
    }
}

/// All of it but the paths, the trajectory and the proof, as JSON.
pub fn details(about: &About, best: &Best, time_s: f64) -> PyResult<String> {
    let (mut result, _) = result(about, best, time_s)?;
    result.path = Vec::new();
    result.certificate = None;
    result.times = None;
    Ok(result.json())
}

/// Writes the file that `taut view` shows and `taut verify` takes.
pub fn save(
    about: &About,
    best: &Best,
    time_s: f64,
    file: &FilePath,
    path_before: &[f64],
    lengths_over_time: Vec<(f64, f64)>,
) -> PyResult<()> {
    let (result, robot) = result(about, best, time_s)?;
    let request = &about.request;
    let columns = request
        .columns_of(&robot)
        .map_err(|error| errors::of(&error))?;
    let mut before = vec![0.0; path_before.len() / columns.width().max(1) * columns.robot_width()];
    columns.write(path_before, &mut before);
    let result = ResultFile {
        path_before: before
            .chunks_exact(columns.robot_width().max(1))
            .map(<[f64]>::to_vec)
            .collect(),
        lengths_over_time,
        subject: subject(about, best, &robot)?,
        ..result
    };
    std::fs::write(file, result.json() + "\n")?;
    Ok(())
}

fn subject(about: &About, best: &Best, robot: &RobotDescription) -> PyResult<ResultSubject> {
    let request = &about.request;
    let header = best.header();
    let scene = request.scene.as_deref().unwrap_or(EMPTY_SCENE);
    let text = about
        .planner
        .get()?
        .show_scene(scene, header.scene_version, 0);
    let content = match text {
        Ok(text) => serde_json::from_str(&text.json).ok(),
        // It is not kept any more; the file says so.
        Err(PlannerError::Refused(_)) => None,
        Err(error) => return Err(errors::of(&error)),
    };
    let is_held = |name: &str| {
        robot
            .held_variables
            .iter()
            .any(|held| held == name)
    };
    Ok(ResultSubject {
        robot: RobotSource {
            label: Some(robot.label.clone()),
            hash: format!("{:016x}", header.robot_hash),
            files: about.files.of(header.robot_hash),
        },
        scene: SceneSource {
            label: Some(scene.to_owned()),
            version: Some(header.scene_version),
            hash: format!("{:016x}", header.scene_hash),
            file: None,
            content,
        },
        unwrapped: request.unwrapped,
        held: request
            .held
            .iter()
            .filter(|(name, _)| is_held(name))
            .cloned()
            .collect(),
    })
}
