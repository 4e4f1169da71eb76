//! What stays loaded: robots and scenes by label, and the collision models made of them.
//!
//! A label is a name of exactly one content. Requests get a [`Snapshot`], which nothing that is
//! loaded or unloaded later changes.

mod error;
mod models;
mod objects;
mod prepared;
#[cfg(test)]
mod tests;
mod versions;

use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;

pub use error::StoreError;
pub use objects::PreparedScene;
pub use prepared::{Made, Missing, PreparedModel, Step};
use versions::Retired;
pub use versions::{LAST_VERSIONS, MOST_PINNED, SceneEntry};

use crate::robot::RobotModel;
use crate::scene::Scene;

/// Robots, scenes and their collision models.
#[derive(Debug)]
pub struct ModelStore {
    id_of: fn(&str) -> u64,
    robots: BTreeMap<String, RobotEntry>,
    scenes: BTreeMap<String, SceneEntry>,
    retired: Retired,
    labels: HashMap<u64, String>,
    /// By the hashes of robot and scene. Each loaded robot has one with nothing around it, whose
    /// solids all others take over.
    models: HashMap<(u64, u64), Arc<PreparedModel>>,
    /// By hash.
    prepared_scenes: HashMap<u64, Arc<PreparedScene>>,
    /// Hash of the scene without objects.
    nothing: u64,
    made: Arc<Made>,
}

/// A loaded robot.
#[derive(Clone, Debug)]
pub struct RobotEntry {
    /// Id of its label.
    pub id: u64,
    /// The robot.
    pub robot: Arc<RobotModel>,
    /// Its default weights, one per velocity coordinate.
    pub weights: Arc<[f64]>,
}

/// What a request wants to be computed with; a hash or version of 0 takes what the label names now.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wanted {
    /// Id of the robot's label.
    pub robot_id: u64,
    /// Content of the robot.
    pub robot_hash: u64,
    /// Id of the scene's label.
    pub scene_id: u64,
    /// Content of the scene.
    pub scene_hash: u64,
    /// Version of the scene, of those that are kept.
    pub scene_version: u64,
}

/// What one request is computed with; it stays as it is whatever is loaded later.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// The robot.
    pub robot: Arc<RobotModel>,
    /// Its default weights.
    pub weights: Arc<[f64]>,
    /// The scene.
    pub scene: Arc<Scene>,
    /// Robot and scene together; made of contents as these, which may have come with other
    /// warnings.
    pub model: Arc<PreparedModel>,
    /// Id of the scene's label.
    pub scene_id: u64,
    /// Content of the scene.
    pub scene_hash: u64,
    /// Version of the scene.
    pub scene_version: u64,
}

/// What loading did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// The label is new.
    Created,
    /// The label names other content now.
    Replaced,
    /// The label named this content already.
    Unchanged,
}

/// How a scene takes the place of what its label names.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Whether the label may be taken away from other content.
    pub replace: bool,
    /// The version that it is to have, where versions are counted elsewhere: above the newest, or
    /// that one with equal content. `None` = the next.
    pub version: Option<u64>,
}

impl From<bool> for Place {
    fn from(replace: bool) -> Self {
        Self {
            replace,
            version: None,
        }
    }
}

impl ModelStore {
    /// An empty store whose labels have these ids.
    pub fn new(id_of: fn(&str) -> u64) -> Self {
        let robots = BTreeMap::new();
        let scenes = BTreeMap::new();
        let retired = Retired::default();
        let labels = HashMap::new();
        let models = HashMap::new();
        let prepared_scenes = HashMap::new();
        let nothing = Scene::default().hash();
        let made = Arc::default();
        Self {
            id_of,
            robots,
            scenes,
            retired,
            labels,
            models,
            prepared_scenes,
            nothing,
            made,
        }
    }

