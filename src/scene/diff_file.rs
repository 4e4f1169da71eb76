//! Diffs: JSON that changes a scene, in the words of MoveIt's planning scene messages.
//!
//! ```json
//! { "is_diff": true,
//!   "objects": [
//!     { "id": "table", "operation": "MOVE", "pose": { "position": [0.5, 0, 0.4] } },
//!     { "id": "tray", "operation": "ADD", "header": { "frame_id": "table" },
//!       "primitives": [ { "type": "box", "dimensions": [0.4, 0.3, 0.02] } ], "primitive_poses": [ {} ] },
//!     { "id": "vase", "operation": "REMOVE" } ],
//!   "attached_collision_objects": [
//!     { "link_name": "hand", "touch_links": ["finger_left", "finger_right"],
//!       "object": { "id": "cup", "operation": "ADD", "pose": { "position": [0, 0, 0.1] } } } ],
//!   "allowed_collisions": [["cup", "tray"]], "forbidden_collisions": [], "default_collisions": [["hand", "table"]],
//!   "link_padding": { "forearm": 0.02 }, "link_scale": { "hand": 1 },
//!   "fixed_frame_transforms": [ { "child_frame_id": "shelf", "transform": null } ] }
//! ```
//! Made in this order: frames, objects, attached objects, pairs that are cleared, allowed,
//! forbidden, paddings, scales, each list from its first entry to its last; either all of it or
//! nothing. A list of such diffs is one change that makes one after the other.
//!
//! Operations (by name or number): ADD 0 (of an object that stands already: it is replaced, and
//! what names it stays), REMOVE 1 (with an empty id: all objects of the world), APPEND 2 (shapes to
//! an object, or a new object), MOVE 3 (the frame only). Poses in `objects` are in the world, or in
//! the frame that `header.frame_id` says, as in whole scenes; what no scene knows has to be what a
//! loaded robot calls the world. `moveit_msgs/PlanningScene` messages are read too. Attached, ADD
//! without shapes takes an object of the world, and REMOVE puts one back there; both need the
//! object's new `pose`, in the link's frame and in the world, because where the robot stands is not
//! the scene's to know. A padding of 0, a scale of 1 and a transform of `null` take theirs away.

#[cfg(test)]
mod tests;

use super::cloud_file::ByteSource;
pub use super::diff::SceneDiff;
use super::diff::{Place, Step};
pub use super::diff_text::text;
use super::frames::check_given_in;
use super::object_file::{MeshSource, ObjectFile, Operation};
use super::scene_file::AttachedObjectFile;
pub use super::scene_file::SceneFile;
use super::spelling::with_nearest;
use super::{SceneChange, SceneError};
use crate::math::Pose;

/// A diff as its text says it, unchecked.
#[derive(Clone, Debug, Default)]
pub struct DiffFile(pub(super) Vec<SceneFile>);

impl DiffFile {
    /// Reads a diff's JSON text.
    ///
    /// # Errors
    /// No JSON of this form, with line and column; a whole scene.
    pub fn parse(text: &str) -> Result<Self, SceneError> {
        let parsed = match text.trim_start().starts_with('[') {
            true => serde_json::from_str(text),
            false => serde_json::from_str(text).map(|part| vec![part]),
        };
        let refuse = |error: serde_json::Error| with_nearest(&format!("not a diff: {error}"));
        Self::of(parsed.map_err(|error| SceneError::Syntax(refuse(error)))?)
    }

    /// The diff of these parts, made one after the other.
    ///
    /// # Errors
    /// One of them is a whole scene.
    pub fn of(parts: Vec<SceneFile>) -> Result<Self, SceneError> {
        let text = match parts
            .iter()
            .find(|part| !part.is_diff())
            .map(|part| part.is_diff)
        {
            None => return Ok(Self(parts)),
            Some(None) => {
                "not a diff: missing field `is_diff`; set it to true, or load the text as a whole scene"
            }
            Some(_) => "is_diff is false; set it to true, or load the text as a whole scene",
        };
        Err(SceneError::Syntax(text.to_owned()))
    }

