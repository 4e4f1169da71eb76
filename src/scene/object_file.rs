//! MoveIt's collision objects as JSON has them.

use std::fmt;

use serde::de::{self, IgnoredAny, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::cloud_file::{ByteSource, CloudFile, Word};
use super::object::set_identity;
use super::pose_file::{HeaderFile, PoseFile, not_set};
use super::sensing::SensingFile;
pub use super::shape_file::MeshSource;
use super::shape_file::{MeshFile, PrimitiveFile};
use super::{Obstacle, Scene, SceneError};
use crate::math::Pose;
use crate::shape::{Cloud, Description, PlacedShape, Shape};
use crate::warning::Warning;

/// What a text does with an object: MoveIt's `operation`, by name or number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Operation {
    Add,
    Remove,
    Append,
    Move,
}

impl Operation {
    const ALL: [(Self, &'static str); 4] = [
        (Self::Add, "ADD"),
        (Self::Remove, "REMOVE"),
        (Self::Append, "APPEND"),
        (Self::Move, "MOVE"),
    ];

    /// Its name in MoveIt's messages.
    pub(super) fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }
}

impl Serialize for Operation {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl<'de> Deserialize<'de> for Operation {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OperationVisitor;
        impl Visitor<'_> for OperationVisitor {
            type Value = Operation;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("ADD (0), REMOVE (1), APPEND (2) or MOVE (3)")
            }
            /// By its name, or as ROS prints a byte: the character of that code.
            fn visit_str<E: de::Error>(self, text: &str) -> Result<Operation, E> {
                if let &[byte @ 0..=3] = text.as_bytes() {
                    return self.visit_u64(byte.into());
                }
                let known = Operation::ALL
                    .iter()
                    .find(|(_, name)| name.eq_ignore_ascii_case(text));
                known
                    .map(|known| known.0)
                    .ok_or_else(|| E::invalid_value(de::Unexpected::Str(text), &self))
            }
            fn visit_bytes<E: de::Error>(self, bytes: &[u8]) -> Result<Operation, E> {
                match bytes {
                    &[byte] => self.visit_u64(byte.into()),
                    _ => Err(E::invalid_value(de::Unexpected::Bytes(bytes), &self)),
                }
            }
            fn visit_i64<E: de::Error>(self, number: i64) -> Result<Operation, E> {
                let refuse = |_| E::invalid_value(de::Unexpected::Signed(number), &self);
                u64::try_from(number)
                    .map_err(refuse)
                    .and_then(|number| self.visit_u64(number))
            }
            fn visit_u64<E: de::Error>(self, number: u64) -> Result<Operation, E> {
                let known = usize::try_from(number)
                    .ok()
                    .and_then(|number| Operation::ALL.get(number));
                known
                    .map(|known| known.0)
                    .ok_or_else(|| E::invalid_value(de::Unexpected::Unsigned(number), &self))
            }
        }
        deserializer.deserialize_any(OperationVisitor)
    }
}

/// MoveIt's collision object. What is ignored by name adds nothing that could be met.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectFile {
    pub(super) id: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) operation: Option<Operation>,
    #[serde(default, skip_serializing_if = "HeaderFile::is_empty")]
    pub(super) header: HeaderFile,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) pose: Option<PoseFile>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) primitives: Vec<PrimitiveFile>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) primitive_poses: Vec<PoseFile>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) meshes: Vec<MeshFile>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) mesh_poses: Vec<PoseFile>,
    /// Where its shape comes from a sensor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) sensed: Option<SensingFile>,
    /// Points, which are all of the object.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) cloud: Option<CloudFile>,
    /// The cells of a map, which are all of the object.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) octomap: Option<CloudFile>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) subframe_names: Vec<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) subframe_poses: Vec<PoseFile>,
    /// Read only to be refused: an infinite plane is no solid here. Written, since a YAML text is
    /// read as the JSON that is made of it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) planes: Vec<serde_json::Value>,
    #[serde(default, rename = "plane_poses", skip_serializing)]
    pub(super) _plane_poses: IgnoredAny,
    /// What kind of thing it is, for databases.
    #[serde(default, rename = "type", skip_serializing)]
    pub(super) _type: IgnoredAny,
    /// A note of problem files on what other optimizers make of it.
    #[serde(default, rename = "peers_treat_it_as", skip_serializing)]
    pub(super) _peers_treat_it_as: IgnoredAny,
}

/// MoveIt's attached collision object.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AttachedObjectFile {
    #[serde(default)]
    pub(super) link_name: String,
    pub(super) object: ObjectFile,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) touch_links: Vec<String>,
    /// How a gripper opens to let go, and how heavy it is.
    #[serde(default, rename = "detach_posture", skip_serializing)]
    pub(super) _detach_posture: IgnoredAny,
    #[serde(default, rename = "weight", skip_serializing)]
    pub(super) _weight: IgnoredAny,
}

