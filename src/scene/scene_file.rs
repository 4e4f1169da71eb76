//! Scene files: JSON with MoveIt's collision objects.
//!
//! ```json
//! { "name": "kitchen", "allowed_collisions": [["hand", "cup"]],
//!   "objects": [ { "id": "table",
//!     "primitives": [ { "type": "box", "dimensions": [1.2, 0.8, 0.05] } ],
//!     "primitive_poses": [ { "position": [0.5, 0, 0.4], "orientation": { "x": 0, "y": 0, "z": 0, "w": 1 } } ] } ] }
//! ```
//! Lengths in metres. `dimensions` are MoveIt's: box x y z; sphere radius; cylinder height, radius;
//! ours: capsule length of its straight part, radius. `meshes` give `file` and `scale`, with
//! `mesh_poses`. An object's own `pose`, where there is one, carries all its shapes.

use std::sync::Arc;

use serde::Deserialize;

use super::{Obstacle, Scene, SceneError, oddities};
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
}

/// MoveIt's collision object.
#[derive(Clone, Debug, Deserialize)]
pub struct ObjectFile {
    id: String,
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
        let obstacles = self.objects.into_iter().map(|object| object.build(meshes)).collect::<Result<Vec<_>, _>>()?;
        let warnings = oddities(&obstacles);
        Scene::new(self.name, obstacles, self.allowed_collisions, warnings)
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
        let carrier = self.pose.map_or(Ok(Pose::identity()), |pose| pose.build(&id))?;
        let mut shapes = Vec::new();
        for (primitive, pose) in self.primitives.iter().zip(&self.primitive_poses) {
            shapes.push(PlacedShape { pose: carrier * pose.build(&id)?, shape: primitive.build(&id)? });
        }
        for (mesh, pose) in self.meshes.iter().zip(&self.mesh_poses) {
            let source = meshes(&mesh.file, Vec3::from_array(mesh.scale));
            let shape = Shape::Mesh(source.map_err(|source| SceneError::Mesh { id: id.clone(), source })?);
            shapes.push(PlacedShape { pose: carrier * pose.build(&id)?, shape });
        }
        Ok(Obstacle { id, shapes })
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

#[cfg(test)]
mod tests {
    use super::*;

    fn parse_objects(objects: &str) -> Result<Scene, SceneError> {
        let mut no_mesh =
            |name: &str, _| Err(MeshError::Unreadable { name: name.to_owned(), reason: "none".to_owned() });
        parse(&format!(r#"{{ "name": "s", "objects": [{objects}] }}"#), &mut no_mesh)
    }

    fn message(objects: &str) -> String {
        parse_objects(objects).expect_err("must be refused").to_string()
    }

    #[test]
    fn dimensions_are_moveits() {
        let object = r#"{ "id": "a",
            "primitives": [{ "type": "box", "dimensions": [1, 2, 3] }, { "type": "cylinder", "dimensions": [4, 0.5] }],
            "primitive_poses": [{ "position": [1, 0, 0] }, { "orientation": { "x": 0, "y": 0, "z": 0, "w": 1 } }] }"#;
        let scene = parse_objects(object).unwrap();
        let [cuboid, cylinder] = scene.obstacles()[0].shapes.as_slice() else { panic!("two shapes") };
        assert_eq!(cuboid.shape, Shape::Box { half_extents: Vec3::new(0.5, 1.0, 1.5) });
        assert_eq!(cuboid.pose.translation, Vec3::X);
        assert_eq!(cylinder.shape, Shape::Cylinder { radius: 0.5, half_height: 2.0 });
    }

    #[test]
    fn the_objects_own_pose_carries_its_shapes() {
        let object = r#"{ "id": "a", "pose": { "position": [0, 0, 1] },
            "primitives": [{ "type": "sphere", "dimensions": [1] }], "primitive_poses": [{ "position": [0, 2, 0] }] }"#;
        let scene = parse_objects(object).unwrap();
        assert_eq!(scene.obstacles()[0].shapes[0].pose.translation, Vec3::new(0.0, 2.0, 1.0));
    }

    #[test]
    fn a_quaternion_that_is_not_unit_is_refused_and_a_rounded_one_normalised() {
        let with_w = |w: f64| {
            format!(
                r#"{{ "id": "cup", "primitives": [{{ "type": "sphere", "dimensions": [1] }}],
                "primitive_poses": [{{ "position": [0, 0, 0], "orientation": {{ "x": 0, "y": 0, "z": 0, "w": {w} }} }}] }}"#
            )
        };
        let text = message(&with_w(1.01));
        assert!(text.contains("cup") && text.contains("1.01") && text.contains("unit quaternion"), "{text}");
        let scene = parse_objects(&with_w(1.0001)).unwrap();
        assert_eq!(scene.obstacles()[0].shapes[0].pose.rotation.w, 1.0);
    }

    #[test]
    fn what_is_no_solid_is_named() {
        let one = |shape: &str| format!(r#"{{ "id": "cup", "primitives": [{shape}], "primitive_poses": [{{}}] }}"#);
        for (objects, parts) in [
            (one(r#"{ "type": "cone", "dimensions": [1, 1] }"#), ["cup", "cone", "cylinder [height, radius]"]),
            (one(r#"{ "type": "box", "dimensions": [1, 1] }"#), ["cup", "2 dimensions", "box [x, y, z]"]),
            (one(r#"{ "type": "sphere", "dimensions": [-1] }"#), ["cup", "radius is -1", "greater than 0"]),
            (
                r#"{ "id": "cup", "primitives": [{ "type": "sphere", "dimensions": [1] }] }"#.into(),
                ["cup", "1 primitives", "0 poses"],
            ),
            (r#"{ "id": "cup", "planes": [{}] }"#.into(), ["cup", "planes", "box"]),
            (
                r#"{ "id": "cup", "meshes": [{ "file": "cup.stl" }], "mesh_poses": [{}] }"#.into(),
                ["cup", "cup.stl", "none"],
            ),
            (r#"{ "id": "cup" }, { "id": "cup" }"#.into(), ["cup", "twice", "unique"]),
            (r#"{ "primitives": [] }"#.into(), ["missing field", "id", "line 1"]),
        ] {
            let text = message(&objects);
            assert!(parts.iter().all(|part| text.contains(part)), "{text}");
        }
    }
}
