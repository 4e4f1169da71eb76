//! What makes one scene of another: the inverse of [`Scene::with`].

use std::collections::BTreeSet;
use std::sync::Arc;

use super::object::is_same;
use super::objects::digest_of_shapes;
use super::{AttachedObject, Obstacle, Scene, SceneChange, Verdict};
use crate::math::Pose;

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
        let at = self.at.clone();
        let other = self.other;
        let standing = at.obstacles.iter().map(|object| &object.id);
        let standing =
            standing.filter(|id| !kept.contains(id.as_str()) && other.attached.get(id).is_none());
        let attached = at.attached.iter().map(|attached| &attached.object.id);
        let attached = attached.filter(|id| other.object(id).is_none());
        let gone: Vec<_> = standing.chain(attached).cloned().collect();
        gone.into_iter()
            .for_each(|id| self.go(SceneChange::Remove { id }));
    }

    fn set_frames(&mut self) {
        let at = self.at.clone();
        let other = self.other;
        for (name, _) in at
            .frames()
            .filter(|(name, _)| other.frames.get(*name).is_none())
        {
            self.go(SceneChange::Frame {
                name: name.to_owned(),
                pose: None,
            });
        }
        // By bits, as hashes do: zeros of either sign compare equal.
        let has =
            |name: &str, pose: &Pose| at.frames.get(name).is_some_and(|held| is_same(held, pose));
        for (name, pose) in other.frames().filter(|(name, pose)| !has(name, pose)) {
            self.go(SceneChange::Frame {
                name: name.to_owned(),
                pose: Some(*pose),
            });
        }
    }

    /// Frames on objects, and what these call the world.
    fn set_frames_of_objects(&mut self) {
        let at = self.at.clone();
        let other = self.other;
        let key = |object: &str, name: &str| (Arc::<str>::from(object), Arc::<str>::from(name));
        for (object, name, _) in at
            .subframes()
            .filter(|(o, n, _)| other.subframes.get(&key(o, n)).is_none())
        {
            self.go(SceneChange::Subframe {
                object: object.to_owned(),
                name: name.to_owned(),
                pose: None,
            });
        }
        let has = |o: &str, n: &str, pose: &Pose| {
            at.subframes
                .get(&key(o, n))
                .is_some_and(|held| is_same(held, pose))
        };
        for (object, name, pose) in other.subframes().filter(|(o, n, pose)| !has(o, n, pose)) {
            self.go(SceneChange::Subframe {
                object: object.to_owned(),
                name: name.to_owned(),
                pose: Some(*pose),
            });
        }
        for (id, _) in at.worlds().filter(|(id, _)| other.world_of(id).is_none()) {
            self.go(SceneChange::World {
                id: id.to_owned(),
                frame: None,
            });
        }
        for (id, frame) in other
            .worlds()
            .filter(|(id, frame)| at.world_of(id) != Some(frame))
        {
            self.go(SceneChange::World {
                id: id.to_owned(),
                frame: Some(frame.to_owned()),
            });
        }
    }

    /// What stands in the other scene, of which the first are kept.
    fn stand(&mut self, kept: usize) {
        for (index, object) in self.other.obstacles.iter().enumerate() {
            if index < kept
                && self
                    .at
                    .obstacles
                    .get(&object.id)
                    .is_some_and(|held| std::ptr::eq(held, object))
            {
                continue;
            }
            let id = object.id.clone();
            self.reshape(object);
            if index >= kept {
                self.go(match self.at.attached.get(&id) {
                    Some(_) => SceneChange::Detach {
                        id,
                        pose: object.pose,
                    },
                    None => SceneChange::Add(object.clone()),
                });
            } else if self.at.obstacles.fact(&id) != self.other.obstacles.fact(&id) {
                self.go(SceneChange::Move {
                    id,
                    pose: object.pose,
                });
            }
        }
    }

    fn attach(&mut self) {
        let mut last = None;
        let mut is_kept = true;
        for attached in &self.other.attached {
            let AttachedObject {
                link_name,
                object,
                touch_links,
            } = attached;
            let id = object.id.clone();
            let pose = object.pose;
            self.reshape(object);
            let number = self.at.attached.number(&id);
            is_kept &= number > last
                && self.at.attached.get(&id).is_some_and(|held| {
                    held.link_name == *link_name && held.touch_links == *touch_links
                });
            last = number;
            if is_kept {
                if self.at.attached.fact(&id) != self.other.attached.fact(&id) {
                    self.go(SceneChange::Move { id, pose });
                }
                continue;
            }
            if number.is_some() {
                self.go(SceneChange::Detach {
                    id: id.clone(),
                    pose,
                });
            } else if self.at.obstacles.get(&id).is_none() {
                self.go(SceneChange::Add(object.clone()));
            }
            let link_name = link_name.clone();
            let touch_links = touch_links.clone();
            self.go(SceneChange::Attach {
                id,
                link_name,
                touch_links,
                pose,
            });
        }
    }

    fn set_sizes(&mut self) {
        let at = self.at.clone();
        let other = self.other;
        for (name, _) in at.padded().chain(other.padded()) {
            if self.at.padding(name) != other.padding(name) {
                self.go(SceneChange::Pad {
                    name: name.to_owned(),
                    padding: other.padding(name),
                });
            }
        }
        for (name, _) in at.scaled().chain(other.scaled()) {
            if self.at.scale(name) != other.scale(name) {
                self.go(SceneChange::Scale {
                    name: name.to_owned(),
                    scale: other.scale(name),
                });
            }
        }
    }

    fn set_verdicts(&mut self) {
        let at = self.at.clone();
        let other = self.other;
        for (a, b, _) in at
            .verdicts
            .iter()
            .filter(|(a, b, _)| other.verdicts.get(a, b).is_none())
        {
            self.go(SceneChange::ClearPair(a.to_owned(), b.to_owned()));
        }
        for (a, b, verdict) in other
            .verdicts
            .iter()
            .filter(|(a, b, verdict)| at.verdicts.get(a, b) != Some(*verdict))
        {
            let a = a.to_owned();
            let b = b.to_owned();
            self.go(match verdict {
                Verdict::Allowed => SceneChange::Allow(a, b),
                Verdict::Forbidden => SceneChange::Forbid(a, b),
            });
        }
    }

    /// Gives an object that is here already the shapes that it has in the other scene.
    fn reshape(&mut self, object: &Obstacle) {
        let Some(held) = self
            .at
            .object(&object.id)
            .filter(|held| !Arc::ptr_eq(&held.shapes, &object.shapes))
        else {
            return;
        };
        let split = object.shapes.split_at_checked(held.shapes.len());
        match split.filter(|(first, _)| digest_of_shapes(first) == digest_of_shapes(&held.shapes)) {
            Some((_, [])) => {}
            Some((_, more)) => self.go(SceneChange::Append {
                id: object.id.clone(),
                shapes: more.to_vec(),
            }),
            None => self.go(SceneChange::Replace(object.clone())),
        }
    }
}
