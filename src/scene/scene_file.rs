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
//! `mesh_poses`; one with `vertices` and `triangles` is not read from its file. An object's own
//! `pose`, where there is one, carries all its shapes; where it is not set and there is one shape,
//! that shape's pose is the object's, as in MoveIt. `link_padding` and `link_scale` may also be
//! maps from names to numbers, and name objects.
//!
//! A `frame_id` is a name of the world (none, or `world`), a frame of the file, one of its objects,
//! or a sub-frame as `OBJECT/SUBFRAME` (`subframe_names`, `subframe_poses`), wherever it stands in
//! the file. Any other has to be what the robot that is checked calls the world: its virtual
//! joint's parent frame, or its root link where that is fixed.
//!
//! Whole `moveit_msgs/PlanningScene` messages are read too (`world`, `robot_state`,
//! `allowed_collision_matrix`; in `fixed_frame_transforms` with a header, that has the frame's name
//! and `child_frame_id` the world's). An unknown field is refused, and so is what would be left
//! out: planes, cones, constraints (a scene has no path to keep them).
//!
//! What sensors saw is an object of its own, in a file of its own; `unknown` has no default, in
//! the `octomap` of messages neither:
//!
//! ```json
//! { "objects": [ { "id": "scan", "cloud": { "file": "scan.pcd", "radius": 0.005, "thin": 0.005 } },
//!   { "id": "<octomap>", "octomap": { "file": "hall.bt", "unknown": "obstacle" } } ] }
//! ```

use crate::warning::Warning;
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};

use super::cloud_file::ByteSource;
use super::frames::{Given, place};
use super::message_file::{Filled, MatrixFile, RobotStateFile, WorldFile};
use super::numbers_file::{Paddings, Scales};
use super::object_file::Operation;
pub use super::object_file::{AttachedObjectFile, MeshSource, ObjectFile};
use super::octomap_file::{OCTOMAP, OctomapFile};
use super::pose_file::FrameFile;
use super::spelling::with_nearest;
use super::{AttachedObject, Obstacle, Scene, SceneDescription, SceneError};

/// A scene, or a part of a diff, as its text says it, unchecked.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// Label.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub name: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) is_diff: Option<bool>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) fixed_frame_transforms: Vec<FrameFile>,
    /// Objects in the text's order.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) objects: Option<Vec<ObjectFile>>,
    /// What links carry.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) attached_collision_objects: Vec<AttachedObjectFile>,
    /// Pairs of which nothing is said any more; of diffs only.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) default_collisions: Vec<(String, String)>,
    /// Pairs of links or objects that may touch.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) allowed_collisions: Vec<(String, String)>,
    /// Pairs of links or objects that are checked whatever allows them to touch.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) forbidden_collisions: Vec<(String, String)>,
    /// Links and objects that count as thicker.
    #[serde(default, skip_serializing_if = "Paddings::is_empty")]
    pub(super) link_padding: Paddings,
    /// Links and objects that count as larger.
    #[serde(default, skip_serializing_if = "Scales::is_empty")]
    pub(super) link_scale: Scales,
    /// MoveIt's words for the objects, what links carry and the pairs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) world: Option<WorldFile>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) robot_state: Option<RobotStateFile>,
    #[serde(default, skip_serializing_if = "MatrixFile::is_empty")]
    pub(super) allowed_collision_matrix: MatrixFile,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) octomap: Option<OctomapFile>,
    /// Read only to be refused where there is something in them.
    #[serde(default, skip_serializing_if = "Filled::is_empty")]
    pub(super) path_constraints: Filled,
    #[serde(default, skip_serializing_if = "Filled::is_empty")]
    pub(super) goal_constraints: Filled,
    #[serde(default, skip_serializing_if = "Filled::is_empty")]
    pub(super) trajectory_constraints: Filled,
    #[serde(default, rename = "robot_model_name", skip_serializing)]
    pub(super) _robot_model_name: IgnoredAny,
    #[serde(default, rename = "robot_model_root", skip_serializing)]
    pub(super) _robot_model_root: IgnoredAny,
    #[serde(default, rename = "object_colors", skip_serializing)]
    pub(super) _object_colors: IgnoredAny,
}

/// Reads a scene's JSON text.
///
/// # Errors
/// No JSON of this form (with line and column), an object whose sizes, poses or meshes are none.
pub fn parse(text: &str, meshes: &mut MeshSource<'_>) -> Result<Scene, SceneError> {
    SceneFile::read(text)?.build(meshes)
}

