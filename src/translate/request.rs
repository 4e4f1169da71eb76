//! From a request on the wire to settings and a path.

use std::sync::Arc;

use super::number;
use super::timing::{Timing, timing};
use crate::constraint::{ConstraintError, ConstraintsFile};
use crate::optimize::{RequestError, Settings};
use crate::path::Path;
use crate::robot::{Component, RobotModel};
use crate::store::{Snapshot, Wanted};
use taut_ipc::control::Refusal;
use taut_ipc::limits::{MAX_CONSTRAINED, MAX_TEXT};
use taut_ipc::wire::{Code, NO_GROUP, RequestHeader, RequestView, label_id};

/// What a request wants to be computed with.
pub fn wanted(header: &RequestHeader) -> Wanted {
    Wanted {
        robot_id: header.robot_id,
        robot_hash: header.robot_hash,
        scene_id: header.scene_id,
        scene_hash: header.scene_hash,
        scene_version: header.scene_version,
    }
}

/// Whatever robot and scene have these labels.
pub fn wanted_newest(robot: &str, scene: &str) -> Wanted {
    Wanted {
        robot_id: label_id(robot),
        scene_id: label_id(scene),
        ..Wanted::default()
    }
}

/// Whether the request is made for the columns that the robot has: by position they would be
/// silently wrong for another maker's robot of the same name.
///
/// # Errors
/// The refusal.
pub fn check_layout(header: &RequestHeader, snapshot: &Snapshot) -> Result<(), Refusal> {
    let robot = &snapshot.robot;
    match header.layout_hash == robot.layout_hash() {
        true => Ok(()),
        false => Err(other_layout(header.layout_hash, robot)),
    }
}

fn other_layout(given: u64, robot: &RobotModel) -> Refusal {
    let text = format!(
        "the request has layout hash {given:016x}, the robot {:016x}: columns {}; describe the robot and send in its order",
        robot.layout_hash(),
        columns(robot)
    );
    Refusal::new(Code::InvalidRobotState, text)
}

/// A request as it is computed.
#[derive(Clone)]
pub struct Question {
    /// How its path is made shorter.
    pub settings: Arc<Settings>,
    /// The path.
    pub path: Arc<Path>,
    /// What its times are to be, where it asks for them.
    pub timing: Option<Arc<Timing>>,
}

/// Copies a request out of shared memory, once, and translates the copy. The path's numbers are not
/// checked yet; the core does that.
///
/// # Errors
/// A refusal with the bad value and the valid ones.
pub fn question(
    view: &RequestView,
    snapshot: &Snapshot,
    default_clearance_m: f64,
) -> Result<Question, Refusal> {
    let path = path(view, &snapshot.robot)?;
    let constraints = constraints(view, snapshot, &path)?;
    check_size(&constraints, path.len())?;
    let settings = Settings {
        constraints,
        ..settings(view, snapshot, default_clearance_m)?
    };
    Ok(Question {
        timing: timing(view.timing, snapshot, &settings, &path)?,
        settings: Arc::new(settings),
        path: Arc::new(path),
    })
}

fn path(view: &RequestView, robot: &RobotModel) -> Result<Path, Refusal> {
    let nq = robot.space().nq();
    let given = view.header.variables;
    if given as usize != nq {
        return Err(other_width(given, robot));
    }
    Path::from_rows(nq, view.path.to_vec()).ok_or_else(|| {
        let text = "the path is empty; it needs a waypoint";
        Refusal::new(Code::MalformedRequest, text)
    })
}

/// What the path must keep besides clearance, with directions as they are where it starts.
fn constraints(
    view: &RequestView,
    snapshot: &Snapshot,
    path: &Path,
) -> Result<ConstraintsFile, Refusal> {
    let Snapshot { robot, scene, .. } = snapshot;
    let defaults = robot.held().iter();
    let held = listed(view.held_values).unwrap_or_else(|| {
        defaults
            .map(|variable| variable.default)
            .collect()
    });
    if held.len() != robot.held().len() {
        return ConstraintsFile::parse(view.constraints).map_err(constraint_refusal);
    }
    ConstraintsFile::parse(view.constraints)
        .and_then(|text| text.started(robot, scene, path.waypoint(0), &held))
        .map_err(constraint_refusal)
}

/// An answer has to have room for what it claims of constraints.
fn check_size(constraints: &ConstraintsFile, waypoints: usize) -> Result<(), Refusal> {
    let refuse = |text: String| Err(Refusal::new(Code::ResourceExhausted, text));
    let bytes = constraints.text().len();
    let count = constraints.most();
    if bytes > MAX_TEXT {
        return refuse(format!(
            "constraints of {bytes} bytes as MoveIt's messages; at most {MAX_TEXT}: ask for fewer"
        ));
    }
    if waypoints * count > MAX_CONSTRAINED {
        return refuse(format!(
            "{waypoints} waypoints with {count} constraints each; at most {MAX_CONSTRAINED} together: split the path or ask for fewer"
        ));
    }
    Ok(())
}

