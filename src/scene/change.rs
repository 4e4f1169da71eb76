//! Changes to a scene: a new scene beside the old one, which shares every shape that stays.

use std::sync::{Arc, OnceLock};

use super::object::{check_pose, check_shapes};
use super::{AttachedObject, Obstacle, Scene, SceneError, Verdict, comma_separated};
use crate::math::Pose;
use crate::shape::PlacedShape;

/// Scales beyond these are slips of units.
const SCALES: std::ops::RangeInclusive<f64> = 1e-3..=1e3;

/// One change to a scene, named as in MoveIt's messages.
#[derive(Clone, Debug, PartialEq)]
pub enum SceneChange {
    /// A new object in the world.
    Add(Obstacle),
    /// An object that is there gets another pose and other shapes; what names it stays.
    Replace(Obstacle),
    /// An object gets more shapes, wherever it is.
    Append {
        /// Object.
        id: String,
        /// The shapes, in the object's frame.
        shapes: Vec<PlacedShape>,
    },
    /// An object goes, wherever it is, and with it every pair, touch link, padding and scale that
    /// names it.
    Remove {
        /// Object.
        id: String,
    },
    /// Every object of the world goes, as by [`SceneChange::Remove`]; what links carry stays
    /// (MoveIt's REMOVE without an id).
    RemoveAll,
    /// An object's frame goes to another place.
    Move {
        /// Object.
        id: String,
        /// Its pose in the world; for an attached object, in its link's frame.
        pose: Pose,
    },
    /// An object of the world is carried by a link from now on.
    Attach {
        /// Object.
        id: String,
        /// The link that carries it; the two may touch.
        link_name: String,
        /// Links and objects that it may touch besides.
        touch_links: Vec<String>,
        /// Its pose in the link's frame.
        pose: Pose,
    },
    /// An attached object stands in the world from now on.
    Detach {
        /// Object.
        id: String,
        /// Its pose in the world.
        pose: Pose,
    },
    /// A link or object counts as thicker by this much wherever robot and obstacles meet.
    Pad {
        /// Link or object.
        name: String,
        /// Added on all sides (m); 0 takes the padding away.
        padding: f64,
    },
    /// A link's or object's shapes count as so many times as large wherever robot and obstacles
    /// meet, each about its own centre (a mesh about the mean of its vertices, as in MoveIt);
    /// padding comes on top.
    Scale {
        /// Link or object.
        name: String,
        /// From 0.001 to 1000; 1 takes the scale away.
        scale: f64,
    },
    /// A named frame, in which poses may be given from now on ([`Scene::in_world`]).
    Frame {
        /// Its name, which no object has.
        name: String,
        /// Its pose in the world; `None` takes the frame away.
        pose: Option<Pose>,
    },
    /// A frame on an object, in which poses may be given as `OBJECT/NAME`.
    Subframe {
        /// Object.
        object: String,
        /// The frame's own name.
        name: String,
        /// Its pose in the object's frame; `None` takes it away.
        pose: Option<Pose>,
    },
    /// The pose of an object of the world is given in a frame that the scene does not know: a robot
    /// that is checked in the scene has to call the world so.
    World {
        /// Object.
        id: String,
        /// The frame; `None` where the scene knows where the object is.
        frame: Option<String>,
    },
    /// Two links or objects may touch, and are not checked against each other.
    Allow(String, String),
    /// Two links or objects are checked against each other, whatever allows them to touch.
    Forbid(String, String),
    /// The scene says nothing any more of whether two links or objects may touch.
    ClearPair(String, String),
}

impl Scene {
    /// The scene after some changes, made one after the other. This one stays as it is; all that no
    /// change touches is shared, so that a change costs the logarithm of the scene's size.
    ///
    /// # Errors
    /// A change to an object that is not there, an id that is taken, an object that is attached
    /// already or not at all, a pose, padding or scale that is none, a frame that is not there.
    pub fn with(&self, changes: impl IntoIterator<Item = SceneChange>) -> Result<Self, SceneError> {
        let mut scene = Self {
            warnings: OnceLock::new(),
            sensed: OnceLock::new(),
            ..self.clone()
        };
        for change in changes {
            scene.apply(change)?;
        }
        Ok(scene.finished())
    }

