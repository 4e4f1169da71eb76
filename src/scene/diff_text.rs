//! Changes as the text of a diff.

use super::diff_file::{DiffFile, SceneFile};
use super::object::set_identity;
use super::object_file::{ObjectFile, Operation};
use super::pose_file::{FrameFile, HeaderFile, PoseFile};
use super::scene_file::AttachedObjectFile;
use super::{AttachedObject, Obstacle, Scene, SceneChange, SceneError};
use crate::math::Pose;

/// The text of a diff that makes these changes to a scene: the first step of one is made against
/// `scene`. Without `with_meshes`, a mesh has its name and hash only, and is looked for under that
/// name when the text is read.
///
/// # Errors
/// A change that the scene does not take, or that takes all shapes from an object which a link
/// carries: without shapes, ADD means an object of the world.
pub fn text(
    scene: &Scene,
    changes: &[SceneChange],
    with_meshes: bool,
) -> Result<String, SceneError> {
    let mut writer = Writer {
        scene: scene.clone(),
        parts: vec![part()],
        rank: 0,
        with_meshes,
    };
    for change in changes {
        writer.check(change)?;
        writer.write(change);
        writer.scene = writer.scene.with([change.clone()])?;
    }
    Ok(DiffFile(writer.parts).text())
}

fn part() -> SceneFile {
    SceneFile {
        is_diff: Some(true),
        ..SceneFile::default()
    }
}

/// What is written so far, and the scene there.
struct Writer {
    scene: Scene,
    parts: Vec<SceneFile>,
    rank: usize,
    with_meshes: bool,
}

impl Writer {
    fn check(&self, change: &SceneChange) -> Result<(), SceneError> {
        match change {
            SceneChange::Replace(object)
                if object.shapes.is_empty() && self.scene.attached().get(&object.id).is_some() =>
            {
                let text = format!(
                    "object {:?} keeps no shapes on its link, which no diff can say",
                    object.id
                );
                Err(SceneError::Syntax(format!(
                    "{text}; remove it, or compare with another version"
                )))
            }
            _ => Ok(()),
        }
    }

    fn write(&mut self, change: &SceneChange) {
        match change.clone() {
            SceneChange::Frame { name, pose } => {
                self.part(0)
                    .fixed_frame_transforms
                    .push(FrameFile::of(&name, pose.as_ref()));
            }
            SceneChange::Add(object) => self.objects(ObjectFile::of(&object, self.with_meshes)),
            SceneChange::Replace(object) => self.replaced(object),
            SceneChange::RemoveAll => self.removed(String::new()),
            SceneChange::Remove { id } => self.removed(id),
            SceneChange::Move { id, pose } => {
                match self
                    .scene
                    .object(&id)
                    .map(|object| object.clone().at(pose))
                {
                    Some(moved) if self.is_framed(&id) || moved.is_framed_by_shape() => {
                        self.replaced(moved)
                    }
                    _ => self.objects(vec![self.moved(id, &pose)]),
                }
            }
            SceneChange::Append { id, shapes } => {
                let longer = self.scene.object(&id).map(|object| {
                    let shapes = object
                        .shapes
                        .iter()
                        .chain(&shapes)
                        .cloned()
                        .collect();
                    Obstacle {
                        shapes,
                        ..object.clone()
                    }
                });
                match longer {
                    Some(longer) if self.is_framed(&id) || longer.is_framed_by_shape() => {
                        self.replaced(longer)
                    }
                    _ => self.objects(ObjectFile::appending(&id, &shapes, self.with_meshes)),
                }
            }
            SceneChange::Attach {
                id,
                link_name,
                touch_links,
                pose,
            } => {
                let standing = self
                    .scene
                    .obstacles()
                    .get(&id)
                    .filter(|standing| !standing.shapes.is_empty());
                match standing.map(|standing| standing.clone().at(pose)) {
                    Some(object) if self.is_framed(&id) || object.is_framed_by_shape() => {
                        let attached = AttachedObject {
                            link_name,
                            object,
                            touch_links,
                        };
                        self.attached_anew(&attached);
                    }
                    _ => self.attached(Operation::Add, link_name, placed(id, &pose), touch_links),
                }
            }
            SceneChange::Detach { id, pose } => self.detached(id, &pose),
            SceneChange::Subframe { object, name, pose } => {
                self.subframe(&object, &name, pose.as_ref())
            }
            SceneChange::World { id, frame } => self.called(&id, frame.as_deref()),
            SceneChange::ClearPair(a, b) => self.part(3).default_collisions.push((a, b)),
            SceneChange::Allow(a, b) => self.part(4).allowed_collisions.push((a, b)),
            SceneChange::Forbid(a, b) => self.part(5).forbidden_collisions.push((a, b)),
            SceneChange::Pad { name, padding } => {
                self.part(6)
                    .link_padding
                    .0
                    .insert(name, padding);
            }
            SceneChange::Scale { name, scale } => {
                self.part(7).link_scale.0.insert(name, scale);
            }
        }
    }

