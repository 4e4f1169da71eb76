//! Robots and scenes: what clients say about them, and what they are told.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::PathBuf;

use crate::collision::{CollisionModelError, check_frames};
use crate::files::result::texts;
use crate::files::{FileError, RobotFiles, RootJoint};
use crate::robot::{Component, JointKind, RobotModel, Variable, VirtualJoint};
use crate::scene::diff_file::SceneDiff;
use crate::scene::{Scene, SceneError, Sensing};
use crate::store::{ModelStore, RobotEntry, SceneEntry, StoreError};
use crate::warning;
use crate::warning::Warning;
use taut_ipc::control::{
    self, GroupDescription, LastFrame, Refusal, RobotDescription, RobotSource, RobotSummary,
    SceneSummary, SensedSummary, VariableDescription, VirtualJointKind,
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
        root: source
            .virtual_joint
            .map_or(RootJoint::OfSrdf, root_joint),
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
    RobotSource {
        urdf: absolute(&files.urdf),
        srdf: files.srdf.as_ref().map(absolute),
        packages: files
            .packages
            .iter()
            .map(|(name, folder)| (name.clone(), absolute(folder)))
            .collect(),
        virtual_joint: given_joint(&files.root),
        variables: files.variables.clone().unwrap_or_default(),
        allowed_collisions: files.allowed_collisions.clone(),
        ..RobotSource::default()
    }
}

fn absolute(path: &PathBuf) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.clone())
}

fn given_joint(root: &RootJoint) -> Option<control::VirtualJoint> {
    match root {
        RootJoint::OfSrdf => None,
        RootJoint::Given(None) => Some(no_joint()),
        RootJoint::Given(Some(joint)) => Some(virtual_joint(joint)),
    }
}

/// What says that the root stands in the world.
fn no_joint() -> control::VirtualJoint {
    control::VirtualJoint {
        name: String::new(),
        kind: VirtualJointKind::Fixed,
        parent_frame: String::new(),
        position_bounds: Vec::new(),
    }
}

fn virtual_joint(joint: &VirtualJoint) -> control::VirtualJoint {
    let kind = match joint.kind {
        JointKind::Planar => VirtualJointKind::Planar,
        JointKind::Floating => VirtualJointKind::Floating,
        _ => VirtualJointKind::Fixed,
    };
    control::VirtualJoint {
        name: joint.name.clone(),
        kind,
        parent_frame: joint.parent_frame.clone(),
        position_bounds: joint.position_bounds.clone(),
    }
}

/// What a client has to know of a robot.
pub fn describe(label: &str, entry: &RobotEntry) -> RobotDescription {
    let robot = &entry.robot;
    let held = robot.held().iter();
    RobotDescription {
        label: label.to_owned(),
        robot_id: entry.id,
        robot_hash: robot.hash(),
        layout_hash: robot.layout_hash(),
        variables: variables(robot),
        held_variables: held
            .clone()
            .map(|variable| variable.name.clone())
            .collect(),
        held_values: held.map(|variable| variable.default).collect(),
        fixed_joints: fixed_joints(robot),
        groups: groups(robot),
        nq: robot.space().nq() as u32,
        nv: robot.space().nv() as u32,
        weights: entry.weights.to_vec(),
        warnings: texts(&warning::told(robot.warnings()), |_| true),
    }
}

fn groups(robot: &RobotModel) -> Vec<GroupDescription> {
    let groups = robot.groups().iter();
    groups
        .map(|(name, moving)| group(robot, name, moving))
        .collect()
}

fn fixed_joints(robot: &RobotModel) -> Vec<String> {
    // Joint 0 holds the root in the world; it is nobody's but ours.
    let joints = robot.joints().iter().skip(1);
    joints
        .filter(|joint| joint.kind == JointKind::Fixed)
        .map(|joint| joint.name.clone())
        .collect()
}

fn variables(robot: &RobotModel) -> Vec<VariableDescription> {
    let mut variables: Vec<_> = robot
        .variables()
        .iter()
        .map(without_coordinate)
        .collect();
    for component in robot.space().components() {
        enter_coordinates(component, &mut variables);
    }
    variables
}

