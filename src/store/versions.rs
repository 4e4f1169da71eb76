//! The versions of one scene: the newest, the last ones before it, and those that somebody has
//! pinned.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;

use super::StoreError;
use crate::scene::{Obstacle, Scene};

/// Versions that are kept before the newest, pinned or not.
pub const LAST_VERSIONS: usize = 64;
/// Bytes of points that the versions before the newest keep, pinned or not: of sensed scenes these
/// are what limits them.
pub const OLD_FRAMES_BYTES: usize = 32 << 20;
/// Versions of one scene that may be pinned at once.
pub const MOST_PINNED: usize = 64;
/// Labels whose last version is remembered after they are unloaded.
const MOST_RETIRED: usize = 1024;

/// A loaded scene.
#[derive(Clone, Debug)]
pub struct SceneEntry {
    /// Id of its label.
    pub id: u64,
    /// Counts the contents that its label had, from 1.
    pub version: u64,
    /// The scene.
    pub scene: Arc<Scene>,
    /// Version of the next content.
    next: u64,
    older: BTreeMap<u64, Arc<Scene>>,
    pinned: BTreeSet<u64>,
}

impl SceneEntry {
    pub(super) fn new(id: u64, version: u64, scene: Arc<Scene>) -> Self {
        Self {
            id,
            version,
            scene,
            next: version.saturating_add(1),
            older: BTreeMap::new(),
            pinned: BTreeSet::new(),
        }
    }

    /// The scene at a version that is kept; 0 is the newest.
    pub fn at(&self, version: u64) -> Option<&Arc<Scene>> {
        if version == 0 || version == self.version {
            Some(&self.scene)
        } else {
            self.older.get(&version)
        }
    }

    /// Versions that are pinned.
    pub fn pinned(&self) -> &BTreeSet<u64> {
        &self.pinned
    }

    /// Oldest version from which on all are kept.
    pub fn kept_from(&self) -> u64 {
        let mut first = self.version;
        while self.older.contains_key(&(first - 1)) {
            first -= 1;
        }
        first
    }

    /// Hashes of what requests are likely to ask for again: the newest and the pinned versions.
    pub(super) fn warm(&self) -> impl Iterator<Item = u64> {
        let pinned = self
            .pinned
            .iter()
            .filter_map(|version| self.at(*version));
        pinned
            .chain([&self.scene])
            .map(|scene| scene.hash())
    }

    /// Whether this is its newest content, at that version if one is named.
    pub(super) fn is(&self, scene: &Scene, version: Option<u64>) -> bool {
        self.scene.hash() == scene.hash() && version.is_none_or(|version| version == self.version)
    }

    /// Takes the next version, or a later one that is named.
    pub(super) fn push(
        &mut self,
        label: &str,
        scene: Arc<Scene>,
        version: Option<u64>,
    ) -> Result<(), StoreError> {
        let next = match version {
            None => self.next,
            Some(later) if later > self.version => later,
            Some(_) => return Err(StoreError::version_taken(label, version, self.version)),
        };
        let before = std::mem::replace(&mut self.scene, scene);
        self.older.insert(self.version, before);
        self.version = next;
        self.next = self.next.max(next.saturating_add(1));
        self.drop_old();
        Ok(())
    }

    /// Leaves numbers out that were given to others.
    pub(super) fn skip(&mut self, versions: u64) {
        self.next = self.next.saturating_add(versions);
    }

    pub(super) fn pin(&mut self, label: &str, version: u64) -> Result<(), StoreError> {
        let version = if version == 0 { self.version } else { version };
        if self.at(version).is_none() {
            return Err(self.unknown(label, version));
        }
        if self.pinned.len() >= MOST_PINNED && !self.pinned.contains(&version) {
            return Err(StoreError::TooManyPinned {
                label: label.to_owned(),
                pinned: ranges(&self.pinned),
            });
        }
        self.pinned.insert(version);
        Ok(())
    }

    pub(super) fn unpin(&mut self, label: &str, version: u64) -> Result<(), StoreError> {
        let version = if version == 0 { self.version } else { version };
        if !self.pinned.remove(&version) {
            return Err(StoreError::NotPinned {
                label: label.to_owned(),
                version,
                pinned: ranges(&self.pinned),
            });
        }
        self.drop_old();
        Ok(())
    }

