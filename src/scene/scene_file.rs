//! Scene files: JSON with MoveIt's collision objects.
//!
//! ```json
//! { "name": "kitchen", "allowed_collisions": [["hand", "cup"]],
//!   "objects": [ { "id": "table",
//!     "primitives": [ { "type": "box", "dimensions": [1.2, 0.8, 0.05] } ],
//!     "primitive_poses": [ { "position": [0.5, 0, 0.4], "orientation": { "x": 0, "y": 0, "z": 0, "w": 1 } } ] } ] }
//! ```
//! What links carry, with poses in the link's frame, and what is thicker or checked in any case:
//!
//! ```json
//! { "objects": [],
//!   "attached_collision_objects": [ { "link_name": "hand", "touch_links": ["finger_left", "finger_right"],
//!     "object": { "id": "cup", "pose": { "position": [0, 0, 0.1] },
//!       "primitives": [ { "type": "cylinder", "dimensions": [0.1, 0.03] } ], "primitive_poses": [ {} ] } } ],
//!   "link_padding": [ { "link_name": "forearm", "padding": 0.02 } ],
//!   "forbidden_collisions": [["forearm", "cup"]] }
//! ```
//! Lengths in metres. `dimensions` are MoveIt's: box x y z; sphere radius; cylinder height, radius;
//! ours: capsule length of its straight part, radius. `meshes` give `file` and `scale`, with
//! `mesh_poses`. An object's own `pose`, where there is one, carries all its shapes. `link_padding` may also be a map
//! from names to lengths, and name objects.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::{AttachedObject, Obstacle, Scene, SceneDescription, SceneError};
use crate::math::{Pose, Quat, Vec3};
use crate::shape::{Mesh, MeshError, PlacedShape, Shape};

/// Norms of quaternions may differ from 1 by this much; they are then normalised.
const NORM_TOLERANCE: f64 = 1e-3;

/// Gives the mesh of a file name (as written in the scene) at a scale.
pub type MeshSource<'a> = dyn FnMut(&str, Vec3) -> Result<Arc<Mesh>, MeshError> + 'a;

/// A scene as its file says it, unchecked. Unknown fields are ignored.
#[derive(Clone, Debug, Default, Deserialize)]
pub struct SceneFile {
    /// Label.
    #[serde(default)]
    pub name: String,
    /// Objects in file order.
    pub objects: Vec<ObjectFile>,
    /// Pairs of links or objects that may touch.
    #[serde(default)]
    pub allowed_collisions: Vec<(String, String)>,
    /// Pairs of links or objects that are checked whatever allows them to touch.
    #[serde(default)]
    pub forbidden_collisions: Vec<(String, String)>,
    /// What links carry.
    #[serde(default)]
    pub attached_collision_objects: Vec<AttachedObjectFile>,
    /// Links and objects that count as thicker.
    #[serde(default)]
    pub link_padding: PaddingFile,
}

/// MoveIt's attached collision object.
#[derive(Clone, Debug, Deserialize)]
pub struct AttachedObjectFile {
    link_name: String,
    object: ObjectFile,
    #[serde(default)]
    touch_links: Vec<String>,
}

/// Paddings (m) by name, written as MoveIt's list or as a map.
#[derive(Clone, Debug, Default)]
pub struct PaddingFile(BTreeMap<String, f64>);

/// MoveIt's collision object.
#[derive(Clone, Debug, Deserialize)]
pub struct ObjectFile {
    id: String,
    #[serde(default)]
    header: HeaderFile,
    pose: Option<PoseFile>,
    #[serde(default)]
    primitives: Vec<PrimitiveFile>,
    #[serde(default)]
    primitive_poses: Vec<PoseFile>,
    #[serde(default)]
    meshes: Vec<MeshFile>,
    #[serde(default)]
    mesh_poses: Vec<PoseFile>,
    /// Read only to be refused: an infinite plane is no solid here.
    #[serde(default)]
    planes: Vec<serde::de::IgnoredAny>,
}

