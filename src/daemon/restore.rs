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

use taut::files::{Packages, Reader};
use taut::robot::{RobotDescription, RobotModel};
use taut::scene::Scene;
use taut::shape::Shape;
use taut::store::{ModelStore, StoreError, Wanted};
use taut_ipc::control::Refusal;
use taut_ipc::limits::{CONTROL_REQUESTS_PER_CLIENT, MAX_CLIENTS};
use taut_ipc::wire::label_id;

use super::config::Config;
use super::error::DaemonError;
use super::journal::{Content, Kept, Key, Kind, State};
use super::prepared::Prepared;
use super::translate::{self, ReadRobot, model_refusal, store_refusal};

/// What is loaded when the daemon starts to serve.
pub(super) struct Beginning {
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
pub(super) fn begin(
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
    let store = ModelStore::new(label_id);
    let live = BTreeMap::new();
    let configured = BTreeSet::new();
    let versions =
        kept.states
            .iter()
            .filter_map(|((_, label), state)| match &state.as_ref().ok()?.content {
                Content::Scene(version, scene) => Some((label.clone(), (*version, scene.hash()))),
                _ => None,
            });
    let begun = Beginning {
        store,
        live,
        configured,
    };
    let versions = versions.collect();
    let restored = BTreeSet::new();
    let was_killed = !kept.ended;
    let mut start = Start {
        versions,
        restored,
        was_killed,
        begun,
        prepared,
        out,
    };
    for (key, state) in kept.states {
        let is_kept = state
            .as_ref()
            .map_or(true, |state| !(kept.ended && state.configured));
        let is_gone = matches!(
            &state,
            Ok(State {
                content: Content::Gone,
                ..
            })
        );
        if is_kept && !(kept.ended && is_gone) {
            start.restore(key, state)?;
        }
    }
    start.load(config)?;
    Ok(start.begun)
}

/// Changes that were made and not written yet when a daemon was killed, at most: each has its
/// client waiting.
const MOST_LOST: u64 = (MAX_CLIENTS * CONTROL_REQUESTS_PER_CLIENT) as u64;

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
        let start = Instant::now();
        let label = &key.1;
        let state = state.unwrap_or_else(|reason| {
            let what = if key.0 == Kind::Robot {
                "robot"
            } else {
                "scene"
            };
            tracing::error!(
                "{what} {label} is not restored, and not served until it is loaded again: {reason}"
            );
            State {
                content: Content::Gone,
                configured: false,
            }
        });
        match &state.content {
            Content::Robot(robot, weights) => {
                let taken =
                    self.begun
                        .store
                        .insert_robot(label, robot.clone(), weights.clone(), false);
                taken.map_err(|error| stored(&error))?;
                if let Some(alone) = self.prepared.and_then(|prepared| prepared.find(robot)) {
                    self.begun.store.take_alone(alone, false);
                }
                say(
                    self.out,
                    &format!("{}  restored", robot_line(label, robot, start)),
                );
            }
            Content::Scene(version, scene) => {
                let taken = self
                    .begun
                    .store
                    .restore_scene(label, scene.clone(), *version);
                taken.map_err(|error| stored(&error))?;
                if self.was_killed {
                    self.begun
                        .store
                        .skip_versions(label, MOST_LOST)
                        .map_err(|error| stored(&error))?;
                }
                say(
                    self.out,
                    &format!("{}  restored", scene_line(label, *version, scene)),
                );
            }
            Content::Gone => {}
        }
        self.restored.insert(key.clone());
        self.begun.live.insert(key, state);
        Ok(())
    }

    fn load(&mut self, config: &Config) -> Result<(), DaemonError> {
        let mut reader = Reader::new(Packages::with_environment(BTreeMap::new()));
        for robot in &config.robots {
            let start = Instant::now();
            if self.is_open(Kind::Robot, &robot.label) {
                let description = reader.robot_of(&robot.files())?;
                self.add_robot(&robot.label, description, &robot.urdf, start)?;
            }
        }
        for scene in &config.scenes {
            if self.is_open(Kind::Scene, &scene.label) {
                let read = reader.scene(&scene.file)?;
                self.add_scene(&scene.label, read)?;
            }
        }
        for problem in &config.problems {
            let start = Instant::now();
            // Without labels the file has to be read to know them. What is restored needs no file.
            if let (Some(robot), Some(scene)) = (&problem.robot, &problem.scene)
                && self.is_restored(robot, scene)
            {
                self.warm(robot, scene)?;
                continue;
            }
            let read = reader.problem(&problem.file, problem.geometry.into())?;
            let robot = problem.robot.as_ref().unwrap_or(&read.robot.name).clone();
            let scene = problem.scene.as_ref().unwrap_or(&read.name).clone();
            if self.is_open(Kind::Robot, &robot) {
                self.add_robot(&robot, read.robot, &read.robot_files.urdf, start)?;
            }
            if self.is_open(Kind::Scene, &scene) {
                self.add_scene(&scene, read.scene)?;
            }
            self.warm(&robot, &scene)?;
        }
        Ok(())
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
        let is_restored = keys.iter().all(|key| self.restored.contains(key));
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
        let taken = self
            .begun
            .store
            .insert_robot(label, robot.clone(), weights.clone(), false);
        taken.map_err(|error| stored(&error))?;
        self.begun.store.take_alone(alone, is_new);
        self.remember(Kind::Robot, label, Content::Robot(robot, weights));
        say(self.out, &line);
        Ok(())
    }

    fn add_scene(&mut self, label: &str, scene: Scene) -> Result<(), DaemonError> {
        let scene = Arc::new(scene);
        let version = match self.versions.get(label) {
            Some((version, hash)) if *hash == scene.hash() => *version,
            Some((version, _)) => version + 1,
            None => 1,
        };
        let taken = self
            .begun
            .store
            .restore_scene(label, scene.clone(), version);
        taken.map_err(|error| stored(&error))?;
        let line = scene_line(label, version, &scene);
        self.remember(Kind::Scene, label, Content::Scene(version, scene));
        say(self.out, &line);
        Ok(())
    }

    fn remember(&mut self, kind: Kind, label: &str, content: Content) {
        self.begun.live.insert(
            (kind, label.to_owned()),
            State {
                content,
                configured: true,
            },
        );
    }

    /// Makes the collision model of a problem now, so that its first request need not. A client may
    /// have unloaded one of the two.
    fn warm(&mut self, robot: &str, scene: &str) -> Result<(), DaemonError> {
        let wanted = Wanted {
            robot_id: label_id(robot),
            scene_id: label_id(scene),
            ..Wanted::default()
        };
        let Ok(snapshot) = self.begun.store.snapshot(&wanted) else {
            return Ok(());
        };
        match snapshot.model.get() {
            Ok(_) => Ok(()),
            Err(error) => Err(refused(&model_refusal(error, &snapshot.robot))),
        }
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
    let shapes = || robot.links().iter().flat_map(|link| &link.shapes);
    let triangles: usize = shapes().map(|placed| triangles(&placed.shape)).sum();
    let bodies = robot
        .links()
        .iter()
        .filter(|link| !link.shapes.is_empty())
        .count();
    format!(
        "robot {label}  {} dof  {bodies} links  {triangles} triangles  hash {:016x}  warm in {:.0} ms",
        robot.space().nv(),
        robot.hash(),
        start.elapsed().as_secs_f64() * 1e3,
    )
}

fn triangles(shape: &Shape) -> usize {
    shape.mesh().map_or(0, |mesh| mesh.triangles().len())
}

fn scene_line(label: &str, version: u64, scene: &Scene) -> String {
    let objects = scene.obstacles().len() + scene.attached().len();
    format!(
        "scene {label} v{version}  {objects} objects  hash {:016x}",
        scene.hash()
    )
}

/// Prints a line of the start. A daemon whose terminal is gone serves all the same.
pub(super) fn say(out: &mut dyn Write, line: &str) {
    let _ = writeln!(out, "{line}").and_then(|()| out.flush());
}
