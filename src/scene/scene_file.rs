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
//! Frames by which objects may be placed, and links or objects that count as larger:
//!
//! ```json
//! { "fixed_frame_transforms": [ { "child_frame_id": "shelf", "transform": { "translation": [1, 0, 0.8] } } ],
//!   "objects": [ { "id": "box", "header": { "frame_id": "shelf" }, "pose": { "position": [0, 0.2, 0.1] },
//!     "primitives": [ { "type": "box", "dimensions": [0.1, 0.1, 0.2] } ], "primitive_poses": [ {} ] } ],
//!   "link_scale": [ { "link_name": "hand", "scale": 1.05 } ] }
//! ```
//! Lengths in metres. `dimensions` are MoveIt's: box x y z; sphere radius; cylinder height, radius;
//! ours: capsule length of its straight part, radius. `meshes` give `file` and `scale`, with
//! `mesh_poses`; one with `vertices` and `triangles` is not read from its file. An object's own `pose`, where there is
//! one, carries all its shapes. `link_padding` and `link_scale` may also be maps from names to numbers, and name
//! objects. A `frame_id` that is no frame of the file is taken for the world's.

use serde::{Deserialize, Serialize};

use super::numbers_file::{Paddings, Scales};
use super::object_file::Operation;
pub use super::object_file::{MeshSource, ObjectFile};
use super::pose_file::FrameFile;
use super::{AttachedObject, Obstacle, Scene, SceneDescription, SceneError};

/// A scene as its file says it, unchecked. Unknown fields are ignored.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct SceneFile {
    /// Label.
    #[serde(default)]
    pub name: String,
    /// Read only to be refused: a diff is no scene.
    #[serde(default, skip_serializing)]
    is_diff: bool,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    fixed_frame_transforms: Vec<FrameFile>,
    /// Objects in file order.
    pub objects: Vec<ObjectFile>,
    /// What links carry.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub attached_collision_objects: Vec<AttachedObjectFile>,
    /// Pairs of links or objects that may touch.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub allowed_collisions: Vec<(String, String)>,
    /// Pairs of links or objects that are checked whatever allows them to touch.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub forbidden_collisions: Vec<(String, String)>,
    /// Links and objects that count as thicker.
    #[serde(default, skip_serializing_if = "Paddings::is_empty")]
    pub link_padding: Paddings,
    /// Links and objects that count as larger.
    #[serde(default, skip_serializing_if = "Scales::is_empty")]
    pub link_scale: Scales,
}

/// MoveIt's attached collision object.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct AttachedObjectFile {
    #[serde(default)]
    pub(super) link_name: String,
    pub(super) object: ObjectFile,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) touch_links: Vec<String>,
}

/// Reads a scene's JSON text.
///
/// # Errors
/// No JSON of this form (with line and column), an object whose sizes, poses or meshes are none.
pub fn parse(text: &str, meshes: &mut MeshSource<'_>) -> Result<Scene, SceneError> {
    let file: SceneFile = serde_json::from_str(text).map_err(|error| SceneError::Syntax(error.to_string()))?;
    file.build(meshes)
}

/// The text of a scene; [`parse`] makes a scene of the same hash of it. Without `with_meshes`, a mesh has its name and
/// hash only, and is looked for under that name when the text is read.
pub fn text(scene: &Scene, with_meshes: bool) -> String {
    serde_json::to_string(&SceneFile::of(scene, with_meshes)).expect("a scene holds only names and finite numbers")
}

impl SceneFile {
    /// What a file says of a scene, as [`text`] does.
    pub fn of(scene: &Scene, with_meshes: bool) -> Self {
        let pairs = |pairs: &mut dyn Iterator<Item = (&str, &str)>| -> Vec<(String, String)> {
            pairs.map(|(a, b)| (a.to_owned(), b.to_owned())).collect()
        };
        let attached = scene.attached().iter().flat_map(|attached| AttachedObjectFile::of(attached, with_meshes));
        Self {
            name: scene.name().to_owned(),
            is_diff: false,
            fixed_frame_transforms: scene.frames().map(|(name, pose)| FrameFile::of(name, Some(pose))).collect(),
            objects: scene.obstacles().iter().flat_map(|object| ObjectFile::of(object, with_meshes)).collect(),
            attached_collision_objects: attached.collect(),
            allowed_collisions: pairs(&mut scene.allowed()),
            forbidden_collisions: pairs(&mut scene.forbidden()),
            link_padding: Paddings::of(scene.padded()),
            link_scale: Scales::of(scene.scaled()),
        }
    }