impl ObjectFile {
    /// An object as text has it: what adds it, then what appends shapes whose place in the order
    /// needs that. Without `with_meshes`, a mesh has its name and hash only.
    pub(super) fn of(object: &Obstacle, with_meshes: bool) -> Vec<Self> {
        let object = &object.unseen();
        let mut files = Self::appending(&object.id, &object.shapes, with_meshes);
        // The first of several shapes is not taken for the object's frame.
        let is_alone = object.shapes.len() > 1
            && files[0].shape_count() == 1
            && object.pose == Pose::identity();
        let pose = Some(PoseFile::of(&if is_alone {
            set_identity()
        } else {
            object.pose
        }));
        files[0] = Self {
            operation: Some(Operation::Add),
            pose,
            sensed: object.sensed.as_deref().map(SensingFile::of),
            ..files[0].clone()
        };
        files
    }

    /// What appends shapes to an object. One text has primitives before meshes; at least one.
    pub(super) fn appending(id: &str, shapes: &[PlacedShape], with_meshes: bool) -> Vec<Self> {
        let is_mesh = |placed: &PlacedShape| placed.shape.mesh().is_some();
        let mut runs = shapes
            .chunk_by(|a, b| is_mesh(b) || !is_mesh(a))
            .collect::<Vec<_>>();
        if runs.is_empty() {
            runs.push(&[]);
        }
        let file = |run: &[PlacedShape]| {
            let mut file = Self {
                id: id.to_owned(),
                operation: Some(Operation::Append),
                ..Self::default()
            };
            file.set_shapes(run, with_meshes);
            file
        };
        runs.into_iter().map(file).collect()
    }

    fn set_shapes(&mut self, shapes: &[PlacedShape], with_meshes: bool) {
        for placed in shapes {
            let pose = PoseFile::of(&placed.pose);
            match placed.shape.description() {
                Description::Mesh(mesh) => {
                    self.meshes
                        .push(MeshFile::of(mesh, with_meshes));
                    self.mesh_poses.push(pose);
                }
                Description::Cloud(cloud) => self.set_cloud(placed, cloud, with_meshes),
                Description::Primitive(kind, dimensions) => {
                    let file = PrimitiveFile::of(kind, kind.own(&dimensions));
                    self.primitives.push(file);
                    self.primitive_poses.push(pose);
                }
            }
        }
    }

    /// Writes a cloud, which no object has other shapes beside.
    fn set_cloud(&mut self, placed: &PlacedShape, cloud: &Cloud, with_content: bool) {
        let words = CloudFile::of(cloud, with_content);
        let words = Some(words.at(&placed.pose));
        match Word::of(cloud) {
            Word::Cloud => self.cloud = words,
            Word::Octomap => self.octomap = words,
        }
    }

    /// Its cloud or octomap.
    fn scanned(&self) -> Option<&CloudFile> {
        self.cloud.as_ref().or(self.octomap.as_ref())
    }

    /// Reads the file of its cloud or octomap.
    pub(super) fn read_clouds(&mut self, bytes: &mut ByteSource<'_>) -> Result<(), SceneError> {
        for (word, file) in [
            (Word::Cloud, &mut self.cloud),
            (Word::Octomap, &mut self.octomap),
        ] {
            if let Some(file) = file {
                file.read(&self.id, word, bytes)?;
            }
        }
        Ok(())
    }

    /// Whether it brings shapes of its own.
    pub(super) fn has_shapes(&self) -> bool {
        self.shape_count() > 0 || self.sensed.is_some()
    }

    fn shape_count(&self) -> usize {
        let sensed = [&self.cloud, &self.octomap]
            .into_iter()
            .flatten();
        self.primitives.len() + self.meshes.len() + sensed.count()
    }

    /// Whether it gives poses of shapes.
    pub(super) fn has_shape_poses(&self) -> bool {
        !(self.primitive_poses.is_empty() && self.mesh_poses.is_empty())
    }

    /// Whether a mesh file or that of a cloud has to be read for it.
    pub(super) fn names_files(&self) -> bool {
        let names_mesh = self
            .meshes
            .iter()
            .any(|mesh| mesh.vertices.is_empty());
        names_mesh
            || self
                .scanned()
                .is_some_and(CloudFile::names_file)
    }

    /// Its own pose, if it has one.
    pub(super) fn own_pose(&self) -> Result<Option<Pose>, SceneError> {
        self.pose
            .map(|pose| pose.build_own(&self.id))
            .transpose()
    }

    /// Whether it says nothing of where it is, as MoveIt takes it.
    pub(super) fn is_unplaced(&self) -> bool {
        self.pose.is_none_or(|pose| pose.is_identity())
    }

    /// Says the sub-frames of an object, and what its text calls the world.
    pub(super) fn say_frames(&mut self, scene: &Scene, id: &str) {
        self.say_subframes(scene, id);
        self.header = HeaderFile::of(scene.world_of(id).unwrap_or_default());
    }

    pub(super) fn say_subframes(&mut self, scene: &Scene, id: &str) {
        for (name, pose) in scene.subframes_of(id) {
            self.subframe_names.push(name.to_owned());
            self.subframe_poses.push(PoseFile::of(pose));
        }
    }

