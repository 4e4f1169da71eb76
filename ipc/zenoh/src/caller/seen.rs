//! The newest versions of scenes that a client has seen.

use crate::live::locked;
use std::collections::HashMap;
use std::sync::Mutex;

/// Scenes that are remembered at most; those that nobody has spoken of longest go first.
const MOST_SCENES: usize = 4096;

/// Version and hash by id of a scene.
#[derive(Debug, Default)]
pub struct Seen(Mutex<Scenes>);

#[derive(Debug, Default)]
struct Scenes {
    newest: HashMap<u64, Newest>,
    /// Counts what is noted.
    clock: u64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Newest {
    version: u64,
    hash: u64,
    noted: u64,
}

impl Seen {
    /// Notes a version; older ones change nothing.
    pub fn note(&self, scene: u64, version: u64, hash: u64) {
        if scene == 0 || version == 0 {
            return;
        }
        let mut scenes = locked(&self.0);
        scenes.make_room(scene);
        scenes.clock += 1;
        let noted = scenes.clock;
        let newest = scenes.newest.entry(scene).or_default();
        newest.noted = noted;
        if version >= newest.version {
            newest.version = version;
            newest.hash = hash;
        }
    }

    /// A scene is gone: another of its label counts anew.
    pub fn forget(&self, scene: u64) {
        locked(&self.0).newest.remove(&scene);
    }

    /// The newest version and its hash, 0 where there is none.
    pub fn newest(&self, scene: u64) -> (u64, u64) {
        let scenes = locked(&self.0);
        let newest = scenes.newest.get(&scene);
        newest.map_or((0, 0), |newest| (newest.version, newest.hash))
    }
}

impl Scenes {
    fn make_room(&mut self, scene: u64) {
        if self.newest.len() < MOST_SCENES || self.newest.contains_key(&scene) {
            return;
        }
        let oldest = self
            .newest
            .iter()
            .min_by_key(|(_, newest)| newest.noted)
            .map(|(scene, _)| *scene);
        oldest.map(|scene| self.newest.remove(&scene));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_go_up_until_a_scene_is_forgotten() {
        let seen = Seen::default();
        for (version, hash) in [(3, 30), (2, 20)] {
            seen.note(7, version, hash);
        }
        assert_eq!(seen.newest(7), (3, 30));
        seen.forget(7);
        assert_eq!(seen.newest(7), (0, 0));
    }

    #[test]
    fn so_many_scenes_are_remembered_and_those_in_use_stay() {
        let seen = Seen::default();
        for scene in 1..3 * MOST_SCENES as u64 {
            seen.note(scene, 1, scene);
            seen.note(1, 1, 1);
        }
        assert_eq!(locked(&seen.0).newest.len(), MOST_SCENES);
        assert_eq!((seen.newest(1), seen.newest(2)), ((1, 1), (0, 0)));
    }
}
