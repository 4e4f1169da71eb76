//! What a daemon begins with: what the last one had, and what the configuration names.
//!
//! After a daemon that was killed, every label names what it named. After one that ended in order,
//! labels that no client has changed are read again from the configuration's files. Versions of
//! scenes go on in both cases.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use taut::collision::{CollisionModel, Count};
use taut::files::{Packages, Reader};
use taut::robot::{RobotDescription, RobotModel};
use taut::scene::Scene;

use taut::store::{ModelStore, Snapshot, StoreError, Wanted};
use taut_ipc::control::Refusal;
use taut_ipc::limits::{CONTROL_REQUESTS_PER_CLIENT, MAX_CLIENTS};
use taut_ipc::wire::label_id;

use crate::daemon::config::{Config, ProblemConfig, RobotConfig, SceneConfig};
use crate::daemon::durability::journal::{Content, Kept, Key, Kind, State};
use crate::daemon::durability::prepared::Prepared;
use crate::daemon::error::DaemonError;
use crate::daemon::service::FRAMES_PER_ENTRY;
use crate::daemon::translate::{self, ReadRobot, model_refusal, store_refusal};

/// What is loaded when the daemon starts to serve.
pub(crate) struct Beginning {
    /// Robots and scenes.
    pub store: ModelStore,
    /// What every label names, and labels that name nothing any more.
    pub live: BTreeMap<Key, State>,
    /// Labels that the configuration names.
    pub configured: BTreeSet<Key>,
}

/// Restores what was kept and loads what the configuration names besides; `out` gets a line for
/// each.
///
/// # Errors
/// A file of the configuration that cannot be used.
pub(crate) fn begin(
    config: &Config,
    kept: Kept,
    prepared: Option<&Prepared>,
    out: &mut dyn Write,
) -> Result<Beginning, DaemonError> {
    if kept.torn > 0 {
        tracing::warn!(
            "the last change before the daemon died was half written, acknowledged to nobody: dropped"
        );
    }
    let mut start = Start {
        versions: versions(&kept),
        restored: BTreeSet::new(),
        was_killed: !kept.ended,
        begun: Beginning::new(),
        prepared,
        out,
    };
    for (key, state) in kept.states {
        if is_wanted(&state, kept.ended) {
            start.restore(key, state)?;
        }
    }
    start.load(config)?;
    Ok(start.begun)
}

impl Beginning {
    fn new() -> Self {
        Self {
            store: ModelStore::new(label_id),
            live: BTreeMap::new(),
            configured: BTreeSet::new(),
        }
    }
}

/// Version and hash that scenes had, by label.
fn versions(kept: &Kept) -> BTreeMap<String, (u64, u64)> {
    let states = kept.states.iter();
    states
        .filter_map(|((_, label), state)| Some((label.clone(), version(state)?)))
        .collect()
}

fn version(state: &Result<State, String>) -> Option<(u64, u64)> {
    match &state.as_ref().ok()?.content {
        Content::Scene(version, scene) => Some((*version, scene.hash())),
        Content::Robot(..) | Content::Gone => None,
    }
}

/// Whether a label is restored. What the configuration said it says again after an end in order.
fn is_wanted(state: &Result<State, String>, ended: bool) -> bool {
    match state {
        Ok(state) if ended => !state.configured && !matches!(state.content, Content::Gone),
        _ => true,
    }
}

/// Changes that were made and not written yet when a daemon was killed, at most: each has its
/// client waiting.
const MOST_LOST: u64 = (MAX_CLIENTS * CONTROL_REQUESTS_PER_CLIENT) as u64;

/// Versions that frames made since one was written, at most: of so many one is, and its sensor waits
/// for that.
const MOST_FRAMES_LOST: u64 = (MAX_CLIENTS as u64 + 1) * FRAMES_PER_ENTRY;

struct Start<'a> {
    /// Version and hash that scenes had.
    versions: BTreeMap<String, (u64, u64)>,
    /// Labels that name, or do not name any more, what was kept.
    restored: BTreeSet<Key>,
    /// Answers may name versions that were not written any more.
    was_killed: bool,
    begun: Beginning,
    prepared: Option<&'a Prepared>,
    out: &'a mut dyn Write,
}