    fn apply(&mut self, change: SceneChange) -> Result<(), SceneError> {
        match change {
            SceneChange::Add(object) => self.add(object),
            SceneChange::Replace(object) => self.replace(object),
            SceneChange::Append { id, shapes } => self.append(&id, shapes),
            SceneChange::Remove { id } => self.remove(&id),
            SceneChange::RemoveAll => self.remove_all(),
            SceneChange::Move { id, pose } => self.move_to(&id, pose),
            SceneChange::Attach {
                id,
                link_name,
                touch_links,
                pose,
            } => self.attach(&id, link_name, touch_links, pose),
            SceneChange::Detach { id, pose } => self.detach(&id, pose),
            SceneChange::Pad { name, padding } => self.pad(&name, padding),
            SceneChange::Scale { name, scale } => self.rescale(&name, scale),
            SceneChange::Frame { name, pose } => self.place_frame(&name, pose),
            SceneChange::Subframe { object, name, pose } => {
                self.place_subframe(&object, &name, pose)
            }
            SceneChange::World { id, frame } => self.call_world(&id, frame.as_deref()),
            SceneChange::Allow(a, b) => self.judge(&a, &b, Some(Verdict::Allowed)),
            SceneChange::Forbid(a, b) => self.judge(&a, &b, Some(Verdict::Forbidden)),
            SceneChange::ClearPair(a, b) => self.judge(&a, &b, None),
        }
    }

    fn replace(&mut self, object: Obstacle) -> Result<(), SceneError> {
        object.check()?;
        self.update("replace", &object.id.clone(), |_| object)
    }

    fn append(&mut self, id: &str, more: Vec<PlacedShape>) -> Result<(), SceneError> {
        let own = self.objects().find(|object| object.id == id);
        let own = own.map_or(&[][..], |object| &object.shapes);
        let all: Vec<_> = own.iter().chain(&more).cloned().collect();
        check_shapes(&all).map_err(|error| error.of_object(id))?;
        self.update("append to", id, |object| object.appended(more))
    }

    fn remove_all(&mut self) -> Result<(), SceneError> {
        let objects = self.obstacles.iter();
        let ids: Vec<_> = objects
            .map(|object| object.id.clone())
            .collect();
        ids.iter().try_for_each(|id| self.remove(id))
    }

    fn move_to(&mut self, id: &str, pose: Pose) -> Result<(), SceneError> {
        check_pose(&pose).map_err(|error| error.of_object(id))?;
        self.update("move", id, |object| object.clone().at(pose))
    }

    fn attach(
        &mut self,
        id: &str,
        link_name: String,
        touch_links: Vec<String>,
        pose: Pose,
    ) -> Result<(), SceneError> {
        let object = self.take_standing(id)?.at(pose);
        self.worlds.set(id.into(), None);
        self.add_attached(AttachedObject {
            link_name,
            object,
            touch_links,
        })
    }

    fn detach(&mut self, id: &str, pose: Pose) -> Result<(), SceneError> {
        let object = self.take_attached(id)?.object.at(pose);
        self.add(object)
    }

    fn judge(&mut self, a: &str, b: &str, verdict: Option<Verdict>) -> Result<(), SceneError> {
        self.verdicts.set(a, b, verdict);
        Ok(())
    }

    pub(super) fn add(&mut self, object: Obstacle) -> Result<(), SceneError> {
        self.check_new(&object)?;
        self.obstacles.push(object);
        Ok(())
    }

    pub(super) fn add_attached(&mut self, attached: AttachedObject) -> Result<(), SceneError> {
        self.check_new(&attached.object)?;
        self.attached.push(attached);
        Ok(())
    }

    fn check_new(&self, object: &Obstacle) -> Result<(), SceneError> {
        if self.has(&object.id) {
            return Err(SceneError::Duplicate(object.id.clone()));
        }
        if self.frames.get(object.id.as_str()).is_some() {
            return Err(SceneError::NameTaken(object.id.clone()));
        }
        object.check()
    }

    fn has(&self, id: &str) -> bool {
        self.obstacles.get(id).is_some() || self.attached.get(id).is_some()
    }

    pub(super) fn pad(&mut self, name: &str, padding: f64) -> Result<(), SceneError> {
        if !padding.is_finite() || padding < 0.0 {
            return Err(SceneError::BadPadding {
                name: name.to_owned(),
                value: padding,
            });
        }
        self.padding
            .set(name.into(), (padding != 0.0).then_some(padding));
        Ok(())
    }

    pub(super) fn rescale(&mut self, name: &str, scale: f64) -> Result<(), SceneError> {
        if !SCALES.contains(&scale) {
            return Err(SceneError::BadScale {
                name: name.to_owned(),
                value: scale,
            });
        }
        self.scale
            .set(name.into(), (scale != 1.0).then_some(scale));
        Ok(())
    }

