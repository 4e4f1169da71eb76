//! Robot and scene as Foxglove's schemas have them, in JSON.

use serde_json::{Value, json};
use taut::math::{Pose, Vec3};
use taut::robot::{Kinematics, RobotModel};
use taut::scene::Scene;
use taut::shape::{Drawn, Mesh, PlacedShape};

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
pub(super) fn scene(robot: &RobotModel, scene: &Scene) -> Value {
    let mut entities = Vec::new();
    for object in scene.obstacles() {
        let solids = Solids::of(&object.pose, &object.shapes, OBSTACLE);
        entities.push(solids.entity("world", &object.id));
    }
    for link in robot.links() {
        let solids = Solids::of(&Pose::identity(), &link.shapes, LINK);
        entities.push(solids.entity(&link.name, &link.name));
    }
    for attached in scene.attached() {
        let object = &attached.object;
        let solids = Solids::of(&object.pose, &object.shapes, CARRIED);
        entities.push(solids.entity(&attached.link_name, &object.id));
    }
    json!({ "deletions": [], "entities": entities })
}

/// The shapes of an entity by what Foxglove has, all of one colour.
struct Solids {
    color: Value,
    cubes: Vec<Value>,
    spheres: Vec<Value>,
    cylinders: Vec<Value>,
    triangles: Vec<Value>,
}

impl Solids {
    fn of(own: &Pose, shapes: &[PlacedShape], tint: [f64; 4]) -> Self {
        let mut solids = Self {
            color: color(tint),
            cubes: Vec::new(),
            spheres: Vec::new(),
            cylinders: Vec::new(),
            triangles: Vec::new(),
        };
        for shape in shapes {
            solids.add(*own * shape.pose, shape.shape.drawn());
        }
        solids
    }

    fn add(&mut self, pose: Pose, shape: Drawn) {
        match shape {
            Drawn::Sphere { radius } => self.sphere(pose, radius),
            Drawn::Box { size } => self.cubes.push(self.sized(&pose, size)),
            Drawn::Cylinder { radius, length } => self.cylinder(&pose, radius, length),
            Drawn::Capsule { radius, length } => {
                self.cylinder(&pose, radius, length);
                for end in [-length / 2.0, length / 2.0] {
                    self.sphere(pose * Pose::translation(0.0, 0.0, end), radius);
                }
            }
            Drawn::Mesh(mesh) => self.mesh(&pose, &mesh),
        }
    }

    fn sized(&self, pose: &Pose, size: Vec3) -> Value {
        json!({ "pose": placed(pose), "size": vector(size), "color": self.color })
    }

    fn sphere(&mut self, at: Pose, radius: f64) {
        let size = Vec3::new(2.0 * radius, 2.0 * radius, 2.0 * radius);
        self.spheres.push(self.sized(&at, size));
    }

    fn cylinder(&mut self, pose: &Pose, radius: f64, length: f64) {
        let size = vector(Vec3::new(2.0 * radius, 2.0 * radius, length));
        self.cylinders.push(json!({
            "pose": placed(pose), "size": size, "bottom_scale": 1.0, "top_scale": 1.0,
            "color": self.color,
        }));
    }

    fn mesh(&mut self, pose: &Pose, mesh: &Mesh) {
        let points: Vec<Value> = mesh
            .vertices()
            .iter()
            .map(|at| vector(*at))
            .collect();
        self.triangles.push(json!({
            "pose": placed(pose), "points": points, "color": self.color, "colors": [],
            "indices": mesh.triangles().concat(),
        }));
    }

    fn entity(self, frame: &str, id: &str) -> Value {
        json!({
            "timestamp": timestamp(0), "frame_id": frame, "id": id, "lifetime": timestamp(0), "frame_locked": true,
            "metadata": [], "arrows": [], "cubes": self.cubes, "spheres": self.spheres,
            "cylinders": self.cylinders, "lines": [], "triangles": self.triangles, "texts": [], "models": [],
        })
    }
}

/// `foxglove.FrameTransforms`: where each link is in the world.
pub(super) fn transforms(robot: &RobotModel, kinematics: &Kinematics, nanoseconds: u64) -> Value {
    let time = timestamp(nanoseconds);
    let links = robot.links().iter().zip(kinematics.poses());
    let transforms: Vec<Value> = links
        .map(|(link, pose)| transform(&link.name, pose, &time))
        .collect();
    json!({ "transforms": transforms })
}

fn transform(link: &str, pose: &Pose, time: &Value) -> Value {
    json!({
        "timestamp": time, "parent_frame_id": "world", "child_frame_id": link,
        "translation": vector(pose.translation), "rotation": rotation(pose),
    })
}
