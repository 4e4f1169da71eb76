//! Changes to a scene: a new scene beside the old one, which shares every shape that stays.

use super::{AttachedObject, Obstacle, Scene, SceneDescription, SceneError, comma_separated};
use crate::math::Pose;

/// One change to a scene, named as in MoveIt's messages.
#[derive(Clone, Debug, PartialEq)]
pub enum SceneChange {
    /// A new object in the world.
    Add(Obstacle),
    /// An object goes, wherever it is, and with it every pair, touch link and padding that names it.
    Remove {
        /// Object.
        id: String,
    },
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
    /// Two links or objects may touch, and are not checked against each other.
    Allow(String, String),
    /// Two links or objects are checked against each other, whatever allows them to touch.
    Forbid(String, String),
}

impl Scene {
    /// The scene after some changes, made one after the other. This one stays as it is; shapes that no change
    /// brings are shared.
    ///
    /// # Errors
    /// A change to an object that is not there, an id that is taken, an object that is attached already or not
    /// at all, a pose or padding that is none.
    pub fn with(&self, changes: impl IntoIterator<Item = SceneChange>) -> Result<Self, SceneError> {
        let mut description = self.description.clone();
        for change in changes {
            description.apply(change)?;
        }
        Self::of(description)
    }
}

impl SceneDescription {
    fn apply(&mut self, change: SceneChange) -> Result<(), SceneError> {
        match change {
            SceneChange::Add(object) => self.add(object)?,
            SceneChange::Remove { id } => self.remove(&id)?,
            SceneChange::Move { id, pose } => self.object_mut("move", &id)?.pose = pose,
            SceneChange::Attach { id, link_name, touch_links, pose } => {
                let object = self.take_standing(&id)?.at(pose);
                self.attached.push(AttachedObject { link_name, object, touch_links });
            }
            SceneChange::Detach { id, pose } => {
                let object = self.take_attached(&id)?.object.at(pose);
                self.obstacles.push(object);
            }
            SceneChange::Pad { name, padding } => {
                self.padding.insert(name, padding);
            }
            SceneChange::Allow(a, b) => {
                self.forbidden.retain(|pair| !is_pair(pair, &a, &b));
                add_pair(&mut self.allowed, a, b);
            }
            SceneChange::Forbid(a, b) => {
                self.allowed.retain(|pair| !is_pair(pair, &a, &b));
                add_pair(&mut self.forbidden, a, b);
            }
        }
        Ok(())
    }

    fn add(&mut self, object: Obstacle) -> Result<(), SceneError> {
        if self.object_mut("add", &object.id).is_ok() {
            return Err(SceneError::Duplicate(object.id));
        }
        self.obstacles.push(object);
        Ok(())
    }

    fn remove(&mut self, id: &str) -> Result<(), SceneError> {
        self.object_mut("remove", id)?;
        self.obstacles.retain(|obstacle| obstacle.id != id);
        self.attached.retain(|attached| attached.object.id != id);
        for pairs in [&mut self.allowed, &mut self.forbidden] {
            pairs.retain(|(a, b)| a != id && b != id);
        }
        for attached in &mut self.attached {
            attached.touch_links.retain(|name| name != id);
        }
        self.padding.remove(id);
        Ok(())
    }

    /// An object wherever it is.
    fn object_mut(&mut self, change: &'static str, id: &str) -> Result<&mut Obstacle, SceneError> {
        let known = || comma_separated(self.objects().map(|object| object.id.as_str()));
        if !self.objects().any(|object| object.id == id) {
            return Err(SceneError::UnknownObject { change, id: id.to_owned(), known: known() });
        }
        let attached = self.attached.iter_mut().map(|attached| &mut attached.object);
        let mut objects = self.obstacles.iter_mut().chain(attached);
        Ok(objects.find(|object| object.id == id).expect("it is there"))
    }

    fn take_standing(&mut self, id: &str) -> Result<Obstacle, SceneError> {
        if let Some(attached) = self.attached.iter().find(|attached| attached.object.id == id) {
            return Err(SceneError::AlreadyAttached { id: id.to_owned(), link_name: attached.link_name.clone() });
        }
        let Some(index) = self.obstacles.iter().position(|obstacle| obstacle.id == id) else {
            let known = comma_separated(self.obstacles.iter().map(|obstacle| obstacle.id.as_str()));
            return Err(SceneError::UnknownObject { change: "attach", id: id.to_owned(), known });
        };
        Ok(self.obstacles.remove(index))
    }

    fn take_attached(&mut self, id: &str) -> Result<AttachedObject, SceneError> {
        if let Some(index) = self.attached.iter().position(|attached| attached.object.id == id) {
            return Ok(self.attached.remove(index));
        }
        let (id, known) = (id.to_owned(), comma_separated(self.attached.iter().map(|a| a.object.id.as_str())));
        match self.obstacles.iter().any(|obstacle| obstacle.id == id) {
            true => Err(SceneError::NotAttached { id, known }),
            false => Err(SceneError::UnknownObject { change: "detach", id, known }),
        }
    }
}

fn is_pair((c, d): &(String, String), a: &str, b: &str) -> bool {
    (c == a && d == b) || (c == b && d == a)
}

fn add_pair(pairs: &mut Vec<(String, String)>, a: String, b: String) {
    if !pairs.iter().any(|pair| is_pair(pair, &a, &b)) {
        pairs.push((a, b));
    }
}