    /// Its text as JSON.
    pub fn text(&self) -> String {
        let text = match self.0.as_slice() {
            [part] => serde_json::to_string(part),
            parts => serde_json::to_string(parts),
        };
        text.expect("a diff holds only names and finite numbers")
    }

    /// Whether files of meshes or clouds have to be read for it.
    pub fn names_files(&self) -> bool {
        self.0.iter().any(SceneFile::names_files)
    }

    /// Reads the files of its clouds and octomaps.
    ///
    /// # Errors
    /// As [`SceneFile::read_clouds`].
    pub fn read_clouds(&mut self, bytes: &mut ByteSource<'_>) -> Result<(), SceneError> {
        let mut parts = self.0.iter_mut();
        parts.try_for_each(|part| part.read_clouds(bytes))
    }

    /// Checks poses and shapes and reads meshes.
    ///
    /// # Errors
    /// An object whose sizes, poses or meshes are none, or that lacks what its operation needs;
    /// what would be left out.
    pub fn build(self, meshes: &mut MeshSource<'_>) -> Result<SceneDiff, SceneError> {
        let mut steps = Vec::new();
        let mut warnings = Vec::new();
        for mut part in self.0 {
            warnings.extend(part.take_message()?);
            steps.extend(steps_of(part, meshes)?);
        }
        Ok(SceneDiff { steps, warnings })
    }
}

fn steps_of(part: SceneFile, meshes: &mut MeshSource<'_>) -> Result<Vec<Step>, SceneError> {
    let mut steps = Vec::new();
    let worlds: Vec<String> = part
        .fixed_frame_transforms
        .iter()
        .map(|frame| frame.name().to_owned())
        .collect();
    for frame in part.fixed_frame_transforms {
        check_given_in(&frame, |name| worlds.iter().any(|world| world == name))?;
        let name = frame.name().to_owned();
        let pose = frame.pose()?;
        // The world's own entry, which every message of MoveIt has.
        if super::is_world(&name) && pose == Some(Pose::identity()) {
            continue;
        }
        steps.push(Step::plain(
            SceneChange::Frame { name, pose },
            Place::Anywhere,
        ));
    }
    for object in part.objects.into_iter().flatten() {
        steps.push(of_world(object, meshes)?);
    }
    for attached in part.attached_collision_objects {
        steps.extend(of_link(attached, meshes)?);
    }
    let mut plain = |change| steps.push(Step::plain(change, Place::Anywhere));
    part.default_collisions
        .into_iter()
        .for_each(|(a, b)| plain(SceneChange::ClearPair(a, b)));
    part.allowed_collisions
        .into_iter()
        .for_each(|(a, b)| plain(SceneChange::Allow(a, b)));
    part.forbidden_collisions
        .into_iter()
        .for_each(|(a, b)| plain(SceneChange::Forbid(a, b)));
    part.link_padding
        .0
        .into_iter()
        .for_each(|(name, padding)| plain(SceneChange::Pad { name, padding }));
    part.link_scale
        .0
        .into_iter()
        .for_each(|(name, scale)| plain(SceneChange::Scale { name, scale }));
    Ok(steps)
}

/// Read without mesh files.
impl TryFrom<DiffFile> for SceneDiff {
    type Error = SceneError;

    fn try_from(file: DiffFile) -> Result<Self, SceneError> {
        file.build(&mut |name, _| {
            let reason = "mesh files are not read here; give its vertices and triangles".to_owned();
            Err(crate::shape::MeshError::Unreadable {
                name: name.to_owned(),
                reason,
            })
        })
    }
}

fn operation(object: &ObjectFile) -> Result<Operation, SceneError> {
    object.operation.ok_or_else(|| {
        let text = format!(
            "object {:?} has no operation; valid: ADD, REMOVE, APPEND, MOVE",
            object.id
        );
        SceneError::Syntax(text)
    })
}

