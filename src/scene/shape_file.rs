//! Primitives and meshes as texts have them.

use std::fmt;
use std::sync::Arc;

use serde::de::{self, IgnoredAny, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use super::SceneError;
use super::numbers::{Corners, Finite, Point};
use crate::math::Vec3;
use crate::shape::{Mesh, MeshError, PRIMITIVES, PrimitiveKind, Shape};

/// Gives the mesh of a file name (as written in the scene) at a scale.
pub type MeshSource<'a> = dyn FnMut(&str, Vec3) -> Result<Arc<Mesh>, MeshError> + 'a;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PrimitiveFile {
    #[serde(rename = "type")]
    kind: KindName,
    dimensions: Vec<Finite>,
    /// Of a prism, which is refused.
    #[serde(default, rename = "polygon", skip_serializing)]
    pub(super) _polygon: IgnoredAny,
}

/// A primitive's type: its name, or its number in `shape_msgs/SolidPrimitive`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
struct KindName(String);

impl<'de> Deserialize<'de> for KindName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct KindVisitor;
        impl Visitor<'_> for KindVisitor {
            type Value = KindName;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(&numbered_kinds())
            }
            fn visit_str<E: de::Error>(self, text: &str) -> Result<KindName, E> {
                Ok(KindName(text.to_ascii_lowercase()))
            }
            fn visit_i64<E: de::Error>(self, number: i64) -> Result<KindName, E> {
                self.visit_u64(u64::try_from(number).unwrap_or_default())
            }
            fn visit_u64<E: de::Error>(self, number: u64) -> Result<KindName, E> {
                let name = match number {
                    4 => "cone",
                    5 => "prism",
                    _ => PRIMITIVES
                        .iter()
                        .find(|kind| kind.number == Some(number))
                        .map(|kind| kind.name)
                        .ok_or_else(|| E::invalid_value(de::Unexpected::Unsigned(number), &self))?,
                };
                Ok(KindName(name.to_owned()))
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
    pub(super) fn of(kind: &PrimitiveKind, dimensions: &[f64]) -> Self {
        Self {
            kind: KindName(kind.name.to_owned()),
            dimensions: dimensions.iter().copied().map(Finite).collect(),
            _polygon: IgnoredAny,
        }
    }

    pub(crate) fn build(&self, id: &str) -> Result<Shape, SceneError> {
        let name = self.kind.0.as_str();
        let dimensions: Vec<f64> = self
            .dimensions
            .iter()
            .map(|number| number.0)
            .collect();
        let shape = PrimitiveKind::named(name).and_then(|kind| kind.checked(&dimensions));
        let shape = shape.ok_or_else(|| SceneError::Syntax(self.refusal(id)))?;
        shape.map_err(|source| SceneError::Shape {
            id: id.to_owned(),
            source,
        })
    }

    /// Why it is no primitive.
    fn refusal(&self, id: &str) -> String {
        let name = self.kind.0.as_str();
        if UNREAD.contains(&name) {
            return format!(
                "object {id:?} has a {name}, which is not read; use a cylinder or a mesh"
            );
        }
        let known: Vec<String> = PRIMITIVES.iter().map(with_dimensions).collect();
        format!(
            "object {id:?} has a {name:?} of {} dimensions; valid: {}",
            self.dimensions.len(),
            known.join(", ")
        )
    }
}

/// Primitives of MoveIt's that are no solids here.
const UNREAD: [&str; 2] = ["cone", "prism"];

/// A kind and what its dimensions are, as in `box [x, y, z]`.
fn with_dimensions(kind: &PrimitiveKind) -> String {
    let sizes = kind.dimensions.iter();
    let sizes: Vec<_> = sizes
        .map(|size| size.trim_end_matches(" size"))
        .collect();
    format!("{} [{}]", kind.name, sizes.join(", "))
}

/// The kinds with their numbers, as in `box (1) or capsule`.
fn numbered_kinds() -> String {
    let named = |kind: &PrimitiveKind| match kind.number {
        Some(number) => format!("{} ({number})", kind.name),
        None => kind.name.to_owned(),
    };
    let names: Vec<String> = PRIMITIVES.iter().map(named).collect();
    let (last, others) = names
        .split_last()
        .expect("there are primitives");
    format!("{} or {last}", others.join(", "))
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
            triangles = mesh
                .triangles()
                .iter()
                .copied()
                .map(Corners)
                .collect();
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
                self.triangles
                    .iter()
                    .map(|corners| corners.0)
                    .collect(),
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