    /// Takes a robot under a label.
    ///
    /// # Errors
    /// [`StoreError::LabelTaken`] if the label names other content and `replace` is not set;
    /// [`StoreError::SameId`] if another label has the same id.
    pub fn insert_robot(
        &mut self,
        label: &str,
        robot: Arc<RobotModel>,
        weights: Arc<[f64]>,
        replace: bool,
    ) -> Result<Change, StoreError> {
        let id = self.take_id(label)?;
        let held = self.robots.get(label).map(|entry| &entry.robot);
        let change = match held {
            None => Change::Created,
            Some(held) if held.is_same(&robot) => return Ok(Change::Unchanged),
            Some(_) if replace => Change::Replaced,
            Some(held) if held.hash() == robot.hash() => {
                return Err(StoreError::OtherMotors(label.to_owned()));
            }
            Some(held) => {
                return Err(StoreError::taken("robot", label, held.hash(), robot.hash()));
            }
        };
        let key = (robot.hash(), self.nothing);
        if !self.models.contains_key(&key) {
            let alone = Arc::new(self.new_alone(&robot));
            self.models.insert(key, alone);
        }
        self.robots
            .insert(label.to_owned(), RobotEntry { id, robot, weights });
        self.drop_unused();
        Ok(change)
    }

    /// Takes a scene under a label; replacing other content makes the next version. The
    /// versions before it stay for a while: the last [`LAST_VERSIONS`], and those that are pinned.
    ///
    /// # Errors
    /// As [`Self::insert_robot`]; [`StoreError::VersionTaken`] for a version that is not above those
    /// that the label had.
    pub fn insert_scene(
        &mut self,
        label: &str,
        scene: Arc<Scene>,
        place: impl Into<Place>,
    ) -> Result<Change, StoreError> {
        let before = self
            .scenes
            .get(label)
            .and_then(|entry| self.prepared_scene(&entry.scene));
        let prepared = match before {
            Some(before) => PreparedScene::after(before, scene),
            None => PreparedScene::new(scene),
        };
        self.insert_prepared_scene(label, prepared.into(), place)
    }

    /// The same of a scene of which solids may be made already.
    ///
    /// # Errors
    /// As [`Self::insert_scene`].
    pub fn insert_prepared_scene(
        &mut self,
        label: &str,
        prepared: Arc<PreparedScene>,
        place: impl Into<Place>,
    ) -> Result<Change, StoreError> {
        let Place { replace, version } = place.into();
        let id = self.take_id(label)?;
        let prepared = self.ready_one(prepared);
        let scene = prepared.scene().clone();
        let change = match self.scenes.get_mut(label) {
            None => {
                let version = self
                    .retired
                    .first_version(id, version)
                    .map_err(|held| StoreError::version_taken(label, version, held))?;
                self.scenes
                    .insert(label.to_owned(), SceneEntry::new(id, version, scene));
                Change::Created
            }
            Some(entry) if entry.is(&scene, version) => return Ok(Change::Unchanged),
            Some(entry) if replace || entry.scene.hash() == scene.hash() => {
                let before = entry.scene.hash();
                entry.push(label, scene.clone(), version)?;
                self.follow(before, &prepared);
                Change::Replaced
            }
            Some(entry) => {
                return Err(StoreError::taken(
                    "scene",
                    label,
                    entry.scene.hash(),
                    scene.hash(),
                ));
            }
        };
        self.prepared_scenes
            .insert(prepared.scene().hash(), prepared);
        self.drop_unused();
        Ok(change)
    }

    /// Takes a scene that an earlier store had under a label, at the version that it had there.
    ///
    /// # Errors
    /// [`StoreError::LabelTaken`] if the label names other content; [`StoreError::SameId`] if
    /// another label has the same id.
    pub fn restore_scene(
        &mut self,
        label: &str,
        scene: Arc<Scene>,
        version: u64,
    ) -> Result<(), StoreError> {
        let id = self.take_id(label)?;
        if let Some(entry) = self
            .scenes
            .get(label)
            .filter(|entry| entry.scene.hash() != scene.hash())
        {
            return Err(StoreError::taken(
                "scene",
                label,
                entry.scene.hash(),
                scene.hash(),
            ));
        }
        let new = || Arc::new(PreparedScene::new(scene.clone()));
        self.prepared_scenes
            .entry(scene.hash())
            .or_insert_with(new);
        self.scenes
            .insert(label.to_owned(), SceneEntry::new(id, version.max(1), scene));
        Ok(())
    }

    /// Leaves out the next versions of a scene: its label may have named other contents by them.
    ///
    /// # Errors
    /// [`StoreError::UnknownScene`].
    pub fn skip_versions(&mut self, label: &str, versions: u64) -> Result<(), StoreError> {
        self.entry_mut(label)?.skip(versions);
        Ok(())
    }

