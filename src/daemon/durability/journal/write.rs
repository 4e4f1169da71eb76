//! Writing: what changed, or everything anew where that is smaller or a write has failed.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;

use taut::shape::PlacedShape;

use super::apart::Large;
use super::log::Log;
use super::record::Record;
use super::{Content, Key, Kind, State};
use crate::daemon::durability::persisted::{RobotRecord, SceneRecord, moves_between};
use crate::daemon::durability::record_log;

/// What the thread owns.
pub(super) struct Writer {
    pub log: Log,
    pub large: Large,
    /// What every label names.
    pub live: BTreeMap<Key, State>,
    /// What labels of [`Self::live`] named when they were last written, of those that changed
    /// since.
    pub before: BTreeMap<Key, Option<State>>,
    pub configured: BTreeSet<Key>,
    /// Held until the end.
    pub _lock: File,
}

impl Writer {
    /// Nothing is to be written yet.
    pub(super) fn new(log: Log, large: Large, lock: File) -> Self {
        Self {
            log,
            large,
            live: BTreeMap::new(),
            before: BTreeMap::new(),
            configured: BTreeSet::new(),
            _lock: lock,
        }
    }

    /// Takes a state, to be written next.
    pub(super) fn take(&mut self, key: Key, state: State) {
        let held = self.live.get(&key);
        if held.is_some_and(|held| held.content.is_same(&state.content)) {
            return;
        }
        let before = self.before.entry(key.clone());
        before.or_insert_with(|| held.cloned());
        self.live.insert(key, state);
    }

    /// Writes what was taken, and that the daemon ends in order.
    pub(super) fn write(&mut self, ends: bool) -> Result<(), String> {
        let written = self.try_write(ends);
        match written {
            Ok(()) => self.before.clear(),
            // Some may be there and some not: next time everything is written.
            Err(_) => self.log.give_up(),
        }
        written
    }

    fn try_write(&mut self, ends: bool) -> Result<(), String> {
        if self.log.needs_all() {
            match self.write_all(ends) {
                // On a disk that has no room for both files there may be some for the change.
                Err(_) if self.log.is_open() => {}
                written => return written,
            }
        }
        self.write_changes(ends)
    }

    fn write_changes(&mut self, ends: bool) -> Result<(), String> {
        let mut bytes = Vec::new();
        for (key, before) in &self.before {
            let state = &self.live[key];
            self.large.keep(shapes(&state.content))?;
            record_log::encode(&change(key, before.as_ref(), state), &mut bytes)?;
        }
        end_if(ends, &mut bytes)?;
        self.append(&bytes)
    }

    fn append(&mut self, bytes: &[u8]) -> Result<(), String> {
        let written = self.log.append(bytes);
        written.map_err(|error| self.log.error(&error))
    }

    fn write_all(&mut self, ends: bool) -> Result<(), String> {
        self.forget_gone();
        let mut bytes = Vec::new();
        for (key, state) in &self.live {
            self.large.keep(shapes(&state.content))?;
            record_log::encode(&whole(key, state), &mut bytes)?;
        }
        end_if(ends, &mut bytes)?;
        self.replace(&bytes)?;
        self.remove_unused();
        Ok(())
    }

    fn replace(&mut self, bytes: &[u8]) -> Result<(), String> {
        let written = self.log.replace(bytes);
        written.map_err(|error| self.log.error(&error))
    }

    /// That a label is gone is worth a record only where the configuration names it, or where its
    /// client waits for that.
    fn forget_gone(&mut self) {
        self.live.retain(|key, state| {
            let is_there = !matches!(state.content, Content::Gone) || self.configured.contains(key);
            is_there || self.before.contains_key(key)
        });
    }

    fn remove_unused(&mut self) {
        let contents = self.live.values().map(|state| &state.content);
        self.large
            .retain(&contents.flat_map(shapes).collect::<Vec<_>>());
    }
}

/// Writes that the daemon ends in order, if it does.
fn end_if(ends: bool, bytes: &mut Vec<u8>) -> Result<(), String> {
    match ends {
        true => record_log::encode(&Record::Ended, bytes),
        false => Ok(()),
    }
}

fn shapes(content: &Content) -> Box<dyn Iterator<Item = &PlacedShape> + '_> {
    match content {
        Content::Robot(robot, _) => Box::new(
            robot
                .links()
                .iter()
                .flat_map(|link| &link.shapes),
        ),
        Content::Scene(_, scene) => Box::new(
            scene
                .objects()
                .flat_map(|object| object.shapes.iter()),
        ),
        Content::Gone => Box::new(std::iter::empty()),
    }
}

fn whole((kind, label): &Key, state: &State) -> Record {
    let label = label.clone();
    let configured = state.configured;
    match (&state.content, kind) {
        (Content::Robot(robot, weights), _) => Record::Robot {
            label,
            hash: robot.hash(),
            weights: weights.to_vec(),
            configured,
            robot: RobotRecord::from(&**robot),
        },
        (Content::Scene(version, scene), _) => Record::Scene {
            label,
            version: *version,
            hash: scene.hash(),
            configured,
            scene: SceneRecord::from(&**scene),
        },
        (Content::Gone, Kind::Robot) => Record::RobotGone { label },
        (Content::Gone, Kind::Scene) => Record::SceneGone { label },
    }
}

/// What only moved is written as that: a large scene of which one thing moves is not written again
/// and again.
fn change(key: &Key, before: Option<&State>, state: &State) -> Record {
    let moved = before.and_then(|before| moved(&key.1, before, state));
    moved.unwrap_or_else(|| whole(key, state))
}

/// The record of a scene of which only something moved.
fn moved(label: &str, before: &State, state: &State) -> Option<Record> {
    let (Content::Scene(_, base), Content::Scene(version, scene)) =
        (&before.content, &state.content)
    else {
        return None;
    };
    if before.configured != state.configured {
        return None;
    }
    Some(Record::Moved {
        label: label.to_owned(),
        version: *version,
        hash: scene.hash(),
        moves: moves_between(base, scene)?,
    })
}
