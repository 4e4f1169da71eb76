//! Robots and scenes: what clients say about them, and what they are told.

use std::collections::BTreeSet;
use std::path::PathBuf;

use crate::collision::{CollisionModelError, check_frames};
use crate::files::result::texts;
use crate::files::{FileError, RobotFiles, RootJoint};
use crate::robot::{Component, JointKind, RobotModel, VirtualJoint};
use crate::scene::diff_file::SceneDiff;
use crate::scene::{Scene, SceneError};
use crate::store::{ModelStore, RobotEntry, SceneEntry, StoreError};
use crate::warning;
use crate::warning::Warning;
use taut_ipc::control::{
    self, GroupDescription, Refusal, RobotDescription, RobotSource, RobotSummary, SceneSummary,
    VariableDescription, VirtualJointKind,
};
use taut_ipc::wire::Code;

/// The files of a robot as a control message names them.
pub fn robot_files(source: RobotSource) -> RobotFiles {
    let mut allowed_collisions = source.allowed_collisions;
    let urdf = match source.spherized_urdf {
        None => source.urdf,
        Some(spheres) => {
            allowed_collisions.extend(source.spherized_allowed_collisions);
            spheres
        }
    };
    RobotFiles {
        urdf,
        srdf: source.srdf,
        packages: source.packages,
        root: source.virtual_joint.map_or(RootJoint::OfSrdf, root_joint),
        variables: Some(source.variables).filter(|variables| !variables.is_empty()),
        allowed_collisions,
    }
}

fn root_joint(joint: control::VirtualJoint) -> RootJoint {
    let kind = match joint.kind {
        VirtualJointKind::Fixed if joint.name.is_empty() => return RootJoint::Given(None),
        VirtualJointKind::Fixed => JointKind::Fixed,
        VirtualJointKind::Planar => JointKind::Planar,
        VirtualJointKind::Floating => JointKind::Floating,
    };
    RootJoint::Given(Some(VirtualJoint {
        name: joint.name,
        kind,
        position_bounds: joint.position_bounds,
        parent_frame: joint.parent_frame,
    }))
}

/// The control message's part that names these files; relative names are made absolute.
pub fn robot_source(files: &RobotFiles) -> RobotSource {
    let absolute = |path: &PathBuf| std::path::absolute(path).unwrap_or_else(|_| path.clone());
    RobotSource {
        urdf: absolute(&files.urdf),
        srdf: files.srdf.as_ref().map(absolute),
        packages: files
            .packages
            .iter()
            .map(|(name, folder)| (name.clone(), absolute(folder)))
            .collect(),
        virtual_joint: match &files.root {
            RootJoint::OfSrdf => None,
            RootJoint::Given(joint) => Some(virtual_joint(joint.as_ref())),
        },
        variables: files.variables.clone().unwrap_or_default(),
        allowed_collisions: files.allowed_collisions.clone(),
        ..RobotSource::default()
    }
}

fn virtual_joint(joint: Option<&VirtualJoint>) -> control::VirtualJoint {
    let kind = match joint.map(|joint| joint.kind) {
        Some(JointKind::Planar) => VirtualJointKind::Planar,
        Some(JointKind::Floating) => VirtualJointKind::Floating,
        _ => VirtualJointKind::Fixed,
    };
    control::VirtualJoint {
        name: joint.map(|joint| joint.name.clone()).unwrap_or_default(),
        kind,
        parent_frame: joint
            .map(|joint| joint.parent_frame.clone())
            .unwrap_or_default(),
        position_bounds: joint
            .map(|joint| joint.position_bounds.clone())
            .unwrap_or_default(),
    }
}

/// What a client has to know of a robot.
pub fn describe(label: &str, entry: &RobotEntry) -> RobotDescription {
    let robot = &entry.robot;
    RobotDescription {
        label: label.to_owned(),
        robot_id: entry.id,
        robot_hash: robot.hash(),
        layout_hash: robot.layout_hash(),
        variables: variables(robot),
        held_variables: robot
            .held()
            .iter()
            .map(|variable| variable.name.clone())
            .collect(),
        held_values: robot
            .held()
            .iter()
            .map(|variable| variable.default)
            .collect(),
        fixed_joints: fixed_joints(robot),
        groups: robot
            .groups()
            .iter()
            .map(|(name, moving)| group(robot, name, moving))
            .collect(),
        nq: robot.space().nq() as u32,
        nv: robot.space().nv() as u32,
        weights: entry.weights.to_vec(),
        warnings: texts(&warning::told(robot.warnings()), |_| true),
    }
}