impl Start<'_> {
    fn restore(&mut self, key: Key, state: Result<State, String>) -> Result<(), DaemonError> {
        let state = state.unwrap_or_else(|reason| lost(&key, &reason));
        match &state.content {
            Content::Robot(robot, weights) => self.restore_robot(&key.1, robot, weights)?,
            Content::Scene(version, scene) => self.restore_scene(&key.1, *version, scene)?,
            Content::Gone => {}
        }
        self.restored.insert(key.clone());
        self.begun.live.insert(key, state);
        Ok(())
    }

    fn restore_robot(
        &mut self,
        label: &str,
        robot: &Arc<RobotModel>,
        weights: &Arc<[f64]>,
    ) -> Result<(), DaemonError> {
        let start = Instant::now();
        self.insert_robot(label, robot, weights)?;
        if let Some(alone) = self.kept_solids(robot) {
            self.begun.store.take_alone(alone, false);
        }
        let line = robot_line(label, robot, start);
        say(self.out, &format!("{line}  restored"));
        Ok(())
    }

    /// The model of a robot with nothing around it, of solids that were kept, unless it shares those
    /// of another one.
    fn kept_solids(&self, robot: &Arc<RobotModel>) -> Option<Arc<CollisionModel>> {
        let alone = self.begun.store.alone(robot)?;
        match alone.is_bare() {
            true => self.prepared?.find(robot),
            false => None,
        }
    }

    fn restore_scene(
        &mut self,
        label: &str,
        version: u64,
        scene: &Arc<Scene>,
    ) -> Result<(), DaemonError> {
        self.insert_scene(label, version, scene)?;
        let skipped = self
            .begun
            .store
            .skip_versions(label, self.most_lost(scene));
        skipped.map_err(|error| stored(&error))?;
        let line = scene_line(label, version, scene);
        say(self.out, &format!("{line}  restored"));
        Ok(())
    }

    /// Versions that were named and not written, at most.
    fn most_lost(&self, scene: &Scene) -> u64 {
        let is_sensed = scene.sensed().next().is_some();
        let by_frames = if is_sensed { MOST_FRAMES_LOST } else { 0 };
        let by_death = if self.was_killed { MOST_LOST } else { 0 };
        by_frames + by_death
    }

    fn insert_robot(
        &mut self,
        label: &str,
        robot: &Arc<RobotModel>,
        weights: &Arc<[f64]>,
    ) -> Result<(), DaemonError> {
        let store = &mut self.begun.store;
        let taken = store.insert_robot(label, robot.clone(), weights.clone(), false);
        taken.map(drop).map_err(|error| stored(&error))
    }

    fn insert_scene(
        &mut self,
        label: &str,
        version: u64,
        scene: &Arc<Scene>,
    ) -> Result<(), DaemonError> {
        let store = &mut self.begun.store;
        let taken = store.restore_scene(label, scene.clone(), version);
        taken.map(drop).map_err(|error| stored(&error))
    }

    fn load(&mut self, config: &Config) -> Result<(), DaemonError> {
        let mut reader = Reader::new(Packages::with_environment(BTreeMap::new()));
        for robot in &config.robots {
            self.load_robot(&mut reader, robot)?;
        }
        for scene in &config.scenes {
            self.load_scene(&mut reader, scene)?;
        }
        for problem in &config.problems {
            self.load_problem(&mut reader, problem)?;
        }
        Ok(())
    }

    fn load_robot(&mut self, reader: &mut Reader, robot: &RobotConfig) -> Result<(), DaemonError> {
        let start = Instant::now();
        if self.is_open(Kind::Robot, &robot.label) {
            let description = reader.robot_of(&robot.files())?;
            self.add_robot(&robot.label, description, &robot.urdf, start)?;
        }
        Ok(())
    }

    fn load_scene(&mut self, reader: &mut Reader, scene: &SceneConfig) -> Result<(), DaemonError> {
        if self.is_open(Kind::Scene, &scene.label) {
            let read = reader.scene(&scene.file)?;
            self.add_scene(&scene.label, read)?;
        }
        Ok(())
    }

    fn load_problem(
        &mut self,
        reader: &mut Reader,
        problem: &ProblemConfig,
    ) -> Result<(), DaemonError> {
        // Without labels the file has to be read to know them. What is restored needs no file.
        match (&problem.robot, &problem.scene) {
            (Some(robot), Some(scene)) if self.is_restored(robot, scene) => self.warm(robot, scene),
            _ => self.read_problem(reader, problem),
        }
    }

    fn read_problem(
        &mut self,
        reader: &mut Reader,
        problem: &ProblemConfig,
    ) -> Result<(), DaemonError> {
        let start = Instant::now();
        let read = reader.problem(&problem.file, problem.geometry.into())?;
        let robot = problem
            .robot
            .as_ref()
            .unwrap_or(&read.robot.name)
            .clone();
        let scene = problem
            .scene
            .as_ref()
            .unwrap_or(&read.name)
            .clone();
        if self.is_open(Kind::Robot, &robot) {
            self.add_robot(&robot, read.robot, &read.robot_files.urdf, start)?;
        }
        if self.is_open(Kind::Scene, &scene) {
            self.add_scene(&scene, read.scene)?;
        }
        self.warm(&robot, &scene)
    }

    /// Whether the configuration says what a label names.
    fn is_open(&mut self, kind: Kind, label: &str) -> bool {
        let key = (kind, label.to_owned());
        self.begun.configured.insert(key.clone());
        !self.restored.contains(&key)
    }

    /// Whether neither label is the configuration's to say.
    fn is_restored(&mut self, robot: &str, scene: &str) -> bool {
        let keys = [
            (Kind::Robot, robot.to_owned()),
            (Kind::Scene, scene.to_owned()),
        ];
        let is_restored = keys
            .iter()
            .all(|key| self.restored.contains(key));
        if is_restored {
            self.begun.configured.extend(keys);
        }
        is_restored
    }

    fn add_robot(
        &mut self,
        label: &str,
        description: RobotDescription,
        urdf: &Path,
        start: Instant,
    ) -> Result<(), DaemonError> {
        let read = translate::prepared(description, urdf).map_err(|refusal| refused(&refusal))?;
        let ReadRobot {
            robot,
            weights,
            alone,
            is_new,
        } = read;
        let line = robot_line(label, &robot, start);
        self.insert_robot(label, &robot, &weights)?;
        self.begun.store.take_alone(alone, is_new);
        self.remember(Kind::Robot, label, Content::Robot(robot, weights));
        say(self.out, &line);
        Ok(())
    }

    fn add_scene(&mut self, label: &str, scene: Scene) -> Result<(), DaemonError> {
        let scene = Arc::new(scene);
        let version = self.version_of(label, scene.hash());
        self.insert_scene(label, version, &scene)?;
        let line = scene_line(label, version, &scene);
        self.remember(Kind::Scene, label, Content::Scene(version, scene));
        say(self.out, &line);
        Ok(())
    }

    /// The version of a scene that was read: the next one, where it is another than before.
    fn version_of(&self, label: &str, hash: u64) -> u64 {
        match self.versions.get(label) {
            Some((version, before)) if *before == hash => *version,
            Some((version, _)) => version + 1,
            None => 1,
        }
    }

    fn remember(&mut self, kind: Kind, label: &str, content: Content) {
        let state = State {
            content,
            configured: true,
        };
        self.begun
            .live
            .insert((kind, label.to_owned()), state);
    }

    /// Makes the collision model of a problem now, so that its first request need not. A client may
    /// have unloaded one of the two.
    fn warm(&mut self, robot: &str, scene: &str) -> Result<(), DaemonError> {
        let wanted = Wanted {
            robot_id: label_id(robot),
            scene_id: label_id(scene),
            ..Wanted::default()
        };
        match self.begun.store.snapshot(&wanted) {
            Ok(snapshot) => made(&snapshot),
            Err(_) => Ok(()),
        }
    }
}

