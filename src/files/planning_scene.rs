//! MoveIt's planning scenes as YAML, such as those of MotionBenchMaker, as the scene files that are read here.

use serde::Deserialize;
use serde_json::{Map, Value, json};

use super::yaml;

/// What a planning scene says besides its objects. Its robot's own state is the path's.
#[derive(Deserialize)]
struct PlanningScene {
    world: World,
    #[serde(default)]
    robot_state: RobotState,
    #[serde(default)]
    allowed_collision_matrix: Matrix,
    #[serde(default)]
    fixed_frame_transforms: Vec<Value>,
}

#[derive(Deserialize)]
struct World {
    #[serde(default)]
    collision_objects: Vec<Value>,
}

#[derive(Default, Deserialize)]
struct RobotState {
    #[serde(default)]
    attached_collision_objects: Vec<Value>,
}

#[derive(Default, Deserialize)]
struct Matrix {
    #[serde(default)]
    entry_names: Vec<String>,
    #[serde(default)]
    entry_values: Vec<Row>,
}

/// A row of the matrix: a bare list, or a message with `enabled`.
#[derive(Deserialize)]
#[serde(untagged)]
enum Row {
    Bare(Vec<bool>),
    Message { enabled: Vec<bool> },
}

/// The JSON of a scene file for a YAML text: a planning scene, or a scene file as YAML.
///
/// # Errors
/// What is wrong, with its line where it is known.
pub(super) fn json(text: &str) -> Result<String, String> {
    let mut documents: Vec<Value> = yaml::documents(text)?;
    if documents.len() != 1 {
        return Err(format!("it holds {} YAML documents; a scene is one", documents.len()));
    }
    let value = documents.swap_remove(0);
    if value.get("world").is_none() {
        return Ok(value.to_string());
    }
    let copied: Map<String, Value> = ["name", "is_diff", "link_padding", "link_scale"]
        .into_iter()
        .filter_map(|field| Some((field.to_owned(), value.get(field)?.clone())))
        .collect();
    let scene: PlanningScene =
        serde_json::from_value(value).map_err(|error| format!("not a planning scene: {error}"))?;
    let mut file = copied;
    file.insert("objects".to_owned(), scene.world.collision_objects.into_iter().map(object).collect());
    let attached = scene.robot_state.attached_collision_objects.into_iter().map(|mut attached| {
        if let Some(inner) = attached.get_mut("object") {
            *inner = object(inner.take());
        }
        attached
    });
    file.insert("attached_collision_objects".to_owned(), attached.collect());
    file.insert("allowed_collisions".to_owned(), json!(scene.allowed_collision_matrix.allowed()?));
    let frames = scene.fixed_frame_transforms.into_iter().filter_map(frame);
    file.insert("fixed_frame_transforms".to_owned(), frames.collect());
    Ok(Value::Object(file).to_string())
}

impl Matrix {
    /// The pairs that may touch.
    fn allowed(&self) -> Result<Vec<[&str; 2]>, String> {
        let names = &self.entry_names;
        let mut pairs = Vec::new();
        if self.entry_values.len() != names.len() {
            let rows = self.entry_values.len();
            return Err(format!("allowed_collision_matrix has {rows} rows for {} names", names.len()));
        }
        for (index, row) in self.entry_values.iter().enumerate() {
            let (Row::Bare(row) | Row::Message { enabled: row }) = row;
            if row.len() != names.len() {
                let text = format!("allowed_collision_matrix has {} entries in the row of {}", row.len(), names[index]);
                return Err(format!("{text}, {} names", names.len()));
            }
            let others = row[..index].iter().zip(names).filter(|(is_allowed, _)| **is_allowed);
            pairs.extend(others.map(|(_, other)| [other.as_str(), names[index].as_str()]));
        }
        Ok(pairs)
    }
}

/// An object with the words of scene files: robowflex's mesh has its `resource` and `dimensions`, ROS's triangles
/// their `vertex_indices`, and points and quaternions are lists or have names.
fn object(mut object: Value) -> Value {
    let name = object.get("id").and_then(Value::as_str).unwrap_or("mesh").to_owned();
    for mesh in object.get_mut("meshes").and_then(Value::as_array_mut).into_iter().flatten() {
        let Some(mesh) = mesh.as_object_mut() else { continue };
        for (theirs, ours) in [("resource", "file"), ("dimensions", "scale")] {
            if let Some(value) = mesh.remove(theirs) {
                mesh.entry(ours).or_insert(value);
            }
        }
        mesh.entry("file").or_insert_with(|| Value::String(name.clone()));
        for triangle in mesh.get_mut("triangles").and_then(Value::as_array_mut).into_iter().flatten() {
            if let Some(indices) = triangle.get_mut("vertex_indices") {
                *triangle = indices.take();
            }
        }
        mesh.get_mut("vertices").and_then(Value::as_array_mut).into_iter().flatten().for_each(vector);
    }
    for list in ["primitive_poses", "mesh_poses"] {
        object.get_mut(list).and_then(Value::as_array_mut).into_iter().flatten().for_each(pose);
    }
    if let Some(own) = object.get_mut("pose") {
        pose(own);
    }
    object
}

/// `{x, y, z}` as a list.
fn vector(value: &mut Value) {
    if let (Some(x), Some(y), Some(z)) = (value.get("x"), value.get("y"), value.get("z")) {
        *value = json!([x, y, z]);
    }
}

fn pose(pose: &mut Value) {
    for field in ["position", "translation"] {
        if let Some(position) = pose.get_mut(field) {
            vector(position);
        }
    }
    for field in ["orientation", "rotation"] {
        if let Some([x, y, z, w]) = pose.get(field).and_then(Value::as_array).map(Vec::as_slice) {
            pose[field] = json!({ "x": x, "y": y, "z": z, "w": w });
        }
    }
}

/// A frame without its header; the root of all frames is none.
fn frame(mut frame: Value) -> Option<Value> {
    let name = frame.get("child_frame_id")?.as_str()?.to_owned();
    let mut transform = frame.get_mut("transform")?.take();
    pose(&mut transform);
    let is_identity = transform == json!({ "translation": [0, 0, 0], "rotation": { "x": 0, "y": 0, "z": 0, "w": 1 } });
    (!is_identity).then(|| json!({ "child_frame_id": name, "transform": transform }))
}
