//! Primitives and meshes as texts have them.

use std::fmt;
use std::sync::Arc;

use serde::de::{self, IgnoredAny, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use super::SceneError;
use super::numbers::{Corners, Finite, Point};
use super::object_file::MeshSource;
use crate::math::Vec3;
use crate::shape::{Mesh, MeshError, Shape};

#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PrimitiveFile {
    #[serde(rename = "type")]
    kind: PrimitiveKind,
    dimensions: Vec<Finite>,
    /// Of a prism, which is refused.
    #[serde(default, rename = "polygon", skip_serializing)]
    pub(super) _polygon: IgnoredAny,
}

/// A primitive's type: its name, or its number in `shape_msgs/SolidPrimitive`.
#[derive(Clone, Debug, Serialize)]
#[serde(transparent)]
struct PrimitiveKind(String);

impl<'de> Deserialize<'de> for PrimitiveKind {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct KindVisitor;
        impl Visitor<'_> for KindVisitor {
            type Value = PrimitiveKind;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("box (1), sphere (2), cylinder (3) or capsule")
            }
            fn visit_str<E: de::Error>(self, text: &str) -> Result<PrimitiveKind, E> {
                Ok(PrimitiveKind(text.to_ascii_lowercase()))
            }
            fn visit_i64<E: de::Error>(self, number: i64) -> Result<PrimitiveKind, E> {
                self.visit_u64(u64::try_from(number).unwrap_or_default())
            }
            fn visit_u64<E: de::Error>(self, number: u64) -> Result<PrimitiveKind, E> {
                let name = match number {
                    1 => "box",
                    2 => "sphere",
                    3 => "cylinder",
                    4 => "cone",
                    5 => "prism",
                    _ => return Err(E::invalid_value(de::Unexpected::Unsigned(number), &self)),
                };
                Ok(PrimitiveKind(name.to_owned()))
            }
        }
        deserializer.deserialize_any(KindVisitor)
    }
}

/// A mesh: a file, or vertices and triangles, of which the file is then only the name. `resource`
/// and `dimensions` are robowflex's words.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MeshFile {
    #[serde(default, alias = "resource", skip_serializing_if = "String::is_empty")]
    file: String,
    #[serde(
        default = "no_scale",
        alias = "dimensions",
        skip_serializing_if = "is_no_scale"
    )]
    scale: Point,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) vertices: Vec<Point>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    triangles: Vec<Corners>,
    /// Hash of its content in hexadecimal digits; a mesh of another content is refused.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    hash: Option<String>,
}

fn no_scale() -> Point {
    Point([1.0; 3])
}

fn is_no_scale(scale: &Point) -> bool {
    *scale == no_scale()
}

impl PrimitiveFile {
    pub(super) fn of(shape: &Shape) -> Self {
        let (kind, dimensions) = match shape {
            Shape::Box { half_extents } => ("box", (*half_extents * 2.0).to_array().to_vec()),
            Shape::Sphere { radius } => ("sphere", vec![*radius]),
            Shape::Cylinder {
                radius,
                half_height,
            } => ("cylinder", vec![half_height * 2.0, *radius]),
            Shape::Capsule {
                radius,
                half_length,
            } => ("capsule", vec![half_length * 2.0, *radius]),
            Shape::Mesh(_) => unreachable!("a mesh is no primitive"),
        };
        let dimensions = dimensions.into_iter().map(Finite).collect();
        Self {
            kind: PrimitiveKind(kind.to_owned()),
            dimensions,
            _polygon: IgnoredAny,
        }
    }

    pub(super) fn build(&self, id: &str) -> Result<Shape, SceneError> {
        let dimensions: Vec<f64> = self.dimensions.iter().map(|number| number.0).collect();
        let shape = match (self.kind.0.as_str(), dimensions.as_slice()) {
            ("box", &[x, y, z]) => Shape::cuboid(Vec3::new(x, y, z)),
            ("sphere", &[radius]) => Shape::sphere(radius),
            ("cylinder", &[height, radius]) => Shape::cylinder(height, radius),
            ("capsule", &[length, radius]) => Shape::capsule(length, radius),
            ("cone" | "prism", _) => {
                let text = format!(
                    "object {id:?} has a {}, which is not read; use a cylinder or a mesh",
                    self.kind.0
                );
                return Err(SceneError::Syntax(text));
            }
            (kind, dimensions) => {
                let known = "box [x, y, z], sphere [radius], cylinder [height, radius], capsule [length, radius]";
                let text = format!(
                    "object {id:?} has a {kind:?} of {} dimensions; valid: {known}",
                    dimensions.len()
                );
                return Err(SceneError::Syntax(text));
            }
        };
        shape.map_err(|source| SceneError::Shape {
            id: id.to_owned(),
            source,
        })
    }
}

impl MeshFile {
    pub(super) fn of(mesh: &Mesh, with_content: bool) -> Self {
        let mut vertices = Vec::new();
        let mut triangles = Vec::new();
        if with_content {
            vertices = mesh
                .vertices()
                .iter()
                .map(|vertex| Point(vertex.to_array()))
                .collect();
            triangles = mesh.triangles().iter().copied().map(Corners).collect();
        }
        let hash = Some(format!("{:016x}", mesh.hash()));
        Self {
            file: mesh.name().to_owned(),
            scale: no_scale(),
            vertices,
            triangles,
            hash,
        }
    }

    pub(super) fn build(&self, id: &str, meshes: &mut MeshSource<'_>) -> Result<Shape, SceneError> {
        let refuse = |source| SceneError::Mesh {
            id: id.to_owned(),
            source,
        };
        let scale = Vec3::from_array(self.scale.0);
        let mesh = if !self.vertices.is_empty() {
            let vertices = self
                .vertices
                .iter()
                .map(|vertex| Vec3::from_array(vertex.0) * scale)
                .collect();
            let name = if self.file.is_empty() { id } else { &self.file };
            Mesh::new(
                name,
                vertices,
                self.triangles.iter().map(|corners| corners.0).collect(),
            )
            .map(Arc::new)
        } else if self.file.is_empty() {
            let text = format!(
                "object {id:?} has a mesh of nothing; give its file, or its vertices and triangles"
            );
            return Err(SceneError::Syntax(text));
        } else {
            meshes(&self.file, scale)
        };
        let mesh = mesh.map_err(refuse)?;
        let found = format!("{:016x}", mesh.hash());
        match &self.hash {
            Some(wanted) if *wanted != found => {
                let reason = format!(
                    "its content has hash {found}, not {wanted}; give the mesh that is meant"
                );
                Err(refuse(MeshError::Unreadable {
                    name: self.file.clone(),
                    reason,
                }))
            }
            _ => Ok(Shape::Mesh(mesh)),
        }
    }
}
