//! The newest versions of scenes that a client has seen.

use crate::live::locked;
use std::collections::HashMap;
use std::sync::Mutex;

/// Version and hash by id of a scene.
#[derive(Debug, Default)]
pub struct Seen(Mutex<HashMap<u64, (u64, u64)>>);

impl Seen {
    /// Notes a version; older ones change nothing.
    pub fn note(&self, scene: u64, version: u64, hash: u64) {
        if scene == 0 || version == 0 {
            return;
        }
        let mut seen = locked(&self.0);
        let newest = seen.entry(scene).or_default();
        if version >= newest.0 {
            *newest = (version, hash);
        }
    }

    /// A scene is gone: another of its label counts anew.
    pub fn forget(&self, scene: u64) {
        locked(&self.0).remove(&scene);
    }

    /// The newest version and its hash, 0 where there is none.
    pub fn newest(&self, scene: u64) -> (u64, u64) {
        locked(&self.0)
            .get(&scene)
            .copied()
            .unwrap_or_default()
    }
}