fn made(snapshot: &Snapshot) -> Result<(), DaemonError> {
    match snapshot.model.get() {
        Ok(_) => Ok(()),
        Err(error) => Err(refused(&model_refusal(error, &snapshot.robot))),
    }
}

/// What is left of a label whose content cannot be restored.
fn lost((kind, label): &Key, reason: &str) -> State {
    let what = match kind {
        Kind::Robot => "robot",
        Kind::Scene => "scene",
    };
    tracing::error!(
        "{what} {label} is not restored, and not served until it is loaded again: {reason}"
    );
    State {
        content: Content::Gone,
        configured: false,
    }
}

fn refused(error: &Refusal) -> DaemonError {
    DaemonError::Model {
        code: error.code,
        message: error.message.clone(),
    }
}

fn stored(error: &StoreError) -> DaemonError {
    refused(&store_refusal(error))
}

fn robot_line(label: &str, robot: &RobotModel, start: Instant) -> String {
    let links = robot.links().iter();
    let count = Count::of(links.map(|link| &*link.shapes));
    format!(
        "robot {label}  {} dof  {} links  {} triangles  hash {:016x}  warm in {:.0} ms",
        robot.space().nv(),
        count.bodies,
        count.triangles,
        robot.hash(),
        start.elapsed().as_secs_f64() * 1e3,
    )
}

fn scene_line(label: &str, version: u64, scene: &Scene) -> String {
    let objects = scene.obstacles().len() + scene.attached().len();
    format!(
        "scene {label} v{version}  {objects} objects  hash {:016x}",
        scene.hash()
    )
}

/// Prints a line of the start. A daemon whose terminal is gone serves all the same.
pub(crate) fn say(out: &mut dyn Write, line: &str) {
    let _ = writeln!(out, "{line}").and_then(|()| out.flush());
}