    /// The newest version of a scene, for a change to it; that has to be `base_version` unless this
    /// is 0.
    ///
    /// # Errors
    /// [`StoreError::UnknownScene`]; [`StoreError::VersionConflict`] if the newest is another
    /// version.
    pub fn base_scene(&self, label: &str, base_version: u64) -> Result<&Arc<Scene>, StoreError> {
        let entry = self.scene(label)?;
        if base_version != 0 && base_version != entry.version {
            let label = label.to_owned();
            let held = entry.version;
            return Err(StoreError::VersionConflict {
                label,
                wanted: base_version,
                held,
            });
        }
        Ok(&entry.scene)
    }

    /// Keeps a version of a scene, 0 being the newest, until it is unpinned. As long as there is
    /// one, the scene cannot be unloaded.
    ///
    /// # Errors
    /// [`StoreError::UnknownScene`]; [`StoreError::UnknownVersion`] if the version is not kept any
    /// more; [`StoreError::TooManyPinned`].
    pub fn pin_scene(&mut self, label: &str, version: u64) -> Result<&SceneEntry, StoreError> {
        self.entry_mut(label)?.pin(label, version)?;
        self.scene(label)
    }

    /// Lets a pinned version go; one that is older than the last [`LAST_VERSIONS`] is gone at once.
    ///
    /// # Errors
    /// [`StoreError::UnknownScene`]; [`StoreError::NotPinned`].
    pub fn unpin_scene(&mut self, label: &str, version: u64) -> Result<&SceneEntry, StoreError> {
        self.entry_mut(label)?.unpin(label, version)?;
        self.drop_unused();
        self.scene(label)
    }

    /// Forgets a robot; snapshots keep theirs.
    ///
    /// # Errors
    /// [`StoreError::UnknownRobot`].
    pub fn remove_robot(&mut self, label: &str) -> Result<RobotEntry, StoreError> {
        let removed = self
            .robots
            .remove(label)
            .ok_or_else(|| self.unknown_robot(format!("{label:?}")))?;
        self.drop_unused();
        Ok(removed)
    }

    /// Forgets a scene with all its versions; snapshots keep theirs. Its label goes on counting if
    /// it is loaded again.
    ///
    /// # Errors
    /// [`StoreError::UnknownScene`]; [`StoreError::Pinned`] while a version is pinned.
    pub fn remove_scene(&mut self, label: &str) -> Result<SceneEntry, StoreError> {
        self.scene(label)?.check_unpinned(label)?;
        let removed = self
            .scenes
            .remove(label)
            .ok_or_else(|| self.unknown_scene(format!("{label:?}")))?;
        self.retired.retire(removed.id, removed.version);
        self.drop_unused();
        Ok(removed)
    }

    /// Robots by label.
    pub fn robots(&self) -> &BTreeMap<String, RobotEntry> {
        &self.robots
    }

    /// Scenes by label.
    pub fn scenes(&self) -> &BTreeMap<String, SceneEntry> {
        &self.scenes
    }

    /// A robot by label.
    ///
    /// # Errors
    /// [`StoreError::UnknownRobot`].
    pub fn robot(&self, label: &str) -> Result<&RobotEntry, StoreError> {
        self.robots
            .get(label)
            .ok_or_else(|| self.unknown_robot(format!("{label:?}")))
    }

    /// A scene by label.
    ///
    /// # Errors
    /// [`StoreError::UnknownScene`].
    pub fn scene(&self, label: &str) -> Result<&SceneEntry, StoreError> {
        self.scenes
            .get(label)
            .ok_or_else(|| self.unknown_scene(format!("{label:?}")))
    }

    /// A version of a scene that is kept; 0 is the newest.
    ///
    /// # Errors
    /// [`StoreError::UnknownScene`]; [`StoreError::UnknownVersion`].
    pub fn scene_at(&self, label: &str, version: u64) -> Result<&Arc<Scene>, StoreError> {
        let entry = self.scene(label)?;
        entry
            .at(version)
            .ok_or_else(|| entry.unknown(label, version))
    }

    /// The label with this id.
    pub fn label(&self, id: u64) -> Option<&str> {
        self.labels.get(&id).map(String::as_str)
    }

    /// Newest version of the scene whose label has this id.
    pub fn scene_version(&self, id: u64) -> Option<u64> {
        Some(self.scene_of(id)?.version)
    }

