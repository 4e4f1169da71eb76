//! What makes one scene of another: the inverse of [`Scene::with`].

use std::collections::BTreeSet;
use std::sync::Arc;

use super::object::is_same;
use super::objects::digest_of_shapes;
use super::{AttachedObject, Obstacle, Scene, SceneChange, Verdict};
use crate::math::Pose;
use crate::shape::PlacedShape;

impl Scene {
    /// Changes that make this scene the other one: made by [`Scene::with`], they give a scene of
    /// its content hash. What both have is left as it is, but for objects that stand elsewhere in
    /// the order: these go and come again.
    pub fn changes_to(&self, other: &Self) -> Vec<SceneChange> {
        let mut way = Way {
            at: self.clone(),
            other,
            changes: Vec::new(),
        };
        let kept = way.kept();
        way.remove(&kept);
        way.set_frames();
        way.stand(kept.len());
        way.attach();
        way.set_frames_of_objects();
        way.set_sizes();
        way.set_verdicts();
        way.changes
    }
}

/// How far the way to another scene has come.
struct Way<'a> {
    at: Scene,
    other: &'a Scene,
    changes: Vec<SceneChange>,
}

impl<'a> Way<'a> {
    fn go(&mut self, change: SceneChange) {
        self.at = self
            .at
            .with([change.clone()])
            .expect("a change towards a checked scene can be made");
        self.changes.push(change);
    }

