//! Scenes in the texts that are read, or that a person would think are.

use serde_json::{Map, Value, json};

use crate::make::mesh::{Format, Mesh};
use crate::make::robot::Made;
use crate::make::scene::{Attached, Object, Octomap, Scene, Text};
use crate::pose::Vector;
use crate::shape::{Geometry, Placement};

/// A scene's texts and meshes.
pub struct Written {
    pub text: String,
    pub ending: &'static str,
    /// What changes the text's scene into the one that is meant.
    pub diff: Option<String>,
    pub meshes: Vec<(String, Vec<u8>)>,
}

pub fn scene(made: &Made, scene: &Scene) -> Written {
    let is_message = scene.text == Text::Message;
    let mut writer = Writer {
        made,
        is_message,
        has_numbers: scene.has_numbers,
        meshes: Vec::new(),
    };
    let ending = match scene.text {
        Text::Own | Text::Diff => "json",
        Text::Message => "yaml",
        Text::Lines => "scene",
    };
    let (text, diff) = match scene.text {
        Text::Own => (writer.own(scene, &scene.objects).to_string(), None),
        Text::Diff => {
            let (first, rest) = scene.objects.split_at(scene.objects.len() / 2);
            let added = rest
                .iter()
                .map(|object| writer.object(object, Some("ADD")));
            let diff = json!({ "is_diff": true, "objects": added.collect::<Vec<_>>() });
            (
                writer
                    .own(
                        &Scene {
                            allowed: Vec::new(),
                            ..scene.clone()
                        },
                        first,
                    )
                    .to_string(),
                Some((diff, scene)),
            )
        }
        // JSON is YAML too.
        Text::Message => (writer.message(scene).to_string(), None),
        Text::Lines => (lines(scene), None),
    };
    let diff = diff.map(|(mut diff, scene)| {
        diff["allowed_collisions"] = json!(scene.allowed);
        diff.to_string()
    });
    let text = scene
        .wrong_letter
        .map_or(text.clone(), |choice| misspelt(&text, choice));
    Written {
        text,
        ending,
        diff,
        meshes: writer.meshes,
    }
}

struct Writer<'a> {
    made: &'a Made,
    is_message: bool,
    has_numbers: bool,
    meshes: Vec<(String, Vec<u8>)>,
}