    /// The scene whose label has this id.
    pub fn scene_of(&self, id: u64) -> Option<&SceneEntry> {
        self.scenes.get(self.labels.get(&id)?)
    }

    /// What a request is computed with. Cheap: the collision model is made by whoever asks it
    /// first.
    ///
    /// # Errors
    /// [`StoreError::UnknownRobot`], [`StoreError::UnknownScene`], [`StoreError::HashConflict`]
    /// where a label names other content than is wanted, [`StoreError::UnknownVersion`] where that
    /// version is not kept.
    pub fn snapshot(&mut self, wanted: &Wanted) -> Result<Snapshot, StoreError> {
        let label = self.labels.get(&wanted.robot_id);
        let Some((robot_label, robot)) = label.and_then(|label| self.robots.get_key_value(label))
        else {
            return Err(self.unknown_robot(format!("of id {:016x}", wanted.robot_id)));
        };
        let label = self.labels.get(&wanted.scene_id);
        let Some((scene_label, entry)) = label.and_then(|label| self.scenes.get_key_value(label))
        else {
            return Err(self.unknown_scene(format!("of id {:016x}", wanted.scene_id)));
        };
        check_hash("robot", robot_label, wanted.robot_hash, robot.robot.hash())?;
        let scene_version = if wanted.scene_version == 0 {
            entry.version
        } else {
            wanted.scene_version
        };
        let scene = entry
            .at(scene_version)
            .ok_or_else(|| entry.unknown(scene_label, scene_version))?;
        check_hash("scene", scene_label, wanted.scene_hash, scene.hash())?;
        let key = (robot.robot.hash(), scene.hash());
        let model = match self.models.get(&key) {
            Some(model) => model.clone(),
            None => self.put_together(&robot.robot, scene, &entry.scene),
        };
        let scene_hash = key.1;
        let weights = robot.weights.clone();
        let scene_id = wanted.scene_id;
        let robot = robot.robot.clone();
        let scene = scene.clone();
        self.models
            .entry(key)
            .or_insert_with(|| model.clone());
        Ok(Snapshot {
            robot,
            weights,
            scene,
            model,
            scene_id,
            scene_hash,
            scene_version,
        })
    }

    fn entry_mut(&mut self, label: &str) -> Result<&mut SceneEntry, StoreError> {
        if !self.scenes.contains_key(label) {
            return Err(self.unknown_scene(format!("{label:?}")));
        }
        Ok(self.scenes.get_mut(label).expect("it is there"))
    }

    fn take_id(&mut self, label: &str) -> Result<u64, StoreError> {
        let id = (self.id_of)(label);
        match self.labels.get(&id) {
            Some(other) if other != label => Err(StoreError::SameId {
                label: label.to_owned(),
                other: other.clone(),
            }),
            Some(_) => Ok(id),
            None => {
                self.labels.insert(id, label.to_owned());
                Ok(id)
            }
        }
    }

    /// Forgets collision models and ids of what is no longer loaded. An old version that a request
    /// names gets its model anew; one that is pinned keeps it.
    fn drop_unused(&mut self) {
        let robots: Vec<u64> = self
            .robots
            .values()
            .map(|entry| entry.robot.hash())
            .collect();
        let mut scenes: HashSet<u64> = self
            .scenes
            .values()
            .flat_map(SceneEntry::warm)
            .collect();
        self.prepared_scenes
            .retain(|scene, _| scenes.contains(scene));
        scenes.insert(self.nothing);
        self.models
            .retain(|(robot, scene), _| robots.contains(robot) && scenes.contains(scene));
        let robots = &self.robots;
        let scenes = &self.scenes;
        self.labels
            .retain(|_, label| robots.contains_key(label) || scenes.contains_key(label));
    }

    fn unknown_robot(&self, asked: String) -> StoreError {
        StoreError::UnknownRobot {
            asked,
            known: error::list(self.robots.keys()),
        }
    }

    fn unknown_scene(&self, asked: String) -> StoreError {
        StoreError::UnknownScene {
            asked,
            known: error::list(self.scenes.keys()),
        }
    }
}

fn check_hash(kind: &'static str, label: &str, wanted: u64, held: u64) -> Result<(), StoreError> {
    if wanted != 0 && wanted != held {
        return Err(StoreError::HashConflict {
            kind,
            label: label.to_owned(),
            wanted,
            held,
        });
    }
    Ok(())
}