    /// Checks every object and builds the scene.
    ///
    /// # Errors
    /// An object whose sizes, poses or meshes are none; a diff.
    pub fn build(self, meshes: &mut MeshSource<'_>) -> Result<Scene, SceneError> {
        if self.is_diff {
            let text = "it is a diff (is_diff is set), not a whole scene; apply it to the scene that it changes";
            return Err(SceneError::Syntax(text.to_owned()));
        }
        let frames = self.fixed_frame_transforms.iter().filter_map(|frame| {
            let pose = frame.pose().transpose()?;
            Some(pose.map(|pose| (frame.child_frame_id.clone(), pose)))
        });
        // Poses in them are resolved by a scene that has nothing else.
        let frames: SceneDescription =
            SceneDescription { frames: frames.collect::<Result<_, _>>()?, ..Default::default() };
        let placed = Scene::of(frames.clone())?;
        let mut obstacles: Vec<Obstacle> = Vec::new();
        for object in self.objects {
            let frame = object.header.frame_id.clone();
            if let Some(mut built) = object.added(meshes, obstacles.last_mut())? {
                if frames.frames.contains_key(&frame) {
                    built.pose = placed.in_world(&frame, &built.pose)?;
                }
                obstacles.push(built);
            }
        }
        let mut attached: Vec<AttachedObject> = Vec::new();
        for entry in self.attached_collision_objects {
            let last = attached.last_mut().map(|attached| &mut attached.object);
            let built = entry.build(meshes, last)?;
            attached.extend(built);
        }
        let description = SceneDescription {
            name: self.name,
            obstacles,
            attached,
            padding: self.link_padding.0,
            scale: self.link_scale.0,
            allowed: self.allowed_collisions,
            forbidden: self.forbidden_collisions,
            ..frames
        };
        Scene::of(description)
    }
}

impl ObjectFile {
    /// An object of a whole scene, which is only added to; `None` where it appends shapes to the last one.
    fn added(self, meshes: &mut MeshSource<'_>, last: Option<&mut Obstacle>) -> Result<Option<Obstacle>, SceneError> {
        match (self.operation, last) {
            (None | Some(Operation::Add), _) => self.build(meshes).map(Some),
            (Some(Operation::Append), Some(last)) if last.id == self.id => {
                last.shapes = last.shapes.iter().cloned().chain(self.shapes(meshes)?).collect();
                Ok(None)
            }
            (Some(other), _) => {
                let text = format!("object {:?} has the operation {} in a whole scene", self.id, other.name());
                let valid = "valid: ADD, and APPEND right after it; set is_diff and apply it to change a scene";
                Err(SceneError::Syntax(format!("{text}; {valid}")))
            }
        }
    }
}

impl AttachedObjectFile {
    /// What attaches an object, and what then appends shapes.
    pub(super) fn of(attached: &AttachedObject, with_meshes: bool) -> Vec<Self> {
        let mut touch_links = attached.touch_links.clone();
        let file = |object| Self {
            link_name: attached.link_name.clone(),
            object,
            touch_links: std::mem::take(&mut touch_links),
        };
        ObjectFile::of(&attached.object, with_meshes).into_iter().map(file).collect()
    }

    fn build(
        self,
        meshes: &mut MeshSource<'_>,
        last: Option<&mut Obstacle>,
    ) -> Result<Option<AttachedObject>, SceneError> {
        self.check_frame()?;
        let Self { link_name, object, touch_links } = self;
        Ok(object.added(meshes, last)?.map(|object| AttachedObject { link_name, object, touch_links }))
    }

    /// Refuses what names no link, or poses in another frame than the link's: taken for poses in that, they would put
    /// the object elsewhere unseen.
    pub(super) fn check_frame(&self) -> Result<(), SceneError> {
        let (id, link_name, frame) = (&self.object.id, &self.link_name, &self.object.header.frame_id);
        if link_name.is_empty() {
            return Err(SceneError::Syntax(format!("object {id:?} is attached to no link; give its link_name")));
        }
        if !frame.is_empty() && frame != link_name {
            let text = format!("object {id:?} is attached to {link_name:?}, but its poses are in the frame {frame:?}");
            return Err(SceneError::Syntax(format!("{text}; give them in the frame of {link_name:?}")));
        }
        Ok(())
    }
}
