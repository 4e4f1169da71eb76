//! Changes as the text of a diff.

use super::diff_file::DiffPart;
use super::object_file::{ObjectFile, Operation};
use super::pose_file::{FrameFile, PoseFile};
use super::scene_file::AttachedObjectFile;
use super::{AttachedObject, Scene, SceneChange, SceneError};
use crate::math::Pose;

/// The text of a diff that makes these changes to a scene: the first step of one is made against `scene`. Without
/// `with_meshes`, a mesh has its name and hash only, and is looked for under that name when the text is read.
///
/// # Errors
/// A change that the scene does not take, or that takes all shapes from an object which a link carries: without
/// shapes, ADD means an object of the world.
pub fn text(scene: &Scene, changes: &[SceneChange], with_meshes: bool) -> Result<String, SceneError> {
    let mut writer = Writer { scene: scene.clone(), parts: vec![part()], rank: 0, with_meshes };
    for change in changes {
        writer.check(change)?;
        writer.write(change);
        writer.scene = writer.scene.with([change.clone()])?;
    }
    let parts = writer.parts;
    let text = if let [part] = parts.as_slice() { serde_json::to_string(part) } else { serde_json::to_string(&parts) };
    Ok(text.expect("a diff holds only names and finite numbers"))
}

fn part() -> DiffPart {
    DiffPart { is_diff: true, ..DiffPart::default() }
}

/// What is written so far, and the scene there.
struct Writer {
    scene: Scene,
    parts: Vec<DiffPart>,
    rank: usize,
    with_meshes: bool,
}

impl Writer {
    fn check(&self, change: &SceneChange) -> Result<(), SceneError> {
        match change {
            SceneChange::Replace(object)
                if object.shapes.is_empty() && self.scene.attached().get(&object.id).is_some() =>
            {
                let text = format!("object {:?} keeps no shapes on its link, which no diff can say", object.id);
                Err(SceneError::Syntax(format!("{text}; remove it, or compare with another version")))
            }
            _ => Ok(()),
        }
    }

    fn write(&mut self, change: &SceneChange) {
        match change.clone() {
            SceneChange::Frame { name, pose } => {
                self.part(0).fixed_frame_transforms.push(FrameFile::of(&name, pose.as_ref()));
            }
            SceneChange::Add(object) => self.objects(ObjectFile::of(&object, self.with_meshes)),
            SceneChange::Replace(object) => match self.scene.attached().get(&object.id).cloned() {
                None => self.objects(ObjectFile::of(&object, self.with_meshes)),
                Some(attached) => {
                    let entries = AttachedObjectFile::of(&AttachedObject { object, ..attached }, self.with_meshes);
                    self.part(2).attached_collision_objects.extend(entries);
                }
            },
            SceneChange::RemoveAll => self.removed(String::new()),
            SceneChange::Remove { id } => self.removed(id),
            SceneChange::Move { id, pose } => {
                self.objects(vec![ObjectFile { operation: Some(Operation::Move), ..placed(id, &pose) }]);
            }
            SceneChange::Append { id, shapes } => {
                self.objects(ObjectFile::appending(&id, &shapes, self.with_meshes));
            }
            SceneChange::Attach { id, link_name, touch_links, pose } => {
                let object = placed(id, &pose);
                self.attached(Operation::Add, link_name, object, touch_links);
            }
            SceneChange::Detach { id, pose } => {
                self.attached(Operation::Remove, String::new(), placed(id, &pose), Vec::new());
            }
            SceneChange::ClearPair(a, b) => self.part(3).default_collisions.push((a, b)),
            SceneChange::Allow(a, b) => self.part(4).allowed_collisions.push((a, b)),
            SceneChange::Forbid(a, b) => self.part(5).forbidden_collisions.push((a, b)),
            SceneChange::Pad { name, padding } => {
                self.part(6).link_padding.0.insert(name, padding);
            }
            SceneChange::Scale { name, scale } => {
                self.part(7).link_scale.0.insert(name, scale);
            }
        }
    }

    /// The part that the next change goes into: a part is made in the order of its lists, so that one which comes
    /// before what is written already begins another.
    fn part(&mut self, rank: usize) -> &mut DiffPart {
        if rank < self.rank {
            self.parts.push(part());
        }
        self.rank = rank;
        self.parts.last_mut().expect("there is one from the start")
    }

    /// Changes to an object where it is: in the world, or on a link.
    fn objects(&mut self, files: Vec<ObjectFile>) {
        let carrier = files.first().and_then(|file| self.scene.attached().get(&file.id));
        match carrier.map(|attached| attached.link_name.clone()) {
            None => self.part(1).objects.extend(files),
            Some(link_name) => {
                let entry =
                    |object| AttachedObjectFile { link_name: link_name.clone(), object, touch_links: Vec::new() };
                self.part(2).attached_collision_objects.extend(files.into_iter().map(entry));
            }
        }
    }

    fn removed(&mut self, id: String) {
        let object = ObjectFile { id, operation: Some(Operation::Remove), ..ObjectFile::default() };
        self.part(1).objects.push(object);
    }

    fn attached(&mut self, operation: Operation, link_name: String, object: ObjectFile, touch_links: Vec<String>) {
        let object = ObjectFile { operation: Some(operation), ..object };
        self.part(2).attached_collision_objects.push(AttachedObjectFile { link_name, object, touch_links });
    }
}

fn placed(id: String, pose: &Pose) -> ObjectFile {
    ObjectFile { id, pose: Some(PoseFile::of(pose)), ..ObjectFile::default() }
}
