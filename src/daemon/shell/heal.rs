//! A daemon whose files somebody removed starts anew in its own process, with what it had.
//!
//! What is open has ended by then, with what it had. Robots, scenes and their versions are those of
//! the store, which nobody can remove; the journal is written anew from them, for it may have lain
//! among the files that are gone. A new process would know only what was kept.

use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

use taut::store::ModelStore;
use taut_ipc::server::{Server, ServerError};
use taut_ipc::{Instance, InstanceError};

use crate::daemon::durability::journal::{Content, Key, Kind, State};
use crate::daemon::durability::restore::Beginning;
use crate::daemon::error::DaemonError;
use crate::daemon::service::kept;

/// How long to begin again and again while files are removed as fast as they are made.
const PATIENCE: Duration = Duration::from_secs(5);
/// Pause between two beginnings.
const PAUSE: Duration = Duration::from_millis(20);

/// What the configuration says, and what its labels named when the daemon began.
#[derive(Clone)]
pub(super) struct Configured {
    contents: BTreeMap<Key, Content>,
    labels: BTreeSet<Key>,
}

impl Configured {
    /// As a daemon begins.
    pub(super) fn of(begun: &Beginning) -> Self {
        let live = begun.live.iter();
        let said = live.filter(|(_, state)| state.configured);
        Self {
            contents: said
                .map(|(key, state)| (key.clone(), state.content.clone()))
                .collect(),
            labels: begun.configured.clone(),
        }
    }

    /// What a daemon goes on with that has this store.
    pub(super) fn again(&self, store: ModelStore) -> Beginning {
        let gone = self
            .labels
            .iter()
            .map(|key| (key, Content::Gone));
        let mut live: BTreeMap<Key, State> = gone
            .map(|(key, content)| (key.clone(), self.state(key, content)))
            .collect();
        for (key, content) in contents(&store) {
            let state = self.state(&key, content);
            live.insert(key, state);
        }
        Beginning {
            store,
            live,
            configured: self.labels.clone(),
        }
    }

    fn state(&self, key: &Key, content: Content) -> State {
        let said = self.contents.get(key);
        State {
            configured: said.is_some_and(|said| said.is_same(&content)),
            content,
        }
    }
}

fn contents(store: &ModelStore) -> impl Iterator<Item = (Key, Content)> {
    let robots = store.robots().iter().map(|(label, entry)| {
        let content = Content::Robot(entry.robot.clone(), entry.weights.clone());
        ((Kind::Robot, label.clone()), content)
    });
    let scenes = store.scenes().iter().map(|(label, entry)| {
        let content = Content::Scene(entry.version, kept(&entry.scene));
        ((Kind::Scene, label.clone()), content)
    });
    robots.chain(scenes)
}

/// Takes the instance again, and `open`s what is kept on disk; again and again while whoever
/// removes files is still at it.
///
/// # Errors
/// Another daemon that has taken the instance meanwhile; what cannot be made for
/// [`PATIENCE`].
pub(super) fn again<T>(
    instance: &Instance,
    mut open: impl FnMut() -> Result<T, DaemonError>,
) -> Result<(Server, T), DaemonError> {
    let end = Instant::now() + PATIENCE;
    loop {
        let taken = Server::create_again(instance).map_err(DaemonError::from);
        let begun = taken.and_then(|server| Ok((server, open()?)));
        match begun {
            Err(error) if is_passing(&error) && Instant::now() < end => std::thread::sleep(PAUSE),
            begun => return begun,
        }
    }
}

/// Whether it may be due to files that are being removed.
fn is_passing(error: &DaemonError) -> bool {
    match error {
        DaemonError::Server(error) => match error {
            ServerError::AlreadyRunning { .. } | ServerError::NoMemory => false,
            ServerError::Instance(InstanceError::RootNotPrivate { uid, me, .. }) => uid == me,
            _ => true,
        },
        DaemonError::Instance(_) | DaemonError::Journal(_) => true,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use taut::robot::{LinkDescription, RobotDescription, RobotModel};
    use taut::scene::Scene;
    use taut_ipc::wire::label_id;

    fn scene_key(label: &str) -> Key {
        (Kind::Scene, label.to_owned())
    }

    fn begun() -> Beginning {
        let mut store = ModelStore::new(label_id);
        let base = LinkDescription {
            name: "base".into(),
            collision: Vec::new(),
        };
        let robot = RobotModel::new(RobotDescription {
            links: vec![base],
            ..RobotDescription::default()
        });
        let robot = Arc::new(robot.unwrap());
        let scene = Arc::new(Scene::default());
        store
            .insert_robot("arm", robot.clone(), [].into(), false)
            .unwrap();
        let labels = ["configured", "changed", "unloaded"];
        for label in labels {
            store
                .restore_scene(label, scene.clone(), 4)
                .unwrap();
        }
        let said = |content| State {
            content,
            configured: true,
        };
        let mut live: BTreeMap<Key, State> = labels
            .map(|label| (scene_key(label), said(Content::Scene(4, scene.clone()))))
            .into();
        live.insert(
            (Kind::Robot, "arm".to_owned()),
            State {
                content: Content::Robot(robot, [].into()),
                configured: false,
            },
        );
        Beginning {
            store,
            live,
            configured: labels.map(scene_key).into(),
        }
    }

    #[test]
    fn the_store_goes_on_and_the_journal_knows_what_no_client_has_changed() {
        let Beginning {
            mut store,
            live,
            configured,
        } = begun();
        let before = Configured::of(&Beginning {
            store: ModelStore::new(label_id),
            live,
            configured,
        });
        store
            .restore_scene("changed", Arc::default(), 9)
            .unwrap();
        store.remove_scene("unloaded").unwrap();
        store
            .restore_scene("loaded", Arc::default(), 1)
            .unwrap();
        let again = before.again(store);
        assert_eq!(again.configured, before.labels);
        let seen: Vec<_> = again
            .live
            .iter()
            .map(|((_, label), state)| {
                let version = match &state.content {
                    Content::Robot(..) => 0,
                    Content::Scene(version, _) => *version,
                    Content::Gone => u64::MAX,
                };
                (label.as_str(), version, state.configured)
            })
            .collect();
        assert_eq!(
            seen,
            [
                ("arm", 0, false),
                ("changed", 9, false),
                ("configured", 4, true),
                ("loaded", 1, false),
                ("unloaded", u64::MAX, false),
            ]
        );
    }

    #[test]
    fn an_instance_that_another_daemon_took_is_left_to_it() {
        let folder = tempfile::tempdir().unwrap();
        let instance = Instance::new("test", folder.path().join("i")).unwrap();
        let first = Server::create(&instance).unwrap();
        let error = again(&instance, || Ok(())).unwrap_err();
        assert!(
            error
                .to_string()
                .contains("another daemon serves"),
            "{error}"
        );
        std::fs::remove_dir_all(instance.root()).unwrap();
        assert!(first.missing_file().is_some());
        let (second, ()) = again(&instance, || Ok(())).unwrap();
        drop(first);
        assert_eq!(
            second.missing_file(),
            None,
            "the first took nothing of it along"
        );
    }
}