    /// Objects that can go on standing where they are in the order, from the other's first:
    /// whatever is put down comes behind all that stand.
    fn kept(&self) -> BTreeSet<&'a str> {
        let mut last = None;
        let stays = |object: &&Obstacle| {
            let number = self.at.obstacles.number(&object.id);
            std::mem::replace(&mut last, number) < number
        };
        self.other
            .obstacles
            .iter()
            .take_while(stays)
            .map(|object| object.id.as_str())
            .collect()
    }

    fn remove(&mut self, kept: &BTreeSet<&str>) {
        for id in self.gone(kept) {
            self.go(SceneChange::Remove { id });
        }
    }

    /// What the other scene does not have, or has elsewhere in the order.
    fn gone(&self, kept: &BTreeSet<&str>) -> Vec<String> {
        let other = self.other;
        let standing = self
            .at
            .obstacles
            .iter()
            .map(|object| &object.id);
        let standing =
            standing.filter(|id| !kept.contains(id.as_str()) && other.attached.get(id).is_none());
        let attached = self
            .at
            .attached
            .iter()
            .map(|held| &held.object.id);
        let attached = attached.filter(|id| other.object(id).is_none());
        standing.chain(attached).cloned().collect()
    }

    fn set_frame(&mut self, name: &str, pose: Option<Pose>) {
        let name = name.to_owned();
        self.go(SceneChange::Frame { name, pose });
    }

    fn set_subframe(&mut self, object: &str, name: &str, pose: Option<Pose>) {
        self.go(SceneChange::Subframe {
            object: object.to_owned(),
            name: name.to_owned(),
            pose,
        });
    }

    fn call_world(&mut self, id: &str, frame: Option<&str>) {
        self.go(SceneChange::World {
            id: id.to_owned(),
            frame: frame.map(str::to_owned),
        });
    }

    fn set_frames(&mut self) {
        let at = self.at.clone();
        let other = self.other;
        for (name, _) in at.frames() {
            if other.frames.get(name).is_none() {
                self.set_frame(name, None);
            }
        }
        for (name, pose) in other.frames() {
            if !has_pose(at.frames.get(name), pose) {
                self.set_frame(name, Some(*pose));
            }
        }
    }

    /// Frames on objects, and what these call the world.
    fn set_frames_of_objects(&mut self) {
        self.set_subframes();
        self.set_worlds();
    }

    fn set_subframes(&mut self) {
        let at = self.at.clone();
        let other = self.other;
        for (object, name, _) in at.subframes() {
            if other.subframe(object, name).is_none() {
                self.set_subframe(object, name, None);
            }
        }
        for (object, name, pose) in other.subframes() {
            if !has_pose(at.subframe(object, name), pose) {
                self.set_subframe(object, name, Some(*pose));
            }
        }
    }

    fn set_worlds(&mut self) {
        let at = self.at.clone();
        let other = self.other;
        for (id, _) in at.worlds() {
            if other.world_of(id).is_none() {
                self.call_world(id, None);
            }
        }
        for (id, frame) in other.worlds() {
            if at.world_of(id) != Some(frame) {
                self.call_world(id, Some(frame));
            }
        }
    }

    /// What stands in the other scene, of which the first are kept.
    fn stand(&mut self, kept: usize) {
        for (index, object) in self.other.obstacles.iter().enumerate() {
            if index >= kept {
                self.reshape(object);
                self.put_down(object);
            } else if !self.stands_as(object) {
                self.reshape(object);
                self.put_in_place(object);
            }
        }
    }

    /// Whether an object that stands is the other scene's very own.
    fn stands_as(&self, object: &Obstacle) -> bool {
        let held = self.at.obstacles.get(&object.id);
        held.is_some_and(|held| std::ptr::eq(held, object))
    }

    fn put_down(&mut self, object: &Obstacle) {
        let id = object.id.clone();
        let pose = object.pose;
        self.go(match self.at.attached.get(&id) {
            Some(_) => SceneChange::Detach { id, pose },
            None => SceneChange::Add(object.clone()),
        });
    }

    fn put_in_place(&mut self, object: &Obstacle) {
        let id = object.id.clone();
        if self.at.obstacles.fact(&id) != self.other.obstacles.fact(&id) {
            let pose = object.pose;
            self.go(SceneChange::Move { id, pose });
        }
    }

    fn attach(&mut self) {
        let mut last = None;
        let mut is_kept = true;
        for attached in &self.other.attached {
            self.reshape(&attached.object);
            let number = self.at.attached.number(&attached.object.id);
            is_kept &= number > last && self.is_carried(attached);
            last = number;
            if is_kept {
                self.carry_in_place(&attached.object);
            } else {
                self.take_up(attached);
            }
        }
    }

    /// Whether its link has an object already, with the same touch links.
    fn is_carried(&self, attached: &AttachedObject) -> bool {
        let held = self.at.attached.get(&attached.object.id);
        held.is_some_and(|held| {
            held.link_name == attached.link_name && held.touch_links == attached.touch_links
        })
    }

    fn carry_in_place(&mut self, object: &Obstacle) {
        let id = object.id.clone();
        if self.at.attached.fact(&id) != self.other.attached.fact(&id) {
            let pose = object.pose;
            self.go(SceneChange::Move { id, pose });
        }
    }

    fn take_up(&mut self, attached: &AttachedObject) {
        let object = &attached.object;
        if self.at.attached.get(&object.id).is_some() || self.at.obstacles.get(&object.id).is_none()
        {
            self.put_down(object);
        }
        self.go(SceneChange::Attach {
            id: object.id.clone(),
            link_name: attached.link_name.clone(),
            touch_links: attached.touch_links.clone(),
            pose: object.pose,
        });
    }

    fn set_sizes(&mut self) {
        let at = self.at.clone();
        let other = self.other;
        for (name, _) in at.padded().chain(other.padded()) {
            self.pad(name, other.padding(name));
        }
        for (name, _) in at.scaled().chain(other.scaled()) {
            self.scale(name, other.scale(name));
        }
    }

    fn pad(&mut self, name: &str, padding: f64) {
        if self.at.padding(name) != padding {
            let name = name.to_owned();
            self.go(SceneChange::Pad { name, padding });
        }
    }

    fn scale(&mut self, name: &str, scale: f64) {
        if self.at.scale(name) != scale {
            let name = name.to_owned();
            self.go(SceneChange::Scale { name, scale });
        }
    }

    fn set_verdicts(&mut self) {
        let at = self.at.clone();
        let other = self.other;
        for (a, b, _) in at.verdicts.iter() {
            if other.verdicts.get(a, b).is_none() {
                self.go(SceneChange::ClearPair(a.to_owned(), b.to_owned()));
            }
        }
        for (a, b, verdict) in other.verdicts.iter() {
            if at.verdicts.get(a, b) != Some(verdict) {
                self.judge(a.to_owned(), b.to_owned(), verdict);
            }
        }
    }

    fn judge(&mut self, a: String, b: String, verdict: Verdict) {
        self.go(match verdict {
            Verdict::Allowed => SceneChange::Allow(a, b),
            Verdict::Forbidden => SceneChange::Forbid(a, b),
        });
    }

    /// Gives an object that is here already the shapes that it has in the other scene.
    fn reshape(&mut self, object: &Obstacle) {
        let held = self.at.object(&object.id);
        if let Some(change) = held.and_then(|held| reshaping(held, object)) {
            self.go(change);
        }
    }
}

/// What gives an object the shapes of another, if it has not got them.
fn reshaping(held: &Obstacle, object: &Obstacle) -> Option<SceneChange> {
    if Arc::ptr_eq(&held.shapes, &object.shapes) {
        return None;
    }
    match more_shapes(held, object) {
        Some([]) => None,
        Some(more) => Some(SceneChange::Append {
            id: object.id.clone(),
            shapes: more.to_vec(),
        }),
        None => Some(SceneChange::Replace(object.clone())),
    }
}

/// The shapes that an object has besides those of another, if it begins with them.
fn more_shapes<'o>(held: &Obstacle, object: &'o Obstacle) -> Option<&'o [PlacedShape]> {
    let (first, more) = object
        .shapes
        .split_at_checked(held.shapes.len())?;
    (digest_of_shapes(first) == digest_of_shapes(&held.shapes)).then_some(more)
}

/// Whether there is this pose, by bits, as hashes have it: zeros of either sign compare equal.
fn has_pose(held: Option<&Pose>, pose: &Pose) -> bool {
    held.is_some_and(|held| is_same(held, pose))
}
