//! Control messages of this process.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use taut_ipc::control::{ControlReply, ControlRequest, Listing, Refusal, RobotSource, SceneText};
use taut_ipc::monotonic_ns;
use taut_ipc::wire::Code;

use crate::scene::Scene;
use crate::store::{Change, ModelStore, SceneEntry, Snapshot, StoreError, Wanted};
use crate::translate::{self, ReadRobot, Unread, store_refusal};

type Answer = Result<ControlReply, Refusal>;

/// What a message says of a text: its label, the text, and the folder that its meshes start from.
struct Text {
    label: String,
    json: String,
    base_dir: Option<PathBuf>,
}

impl Text {
    /// What messages call it: its label. Meshes are found beside it.
    fn file(&self) -> PathBuf {
        let folder = self.base_dir.clone();
        folder
            .unwrap_or_else(|| PathBuf::from("/"))
            .join(&self.label)
    }
}

fn refuse(error: StoreError) -> Refusal {
    store_refusal(&error)
}

/// Robots and scenes of this process.
#[derive(Debug)]
pub(super) struct Models {
    store: Mutex<ModelStore>,
    /// Changes of scenes are made one after the other.
    changing: Mutex<()>,
}

impl Models {
    pub(super) fn new(store: ModelStore) -> Self {
        Self {
            store: Mutex::new(store),
            changing: Mutex::default(),
        }
    }

    fn store(&self) -> MutexGuard<'_, ModelStore> {
        self.store
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    /// Robot and scene of a request.
    pub(super) fn snapshot(&self, wanted: &Wanted) -> Result<Snapshot, Refusal> {
        self.store().snapshot(wanted).map_err(refuse)
    }

    pub(super) fn answer(&self, message: ControlRequest) -> Answer {
        use ControlRequest as Message;
        match message {
            Message::LoadRobot {
                label,
                source,
                replace,
                files: None,
            } => self.load_robot(&label, source, replace),
            Message::SelectVariables { label, variables } => self.select(&label, variables),
            Message::UnloadRobot { label } => self.unload_robot(&label),
            Message::Describe { label } => self.describe(&label),
            Message::List => Ok(self.list()),
            other => self.answer_of_scene(other),
        }
    }

    fn answer_of_scene(&self, message: ControlRequest) -> Answer {
        use ControlRequest as Message;
        match message {
            Message::LoadScene {
                label,
                json,
                base_dir,
                replace,
                files: None,
                version: None,
            } => self.load_scene(
                &Text {
                    label,
                    json,
                    base_dir,
                },
                replace,
            ),
            Message::DiffScene {
                label,
                json,
                base_dir,
                base_version,
                files: None,
                version: None,
            } => self.change_scene(
                &Text {
                    label,
                    json,
                    base_dir,
                },
                base_version,
            ),
            Message::ShowScene {
                label,
                version,
                base_version,
            } => self.show(label, version, base_version),
            Message::UnloadScene { label } => self.unload_scene(&label),
            Message::PinScene {
                label,
                version,
                pinned,
            } => self.pin(&label, version, pinned),
            other => Err(of_daemon(&other)),
        }
    }

    fn load_robot(&self, label: &str, source: RobotSource, replace: bool) -> Answer {
        let read = translate::robot_of(
            translate::reader(None),
            &translate::robot_files(source),
            None,
            |_| (),
        )
        .map_err(Unread::into_refusal)?;
        self.take_robot(label, read, replace)
    }

    fn select(&self, label: &str, variables: Vec<String>) -> Answer {
        let alone = self.store().whole(label).map_err(refuse)?;
        let selected = translate::selected_label(label, &variables);
        self.take_robot(&selected, translate::selected(&alone, variables)?, true)
    }

    pub(super) fn take_robot(&self, label: &str, read: ReadRobot, replace: bool) -> Answer {
        let ReadRobot {
            robot,
            weights,
            alone,
            is_new,
        } = read;
        let mut store = self.store();
        store
            .insert_robot(label, robot, weights, replace)
            .map_err(refuse)?;
        store.take_alone(alone, is_new);
        drop(store);
        self.describe(label)
    }

    fn unload_robot(&self, label: &str) -> Answer {
        let removed = self.store().remove_robot(label);
        removed
            .map(|_| ControlReply::Done)
            .map_err(refuse)
    }

    fn describe(&self, label: &str) -> Answer {
        let store = self.store();
        let robot = translate::describe(label, store.robot(label).map_err(refuse)?);
        Ok(ControlReply::Robot(Box::new(robot)))
    }