/// Says of a component's variables which velocity coordinates are theirs.
fn enter_coordinates(component: &Component, variables: &mut [VariableDescription]) {
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

fn without_coordinate(variable: &Variable) -> VariableDescription {
    VariableDescription {
        name: variable.name.clone(),
        lower: variable.lower,
        upper: variable.upper,
        ..VariableDescription::default()
    }
}

fn group(robot: &RobotModel, name: &str, moving: &[bool]) -> GroupDescription {
    let components = robot.space().components().iter();
    GroupDescription {
        name: name.to_owned(),
        variables: components
            .flat_map(|component| moved_columns(component, moving))
            .map(|column| column as u32)
            .collect(),
    }
}

/// The columns of a component, none where it does not move.
fn moved_columns(component: &Component, moving: &[bool]) -> Range<usize> {
    match *component {
        Component::Line { q, v } | Component::Circle { q, v } if moving[v] => q..q + 1,
        Component::Rotation { q, v } if moving[v] => q..q + 4,
        _ => 0..0,
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

/// A scene in a listing, at `now_ns` (monotonic).
pub fn scene_summary(label: &str, entry: &SceneEntry, now_ns: u64) -> SceneSummary {
    let scene = &entry.scene;
    let worlds = scene
        .worlds()
        .map(|(id, frame)| other_world(id, frame));
    let warnings: Vec<Warning> = scene
        .warnings()
        .iter()
        .cloned()
        .chain(worlds)
        .collect();
    SceneSummary {
        warnings: texts(&warning::told(&warnings), |_| true),
        ..scene_state(label, entry, now_ns)
    }
}

fn sensed(object: &str, sensing: &Sensing, now_ns: u64) -> SensedSummary {
    SensedSummary {
        object: object.to_owned(),
        last: sensing.frame.map(|frame| LastFrame {
            age_ns: frame.age_ns(now_ns),
            period_ns: sensing.period_ns,
            came: frame.came,
            on_robot: frame.on_robot,
            in_padding: frame.in_padding,
            points: frame.points,
        }),
    }
}

fn other_world(id: &str, frame: &str) -> Warning {
    Warning::uncovered(format!(
        "object {id:?}: its frame {frame:?} is none of the scene's; robots in it have to call the world so"
    ))
}

/// The same without a look at what is odd about its objects.
pub fn scene_state(label: &str, entry: &SceneEntry, now_ns: u64) -> SceneSummary {
    let objects = entry.scene.sensed();
    SceneSummary {
        label: label.to_owned(),
        scene_id: entry.id,
        scene_hash: entry.scene.hash(),
        version: entry.version,
        objects: (entry.scene.obstacles().len() + entry.scene.attached().len()) as u32,
        warnings: Vec::new(),
        kept_from: entry.kept_from(),
        pinned: entry.pinned().iter().copied().collect(),
        sensed: objects
            .map(|(object, sensing)| sensed(&object.id, sensing, now_ns))
            .collect(),
    }
}

/// The refusal of what the store refuses.
pub fn store_refusal(error: &StoreError) -> Refusal {
    let code = match error {
        StoreError::LabelTaken { .. } | StoreError::OtherMotors(_) | StoreError::SameId { .. } => {
            Code::LabelTaken
        }
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
    if store.robots().is_empty() {
        return Ok(());
    }
    if let Some(name) = diff.links().find(|name| !is_link(name, store)) {
        return Err(no_link(name, store));
    }
    let is_known = |name: &str| is_link(name, store) || is_object(name, scene);
    match diff.names().find(|name| !is_known(name)) {
        None => Ok(()),
        Some(name) => Err(neither(name, scene, store)),
    }
}

fn is_link(name: &str, store: &ModelStore) -> bool {
    let mut robots = store.robots().values();
    robots.any(|entry| entry.robot.link_index(name).is_some())
}

fn is_object(name: &str, scene: &Scene) -> bool {
    scene.obstacles().get(name).is_some() || scene.attached().get(name).is_some()
}

fn no_link(name: &str, store: &ModelStore) -> Refusal {
    let links = links(store);
    let text = format!("{name:?} is no link of a loaded robot; links: {links}");
    Refusal::new(Code::InvalidLinkName, text)
}

fn neither(name: &str, scene: &Scene, store: &ModelStore) -> Refusal {
    let objects = listed(scene.objects().map(|object| object.id.as_str()));
    let links = links(store);
    let text = format!(
        "{name:?} is neither an object of the scene nor a link of a loaded robot; objects: {objects}; links: {links}"
    );
    Refusal::new(Code::InvalidObjectName, text)
}

/// The links of all robots, for a message.
fn links(store: &ModelStore) -> String {
    let robots = store.robots().values();
    let names: BTreeSet<&str> = robots
        .flat_map(|entry| entry.robot.links())
        .map(|link| link.name.as_str())
        .collect();
    listed(names.into_iter())
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
    let robots = store
        .robots()
        .values()
        .map(|entry| &*entry.robot);
    let mut refused: Option<(CollisionModelError, &RobotModel)> = None;
    for robot in robots {
        let Err(error) = check_frames(robot, scene) else {
            return Ok(());
        };
        let is_better =
            |(known, _): &(CollisionModelError, _)| is_meant(&error) && !is_meant(known);
        if refused.as_ref().is_none_or(is_better) {
            refused = Some((error, robot));
        }
    }
    refused.map_or(Ok(()), |(error, robot)| Err(model_refusal(&error, robot)))
}

/// The robot that has a link of that name is the one that was meant.
fn is_meant(error: &CollisionModelError) -> bool {
    matches!(error, CollisionModelError::FrameOfLink { .. })
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
    let is_link = |name: &str| robot.link_index(name).is_some();
    let code = match error {
        CollisionModelError::UnknownName { beside, .. } if is_link(beside) => {
            Code::InvalidObjectName
        }
        CollisionModelError::UnknownName { .. } | CollisionModelError::UnknownLink { .. } => {
            Code::InvalidLinkName
        }
        _ => Code::InvalidModel,
    };
    Refusal::new(code, error.to_string())
}