/// The text of a scene; [`parse`] makes a scene of the same hash of it. Without `with_meshes`, a
/// mesh has its name and hash only, and is looked for under that name when the text is read.
pub fn text(scene: &Scene, with_meshes: bool) -> String {
    serde_json::to_string(&SceneFile::of(scene, with_meshes))
        .expect("a scene holds only names and finite numbers")
}

impl SceneFile {
    /// What a file says of a scene, as [`text`] does.
    pub fn of(scene: &Scene, with_meshes: bool) -> Self {
        let pairs = |pairs: &mut dyn Iterator<Item = (&str, &str)>| -> Vec<(String, String)> {
            pairs
                .map(|(a, b)| (a.to_owned(), b.to_owned()))
                .collect()
        };
        let attached =
            |attached: &AttachedObject| AttachedObjectFile::of(scene, attached, with_meshes);
        let object = |object: &Obstacle| {
            let mut files = ObjectFile::of(object, with_meshes);
            files[0].say_frames(scene, &object.id);
            files
        };
        Self {
            name: scene.name().to_owned(),
            fixed_frame_transforms: scene
                .frames()
                .map(|(name, pose)| FrameFile::of(name, Some(pose)))
                .collect(),
            objects: Some(
                scene
                    .obstacles()
                    .iter()
                    .flat_map(object)
                    .collect(),
            ),
            attached_collision_objects: scene
                .attached()
                .iter()
                .flat_map(attached)
                .collect(),
            allowed_collisions: pairs(&mut scene.allowed()),
            forbidden_collisions: pairs(&mut scene.forbidden()),
            link_padding: Paddings::of(scene.padded()),
            link_scale: Scales::of(scene.scaled()),
            ..Self::default()
        }
    }

    /// Reads a text as JSON.
    ///
    /// # Errors
    /// No JSON of this form, with line and column, and for an unknown field the nearest known one.
    pub fn read(text: &str) -> Result<Self, SceneError> {
        serde_json::from_str(text)
            .map_err(|error| SceneError::Syntax(with_nearest(&error.to_string())))
    }

    /// Whether it changes a scene instead of being one.
    pub fn is_diff(&self) -> bool {
        self.is_diff == Some(true)
    }

    /// Whether files of meshes or clouds have to be read for it.
    pub fn names_files(&self) -> bool {
        let world = self.world.iter();
        let state = self.robot_state.iter();
        let attached = state.flat_map(|state| &state.attached_collision_objects);
        let attached = attached
            .chain(&self.attached_collision_objects)
            .map(|attached| &attached.object);
        let objects = world
            .flat_map(|world| &world.collision_objects)
            .chain(self.objects.iter().flatten());
        objects
            .chain(attached)
            .any(ObjectFile::names_files)
    }

    /// Reads the files of its clouds and octomaps; meshes are read where it is built.
    ///
    /// # Errors
    /// A file that cannot be read, or is no cloud or map of the kind that it should be.
    pub fn read_clouds(&mut self, bytes: &mut ByteSource<'_>) -> Result<(), SceneError> {
        let world = self.world.iter_mut();
        let world = world.flat_map(|world| &mut world.collision_objects);
        let state = self.robot_state.iter_mut();
        let attached = state
            .flat_map(|state| &mut state.attached_collision_objects)
            .chain(&mut self.attached_collision_objects)
            .map(|attached| &mut attached.object);
        let objects = self.objects.iter_mut().flatten();
        let mut all = world.chain(objects).chain(attached);
        all.try_for_each(|object| object.read_clouds(bytes))
    }

    /// Whether one of its objects is MoveIt's octomap.
    fn has_octomap(&self) -> bool {
        let mut objects = self.objects.iter().flatten();
        objects.any(|object| object.id == OCTOMAP)
    }