fn constraint_refusal(error: ConstraintError) -> Refusal {
    request_refusal(&RequestError::Constraint(error))
}

fn other_width(given: u32, robot: &RobotModel) -> Refusal {
    let text = format!(
        "the path has {given} columns, the robot has {}: {}",
        robot.space().nq(),
        columns(robot)
    );
    Refusal::new(Code::InvalidRobotState, text)
}

fn columns(robot: &RobotModel) -> String {
    let variables = robot.variables().iter();
    let names: Vec<&str> = variables
        .map(|variable| variable.name.as_str())
        .collect();
    names.join(", ")
}

fn listed(numbers: &[f64]) -> Option<Vec<f64>> {
    (!numbers.is_empty()).then(|| numbers.to_vec())
}

/// What each option of the header and each section is to the core.
fn settings(
    view: &RequestView,
    snapshot: &Snapshot,
    default_clearance_m: f64,
) -> Result<Settings, Refusal> {
    let header = &view.header;
    Ok(Settings {
        mode: number::mode(view.mode),
        seed: header.seed,
        clearance_m: match header.clearance_m {
            0.0 => default_clearance_m,
            metres => metres,
        },
        strict: header.strict(),
        unwrapped: header.unwrapped(),
        keep_goal: header.keep_goal(),
        // Given here so that the core need not work them out for each request.
        weights: listed(view.weights).or_else(|| Some(snapshot.weights.to_vec())),
        work_budget: header.work_budget,
        fixed_waypoints: mask("fixed_waypoints", view.fixed_waypoints)?,
        moving: moving(view, &snapshot.robot)?,
        held: listed(view.held_values),
        corridor: header.corridor(),
        contacts: header.contacts(),
        ..Settings::default()
    })
}

/// A mask of the wire, or none where it is absent.
fn mask(name: &str, bytes: &[u8]) -> Result<Option<Vec<bool>>, Refusal> {
    if bytes.is_empty() {
        return Ok(None);
    }
    let entries = bytes.iter().enumerate();
    entries
        .map(|(index, byte)| entry(name, index, *byte))
        .collect::<Result<_, _>>()
        .map(Some)
}

/// An entry of the mask of that name.
fn entry(name: &str, index: usize, byte: u8) -> Result<bool, Refusal> {
    match byte {
        0 => Ok(false),
        1 => Ok(true),
        other => {
            let text = format!("section {name} has {other} at entry {index}; valid: 0, 1");
            Err(Refusal::new(Code::MalformedRequest, text))
        }
    }
}

/// Which velocity coordinates may move: the mask of variables, else the group, else all.
fn moving(view: &RequestView, robot: &RobotModel) -> Result<Option<Vec<bool>>, Refusal> {
    if let Some(columns) = mask("group_mask", view.group_mask)? {
        return coordinates(robot, &columns).map(Some);
    }
    match view.header.group {
        NO_GROUP => Ok(None),
        group => of_group(robot, group).map(Some),
    }
}

/// What a group moves.
fn of_group(robot: &RobotModel, group: u32) -> Result<Vec<bool>, Refusal> {
    match robot.groups().get(group as usize) {
        Some((_, moving)) => Ok(moving.clone()),
        None => Err(Refusal::new(
            Code::InvalidGroupName,
            format!("the robot has no group {group}; valid: {}", groups(robot)),
        )),
    }
}

/// The groups by name and number.
fn groups(robot: &RobotModel) -> String {
    let groups = robot.groups().iter().enumerate();
    let names: Vec<String> = groups
        .map(|(i, (name, _))| format!("{name} {i}"))
        .collect();
    match names.is_empty() {
        true => "none".to_owned(),
        false => names.join(", "),
    }
}

/// A mask of columns as one of velocity coordinates.
fn coordinates(robot: &RobotModel, columns: &[bool]) -> Result<Vec<bool>, Refusal> {
    let mut moving = vec![false; robot.space().nv()];
    for component in robot.space().components() {
        match *component {
            Component::Line { q, v } | Component::Circle { q, v } => moving[v] = columns[q],
            Component::Rotation { q, v } => {
                if columns[q..q + 4]
                    .iter()
                    .any(|column| *column != columns[q])
                {
                    return Err(split_quaternion(robot, q));
                }
                moving[v..v + 3].fill(columns[q]);
            }
        }
    }
    Ok(moving)
}

fn split_quaternion(robot: &RobotModel, q: usize) -> Refusal {
    let name = &robot.variables()[q].name;
    let text =
        format!("group_mask splits the quaternion that starts at {name}; its four move together");
    Refusal::new(Code::MalformedRequest, text)
}

/// The refusal of a request that the core cannot compute.
pub fn request_refusal(error: &RequestError) -> Refusal {
    let code = match error {
        RequestError::Constraint(_) => Code::InvalidConstraint,
        RequestError::WithConstraints { .. }
        | RequestError::Metric(_)
        | RequestError::Count { .. }
        | RequestError::Clearance(_) => Code::MalformedRequest,
        _ => Code::InvalidRobotState,
    };
    Refusal::new(code, error.to_string())
}