    pub(super) fn place_frame(&mut self, name: &str, pose: Option<Pose>) -> Result<(), SceneError> {
        match &pose {
            Some(_) if self.has(name) => return Err(SceneError::NameTaken(name.to_owned())),
            Some(pose) => check_pose(pose).map_err(|error| error.of_frame(name))?,
            None if self.frames.get(name).is_none() => return Err(self.unknown_frame(name, &[])),
            None => {}
        }
        self.frames.set(name.into(), pose);
        Ok(())
    }

    pub(super) fn place_subframe(
        &mut self,
        object: &str,
        name: &str,
        pose: Option<Pose>,
    ) -> Result<(), SceneError> {
        if !self.has(object) {
            return Err(self.unknown("place a frame on", object));
        }
        if let Some(pose) = &pose {
            check_pose(pose).map_err(|error| error.of_frame(&format!("{object}/{name}")))?;
        }
        self.subframes
            .set((object.into(), name.into()), pose);
        Ok(())
    }

    pub(super) fn call_world(&mut self, id: &str, frame: Option<&str>) -> Result<(), SceneError> {
        if self.obstacles.get(id).is_none() {
            return Err(self.unknown("place", id));
        }
        self.worlds
            .set(id.into(), frame.map(Into::into));
        Ok(())
    }

    fn remove(&mut self, id: &str) -> Result<(), SceneError> {
        if self.obstacles.remove(id).is_none() && self.attached.remove(id).is_none() {
            return Err(self.unknown("remove", id));
        }
        self.forget(id);
        Ok(())
    }

    /// Takes away all that names an object.
    fn forget(&mut self, id: &str) {
        self.verdicts.forget(id);
        self.forget_touching(id);
        self.forget_subframes(id);
        self.worlds.set(id.into(), None);
        self.padding.set(id.into(), None);
        self.scale.set(id.into(), None);
    }

    fn forget_touching(&mut self, id: &str) {
        let touching = self
            .attached
            .iter()
            .filter(|held| held.may_touch(id));
        let touching: Vec<_> = touching
            .map(|held| held.object.id.clone())
            .collect();
        for carried in touching {
            self.attached
                .update(&carried, |held| held.clone().not_touching(id));
        }
    }

    fn forget_subframes(&mut self, id: &str) {
        let frames = self
            .subframes_of(id)
            .map(|(name, _)| name.into());
        for name in frames.collect::<Vec<Arc<str>>>() {
            self.subframes.set((id.into(), name), None);
        }
    }

    /// Changes an object wherever it is.
    fn update(
        &mut self,
        what: &'static str,
        id: &str,
        change: impl FnOnce(&Obstacle) -> Obstacle,
    ) -> Result<(), SceneError> {
        if self.obstacles.get(id).is_some() {
            self.obstacles.update(id, change);
        } else if self.attached.get(id).is_some() {
            self.attached
                .update(id, |held| held.with_object(change));
        } else {
            return Err(self.unknown(what, id));
        }
        Ok(())
    }

    fn unknown(&self, change: &'static str, id: &str) -> SceneError {
        let known = comma_separated(self.objects().map(|object| object.id.as_str()));
        SceneError::unknown_object(change, id, known)
    }

    fn standing_names(&self) -> String {
        comma_separated(
            self.obstacles
                .iter()
                .map(|object| object.id.as_str()),
        )
    }

    /// Ids of the objects that links carry, for a message.
    pub(super) fn attached_names(&self) -> String {
        comma_separated(
            self.attached
                .iter()
                .map(|held| held.object.id.as_str()),
        )
    }

    fn take_standing(&mut self, id: &str) -> Result<Obstacle, SceneError> {
        if let Some(attached) = self.attached.get(id) {
            return Err(SceneError::AlreadyAttached {
                id: id.to_owned(),
                link_name: attached.link_name.clone(),
            });
        }
        let taken = self.obstacles.remove(id);
        taken.ok_or_else(|| SceneError::unknown_object("attach", id, self.standing_names()))
    }

    fn take_attached(&mut self, id: &str) -> Result<AttachedObject, SceneError> {
        let taken = self.attached.remove(id);
        taken.ok_or_else(|| self.not_carried(id))
    }

    fn not_carried(&self, id: &str) -> SceneError {
        let known = self.attached_names();
        match self.obstacles.get(id) {
            Some(_) => SceneError::not_attached(id, known),
            None => SceneError::unknown_object("detach", id, known),
        }
    }
}
