//! Scenes whose home is elsewhere.

use crate::live::locked;
use std::collections::HashMap;
use std::sync::Mutex;
use taut_ipc::control::SceneSummary;

/// A scene that is a copy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Copy {
    pub(super) label: String,
    pub(super) home: String,
    pub(super) version: u64,
    hash: u64,
}

/// The copies of a gateway, by id of the scene.
#[derive(Debug, Default)]
pub(super) struct Copies(Mutex<HashMap<u64, Copy>>);

impl Copies {
    pub(super) fn of(&self, scene: u64) -> Option<Copy> {
        locked(&self.0).get(&scene).cloned()
    }

    pub(super) fn labelled(&self, label: &str) -> Option<Copy> {
        let copies = locked(&self.0);
        let mut copies = copies.values();
        copies.find(|copy| copy.label == label).cloned()
    }

    pub(super) fn is_as(&self, scene: u64, version: u64, hash: u64) -> bool {
        self.of(scene)
            .is_some_and(|copy| (copy.version, copy.hash) == (version, hash))
    }

    pub(super) fn note(&self, home: &str, scene: &SceneSummary) {
        let copy = Copy {
            label: scene.label.clone(),
            home: home.to_owned(),
            version: scene.version,
            hash: scene.scene_hash,
        };
        locked(&self.0).insert(scene.scene_id, copy);
    }

    /// Those of a home that it does not have any more; they are copies no longer.
    pub(super) fn take_gone(&self, home: &str, there: &[SceneSummary]) -> Vec<Copy> {
        let is_gone = |id: &u64, copy: &mut Copy| {
            copy.home == home && there.iter().all(|scene| scene.scene_id != *id)
        };
        let mut copies = locked(&self.0);
        let gone = copies.extract_if(is_gone);
        gone.map(|(_, copy)| copy).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(label: &str, id: u64, version: u64) -> SceneSummary {
        SceneSummary {
            label: label.to_owned(),
            scene_id: id,
            version,
            scene_hash: version * 7,
            ..SceneSummary::default()
        }
    }

    #[test]
    fn copies_are_known_by_id_and_label_until_their_home_drops_them() {
        let copies = Copies::default();
        copies.note("a", &scene("shelf", 1, 3));
        copies.note("b", &scene("bin", 2, 1));
        assert!(copies.is_as(1, 3, 21) && !copies.is_as(1, 4, 28));
        assert_eq!(copies.labelled("shelf").unwrap().home, "a");
        assert!(
            copies
                .take_gone("a", &[scene("shelf", 1, 9)])
                .is_empty()
        );
        assert_eq!(copies.take_gone("a", &[]).len(), 1);
        assert!(copies.of(1).is_none() && copies.of(2).is_some());
    }
}
