//! Writing: what changed, or everything anew where that is smaller or a write has failed.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;

use taut::shape::PlacedShape;

use super::log::Log;
use super::meshes::Meshes;
use super::record::Record;
use super::{Content, Key, Kind, State};
use crate::daemon::persisted::{self, RobotRecord, SceneRecord, moves_between};
use crate::daemon::record_log;

/// What the thread owns.
pub(super) struct Writer {
    pub log: Log,
    pub meshes: Meshes,
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
    /// Takes a state, to be written next.
    pub(super) fn take(&mut self, key: Key, state: State) {
        let held = self.live.get(&key);
        if held.is_some_and(|held| held.content.is_same(&state.content)) {
            return;
        }
        self.before
            .entry(key.clone())
            .or_insert_with(|| held.cloned());
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
        let mut bytes = Vec::new();
        for (key, before) in &self.before {
            let state = &self.live[key];
            persisted::meshes(shapes(&state.content))
                .try_for_each(|mesh| self.meshes.keep(mesh))?;
            record_log::encode(&change(key, before.as_ref(), state), &mut bytes)?;
        }
        if ends {
            record_log::encode(&Record::Ended, &mut bytes)?;
        }
        self.log
            .append(&bytes)
            .map_err(|error| self.log.error(&error))
    }

    fn write_all(&mut self, ends: bool) -> Result<(), String> {
        self.live.retain(|key, state| {
            let is_there = !matches!(state.content, Content::Gone) || self.configured.contains(key);
            is_there || self.before.contains_key(key)
        });
        let mut bytes = Vec::new();
        for (key, state) in &self.live {
            persisted::meshes(shapes(&state.content))
                .try_for_each(|mesh| self.meshes.keep(mesh))?;
            record_log::encode(&whole(key, state), &mut bytes)?;
        }
        if ends {
            record_log::encode(&Record::Ended, &mut bytes)?;
        }
        self.log
            .replace(&bytes)
            .map_err(|error| self.log.error(&error))?;
        let used = self
            .live
            .values()
            .flat_map(|state| persisted::meshes(shapes(&state.content)));
        self.meshes.retain(&used.map(|mesh| mesh.hash()).collect());
        Ok(())
    }
}

fn shapes(content: &Content) -> Box<dyn Iterator<Item = &PlacedShape> + '_> {
    match content {
        Content::Robot(robot, _) => Box::new(robot.links().iter().flat_map(|link| &link.shapes)),
        Content::Scene(_, scene) => {
            Box::new(scene.objects().flat_map(|object| object.shapes.iter()))
        }
        Content::Gone => Box::new(std::iter::empty()),
    }
}

fn whole((kind, label): &Key, state: &State) -> Record {
    let label = label.clone();
    let configured = state.configured;
    match (&state.content, kind) {
        (Content::Robot(robot, weights), _) => {
            let hash = robot.hash();
            let weights = weights.to_vec();
            let robot = RobotRecord::from(&**robot);
            Record::Robot {
                label,
                hash,
                weights,
                configured,
                robot,
            }
        }
        (Content::Scene(version, scene), _) => {
            let hash = scene.hash();
            let version = *version;
            let scene = SceneRecord::from(&**scene);
            Record::Scene {
                label,
                version,
                hash,
                configured,
                scene,
            }
        }
        (Content::Gone, Kind::Robot) => Record::RobotGone { label },
        (Content::Gone, Kind::Scene) => Record::SceneGone { label },
    }
}

/// What only moved is written as that: a large scene of which one thing moves is not written again
/// and again.
fn change(key: &Key, before: Option<&State>, state: &State) -> Record {
    if let (
        Some(State {
            content: Content::Scene(_, before),
            configured,
        }),
        Content::Scene(version, scene),
    ) = (before, &state.content)
        && *configured == state.configured
        && let Some(moves) = moves_between(before, scene)
    {
        return Record::Moved {
            label: key.1.clone(),
            version: *version,
            hash: scene.hash(),
            moves,
        };
    }
    whole(key, state)
}
