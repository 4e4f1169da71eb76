//! MoveIt's collision objects as JSON has them.

use std::fmt;
use std::sync::Arc;

use serde::de::{self, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::pose_file::PoseFile;
use super::{Obstacle, SceneError};
use crate::math::{Pose, Vec3};
use crate::shape::{Mesh, MeshError, PlacedShape, Shape};

/// Gives the mesh of a file name (as written in the scene) at a scale.
pub type MeshSource<'a> = dyn FnMut(&str, Vec3) -> Result<Arc<Mesh>, MeshError> + 'a;

/// What a text does with an object: MoveIt's `operation`, by name or number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Operation {
    Add,
    Remove,
    Append,
    Move,
}

impl Operation {
    const ALL: [(Self, &'static str); 4] =
        [(Self::Add, "ADD"), (Self::Remove, "REMOVE"), (Self::Append, "APPEND"), (Self::Move, "MOVE")];

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
            fn visit_str<E: de::Error>(self, text: &str) -> Result<Operation, E> {
                let known = Operation::ALL.iter().find(|(_, name)| name.eq_ignore_ascii_case(text));
                known.map(|known| known.0).ok_or_else(|| E::invalid_value(de::Unexpected::Str(text), &self))
            }
            fn visit_u64<E: de::Error>(self, number: u64) -> Result<Operation, E> {
                let known = usize::try_from(number).ok().and_then(|number| Operation::ALL.get(number));
                known.map(|known| known.0).ok_or_else(|| E::invalid_value(de::Unexpected::Unsigned(number), &self))
            }
        }
        deserializer.deserialize_any(OperationVisitor)
    }
}

/// MoveIt's collision object.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct ObjectFile {
    pub(super) id: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) operation: Option<Operation>,
    #[serde(default, skip_serializing_if = "HeaderFile::is_empty")]
    pub(super) header: HeaderFile,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) pose: Option<PoseFile>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) primitives: Vec<PrimitiveFile>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) primitive_poses: Vec<PoseFile>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) meshes: Vec<MeshFile>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) mesh_poses: Vec<PoseFile>,
    /// Read only to be refused: an infinite plane is no solid here.
    #[serde(default, skip_serializing)]
    pub(super) planes: Vec<de::IgnoredAny>,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct HeaderFile {
    #[serde(default)]
    pub(super) frame_id: String,
}

impl HeaderFile {
    fn is_empty(&self) -> bool {
        self.frame_id.is_empty()
    }
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct PrimitiveFile {
    #[serde(rename = "type")]
    kind: String,
    dimensions: Vec<f64>,
}

/// A mesh: a file, or vertices and triangles, of which the file is then only the name.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct MeshFile {
    file: String,
    #[serde(default = "no_scale", skip_serializing)]
    scale: [f64; 3],
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    vertices: Vec<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    triangles: Vec<[u32; 3]>,
    /// Hash of its content in hexadecimal digits; a mesh of another content is refused.
    #[serde(skip_serializing_if = "Option::is_none")]
    hash: Option<String>,
}

fn no_scale() -> [f64; 3] {
    [1.0; 3]
}

impl ObjectFile {
    /// An object as text has it: what adds it, then what appends shapes whose place in the order needs that. Without
    /// `with_meshes`, a mesh has its name and hash only.
    pub(super) fn of(object: &Obstacle, with_meshes: bool) -> Vec<Self> {
        let mut files = Self::appending(&object.id, &object.shapes, with_meshes);
        let pose = Some(PoseFile::of(&object.pose));
        files[0] = Self { operation: Some(Operation::Add), pose, ..files[0].clone() };
        files
    }

    /// What appends shapes to an object. One text has primitives before meshes; at least one.
    pub(super) fn appending(id: &str, shapes: &[PlacedShape], with_meshes: bool) -> Vec<Self> {
        let is_mesh = |placed: &PlacedShape| matches!(placed.shape, Shape::Mesh(_));
        let mut runs = shapes.chunk_by(|a, b| is_mesh(b) || !is_mesh(a)).collect::<Vec<_>>();
        if runs.is_empty() {
            runs.push(&[]);
        }
        let file = |run: &[PlacedShape]| {
            let mut file = Self { id: id.to_owned(), operation: Some(Operation::Append), ..Self::default() };
            file.set_shapes(run, with_meshes);
            file
        };
        runs.into_iter().map(file).collect()
    }