    /// Refuses a pose that APPEND would not follow.
    pub(super) fn check_appends(&self) -> Result<(), SceneError> {
        if self.scanned().is_some() {
            let text = format!(
                "object {:?} has a cloud or octomap, which nothing is appended to; ADD takes the place of the former one",
                self.id
            );
            return Err(SceneError::Syntax(text));
        }
        match self.is_unplaced() {
            true => Ok(()),
            false => {
                let text = format!(
                    "object {:?} has a pose, which APPEND does not change; MOVE does",
                    self.id
                );
                Err(SceneError::Syntax(text))
            }
        }
    }

    /// Frames on it by name, in its own.
    pub(super) fn subframes(&self) -> Result<Vec<(String, Pose)>, SceneError> {
        let id = &self.id;
        let names = &self.subframe_names;
        let poses = &self.subframe_poses;
        if names.len() != poses.len() {
            let names = names.len();
            let poses = poses.len();
            let text = format!(
                "object {id:?} has {names} subframe_names and {poses} subframe_poses; each needs one"
            );
            return Err(SceneError::Syntax(text));
        }
        let built = poses
            .iter()
            .enumerate()
            .map(|(index, pose)| pose.build(id, &format!("subframe_poses[{index}]")));
        names
            .iter()
            .zip(built)
            .map(|(name, pose)| Ok((name.clone(), pose?)))
            .collect()
    }

    /// What is odd about its poses, a line each.
    pub(super) fn warnings(&self) -> Vec<Warning> {
        let lists = [
            ("primitive_poses", &self.primitive_poses),
            ("mesh_poses", &self.mesh_poses),
            ("subframe_poses", &self.subframe_poses),
        ];
        let listed = lists.iter().flat_map(|(name, list)| {
            list.iter()
                .enumerate()
                .map(move |(index, pose)| (format!("{name}[{index}]"), *pose))
        });
        let own = self.pose.map(|pose| ("pose".to_owned(), pose));
        let unset = own
            .into_iter()
            .chain(listed)
            .filter(|(_, pose)| pose.is_unturned());
        let text = |what: &str| format!("object {:?}: {}", self.id, not_set(what));
        unset
            .map(|(what, _)| Warning::uncovered(text(&what)))
            .collect()
    }

    pub(super) fn build(self, meshes: &mut MeshSource<'_>) -> Result<Obstacle, SceneError> {
        let own = self.own_pose()?.unwrap_or_default();
        let shapes = self.shapes(meshes)?;
        let sensed = self.sensed.map(|file| file.build().into());
        if sensed.is_some() && !shapes.is_empty() {
            return Err(SceneError::SensedShapes(self.id));
        }
        let object = Obstacle {
            sensed,
            ..Obstacle::new(self.id, shapes)
        };
        Ok(object.at(own).told_plainly())
    }

    pub(super) fn shapes(
        &self,
        meshes: &mut MeshSource<'_>,
    ) -> Result<Vec<PlacedShape>, SceneError> {
        let id = &self.id;
        if !self.planes.is_empty() {
            return Err(SceneError::Syntax(format!(
                "object {id:?} has planes; use a thick box instead"
            )));
        }
        for (shapes, count, poses) in [
            (
                "primitives",
                self.primitives.len(),
                self.primitive_poses.len(),
            ),
            ("meshes", self.meshes.len(), self.mesh_poses.len()),
        ] {
            if count != poses {
                let text = format!("object {id:?} has {count} {shapes} and {poses} poses for them");
                return Err(SceneError::Syntax(format!("{text}; each needs one")));
            }
        }
        if let Some(sensed) = self.scanned() {
            self.check_alone()?;
            let pose = sensed.pose(id)?;
            let shape = Shape::Cloud(sensed.build(id)?);
            return Ok(vec![PlacedShape { pose, shape }]);
        }
        let mut shapes = Vec::new();
        for (index, (primitive, pose)) in self
            .primitives
            .iter()
            .zip(&self.primitive_poses)
            .enumerate()
        {
            let pose = pose.build(id, &format!("primitive_poses[{index}]"))?;
            shapes.push(PlacedShape {
                pose,
                shape: primitive.build(id)?,
            });
        }
        for (index, (mesh, pose)) in self
            .meshes
            .iter()
            .zip(&self.mesh_poses)
            .enumerate()
        {
            let pose = pose.build(id, &format!("mesh_poses[{index}]"))?;
            shapes.push(PlacedShape {
                pose,
                shape: mesh.build(id, meshes)?,
            });
        }
        Ok(shapes)
    }

    /// Refuses shapes beside a cloud or octomap.
    fn check_alone(&self) -> Result<(), SceneError> {
        match self.shape_count() {
            1 => Ok(()),
            _ => Err(SceneError::Syntax(format!(
                "object {:?} has other shapes beside its cloud or octomap, which is an object of its own; give them another id",
                self.id
            ))),
        }
    }
}