fn fixed_joints(robot: &RobotModel) -> Vec<String> {
    // Joint 0 holds the root in the world; it is nobody's but ours.
    let fixed = robot
        .joints()
        .iter()
        .skip(1)
        .filter(|joint| joint.kind == JointKind::Fixed);
    fixed.map(|joint| joint.name.clone()).collect()
}

fn variables(robot: &RobotModel) -> Vec<VariableDescription> {
    let described = |variable: &crate::robot::Variable| VariableDescription {
        name: variable.name.clone(),
        lower: variable.lower,
        upper: variable.upper,
        ..VariableDescription::default()
    };
    let mut variables: Vec<_> = robot.variables().iter().map(described).collect();
    for component in robot.space().components() {
        let (columns, first, coordinates) = match *component {
            Component::Line { q, v } | Component::Circle { q, v } => (q..q + 1, v, 1),
            Component::Rotation { q, v } => (q..q + 4, v, 3),
        };
        for variable in &mut variables[columns] {
            variable.continuous = matches!(component, Component::Circle { .. });
            variable.coordinate = first as u32;
            variable.coordinates = coordinates;
        }
    }
    variables
}

fn group(robot: &RobotModel, name: &str, moving: &[bool]) -> GroupDescription {
    let mut variables = Vec::new();
    for component in robot.space().components() {
        match *component {
            Component::Line { q, v } | Component::Circle { q, v } if moving[v] => {
                variables.push(q as u32)
            }
            Component::Rotation { q, v } if moving[v] => variables.extend(q as u32..q as u32 + 4),
            _ => {}
        }
    }
    GroupDescription {
        name: name.to_owned(),
        variables,
    }
}

/// A robot in a listing.
pub fn robot_summary(label: &str, entry: &RobotEntry) -> RobotSummary {
    let nq = entry.robot.space().nq() as u32;
    RobotSummary {
        label: label.to_owned(),
        robot_id: entry.id,
        robot_hash: entry.robot.hash(),
        nq,
    }
}

/// A scene in a listing.
pub fn scene_summary(label: &str, entry: &SceneEntry) -> SceneSummary {
    let worlds = entry.scene.worlds().map(|(id, frame)| {
        let text = format!("object {id:?}: its frame {frame:?} is none of the scene's");
        Warning::uncovered(format!("{text}; robots in it have to call the world so"))
    });
    let warnings: Vec<Warning> = entry
        .scene
        .warnings()
        .iter()
        .cloned()
        .chain(worlds)
        .collect();
    let warnings = texts(&warning::told(&warnings), |_| true);
    SceneSummary {
        warnings,
        ..scene_state(label, entry)
    }
}

/// The same without a look at what is odd about its objects.
pub fn scene_state(label: &str, entry: &SceneEntry) -> SceneSummary {
    SceneSummary {
        label: label.to_owned(),
        scene_id: entry.id,
        scene_hash: entry.scene.hash(),
        version: entry.version,
        objects: (entry.scene.obstacles().len() + entry.scene.attached().len()) as u32,
        warnings: Vec::new(),
        kept_from: entry.kept_from(),
        pinned: entry.pinned().iter().copied().collect(),
    }
}

/// The refusal of what the store refuses.
pub fn store_refusal(error: &StoreError) -> Refusal {
    let code = match error {
        StoreError::LabelTaken { .. } | StoreError::SameId { .. } => Code::LabelTaken,
        StoreError::UnknownRobot { .. } => Code::UnknownRobot,
        StoreError::UnknownScene { .. } => Code::UnknownScene,
        StoreError::TooManyPinned { .. } => Code::ResourceExhausted,
        _ => Code::VersionConflict,
    };
    Refusal::new(code, error.to_string())
}

