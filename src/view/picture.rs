//! What a page shows: an answer, and the robot and scene that it is about.

use serde::Serialize;
use taut::files::ResultFile;
use taut::robot::urdf::Visual;
use taut::robot::{Component, ConfigurationSpace, Drive, HeldVariable, Joint, RobotModel};
use taut::scene::{AttachedObject, Obstacle, Scene};

use super::kept::Kept;
use super::shapes::{MeshBytes, Meshes, Place, Solid, place};
use super::urdf_text::urdf_text;

/// The data of a page.
#[derive(Serialize)]
pub(crate) struct Picture {
    result: ResultFile,
    urdf: String,
    meshes: Vec<MeshBytes>,
    /// Joints that are columns of the path.
    driven: Vec<DrivenJoint>,
    /// Joints that stand still, and where.
    held: Vec<HeldJoint>,
    /// Factors of the configuration space, in column order.
    factors: Vec<Factor>,
    objects: Vec<Object>,
    /// What the path keeps besides clearance.
    kept: Kept,
    /// What cannot be shown as it is, a line each.
    notes: Vec<String>,
}

/// What a picture is made of.
pub(crate) struct Sight<'a> {
    /// The answer.
    pub result: ResultFile,
    /// Its robot.
    pub robot: &'a RobotModel,
    /// Its scene.
    pub scene: &'a Scene,
    /// What the robot looks like; a link without a visual shape shows its collision shapes.
    pub visuals: Vec<Visual>,
    /// What cannot be shown as it is, a line each.
    pub notes: Vec<String>,
}

#[derive(Serialize)]
struct DrivenJoint {
    joint: String,
    kind: &'static str,
    /// First column.
    q: usize,
}

#[derive(Serialize)]
struct HeldJoint {
    joint: String,
    kind: &'static str,
    values: Vec<f64>,
}

#[derive(Serialize)]
struct Factor {
    kind: &'static str,
    /// First column.
    q: usize,
    /// First velocity coordinate.
    v: usize,
}

#[derive(Serialize)]
struct Object {
    name: String,
    /// The link that carries it.
    link: Option<String>,
    pose: Place,
    solids: Vec<Solid>,
}

impl Picture {
    /// Draws.
    pub(crate) fn of(sight: Sight) -> Self {
        let Sight {
            mut result,
            robot,
            scene,
            visuals,
            mut notes,
        } = sight;
        let mut meshes = Meshes::default();
        let urdf = urdf_text(robot, &visuals, &mut meshes);
        let objects = objects(scene, &mut meshes);
        // It is drawn already.
        result.subject.scene.content = None;
        let space = space(robot, result.subject.unwrapped);
        let values = held_values(robot, &result);
        let (kept, not_drawn) = Kept::of(&result, robot, scene, &space, &values);
        notes.extend(not_drawn);
        Self {
            driven: robot
                .joints()
                .iter()
                .filter_map(driven)
                .collect(),
            held: held(robot, &values),
            factors: space.components().iter().map(factor).collect(),
            result,
            urdf,
            meshes: meshes.into_bytes(),
            objects,
            kept,
            notes,
        }
    }
}

fn objects(scene: &Scene, meshes: &mut Meshes) -> Vec<Object> {
    let standing = scene
        .obstacles()
        .iter()
        .map(|object| (object, None));
    let carried = scene.attached().iter().map(carried);
    standing
        .chain(carried)
        .map(|(object, link)| Object::of(object, link, meshes))
        .collect()
}

/// An object and the link that carries it.
fn carried(attached: &AttachedObject) -> (&Obstacle, Option<String>) {
    (&attached.object, Some(attached.link_name.clone()))
}

fn space(robot: &RobotModel, unwrapped: bool) -> ConfigurationSpace {
    match unwrapped {
        true => robot.space().unwrapped(),
        false => robot.space().clone(),
    }
}

impl Object {
    fn of(object: &Obstacle, link: Option<String>, meshes: &mut Meshes) -> Self {
        let shapes = object.shapes.iter();
        Self {
            name: object.id.clone(),
            link,
            pose: place(&object.pose),
            solids: shapes
                .map(|shape| Solid::of(shape, meshes))
                .collect(),
        }
    }
}

fn driven(joint: &Joint) -> Option<DrivenJoint> {
    let Drive::Variable { q, .. } = joint.drive else {
        return None;
    };
    Some(DrivenJoint {
        joint: joint.name.clone(),
        kind: joint.kind.name(),
        q,
    })
}

/// Where the variables stand that are no columns of the path.
fn held_values(robot: &RobotModel, result: &ResultFile) -> Vec<f64> {
    let held = robot.held().iter();
    held.map(|variable| value(variable, result))
        .collect()
}

fn held(robot: &RobotModel, values: &[f64]) -> Vec<HeldJoint> {
    let joints = robot.joints().iter();
    joints
        .filter_map(|joint| held_joint(joint, values))
        .collect()
}

/// Where a variable stands that is no column of the path.
fn value(variable: &HeldVariable, result: &ResultFile) -> f64 {
    let held = &result.subject.held;
    held.get(&variable.name)
        .copied()
        .unwrap_or(variable.default)
}

fn held_joint(joint: &Joint, values: &[f64]) -> Option<HeldJoint> {
    let Drive::Held { first } = joint.drive else {
        return None;
    };
    Some(HeldJoint {
        joint: joint.name.clone(),
        kind: joint.kind.name(),
        values: values[first..first + joint.kind.nq()].to_vec(),
    })
}

fn factor(component: &Component) -> Factor {
    match *component {
        Component::Line { q, v } => Factor { kind: "line", q, v },
        Component::Circle { q, v } => Factor {
            kind: "circle",
            q,
            v,
        },
        Component::Rotation { q, v } => Factor {
            kind: "rotation",
            q,
            v,
        },
    }
}
