//! Writing: what changed, or everything anew where that is smaller or a write has failed.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;

use taut::shape::PlacedShape;

use super::log::{self, Log};
use super::meshes::Meshes;
use super::record::{self, Record, RobotRecord, SceneRecord, moves_between};
use super::{Content, Key, Kind, State};

/// What the thread owns.
pub(super) struct Writer {
    pub log: Log,
    pub meshes: Meshes,
    /// What every label names.
    pub live: BTreeMap<Key, State>,
    /// What labels of [`Self::live`] named when they were last written, of those that changed since.
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
        self.before.entry(key.clone()).or_insert_with(|| held.cloned());
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
        let is_anew = self.log.needs_all();
        if is_anew {
            self.live.retain(|key, state| !matches!(state.content, Content::Gone) || self.configured.contains(key));
        }
        let changed = self.live.iter().filter(|(key, _)| is_anew || self.before.contains_key(*key));
        for mesh in record::meshes(changed.flat_map(|(_, state)| shapes(&state.content))) {
            self.meshes.keep(mesh)?;
        }
        let mut bytes = Vec::new();
        if is_anew {
            for (key, state) in &self.live {
                log::encode(&whole(key, state)?, &mut bytes)?;
            }
        } else {
            for (key, before) in &self.before {
                log::encode(&change(key, before.as_ref(), &self.live[key])?, &mut bytes)?;
            }
        }
        if ends {
            log::encode(&Record::Ended, &mut bytes)?;
        }
        let written = if is_anew { self.log.replace(&bytes) } else { self.log.append(&bytes) };
        written.map_err(|error| self.log.error(&error))?;
        if is_anew {
            let used = self.live.values().flat_map(|state| record::meshes(shapes(&state.content)));
            self.meshes.retain(&used.map(|mesh| mesh.hash()).collect());
        }
        Ok(())
    }
}

fn shapes(content: &Content) -> Box<dyn Iterator<Item = &PlacedShape> + '_> {
    match content {
        Content::Robot(robot, _) => Box::new(robot.links().iter().flat_map(|link| &link.shapes)),
        Content::Scene(_, scene) => Box::new(scene.objects().flat_map(|object| object.shapes.iter())),
        Content::Gone => Box::new(std::iter::empty()),
    }
}

fn whole((kind, label): &Key, state: &State) -> Result<Record, String> {
    let (label, configured) = (label.clone(), state.configured);
    Ok(match (&state.content, kind) {
        (Content::Robot(robot, weights), _) => {
            let (hash, weights, robot) = (robot.hash(), weights.to_vec(), RobotRecord::of(robot)?);
            Record::Robot { label, hash, weights, configured, robot }
        }
        (Content::Scene(version, scene), _) => {
            let (hash, version, scene) = (scene.hash(), *version, SceneRecord::of(scene)?);
            Record::Scene { label, version, hash, configured, scene }
        }
        (Content::Gone, Kind::Robot) => Record::RobotGone { label },
        (Content::Gone, Kind::Scene) => Record::SceneGone { label },
    })
}

/// What only moved is written as that: a large scene of which one thing moves is not written again and again.
fn change(key: &Key, before: Option<&State>, state: &State) -> Result<Record, String> {
    if let (Some(State { content: Content::Scene(_, before), configured }), Content::Scene(version, scene)) =
        (before, &state.content)
        && *configured == state.configured
        && let Some(moves) = moves_between(before, scene)
    {
        return Ok(Record::Moved { label: key.1.clone(), version: *version, hash: scene.hash(), moves });
    }
    whole(key, state)
}
