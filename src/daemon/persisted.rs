//! Robots and scenes as plain data, for files: the journal's and those of recorded runs. Meshes
//! stand apart, by hash.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use taut::math::{Pose, Vec3};
use taut::robot::{
    JointDescription, LinkDescription, RobotDescription, RobotModel, Semantics, VirtualJoint,
};
use taut::scene::{AttachedObject, Obstacle, Scene, SceneDescription};
use taut::shape::{Mesh, PlacedShape, Shape};
use taut::warning::Warning;

/// Gives a mesh by its hash.
pub(super) type FindMesh<'a> = dyn FnMut(u64) -> Result<Arc<Mesh>, String> + 'a;

/// A shape; meshes lie in files of their own.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct ShapeRecord {
    pose: Pose,
    shape: Kind,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
enum Kind {
    Sphere { radius: f64 },
    Box { half_extents: Vec3 },
    Cylinder { radius: f64, half_height: f64 },
    Capsule { radius: f64, half_length: f64 },
    Mesh { hash: u64 },
}

impl ShapeRecord {
    fn of(placed: &PlacedShape) -> Result<Self, String> {
        let shape = match placed.shape {
            Shape::Sphere { radius } => Kind::Sphere { radius },
            Shape::Box { half_extents } => Kind::Box { half_extents },
            Shape::Cylinder {
                radius,
                half_height,
            } => Kind::Cylinder {
                radius,
                half_height,
            },
            Shape::Capsule {
                radius,
                half_length,
            } => Kind::Capsule {
                radius,
                half_length,
            },
            Shape::Mesh(ref mesh) => Kind::Mesh { hash: mesh.hash() },
        };
        Ok(Self {
            pose: placed.pose,
            shape,
        })
    }

    fn restore(&self, find: &mut FindMesh) -> Result<PlacedShape, String> {
        let shape = match self.shape {
            Kind::Sphere { radius } => Shape::Sphere { radius },
            Kind::Box { half_extents } => Shape::Box { half_extents },
            Kind::Cylinder {
                radius,
                half_height,
            } => Shape::Cylinder {
                radius,
                half_height,
            },
            Kind::Capsule {
                radius,
                half_length,
            } => Shape::Capsule {
                radius,
                half_length,
            },
            Kind::Mesh { hash } => Shape::Mesh(find(hash)?),
        };
        Ok(PlacedShape {
            pose: self.pose,
            shape,
        })
    }
}

fn records<'a>(
    shapes: impl IntoIterator<Item = &'a PlacedShape>,
) -> Result<Vec<ShapeRecord>, String> {
    shapes.into_iter().map(ShapeRecord::of).collect()
}

fn restored(shapes: &[ShapeRecord], find: &mut FindMesh) -> Result<Vec<PlacedShape>, String> {
    shapes.iter().map(|shape| shape.restore(find)).collect()
}

/// A robot: what its model was made of, and what was found when it was put to use.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct RobotRecord {
    name: String,
    links: Vec<(String, Vec<ShapeRecord>)>,
    joints: Vec<JointDescription>,
    virtual_joint: Option<VirtualJoint>,
    variables: Option<Vec<String>>,
    semantics: Option<Semantics>,
    allowed_collisions: Vec<(String, String)>,
    warnings: Vec<Warning>,
    /// All warnings of the model.
    found: Vec<Warning>,
}

impl RobotRecord {
    pub(super) fn of(robot: &RobotModel) -> Result<Self, String> {
        // Named one by one, so that nothing a description gains is forgotten here.
        let RobotDescription {
            name,
            links,
            joints,
            virtual_joint,
            variables,
            semantics,
            allowed_collisions,
            warnings,
        } = robot.description().clone();
        let links = links
            .into_iter()
            .map(|link| Ok((link.name, records(&link.collision)?)));
        let links = links.collect::<Result<_, String>>()?;
        let found = robot.warnings().to_vec();
        Ok(Self {
            name,
            links,
            joints,
            virtual_joint,
            variables,
            semantics,
            allowed_collisions,
            warnings,
            found,
        })
    }