/// The refusal of a diff that names a link which no loaded robot has, or what is neither such a
/// link nor an object of the scene that the diff makes. Where no robot is loaded, nothing is known
/// of links.
///
/// # Errors
/// The refusal.
pub fn name_refusal(diff: &SceneDiff, scene: &Scene, store: &ModelStore) -> Result<(), Refusal> {
    let robots = || store.robots().values().map(|entry| &entry.robot);
    if store.robots().is_empty() {
        return Ok(());
    }
    let is_link = |name: &str| robots().any(|robot| robot.link_index(name).is_some());
    let is_object =
        |name: &str| scene.obstacles().get(name).is_some() || scene.attached().get(name).is_some();
    let links = || {
        let names: BTreeSet<&str> = robots()
            .flat_map(|robot| robot.links())
            .map(|link| link.name.as_str())
            .collect();
        listed(names.into_iter())
    };
    if let Some(name) = diff.links().find(|name| !is_link(name)) {
        let text = format!("{name:?} is no link of a loaded robot; links: {}", links());
        return Err(Refusal::new(Code::InvalidLinkName, text));
    }
    if let Some(name) = diff.names().find(|name| !is_link(name) && !is_object(name)) {
        let objects = listed(scene.objects().map(|object| object.id.as_str()));
        let text =
            format!("{name:?} is neither an object of the scene nor a link of a loaded robot");
        return Err(Refusal::new(
            Code::InvalidObjectName,
            format!("{text}; objects: {objects}; links: {}", links()),
        ));
    }
    Ok(())
}

/// What robots call the world.
pub fn worlds(store: &ModelStore) -> Vec<String> {
    let names: BTreeSet<String> = store
        .robots()
        .values()
        .flat_map(|entry| entry.robot.worlds())
        .collect();
    names.into_iter().collect()
}

/// The refusal of a scene whose frames are those of no loaded robot. Where none is loaded, nothing
/// is known of that.
///
/// # Errors
/// The refusal.
pub fn frame_refusal(scene: &Scene, store: &ModelStore) -> Result<(), Refusal> {
    let mut refused: Option<(bool, Refusal)> = None;
    for entry in store.robots().values() {
        let Err(error) = check_frames(&entry.robot, scene) else {
            return Ok(());
        };
        // The robot that has a link of that name is the one that was meant.
        let is_meant = matches!(error, CollisionModelError::FrameOfLink { .. });
        if refused
            .as_ref()
            .is_none_or(|(was_meant, _)| is_meant && !was_meant)
        {
            refused = Some((is_meant, model_refusal(&error, &entry.robot)));
        }
    }
    refused.map_or(Ok(()), |(_, refusal)| Err(refusal))
}

/// Names for a message, cut where there are many.
fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    const MOST: usize = 20;
    let names: Vec<&str> = names.collect();
    match names.len() {
        0 => "none".to_owned(),
        1..=MOST => names.join(", "),
        count => format!("{}, … ({count} in all)", names[..MOST].join(", ")),
    }
}

/// The refusal of a change that a scene does not take.
pub fn scene_refusal(error: &SceneError) -> Refusal {
    let code = match error {
        SceneError::Duplicate(_)
        | SceneError::UnknownObject { .. }
        | SceneError::AlreadyAttached { .. }
        | SceneError::NotAttached { .. }
        | SceneError::NameTaken(_)
        | SceneError::Carried { .. } => Code::InvalidObjectName,
        SceneError::OtherLink { .. } => Code::InvalidLinkName,
        _ => Code::InvalidModel,
    };
    Refusal::new(code, error.to_string())
}

/// The refusal of a file that cannot be read or is wrong.
pub fn file_refusal(error: &FileError) -> Refusal {
    let code = match error {
        FileError::Unreadable { .. } => Code::UnreadableFile,
        _ => Code::InvalidModel,
    };
    Refusal::new(code, error.to_string())
}

/// The refusal of a robot and a scene that do not go together: a pair of names one of which does
/// not exist. Beside a link the missing one is taken for an object, beside an object for a link.
pub fn model_refusal(error: &CollisionModelError, robot: &RobotModel) -> Refusal {
    let code = match error {
        CollisionModelError::UnknownName { beside, .. } => {
            if robot.link_index(beside).is_some() {
                Code::InvalidObjectName
            } else {
                Code::InvalidLinkName
            }
        }
        CollisionModelError::UnknownLink { .. } => Code::InvalidLinkName,
        _ => Code::InvalidModel,
    };
    Refusal::new(code, error.to_string())
}