    /// What a request for a version that is not kept is told.
    pub(super) fn unknown(&self, label: &str, wanted: u64) -> StoreError {
        let kept = self
            .older
            .keys()
            .copied()
            .chain([self.version])
            .collect();
        StoreError::UnknownVersion {
            label: label.to_owned(),
            wanted,
            kept: ranges(&kept),
        }
    }

    /// The refusal of what would lose pinned versions.
    pub(super) fn check_unpinned(&self, label: &str) -> Result<(), StoreError> {
        match self.pinned.is_empty() {
            true => Ok(()),
            false => Err(StoreError::Pinned {
                label: label.to_owned(),
                pinned: ranges(&self.pinned),
            }),
        }
    }

    /// The first version from which on the frames of sensors have room.
    fn first_by_bytes(&self) -> u64 {
        let mut newer = &self.scene;
        let mut bytes = 0;
        for (version, older) in self.older.iter().rev() {
            bytes += frame_bytes(older, newer);
            if bytes > OLD_FRAMES_BYTES {
                return version + 1;
            }
            newer = older;
        }
        0
    }

    fn drop_old(&mut self) {
        let first = self
            .version
            .saturating_sub(LAST_VERSIONS as u64)
            .max(self.first_by_bytes());
        let old: Vec<u64> = self
            .older
            .range(..first)
            .map(|(version, _)| *version)
            .collect();
        for version in old
            .iter()
            .filter(|version| !self.pinned.contains(version))
        {
            self.older.remove(version);
        }
    }
}

/// Bytes of what sensors saw in a scene and not in the next.
fn frame_bytes(scene: &Scene, newer: &Scene) -> usize {
    let is_same = |object: &Obstacle| {
        let other = newer.object(&object.id);
        other.is_some_and(|other| Arc::ptr_eq(&other.shapes, &object.shapes))
    };
    let objects = scene.sensed().map(|(object, _)| object);
    let others = objects.filter(|object| !is_same(object));
    let clouds = others.flat_map(|object| {
        object
            .shapes
            .iter()
            .filter_map(|placed| placed.shape.cloud())
    });
    clouds.map(|cloud| cloud.bytes()).sum()
}

/// Numbers for a message, runs of them as their ends: `3, 12 to 76`.
fn ranges(numbers: &BTreeSet<u64>) -> String {
    let mut runs: Vec<(u64, u64)> = Vec::new();
    for &number in numbers {
        match runs.last_mut() {
            Some((_, last)) if *last + 1 == number => *last = number,
            _ => runs.push((number, number)),
        }
    }
    let text = runs
        .iter()
        .map(|(first, last)| match last - first {
            0 => first.to_string(),
            1 => format!("{first}, {last}"),
            _ => format!("{first} to {last}"),
        });
    if runs.is_empty() {
        "none".to_owned()
    } else {
        text.collect::<Vec<_>>().join(", ")
    }
}

/// The last versions of labels that are unloaded, so that a label never names two contents by one
/// version.
#[derive(Debug, Default)]
pub(super) struct Retired {
    last: HashMap<u64, u64>,
    // Of the labels that were forgotten to bound the memory: none of them had a higher version.
    floor: u64,
}

impl Retired {
    /// The first version of a label that is loaded now, which may be named; where it had that one
    /// or may have had it, the last that it had.
    pub(super) fn first_version(&mut self, id: u64, named: Option<u64>) -> Result<u64, u64> {
        let last = self.last.get(&id).copied().unwrap_or(0);
        let last = last.max(self.floor);
        let first = named.unwrap_or(last.saturating_add(1));
        if first <= last {
            return Err(last);
        }
        self.last.remove(&id);
        Ok(first)
    }

    /// Remembers a label that is unloaded.
    pub(super) fn retire(&mut self, id: u64, version: u64) {
        if self.last.len() >= MOST_RETIRED {
            self.floor = self
                .last
                .drain()
                .map(|(_, version)| version)
                .fold(self.floor, u64::max);
        }
        self.last.insert(id, version);
    }
}