    /// The model, checked as when it was first made.
    pub(super) fn restore(self, find: &mut FindMesh) -> Result<RobotModel, String> {
        let link = |(name, shapes): (String, Vec<ShapeRecord>)| {
            Ok(LinkDescription {
                name,
                collision: restored(&shapes, find)?,
            })
        };
        let links = self
            .links
            .into_iter()
            .map(link)
            .collect::<Result<_, String>>()?;
        let model = RobotModel::new(RobotDescription {
            name: self.name,
            links,
            joints: self.joints,
            virtual_joint: self.virtual_joint,
            variables: self.variables,
            semantics: self.semantics,
            allowed_collisions: self.allowed_collisions,
            warnings: self.warnings,
        });
        let model = model.map_err(|error| error.to_string())?;
        let more = self
            .found
            .into_iter()
            .filter(|warning| !model.warnings().contains(warning))
            .collect();
        Ok(model.with_warnings(more))
    }
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct ObjectRecord {
    id: String,
    pose: Pose,
    shapes: Vec<ShapeRecord>,
}

impl ObjectRecord {
    fn of(object: &Obstacle) -> Result<Self, String> {
        Ok(Self {
            id: object.id.clone(),
            pose: object.pose,
            shapes: records(object.shapes.iter())?,
        })
    }

    fn restore(self, find: &mut FindMesh) -> Result<Obstacle, String> {
        Ok(Obstacle {
            id: self.id,
            pose: self.pose,
            shapes: restored(&self.shapes, find)?.into(),
        })
    }
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct AttachedRecord {
    link_name: String,
    object: ObjectRecord,
    touch_links: Vec<String>,
}

/// A scene.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct SceneRecord {
    name: String,
    obstacles: Vec<ObjectRecord>,
    attached: Vec<AttachedRecord>,
    padding: BTreeMap<String, f64>,
    scale: BTreeMap<String, f64>,
    frames: BTreeMap<String, Pose>,
    subframes: BTreeMap<(String, String), Pose>,
    worlds: BTreeMap<String, String>,
    allowed: Vec<(String, String)>,
    forbidden: Vec<(String, String)>,
    /// All warnings of the scene.
    found: Vec<Warning>,
}

/// Objects that went elsewhere: their numbers among all objects, those that stand first, and their
/// poses.
pub(super) type Moves = Vec<(u32, Pose)>;

impl SceneRecord {
    pub(super) fn of(scene: &Scene) -> Result<Self, String> {
        let attached = scene.attached().iter().map(|attached| {
            let AttachedObject {
                link_name,
                object,
                touch_links,
            } = attached;
            let link_name = link_name.clone();
            let touch_links = touch_links.clone();
            Ok(AttachedRecord {
                link_name,
                object: ObjectRecord::of(object)?,
                touch_links,
            })
        });
        Ok(Self {
            name: scene.name().to_owned(),
            obstacles: scene
                .obstacles()
                .iter()
                .map(ObjectRecord::of)
                .collect::<Result<_, _>>()?,
            attached: attached.collect::<Result<_, String>>()?,
            padding: scene.padded().map(named).collect(),
            scale: scene.scaled().map(named).collect(),
            frames: scene
                .frames()
                .map(|(name, pose)| named((name, *pose)))
                .collect(),
            subframes: scene
                .subframes()
                .map(|(object, name, pose)| (pair((object, name)), *pose))
                .collect(),
            worlds: scene.worlds().map(pair).collect(),
            allowed: scene.allowed().map(pair).collect(),
            forbidden: scene.forbidden().map(pair).collect(),
            found: scene.warnings().to_vec(),
        })
    }

    /// Puts objects elsewhere.
    pub(super) fn apply(&mut self, moves: &Moves) -> Result<(), String> {
        let standing = self.obstacles.len();
        for &(index, pose) in moves {
            let index = index as usize;
            let object = match index.checked_sub(standing) {
                None => &mut self.obstacles[index],
                Some(index) => {
                    let attached = self.attached.get_mut(index);
                    &mut attached
                        .ok_or_else(|| {
                            format!("object number {} moves, there is none", index + standing)
                        })?
                        .object
                }
            };
            object.pose = pose;
        }
        Ok(())
    }