    fn list(&self) -> ControlReply {
        let store = self.store();
        let now_ns = monotonic_ns();
        ControlReply::Listing(Listing {
            robots: summaries(store.robots(), translate::robot_summary),
            scenes: summaries(store.scenes(), |label, entry| {
                translate::scene_summary(label, entry, now_ns)
            }),
            models: translate::model_states(&store, now_ns),
        })
    }

    fn load_scene(&self, text: &Text, replace: bool) -> Answer {
        let scene = translate::scene_of(translate::reader(None), &text.json, &text.file())
            .map_err(Unread::into_refusal)?;
        translate::frame_refusal(&scene, &self.store())?;
        let prepared = translate::warm_scene(scene, |_| ());
        let taken = self
            .store()
            .insert_prepared_scene(&text.label, prepared, replace);
        self.scene_after(&text.label, taken)
    }

    pub(super) fn take_scene(&self, label: &str, scene: Arc<Scene>, replace: bool) -> Answer {
        let taken = self.store().insert_scene(label, scene, replace);
        self.scene_after(label, taken)
    }

    /// The scene of a label after a change to it.
    fn scene_after(&self, label: &str, taken: Result<Change, StoreError>) -> Answer {
        taken.map_err(refuse)?;
        let store = self.store();
        let entry = store.scene(label);
        entry
            .map(|entry| summary(label, entry))
            .map_err(refuse)
    }

    fn change_scene(&self, text: &Text, base_version: u64) -> Answer {
        let diff = translate::diff_of(translate::reader(None), &text.json, &text.file())
            .map_err(Unread::into_refusal)?;
        let _one_at_a_time = self
            .changing
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let base = self.base(&text.label, base_version)?;
        let worlds = translate::worlds(&self.store());
        let scene = diff.apply_among(&base, &worlds);
        let scene = scene.map_err(|error| translate::scene_refusal(&error))?;
        translate::name_refusal(&diff, &scene, &self.store())?;
        self.take_scene(&text.label, scene.into(), true)
    }

    fn base(&self, label: &str, version: u64) -> Result<Arc<Scene>, Refusal> {
        let store = self.store();
        store
            .base_scene(label, version)
            .cloned()
            .map_err(refuse)
    }

    fn unload_scene(&self, label: &str) -> Answer {
        let removed = self.store().remove_scene(label);
        removed
            .map(|_| ControlReply::Done)
            .map_err(refuse)
    }

    fn pin(&self, label: &str, version: u64, pinned: bool) -> Answer {
        let mut store = self.store();
        let entry = match pinned {
            true => store.pin_scene(label, version),
            false => store.unpin_scene(label, version),
        };
        entry
            .map(|entry| summary(label, entry))
            .map_err(refuse)
    }

    fn show(&self, label: String, version: u64, base_version: u64) -> Answer {
        let newest = self
            .store()
            .scene(&label)
            .map_err(refuse)?
            .version;
        let scene = self.at(&label, version)?;
        let base = match base_version {
            0 => None,
            base => Some(self.at(&label, base)?),
        };
        Ok(ControlReply::SceneText(SceneText {
            version: if version == 0 { newest } else { version },
            scene_hash: scene.hash(),
            base_version,
            json: translate::scene_text(&scene, base.as_deref())?,
            label,
        }))
    }

    fn at(&self, label: &str, version: u64) -> Result<Arc<Scene>, Refusal> {
        let store = self.store();
        store
            .scene_at(label, version)
            .cloned()
            .map_err(refuse)
    }
}

fn summary(label: &str, entry: &SceneEntry) -> ControlReply {
    ControlReply::Scene(translate::scene_summary(label, entry, monotonic_ns()))
}

/// What a listing says of each entry.
fn summaries<T, S>(entries: &BTreeMap<String, T>, summary: impl Fn(&str, &T) -> S) -> Vec<S> {
    let entries = entries.iter();
    entries
        .map(|(label, entry)| summary(label, entry))
        .collect()
}

fn of_daemon(message: &ControlRequest) -> Refusal {
    let text = format!("{message:?}");
    // Without what it carries.
    let name = text
        .split([' ', '{', '('])
        .next()
        .unwrap_or_default();
    let text =
        format!("{name} is for a daemon; there is none, requests are answered in this process");
    Refusal::new(Code::MalformedRequest, text)
}
