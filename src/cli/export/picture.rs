//! Robot and scene as Foxglove's schemas have them, in JSON.

use serde_json::{Value, json};
use taut::math::{Pose, Vec3};
use taut::robot::{Kinematics, RobotModel};
use taut::scene::Scene;
use taut::shape::{Drawn, PlacedShape};

use crate::cli::error::CliError;

const OBSTACLE: [f64; 4] = [0.55, 0.55, 0.6, 1.0];
const LINK: [f64; 4] = [0.25, 0.5, 0.85, 1.0];
const CARRIED: [f64; 4] = [0.9, 0.6, 0.2, 1.0];

/// A time as Foxglove's JSON has it.
pub(super) fn timestamp(nanoseconds: u64) -> Value {
    json!({ "sec": nanoseconds / 1_000_000_000, "nsec": nanoseconds % 1_000_000_000 })
}

fn vector(v: Vec3) -> Value {
    let [x, y, z] = v.to_array();
    json!({ "x": x, "y": y, "z": z })
}

fn rotation(pose: &Pose) -> Value {
    let [x, y, z, w] = pose.rotation.to_array();
    json!({ "x": x, "y": y, "z": z, "w": w })
}

fn placed(pose: &Pose) -> Value {
    json!({ "position": vector(pose.translation), "orientation": rotation(pose) })
}

fn color([r, g, b, a]: [f64; 4]) -> Value {
    json!({ "r": r, "g": g, "b": b, "a": a })
}

/// `foxglove.SceneUpdate`: obstacles in the world, links and what they carry in their links'
/// frames.
///
/// # Errors
/// A shape of a kind that Foxglove has not.
pub(super) fn scene(robot: &RobotModel, scene: &Scene) -> Result<Value, CliError> {
    let mut entities = Vec::new();
    for object in scene.obstacles() {
        entities.push(entity(
            "world",
            &object.id,
            &object.pose,
            &object.shapes,
            OBSTACLE,
        )?);
    }
    for link in robot.links() {
        entities.push(entity(
            &link.name,
            &link.name,
            &Pose::identity(),
            &link.shapes,
            LINK,
        )?);
    }
    for attached in scene.attached() {
        let object = &attached.object;
        entities.push(entity(
            &attached.link_name,
            &object.id,
            &object.pose,
            &object.shapes,
            CARRIED,
        )?);
    }
    Ok(json!({ "deletions": [], "entities": entities }))
}

fn entity(
    frame: &str,
    id: &str,
    own: &Pose,
    shapes: &[PlacedShape],
    tint: [f64; 4],
) -> Result<Value, CliError> {
    let mut cubes = Vec::new();
    let mut spheres = Vec::new();
    let mut cylinders = Vec::new();
    let mut triangles = Vec::new();
    let tint = color(tint);
    let size = |x: f64, y: f64, z: f64| vector(Vec3::new(x, y, z));
    for shape in shapes {
        let pose = *own * shape.pose;
        let ball = |at: Pose, radius: f64| json!({ "pose": placed(&at), "size": size(2.0 * radius, 2.0 * radius, 2.0 * radius), "color": tint });
        let tube = |radius: f64, length: f64| {
            let size = size(2.0 * radius, 2.0 * radius, length);
            json!({ "pose": placed(&pose), "size": size, "bottom_scale": 1.0, "top_scale": 1.0, "color": tint })
        };
        match shape.shape.drawn() {
            Drawn::Sphere { radius } => spheres.push(ball(pose, radius)),
            Drawn::Box { size } => {
                cubes.push(json!({ "pose": placed(&pose), "size": vector(size), "color": tint }));
            }
            Drawn::Cylinder { radius, length } => cylinders.push(tube(radius, length)),
            Drawn::Capsule { radius, length } => {
                cylinders.push(tube(radius, length));
                for end in [-length / 2.0, length / 2.0] {
                    spheres.push(ball(pose * Pose::translation(0.0, 0.0, end), radius));
                }
            }
            Drawn::Mesh(mesh) => {
                let points: Vec<_> = mesh
                    .vertices()
                    .iter()
                    .map(|vertex| vector(*vertex))
                    .collect();
                let indices = mesh.triangles().concat();
                triangles.push(json!({
                    "pose": placed(&pose), "points": points, "color": tint, "colors": [], "indices": indices
                }));
            }
        }
    }
    Ok(json!({
        "timestamp": timestamp(0), "frame_id": frame, "id": id, "lifetime": timestamp(0), "frame_locked": true,
        "metadata": [], "arrows": [], "cubes": cubes, "spheres": spheres, "cylinders": cylinders, "lines": [],
        "triangles": triangles, "texts": [], "models": [],
    }))
}

/// `foxglove.FrameTransforms`: where each link is in the world.
pub(super) fn transforms(robot: &RobotModel, kinematics: &Kinematics, nanoseconds: u64) -> Value {
    let links = robot.links().iter().zip(kinematics.poses());
    let transform = |(link, pose): (&taut::robot::Link, &Pose)| {
        json!({
            "timestamp": timestamp(nanoseconds), "parent_frame_id": "world", "child_frame_id": link.name,
            "translation": vector(pose.translation), "rotation": rotation(pose),
        })
    };
    json!({ "transforms": links.map(transform).collect::<Vec<_>>() })
}