    /// The scene, checked as when it was first made.
    pub(super) fn restore(self, find: &mut FindMesh) -> Result<Scene, String> {
        let obstacles = self
            .obstacles
            .into_iter()
            .map(|object| object.restore(find))
            .collect::<Result<_, _>>()?;
        let attached = self.attached.into_iter().map(|attached| {
            let AttachedRecord {
                link_name,
                object,
                touch_links,
            } = attached;
            Ok(AttachedObject {
                link_name,
                object: object.restore(find)?,
                touch_links,
            })
        });
        let mut description = SceneDescription {
            name: self.name,
            obstacles,
            attached: attached.collect::<Result<_, String>>()?,
            padding: self.padding,
            scale: self.scale,
            frames: self.frames,
            subframes: self.subframes,
            worlds: self.worlds,
            allowed: self.allowed,
            forbidden: self.forbidden,
            warnings: Vec::new(),
        };
        let scene = Scene::of(description.clone()).map_err(|error| error.to_string())?;
        description.warnings = self
            .found
            .into_iter()
            .filter(|warning| !scene.warnings().contains(warning))
            .collect();
        match description.warnings.is_empty() {
            true => Ok(scene),
            false => Scene::of(description).map_err(|error| error.to_string()),
        }
    }
}

fn named<T>((name, value): (&str, T)) -> (String, T) {
    (name.to_owned(), value)
}

fn pair((a, b): (&str, &str)) -> (String, String) {
    (a.to_owned(), b.to_owned())
}

/// The meshes of a robot or scene.
pub(super) fn meshes<'a>(
    shapes: impl Iterator<Item = &'a PlacedShape>,
) -> impl Iterator<Item = &'a Arc<Mesh>> {
    shapes.filter_map(|placed| placed.shape.mesh())
}

/// What a mesh is made of: its name, vertices, triangles and warnings.
pub(super) type MeshParts = (String, Vec<Vec3>, Vec<[u32; 3]>, Vec<Warning>);

/// A mesh as plain data.
pub(super) fn mesh_parts(mesh: &Mesh) -> MeshParts {
    (
        mesh.name().to_owned(),
        mesh.vertices().to_vec(),
        mesh.triangles().to_vec(),
        mesh.warnings().to_vec(),
    )
}

/// The mesh again; one that has not this hash is refused.
pub(super) fn restore_mesh(
    (name, vertices, triangles, warnings): MeshParts,
    hash: u64,
) -> Result<Mesh, String> {
    let mesh =
        Mesh::restore(name, vertices, triangles, warnings).map_err(|error| error.to_string())?;
    match mesh.hash() == hash {
        true => Ok(mesh),
        false => Err(format!(
            "its content has hash {:016x}, not {hash:016x}",
            mesh.hash()
        )),
    }
}

/// The objects that are elsewhere in `after`, if nothing else differs from `before`.
pub(super) fn moves_between(before: &Scene, after: &Scene) -> Option<Moves> {
    let same_lists = before.obstacles().len() == after.obstacles().len()
        && before.attached().len() == after.attached().len()
        && before.name() == after.name()
        && before.padded().eq(after.padded())
        && before.scaled().eq(after.scaled())
        && before.frames().eq(after.frames())
        && before.subframes().eq(after.subframes())
        && before.worlds().eq(after.worlds())
        && before.allowed().eq(after.allowed())
        && before.forbidden().eq(after.forbidden())
        && before.warnings() == after.warnings();
    let attached = before.attached().iter().zip(after.attached());
    let same_carriers = |(a, b): (&AttachedObject, &AttachedObject)| {
        a.link_name == b.link_name && a.touch_links == b.touch_links
    };
    if !same_lists || !attached.into_iter().all(same_carriers) {
        return None;
    }
    let mut moves = Moves::new();
    for (index, (a, b)) in before.objects().zip(after.objects()).enumerate() {
        if a.id != b.id || !Arc::ptr_eq(&a.shapes, &b.shapes) {
            return None;
        }
        if a.pose != b.pose {
            moves.push((u32::try_from(index).ok()?, b.pose));
        }
    }
    Some(moves)
}