    fn set_shapes(&mut self, shapes: &[PlacedShape], with_meshes: bool) {
        for placed in shapes {
            let pose = PoseFile::of(&placed.pose);
            match &placed.shape {
                Shape::Mesh(mesh) => {
                    self.meshes.push(MeshFile::of(mesh, with_meshes));
                    self.mesh_poses.push(pose);
                }
                primitive => {
                    self.primitives.push(PrimitiveFile::of(primitive));
                    self.primitive_poses.push(pose);
                }
            }
        }
    }

    /// Whether it brings shapes of its own.
    pub(super) fn has_shapes(&self) -> bool {
        !(self.primitives.is_empty() && self.meshes.is_empty())
    }

    /// Whether it gives poses of shapes.
    pub(super) fn has_shape_poses(&self) -> bool {
        !(self.primitive_poses.is_empty() && self.mesh_poses.is_empty())
    }

    /// Whether a mesh file has to be read for it.
    pub(super) fn names_mesh_files(&self) -> bool {
        self.meshes.iter().any(|mesh| mesh.vertices.is_empty())
    }

    /// Its own pose, if it has one.
    pub(super) fn own_pose(&self) -> Result<Option<Pose>, SceneError> {
        self.pose.map(|pose| pose.build(&self.id)).transpose()
    }

    pub(super) fn build(self, meshes: &mut MeshSource<'_>) -> Result<Obstacle, SceneError> {
        let own = self.own_pose()?.unwrap_or_default();
        let shapes = self.shapes(meshes)?;
        Ok(Obstacle::new(self.id, shapes).at(own))
    }

    pub(super) fn shapes(&self, meshes: &mut MeshSource<'_>) -> Result<Vec<PlacedShape>, SceneError> {
        let id = &self.id;
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
        let mut shapes = Vec::new();
        for (primitive, pose) in self.primitives.iter().zip(&self.primitive_poses) {
            shapes.push(PlacedShape { pose: pose.build(id)?, shape: primitive.build(id)? });
        }
        for (mesh, pose) in self.meshes.iter().zip(&self.mesh_poses) {
            shapes.push(PlacedShape { pose: pose.build(id)?, shape: mesh.build(id, meshes)? });
        }
        Ok(shapes)
    }
}

impl PrimitiveFile {
    fn of(shape: &Shape) -> Self {
        let (kind, dimensions) = match shape {
            Shape::Box { half_extents } => ("box", (*half_extents * 2.0).to_array().to_vec()),
            Shape::Sphere { radius } => ("sphere", vec![*radius]),
            Shape::Cylinder { radius, half_height } => ("cylinder", vec![half_height * 2.0, *radius]),
            Shape::Capsule { radius, half_length } => ("capsule", vec![half_length * 2.0, *radius]),
            Shape::Mesh(_) => unreachable!("a mesh is no primitive"),
        };
        Self { kind: kind.to_owned(), dimensions }
    }

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

impl MeshFile {
    fn of(mesh: &Mesh, with_content: bool) -> Self {
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        if with_content {
            vertices = mesh.vertices().iter().map(|vertex| vertex.to_array()).collect();
            triangles = mesh.triangles().to_vec();
        }
        let hash = Some(format!("{:016x}", mesh.hash()));
        Self { file: mesh.name().to_owned(), scale: no_scale(), vertices, triangles, hash }
    }

    fn build(&self, id: &str, meshes: &mut MeshSource<'_>) -> Result<Shape, SceneError> {
        let refuse = |source| SceneError::Mesh { id: id.to_owned(), source };
        let scale = Vec3::from_array(self.scale);
        let mesh = if self.vertices.is_empty() {
            meshes(&self.file, scale)
        } else {
            let vertices = self.vertices.iter().map(|vertex| Vec3::from_array(*vertex) * scale).collect();
            Mesh::new(self.file.clone(), vertices, self.triangles.clone()).map(Arc::new)
        };
        let mesh = mesh.map_err(refuse)?;
        let found = format!("{:016x}", mesh.hash());
        match &self.hash {
            Some(wanted) if *wanted != found => {
                let reason = format!("its content has hash {found}, not {wanted}; give the mesh that is meant");
                Err(refuse(MeshError::Unreadable { name: self.file.clone(), reason }))
            }
            _ => Ok(Shape::Mesh(mesh)),
        }
    }
}