    /// Puts what MoveIt's message says into the lists of ours, and gives what is odd about it, a
    /// line each.
    pub(super) fn take_message(&mut self) -> Result<Vec<Warning>, SceneError> {
        for (field, constraints) in [
            ("path_constraints", self.path_constraints),
            ("goal_constraints", self.goal_constraints),
            ("trajectory_constraints", self.trajectory_constraints),
        ] {
            refuse_constraints(field, constraints)?;
        }
        let mut octomap = self
            .octomap
            .take()
            .map(|octomap| ("octomap", octomap));
        if let Some(world) = self.world.take() {
            self.objects
                .get_or_insert_default()
                .extend(world.collision_objects);
            octomap = octomap.or(world
                .octomap
                .map(|octomap| ("world.octomap", octomap)));
        }
        if let Some((place, octomap)) = octomap
            && let Some(object) = octomap.object(place)?
        {
            self.objects
                .get_or_insert_default()
                .push(object);
        }
        let has_octomap = self.has_octomap();
        if let Some(state) = self.robot_state.take() {
            if self.is_diff() {
                state
                    .attached_collision_objects
                    .iter()
                    .try_for_each(AttachedObjectFile::check_placed)?;
            }
            self.attached_collision_objects
                .extend(state.attached_collision_objects);
        }
        let matrix = std::mem::take(&mut self.allowed_collision_matrix);
        let pairs = matrix.pairs(has_octomap)?;
        self.allowed_collisions.extend(pairs.allowed);
        self.forbidden_collisions
            .extend(pairs.forbidden);
        let attached = self
            .attached_collision_objects
            .iter()
            .map(|attached| &attached.object);
        let objects = self
            .objects
            .iter()
            .flatten()
            .chain(attached)
            .flat_map(ObjectFile::warnings);
        let frames = self
            .fixed_frame_transforms
            .iter()
            .filter_map(FrameFile::warning)
            .map(Warning::uncovered);
        let defaults = matrix
            .warning(has_octomap)
            .map(|text| Warning::cosmetic("default entries", text));
        Ok(frames.chain(objects).chain(defaults).collect())
    }

    /// Checks every object and builds the scene.
    ///
    /// # Errors
    /// An object whose sizes, poses or meshes are none; frames that hang on one another; a diff;
    /// what would be left out.
    pub fn build(mut self, meshes: &mut MeshSource<'_>) -> Result<Scene, SceneError> {
        if self.is_diff() {
            let text = "it is a diff (is_diff is true), not a whole scene; apply it to the scene that it changes";
            return Err(SceneError::Syntax(format!(
                "{text}: taut scene apply SCENE FILE"
            )));
        }
        let warnings = self.take_message()?;
        let Some(objects) = self.objects else {
            let text = "missing field `objects` (in MoveIt's messages `world`); an empty list where there are none";
            return Err(SceneError::Syntax(text.to_owned()));
        };
        if !self.default_collisions.is_empty() {
            let text = "default_collisions take back what a scene says; a whole scene says nothing yet, leave them out";
            return Err(SceneError::Syntax(text.to_owned()));
        }
        let frames = super::frames::fixed(&self.fixed_frame_transforms)?;
        let mut given: Vec<Given> = Vec::new();
        for object in objects {
            object.add_to(&mut given, meshes)?;
        }
        let mut attached: Vec<AttachedObject> = Vec::new();
        let mut subframes: Vec<((String, String), crate::math::Pose)> = Vec::new();
        for entry in self.attached_collision_objects {
            let names = entry.object.subframes()?;
            let id = entry.object.id.clone();
            subframes.extend(
                names
                    .into_iter()
                    .map(|(name, pose)| ((id.clone(), name), pose)),
            );
            let last = attached
                .last_mut()
                .map(|attached| &mut attached.object);
            let built = entry.build(meshes, last)?;
            attached.extend(built);
        }
        for object in &given {
            let id = &object.object.id;
            subframes.extend(
                object
                    .subframes
                    .iter()
                    .map(|(name, pose)| ((id.clone(), name.clone()), *pose)),
            );
        }
        let placed = place(
            &frames,
            given,
            attached
                .iter()
                .map(|attached| attached.object.id.as_str()),
        )?;
        Scene::of(SceneDescription {
            name: self.name,
            obstacles: placed.obstacles,
            attached,
            padding: self.link_padding.0,
            scale: self.link_scale.0,
            frames,
            subframes: subframes.into_iter().collect(),
            worlds: placed.worlds,
            allowed: self.allowed_collisions,
            forbidden: self.forbidden_collisions,
            warnings,
        })
    }
}

/// Refuses constraints that a path would have to keep to.
///
/// # Errors
/// There are some.
pub fn refuse_constraints(field: &str, constraints: Filled) -> Result<(), SceneError> {
    match constraints.is_empty() {
        true => Ok(()),
        false => Err(SceneError::Unsupported {
            what: format!("it has {field}"),
            advice: "they are not supported here, and what is proved would not keep to them; give path_constraints \
                     with the path, or leave them out where the path need not",
        }),
    }
}