#[derive(Clone, Debug, Default, Deserialize)]
struct HeaderFile {
    #[serde(default)]
    frame_id: String,
}

#[derive(Clone, Debug, Deserialize)]
struct PrimitiveFile {
    #[serde(rename = "type")]
    kind: String,
    dimensions: Vec<f64>,
}

#[derive(Clone, Debug, Deserialize)]
struct MeshFile {
    file: String,
    #[serde(default = "no_scale")]
    scale: [f64; 3],
}

fn no_scale() -> [f64; 3] {
    [1.0; 3]
}

#[derive(Clone, Copy, Debug, Deserialize)]
struct PoseFile {
    #[serde(default)]
    position: [f64; 3],
    #[serde(default)]
    orientation: QuaternionFile,
}

#[derive(Clone, Copy, Debug, Deserialize)]
struct QuaternionFile {
    x: f64,
    y: f64,
    z: f64,
    w: f64,
}

impl Default for QuaternionFile {
    fn default() -> Self {
        Self { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }
    }
}

/// Reads a scene's JSON text.
///
/// # Errors
/// No JSON of this form (with line and column), an object whose sizes, poses or meshes are none.
pub fn parse(text: &str, meshes: &mut MeshSource<'_>) -> Result<Scene, SceneError> {
    let file: SceneFile = serde_json::from_str(text).map_err(|error| SceneError::Syntax(error.to_string()))?;
    file.build(meshes)
}

impl SceneFile {
    /// Checks every object and builds the scene.
    ///
    /// # Errors
    /// An object whose sizes, poses or meshes are none.
    pub fn build(self, meshes: &mut MeshSource<'_>) -> Result<Scene, SceneError> {
        let obstacles = self.objects.into_iter().map(|object| object.build(meshes));
        let obstacles = obstacles.collect::<Result<_, _>>()?;
        let attached = self.attached_collision_objects.into_iter().map(|object| object.build(meshes));
        let attached = attached.collect::<Result<_, _>>()?;
        let description = SceneDescription {
            name: self.name,
            obstacles,
            attached,
            padding: self.link_padding.0,
            allowed: self.allowed_collisions,
            forbidden: self.forbidden_collisions,
            ..SceneDescription::default()
        };
        Scene::of(description)
    }
}

impl AttachedObjectFile {
    fn build(self, meshes: &mut MeshSource<'_>) -> Result<AttachedObject, SceneError> {
        let (id, link_name, frame) = (&self.object.id, &self.link_name, &self.object.header.frame_id);
        // Taken for poses in the link's frame, those of another frame would put the object elsewhere unseen.
        if !frame.is_empty() && frame != link_name {
            let text = format!("object {id:?} is attached to {link_name:?}, but its poses are in the frame {frame:?}");
            return Err(SceneError::Syntax(format!("{text}; give them in the frame of {link_name:?}")));
        }
        let object = self.object.build(meshes)?;
        Ok(AttachedObject { link_name: self.link_name, object, touch_links: self.touch_links })
    }
}

impl<'de> Deserialize<'de> for PaddingFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(PaddingVisitor)
    }
}

struct PaddingVisitor;

