//! A bare path for a robot and a scene that the daemon has loaded.

use std::path::Path as FilePath;
use std::sync::Arc;

use taut::constraint::ConstraintsFile;
use taut::files::{FileError, PathTable};
use taut::path::Path;
use taut::robot::Variable;
use taut::warning::Warning;
use taut_ipc::control::{ControlRequest, RobotDescription, SceneSummary, VariableDescription};
use taut_ipc::planner::{Columns, Planner};
use taut_ipc::wire::Code;

use super::error::CliError;
use super::subject::Subject;

/// What was read.
pub(super) struct Labelled {
    /// What the report says about it.
    pub subject: Subject,
    /// The robot, of the path's columns only.
    pub robot: Arc<RobotDescription>,
    /// The scene.
    pub scene: SceneSummary,
    /// The path.
    pub path: Path,
    /// What its file asks it to keep besides clearance.
    pub constraints: ConstraintsFile,
}

/// Reads a path whose columns are some of those of a robot.
///
/// # Errors
/// A file that is no such path, labels that name nothing.
pub(super) fn read(
    planner: &Planner,
    file: &FilePath,
    label: &str,
    scene: Option<&FilePath>,
    held: &[(String, f64)],
) -> Result<Labelled, CliError> {
    let whole = planner.robot(label)?;
    let scene = scene_named(planner, scene)?;
    let table = PathTable::read(file)?.for_variables(&variables_of(&whole), &whole.fixed_joints)?;
    let columns = columns_of(&table, file, &whole, held)?;
    let robot = match columns.width() < columns.robot_width() {
        true => selected(planner, label, table.variables())?,
        false => whole,
    };
    table.check_held(where_held(&robot, held))?;
    let notes = notes_of(&columns, &table);
    let (path, constraints) = table.into_path(&variables_of(&robot))?;
    let name = file
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy();
    Ok(Labelled {
        subject: Subject::of_labels(name.into_owned(), &robot, &path, notes),
        robot,
        scene,
        path,
        constraints,
    })
}

fn columns_of(
    table: &PathTable,
    file: &FilePath,
    robot: &RobotDescription,
    held: &[(String, f64)],
) -> Result<Columns, FileError> {
    Columns::new(&robot.variables, table.variables(), held)
        .map_err(|error| FileError::content(file, error.to_string()))
}

fn notes_of(columns: &Columns, table: &PathTable) -> Vec<Warning> {
    let uncovered = columns.note().map(Warning::uncovered);
    uncovered
        .into_iter()
        .chain(table.warnings().iter().cloned())
        .collect()
}

fn scene_named(planner: &Planner, name: Option<&FilePath>) -> Result<SceneSummary, CliError> {
    match name {
        Some(name) => scene(planner, &name.to_string_lossy()),
        None => scene(planner, planner.empty_scene()?),
    }
}

/// A scene that is loaded.
///
/// # Errors
/// An unknown label, with those that are loaded.
pub(super) fn scene(planner: &Planner, label: &str) -> Result<SceneSummary, CliError> {
    let scenes = planner.list()?.scenes;
    let known = scenes.iter().find(|scene| scene.label == label);
    known
        .cloned()
        .ok_or_else(|| not_loaded(label, &scenes))
}

fn not_loaded(label: &str, scenes: &[SceneSummary]) -> CliError {
    let known = labels_of(scenes).join(", ");
    let text = format!("no scene {label:?} is loaded; loaded: {known}");
    CliError::refused(Code::UnknownScene, text)
}

fn labels_of(scenes: &[SceneSummary]) -> Vec<&str> {
    let labels = scenes.iter().map(|scene| &*scene.label);
    labels.collect()
}

/// The robot of a label with these columns only: as for a file, joints without a column are held,
/// and what only they move is built so.
fn selected(
    planner: &Planner,
    label: &str,
    variables: &[String],
) -> Result<Arc<RobotDescription>, CliError> {
    Ok(planner.robot_after(&ControlRequest::SelectVariables {
        label: label.to_owned(),
        variables: variables.to_vec(),
    })?)
}

fn variables_of(robot: &RobotDescription) -> Vec<Variable> {
    let variable = |v: &VariableDescription| Variable::within(&v.name, v.lower, v.upper);
    robot.variables.iter().map(variable).collect()
}

/// Where each held joint stands.
fn where_held<'a>(
    robot: &'a RobotDescription,
    held: &'a [(String, f64)],
) -> impl Iterator<Item = (&'a str, f64)> {
    let names = robot.held_variables.iter().map(String::as_str);
    let given = |name: &str| {
        held.iter()
            .rev()
            .find(|(known, _)| known == name)
    };
    names
        .zip(robot.held_values.iter().copied())
        .map(move |(name, value)| (name, given(name).map_or(value, |(_, value)| *value)))
}