impl ObjectFile {
    /// Adds an object of a whole scene to those before it, or appends shapes to the last one.
    fn add_to(self, given: &mut Vec<Given>, meshes: &mut MeshSource<'_>) -> Result<(), SceneError> {
        let frame = self.header.frame_id.clone();
        let subframes = self.subframes()?;
        match self.added(meshes, given.last_mut().map(|given| &mut given.object))? {
            Some(object) => given.push(Given {
                object,
                frame,
                subframes,
            }),
            None => given
                .last_mut()
                .into_iter()
                .for_each(|last| last.subframes.extend(subframes.clone())),
        }
        Ok(())
    }

    /// An object of a whole scene, which is only added to; `None` where it appends shapes to the
    /// last one.
    fn added(
        self,
        meshes: &mut MeshSource<'_>,
        last: Option<&mut Obstacle>,
    ) -> Result<Option<Obstacle>, SceneError> {
        match (self.operation, last) {
            (None | Some(Operation::Add), _) => self.build(meshes).map(Some),
            (Some(Operation::Append), Some(last)) if last.id == self.id => {
                self.check_appends()?;
                *last = last.with_more(self.shapes(meshes)?);
                Ok(None)
            }
            (Some(other), _) => {
                let text = format!(
                    "object {:?} has the operation {} in a whole scene",
                    self.id,
                    other.name()
                );
                let valid = "valid: ADD, and APPEND right after it; set is_diff and apply it to change a scene";
                Err(SceneError::Syntax(format!("{text}; {valid}")))
            }
        }
    }
}

impl AttachedObjectFile {
    pub(super) fn new(link_name: String, object: ObjectFile) -> Self {
        Self {
            link_name,
            object,
            touch_links: Vec::new(),
            _detach_posture: IgnoredAny,
            _weight: IgnoredAny,
        }
    }

    /// Refuses a message by which MoveIt takes an object up, or puts it down, where the robot then
    /// is: its pose says nothing.
    fn check_placed(&self) -> Result<(), SceneError> {
        let (id, what) = match self.object.operation {
            Some(Operation::Add) if !self.object.has_shapes() => (&self.object.id, "taken up"),
            Some(Operation::Remove) => (&self.object.id, "put down"),
            _ => return Ok(()),
        };
        let text = format!(
            "robot_state: object {id:?} is {what} where the robot then stands, which no scene knows"
        );
        let advice = "give it in attached_collision_objects with its pose in the link's frame, or in the world";
        Err(SceneError::Syntax(format!("{text}; {advice}")))
    }

    /// What attaches an object, and what then appends shapes.
    pub(super) fn of(scene: &Scene, attached: &AttachedObject, with_meshes: bool) -> Vec<Self> {
        let mut touch_links = attached.touch_links.clone();
        let file = |object| Self {
            touch_links: std::mem::take(&mut touch_links),
            ..Self::new(attached.link_name.clone(), object)
        };
        let mut objects = ObjectFile::of(&attached.object, with_meshes);
        // Its poses are in the link's frame, whatever it called the world before.
        objects[0].say_subframes(scene, &attached.object.id);
        objects.into_iter().map(file).collect()
    }

    fn build(
        self,
        meshes: &mut MeshSource<'_>,
        last: Option<&mut Obstacle>,
    ) -> Result<Option<AttachedObject>, SceneError> {
        self.check_frame()?;
        let Self {
            link_name,
            object,
            touch_links,
            ..
        } = self;
        Ok(object
            .added(meshes, last)?
            .map(|object| AttachedObject {
                link_name,
                object,
                touch_links,
            }))
    }

    /// Refuses what names no link, or poses in another frame than the link's: taken for poses in
    /// that, they would put the object elsewhere unseen.
    pub(super) fn check_frame(&self) -> Result<(), SceneError> {
        let id = &self.object.id;
        let link_name = &self.link_name;
        let frame = &self.object.header.frame_id;
        if link_name.is_empty() {
            return Err(SceneError::Syntax(format!(
                "object {id:?} is attached to no link; give its link_name"
            )));
        }
        if !frame.is_empty() && frame != link_name {
            let text = format!(
                "object {id:?} is attached to {link_name:?}, but its poses are in the frame {frame:?}"
            );
            return Err(SceneError::Syntax(format!(
                "{text}; give them in the frame of {link_name:?}"
            )));
        }
        Ok(())
    }
}