impl<'de> Visitor<'de> for PaddingVisitor {
    type Value = PaddingFile;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a list of { \"link_name\": …, \"padding\": … } or a map from names to lengths (m)")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<PaddingFile, A::Error> {
        #[derive(Deserialize)]
        struct Entry {
            link_name: String,
            padding: f64,
        }
        let mut file = PaddingFile::default();
        while let Some(Entry { link_name, padding }) = list.next_element()? {
            file.add(link_name, padding)?;
        }
        Ok(file)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<PaddingFile, A::Error> {
        let mut file = PaddingFile::default();
        while let Some((name, padding)) = map.next_entry()? {
            file.add(name, padding)?;
        }
        Ok(file)
    }
}

impl PaddingFile {
    fn add<E: Error>(&mut self, name: String, padding: f64) -> Result<(), E> {
        match self.0.insert(name.clone(), padding) {
            None => Ok(()),
            Some(before) => {
                Err(E::custom(format!("link_padding gives {name:?} both {before} and {padding}; give it one")))
            }
        }
    }
}

impl ObjectFile {
    fn build(self, meshes: &mut MeshSource<'_>) -> Result<Obstacle, SceneError> {
        let id = self.id;
        if !self.planes.is_empty() {
            return Err(SceneError::Syntax(format!("object {id:?} has planes; use a thick box instead")));
        }
        for (shapes, count, poses) in [
            ("primitives", self.primitives.len(), self.primitive_poses.len()),
            ("meshes", self.meshes.len(), self.mesh_poses.len()),
        ] {
            if count != poses {
                let text = format!("object {id:?} has {count} {shapes} and {poses} poses for them");
                return Err(SceneError::Syntax(format!("{text}; each needs one")));
            }
        }
        let own = self.pose.map_or(Ok(Pose::identity()), |pose| pose.build(&id))?;
        let mut shapes = Vec::new();
        for (primitive, pose) in self.primitives.iter().zip(&self.primitive_poses) {
            shapes.push(PlacedShape { pose: pose.build(&id)?, shape: primitive.build(&id)? });
        }
        for (mesh, pose) in self.meshes.iter().zip(&self.mesh_poses) {
            let source = meshes(&mesh.file, Vec3::from_array(mesh.scale));
            let shape = Shape::Mesh(source.map_err(|source| SceneError::Mesh { id: id.clone(), source })?);
            shapes.push(PlacedShape { pose: pose.build(&id)?, shape });
        }
        Ok(Obstacle::new(id, shapes).at(own))
    }
}

impl PrimitiveFile {
    fn build(&self, id: &str) -> Result<Shape, SceneError> {
        let shape = match (self.kind.to_ascii_lowercase().as_str(), self.dimensions.as_slice()) {
            ("box", &[x, y, z]) => Shape::cuboid(Vec3::new(x, y, z)),
            ("sphere", &[radius]) => Shape::sphere(radius),
            ("cylinder", &[height, radius]) => Shape::cylinder(height, radius),
            ("capsule", &[length, radius]) => Shape::capsule(length, radius),
            (kind, dimensions) => {
                let known = "box [x, y, z], sphere [radius], cylinder [height, radius], capsule [length, radius]";
                let text = format!("object {id:?} has a {kind:?} of {} dimensions; valid: {known}", dimensions.len());
                return Err(SceneError::Syntax(text));
            }
        };
        shape.map_err(|source| SceneError::Shape { id: id.to_owned(), source })
    }
}

impl PoseFile {
    fn build(&self, id: &str) -> Result<Pose, SceneError> {
        let QuaternionFile { x, y, z, w } = self.orientation;
        checked_pose(id, self.position, [x, y, z, w])
    }
}

/// The pose of a position (m) and a quaternion (x, y, z, w) that is of unit length but for rounding.
///
/// # Errors
/// A number that is not finite, or a quaternion that is no rotation; `id` is the object whose pose it is.
pub(super) fn checked_pose(id: &str, position: [f64; 3], [x, y, z, w]: [f64; 4]) -> Result<Pose, SceneError> {
    let bad = |what, value, rule| SceneError::BadPose { id: id.to_owned(), what, value, rule };
    let position = Vec3::from_array(position);
    if !position.is_finite() {
        return Err(bad("position", position.to_string(), "it must be finite"));
    }
    let rotation = Quat::from_xyzw(x, y, z, w);
    let norm = rotation.length();
    if !norm.is_finite() || (norm - 1.0).abs() > NORM_TOLERANCE {
        let value = format!("x {x}, y {y}, z {z}, w {w} (norm {norm})");
        return Err(bad("orientation", value, "it must be a unit quaternion"));
    }
    Ok(Pose::from_parts(position, rotation.normalize()))
}