fn of_world(object: ObjectFile, meshes: &mut MeshSource<'_>) -> Result<Step, SceneError> {
    let frame = object.header.frame_id.clone();
    let subframes = object.subframes()?;
    let (change, place) = match operation(&object)? {
        Operation::Add => (SceneChange::Add(object.build(meshes)?), Place::World),
        Operation::Remove if object.id.is_empty() => (SceneChange::RemoveAll, Place::Anywhere),
        Operation::Remove => (SceneChange::Remove { id: object.id }, Place::Anywhere),
        Operation::Append => (append(object, meshes)?, Place::World),
        Operation::Move => (moved(object, "the world")?, Place::World),
    };
    Ok(Step {
        change,
        place,
        frame,
        subframes,
    })
}

fn of_link(
    attached: AttachedObjectFile,
    meshes: &mut MeshSource<'_>,
) -> Result<Vec<Step>, SceneError> {
    let operation = operation(&attached.object)?;
    if operation == Operation::Add {
        return taken(attached, meshes);
    }
    let AttachedObjectFile {
        link_name,
        object,
        touch_links,
        ..
    } = attached;
    if !touch_links.is_empty() {
        let id = &object.id;
        let name = operation.name();
        return Err(SceneError::Syntax(format!(
            "object {id:?} has touch_links, which {name} does not change; ADD does"
        )));
    }
    let mut frame = object.header.frame_id.clone();
    let subframes = object.subframes()?;
    let change = match operation {
        Operation::Remove => SceneChange::Detach {
            pose: needed_pose(&object, "the world")?,
            id: object.id,
        },
        Operation::Append | Operation::Move | Operation::Add => {
            let of_link = AttachedObjectFile::new(link_name.clone(), object);
            if !frame.is_empty() {
                of_link.check_frame()?;
                frame = String::new();
            }
            match operation {
                Operation::Append => append(of_link.object, meshes)?,
                _ => moved(of_link.object, "its link's frame")?,
            }
        }
    };
    Ok(vec![Step {
        change,
        place: Place::Link(link_name),
        frame,
        subframes,
    }])
}

/// What a link takes: an object of the world, or one that the diff brings.
fn taken(
    attached: AttachedObjectFile,
    meshes: &mut MeshSource<'_>,
) -> Result<Vec<Step>, SceneError> {
    attached.check_frame()?;
    let AttachedObjectFile {
        link_name,
        object,
        touch_links,
        ..
    } = attached;
    let brings_shapes = object.has_shapes();
    let place = if brings_shapes {
        Place::Link(link_name.clone())
    } else {
        Place::Anywhere
    };
    let mut steps = Vec::new();
    let id = object.id.clone();
    let pose = if brings_shapes {
        // It stands in the world for a moment, which nobody sees, unless the link carries it
        // already.
        let subframes = object.subframes()?;
        let built = object.build(meshes)?;
        let pose = built.pose;
        steps.push(Step {
            subframes,
            ..Step::plain(SceneChange::Add(built), place.clone())
        });
        pose
    } else {
        needed_pose(&object, "its link's frame")?
    };
    steps.push(Step::plain(
        SceneChange::Attach {
            id,
            link_name,
            touch_links,
            pose,
        },
        place,
    ));
    Ok(steps)
}

fn append(object: ObjectFile, meshes: &mut MeshSource<'_>) -> Result<SceneChange, SceneError> {
    object.check_appends()?;
    let shapes = object.shapes(meshes)?;
    Ok(SceneChange::Append {
        id: object.id,
        shapes,
    })
}

fn moved(object: ObjectFile, frame: &str) -> Result<SceneChange, SceneError> {
    if object.has_shapes() || object.has_shape_poses() {
        let text = format!(
            "object {:?} has shapes, which MOVE does not change; valid: its pose",
            object.id
        );
        return Err(SceneError::Syntax(text));
    }
    let pose = needed_pose(&object, frame)?;
    Ok(SceneChange::Move {
        id: object.id,
        pose,
    })
}

fn needed_pose(object: &ObjectFile, frame: &str) -> Result<Pose, SceneError> {
    object.own_pose()?.ok_or_else(|| {
        let text = format!(
            "object {:?} has no pose; give its pose in {frame}",
            object.id
        );
        SceneError::Syntax(text)
    })
}