impl Writer<'_> {
    fn own(&mut self, scene: &Scene, objects: &[Object]) -> Value {
        let frames = scene.frames.iter().map(|(name, pose)| {
            let transform = json!({ "translation": pose.at, "rotation": named(&["x", "y", "z", "w"], &pose.turn) });
            json!({ "child_frame_id": name, "transform": transform })
        });
        json!({
            "name": "random",
            "fixed_frame_transforms": frames.collect::<Vec<_>>(),
            "objects": objects.iter().map(|object| self.object(object, None)).collect::<Vec<_>>(),
            "attached_collision_objects": scene.attached.iter().map(|held| self.attached(held)).collect::<Vec<_>>(),
            "allowed_collisions": scene.allowed,
        })
    }

    fn message(&mut self, scene: &Scene) -> Value {
        let frames = scene.frames.iter().map(|(name, pose)| {
            let at = named(&["x", "y", "z"], &pose.at); let turn = named(&["x", "y", "z", "w"], &pose.turn);
            let header = json!({ "stamp": { "sec": 0, "nanosec": 0 }, "frame_id": "" });
            json!({ "header": header, "child_frame_id": name, "transform": { "translation": at, "rotation": turn } })
        });
        let mut world = json!({
            "collision_objects": scene.objects.iter().map(|object| self.object(object, Some("ADD"))).collect::<Vec<_>>(),
        });
        if let Some(octomap) = &scene.octomap {
            world["octomap"] = self.octomap(octomap);
        }
        let attached = scene
            .attached
            .iter()
            .map(|held| self.attached(held))
            .collect::<Vec<_>>();
        json!({
            "name": "random",
            "robot_state": { "attached_collision_objects": attached, "is_diff": false },
            "robot_model_name": "random",
            "fixed_frame_transforms": frames.collect::<Vec<_>>(),
            "world": world,
            "is_diff": false,
        })
    }

    fn octomap(&self, octomap: &Octomap) -> Value {
        // Two bits a child, two bytes a node: 10 is occupied, 11 has children of its own.
        let last = octomap.path.len() - 1;
        let node = |(level, child): (usize, &usize)| {
            let bits: u16 = if level == last { 0b10 } else { 0b11 };
            (bits << (2 * child))
                .to_le_bytes()
                .map(|byte| byte as i8)
        };
        let data: Vec<i8> = octomap
            .path
            .iter()
            .enumerate()
            .flat_map(node)
            .collect();
        let resolution = octomap.resolution;
        json!({
            "header": { "frame_id": "" },
            "origin": self.pose(&octomap.origin),
            "unknown": "free",
            "octomap": { "binary": true, "id": "OcTree", "resolution": resolution, "data": data },
        })
    }

    fn pose(&self, pose: &Placement) -> Value {
        let turn = named(&["x", "y", "z", "w"], &pose.turn);
        let at = if self.is_message {
            named(&["x", "y", "z"], &pose.at)
        } else {
            json!(pose.at)
        };
        json!({ "position": at, "orientation": turn })
    }

    fn object(&mut self, object: &Object, operation: Option<&str>) -> Value {
        let mut fields = Map::new();
        fields.insert("id".into(), json!(object.id));
        if let Some(operation) = operation {
            let word = if self.is_message {
                json!(0)
            } else {
                json!(operation)
            };
            fields.insert("operation".into(), word);
        }
        if !object.frame.is_empty() {
            fields.insert("header".into(), json!({ "frame_id": object.frame }));
        }
        fields.insert("pose".into(), self.pose(&object.pose));
        let mut primitives = Vec::new();
        let mut primitive_poses = Vec::new();
        let mut meshes = Vec::new();
        let mut mesh_poses = Vec::new();
        for (geometry, pose) in &object.shapes {
            match geometry {
                Geometry::Mesh(mesh) => {
                    meshes.push(self.mesh(mesh, &object.id));
                    mesh_poses.push(self.pose(pose));
                }
                primitive => {
                    primitives.push(self.primitive(primitive));
                    primitive_poses.push(self.pose(pose));
                }
            }
        }
        if !primitives.is_empty() {
            fields.insert("primitives".into(), json!(primitives));
            fields.insert("primitive_poses".into(), json!(primitive_poses));
        }
        if !meshes.is_empty() {
            fields.insert("meshes".into(), json!(meshes));
            fields.insert("mesh_poses".into(), json!(mesh_poses));
        }
        if !object.subframes.is_empty() {
            let names: Vec<&String> = object
                .subframes
                .iter()
                .map(|(name, _)| name)
                .collect();
            fields.insert("subframe_names".into(), json!(names));
            let poses: Vec<Value> = object
                .subframes
                .iter()
                .map(|(_, pose)| self.pose(pose))
                .collect();
            fields.insert("subframe_poses".into(), json!(poses));
        }
        Value::Object(fields)
    }

    fn primitive(&self, geometry: &Geometry) -> Value {
        // MoveIt's numbers and order: box 1, sphere 2, cylinder 3 (height, radius).
        let (name, number, dimensions) = match geometry {
            Geometry::Box(size) => ("box", 1, size.to_vec()),
            Geometry::Sphere { radius } => ("sphere", 2, vec![*radius]),
            Geometry::Cylinder { length, radius } => ("cylinder", 3, vec![*length, *radius]),
            Geometry::Capsule { length, radius } => ("capsule", 0, vec![*length, *radius]),
            Geometry::Mesh(_) => unreachable!("a mesh is no primitive"),
        };
        let is_number = self.has_numbers && number != 0;
        json!({ "type": if is_number { json!(number) } else { json!(name) }, "dimensions": dimensions })
    }

    fn mesh(&mut self, mesh: &Mesh, id: &str) -> Value {
        if mesh.format == Format::Inline {
            let vertices: Vec<Vector> = mesh
                .column
                .vertices()
                .iter()
                .map(|vertex| mesh.in_file(*vertex))
                .collect();
            let triangles = mesh.faces();
            return match self.is_message {
                true => json!({
                    "vertices": vertices.iter().map(|vertex| named(&["x", "y", "z"], vertex)).collect::<Vec<_>>(),
                    "triangles": triangles.iter().map(|face| json!({ "vertex_indices": face })).collect::<Vec<_>>(),
                }),
                false => json!({ "file": id, "vertices": vertices, "triangles": triangles }),
            };
        }
        let name = format!("object{}.{}", self.meshes.len(), mesh.format.ending());
        self.meshes
            .push((name.clone(), super::mesh::bytes(mesh)));
        match self.is_message {
            true => json!({ "resource": name, "dimensions": mesh.scale }),
            false => json!({ "file": name, "scale": mesh.scale }),
        }
    }

    fn attached(&mut self, attached: &Attached) -> Value {
        let name = |link: &usize| self.made.robot.links[*link].clone();
        let link = name(&attached.link);
        let touch_links = attached
            .touch_links
            .iter()
            .map(name)
            .collect::<Vec<_>>();
        let operation = self.is_message.then_some("ADD");
        json!({ "link_name": link, "touch_links": touch_links, "object": self.object(&attached.object, operation) })
    }
}

