//! Changes of the store: told to their client, and to everybody who listens, once they are kept.
//!
//! A change is served from the moment it is made, and acknowledged when the journal has it. Where
//! the journal cannot be written (a full disk), the change stays, for listeners already hear of it,
//! and its client is told RESOURCE_EXHAUSTED: made, but not kept. The next change that is kept
//! keeps all of those before it too.

use std::sync::Arc;

use taut::scene::Scene;

use super::Service;
use super::event::KeptUpTo;
use super::keeping::{Acknowledgement, Changed};
use crate::daemon::durability::journal::{Content, Key, Kind};

impl Service {
    /// Keeps a change that was made to the store, then tells of it.
    pub(super) fn keep(&mut self, changed: &Changed, told: Acknowledgement) {
        let (key, content) = self.named(changed);
        self.keeping.keep(key, content, told);
    }

    /// What the label of a change names now.
    fn named(&self, changed: &Changed) -> (Key, Content) {
        match changed {
            Changed::Robot(label) => ((Kind::Robot, label.clone()), self.robot_named(label)),
            Changed::Scene(label) => ((Kind::Scene, label.clone()), self.scene_named(label)),
        }
    }

    fn robot_named(&self, label: &str) -> Content {
        match self.store.robots().get(label) {
            Some(entry) => Content::Robot(entry.robot.clone(), entry.weights.clone()),
            None => Content::Gone,
        }
    }

    fn scene_named(&self, label: &str) -> Content {
        match self.store.scenes().get(label) {
            Some(entry) => Content::Scene(entry.version, kept(&entry.scene)),
            None => Content::Gone,
        }
    }

    /// Tells of the changes that the journal has dealt with.
    pub(super) fn kept(&mut self, kept: &KeptUpTo) {
        self.keeping.kept(kept);
    }
}

/// What the disk keeps of a scene: all but what its sensors see.
pub(crate) fn kept(scene: &Arc<Scene>) -> Arc<Scene> {
    let has_seen = scene.has_seen();
    if has_seen {
        Arc::new(scene.unseen())
    } else {
        scene.clone()
    }
}