    /// Whether an object's frame is its shape's: words that speak of its frame would then say
    /// something else.
    fn is_framed(&self, id: &str) -> bool {
        self.scene
            .object(id)
            .is_some_and(Obstacle::is_framed_by_shape)
    }

    /// An object anew, with all that it keeps.
    fn replaced(&mut self, object: Obstacle) {
        match self.scene.attached().get(&object.id).cloned() {
            None => {
                let files = self.whole(&object);
                self.objects(files);
            }
            Some(attached) => self.attached_anew(&AttachedObject { object, ..attached }),
        }
    }

    fn whole(&self, object: &Obstacle) -> Vec<ObjectFile> {
        let mut files = ObjectFile::of(object, self.with_meshes);
        files[0].say_frames(&self.scene, &object.id);
        files
    }

    fn attached_anew(&mut self, attached: &AttachedObject) {
        let entries = AttachedObjectFile::of(&self.scene, attached, self.with_meshes);
        self.part(2)
            .attached_collision_objects
            .extend(entries);
    }

    /// An object's frame elsewhere; what it calls the world stays.
    fn moved(&self, id: String, pose: &Pose) -> ObjectFile {
        let header = HeaderFile::of(self.scene.world_of(&id).unwrap_or_default());
        ObjectFile {
            operation: Some(Operation::Move),
            header,
            ..placed(id, pose)
        }
    }

    fn detached(&mut self, id: String, pose: &Pose) {
        let Some(object) = self
            .scene
            .attached()
            .get(&id)
            .map(|attached| attached.object.clone())
        else {
            return;
        };
        if object.is_framed_by_shape() {
            self.replaced(object.clone().at(set_identity()));
        }
        self.attached(
            Operation::Remove,
            String::new(),
            placed(id, pose),
            Vec::new(),
        );
        let standing = object.at(*pose);
        if standing.is_framed_by_shape() {
            let files = self.whole(&standing);
            self.part(1)
                .objects
                .get_or_insert_default()
                .extend(files);
        }
    }

    /// One more frame on an object, or the object anew without it.
    fn subframe(&mut self, id: &str, name: &str, pose: Option<&Pose>) {
        let Some(object) = self.scene.object(id).cloned() else {
            return;
        };
        match pose {
            Some(pose) => {
                let file = ObjectFile {
                    id: id.to_owned(),
                    operation: Some(Operation::Append),
                    subframe_names: vec![name.to_owned()],
                    subframe_poses: vec![PoseFile::of(pose)],
                    ..ObjectFile::default()
                };
                self.objects(vec![file]);
            }
            None => {
                let without = SceneChange::Subframe {
                    object: id.to_owned(),
                    name: name.to_owned(),
                    pose: None,
                };
                self.scene = self
                    .scene
                    .with([without])
                    .unwrap_or_else(|_| self.scene.clone());
                self.replaced(object);
            }
        }
    }

    /// An object where it is, but for what it calls the world.
    fn called(&mut self, id: &str, frame: Option<&str>) {
        let Some(object) = self.scene.obstacles().get(id).cloned() else {
            return;
        };
        let mut files = self.whole(&object);
        files[0].header = HeaderFile::of(frame.unwrap_or_default());
        self.objects(files);
    }

    /// The part that the next change goes into: a part is made in the order of its lists, so that
    /// one which comes before what is written already begins another.
    fn part(&mut self, rank: usize) -> &mut SceneFile {
        if rank < self.rank {
            self.parts.push(part());
        }
        self.rank = rank;
        self.parts
            .last_mut()
            .expect("there is one from the start")
    }

    /// Changes to an object where it is: in the world, or on a link.
    fn objects(&mut self, files: Vec<ObjectFile>) {
        let carrier = files
            .first()
            .and_then(|file| self.scene.attached().get(&file.id));
        match carrier.map(|attached| attached.link_name.clone()) {
            None => self
                .part(1)
                .objects
                .get_or_insert_default()
                .extend(files),
            Some(link_name) => {
                let entry = |object| AttachedObjectFile::new(link_name.clone(), object);
                self.part(2)
                    .attached_collision_objects
                    .extend(files.into_iter().map(entry));
            }
        }
    }

    fn removed(&mut self, id: String) {
        let object = ObjectFile {
            id,
            operation: Some(Operation::Remove),
            ..ObjectFile::default()
        };
        self.part(1)
            .objects
            .get_or_insert_default()
            .push(object);
    }

    fn attached(
        &mut self,
        operation: Operation,
        link_name: String,
        object: ObjectFile,
        touch_links: Vec<String>,
    ) {
        let object = ObjectFile {
            operation: Some(operation),
            ..object
        };
        self.part(2)
            .attached_collision_objects
            .push(AttachedObjectFile {
                touch_links,
                ..AttachedObjectFile::new(link_name, object)
            });
    }
}

fn placed(id: String, pose: &Pose) -> ObjectFile {
    ObjectFile {
        id,
        pose: Some(PoseFile::of(pose)),
        ..ObjectFile::default()
    }
}