fn named(names: &[&str], numbers: &[f64]) -> Value {
    names
        .iter()
        .zip(numbers)
        .map(|(name, number)| ((*name).to_owned(), json!(number)))
        .collect()
}

/// Fields whose loss would move or remove something.
const FIELDS: [&str; 17] = [
    "objects",
    "collision_objects",
    "attached_collision_objects",
    "primitives",
    "primitive_poses",
    "meshes",
    "mesh_poses",
    "pose",
    "position",
    "orientation",
    "header",
    "frame_id",
    "fixed_frame_transforms",
    "translation",
    "rotation",
    "scale",
    "operation",
];

/// The text with a wrong letter in the name of one of its fields.
fn misspelt(text: &str, choice: u64) -> String {
    let known = FIELDS.iter().flat_map(|field| {
        let quoted = format!("\"{field}\":");
        text.match_indices(&quoted)
            .map(|(at, _)| (at + 1, field.len()))
            .collect::<Vec<_>>()
    });
    let places: Vec<(usize, usize)> = known.collect();
    let (at, length) = places[choice as usize % places.len()];
    let letter = at + 1 + (choice >> 20) as usize % (length - 1);
    let (before, after) = text.split_at(letter);
    let rest = &after[1..];
    let wrong = after[..1].to_owned();
    match (choice >> 40) % 3 {
        0 => format!("{before}{rest}"),
        1 => format!("{before}{wrong}{wrong}{rest}"),
        _ => format!("{before}{}{rest}", wrong.to_ascii_uppercase()),
    }
}

/// MoveIt's own text: name, shapes, each with its pose and colour.
fn lines(scene: &Scene) -> String {
    let mut text = "random\n".to_owned();
    let pose =
        |pose: &Placement| format!("{}\n{}\n", super::words(&pose.at), super::words(&pose.turn));
    for object in &scene.objects {
        text += &format!(
            "* {}\n{}{}\n",
            object.id,
            pose(&object.pose),
            object.shapes.len()
        );
        for (geometry, place) in &object.shapes {
            text += &match geometry {
                Geometry::Box(size) => format!("box\n{}\n", super::words(size)),
                Geometry::Sphere { radius } => format!("sphere\n{radius}\n"),
                Geometry::Cylinder { length, radius } => format!("cylinder\n{radius} {length}\n"),
                Geometry::Capsule { .. } => unreachable!("MoveIt's text has no capsule"),
                Geometry::Mesh(mesh) => triangles(mesh),
            };
            text += &format!("{}0 0 0 0\n", pose(place));
        }
        text += &format!("{}\n", object.subframes.len());
        object
            .subframes
            .iter()
            .for_each(|(name, place)| text += &format!("{name} {}", pose(place)));
    }
    text + ".\n"
}

fn triangles(mesh: &Mesh) -> String {
    let vertices = mesh.column.vertices();
    let faces = mesh.faces();
    let mut text = format!("mesh\n{} {}\n", vertices.len(), faces.len());
    vertices
        .iter()
        .for_each(|vertex| text += &format!("{}\n", super::words(&mesh.in_file(*vertex))));
    for face in faces {
        let face: Vec<String> = face.iter().map(usize::to_string).collect();
        text += &format!("{}\n", face.join(" "));
    }
    text
}
