//! Control messages of this process.

use std::path::PathBuf;
use std::sync::PoisonError;

use taut_ipc::control::{ControlReply, ControlRequest, Listing, Refusal, SceneText};
use taut_ipc::wire::Code;

use super::LocalService;
use crate::translate::{self, ReadRobot, store_refusal};

impl LocalService {
    pub(super) fn answer_control(&self, message: ControlRequest) -> Result<ControlReply, Refusal> {
        let refuse = |error| store_refusal(&error);
        match message {
            ControlRequest::LoadRobot {
                label,
                source,
                replace,
            } => {
                let read = translate::robot_of(&translate::robot_files(source))?;
                self.take_robot(&label, read, replace)
            }
            ControlRequest::SelectVariables { label, variables } => {
                let alone = self.store().whole(&label).map_err(refuse)?;
                let selected = translate::selected_label(&label, &variables);
                self.take_robot(&selected, translate::selected(&alone, variables)?, true)
            }
            ControlRequest::LoadScene {
                label,
                json,
                base_dir,
                replace,
            } => {
                let scene = translate::scene_of(&json, &file_of(&label, base_dir))?;
                translate::frame_refusal(&scene, &self.store())?;
                self.store()
                    .insert_scene(&label, scene, replace)
                    .map_err(refuse)?;
                self.summary(&label)
            }
            ControlRequest::DiffScene {
                label,
                json,
                base_dir,
                base_version,
            } => {
                let diff = translate::diff_of(&json, &file_of(&label, base_dir))?;
                let _one_at_a_time = self.changing.lock().unwrap_or_else(PoisonError::into_inner);
                let base = self
                    .store()
                    .base_scene(&label, base_version)
                    .map_err(refuse)?
                    .clone();
                let worlds = translate::worlds(&self.store());
                let scene = diff
                    .apply_among(&base, &worlds)
                    .map_err(|error| translate::scene_refusal(&error))?;
                translate::name_refusal(&diff, &scene, &self.store())?;
                self.store()
                    .insert_scene(&label, scene.into(), true)
                    .map_err(refuse)?;
                self.summary(&label)
            }
            ControlRequest::ShowScene {
                label,
                version,
                base_version,
            } => self.show(label, version, base_version),
            ControlRequest::UnloadRobot { label } => self
                .store()
                .remove_robot(&label)
                .map(|_| ControlReply::Done)
                .map_err(refuse),
            ControlRequest::UnloadScene { label } => self
                .store()
                .remove_scene(&label)
                .map(|_| ControlReply::Done)
                .map_err(refuse),
            ControlRequest::PinScene {
                label,
                version,
                pinned,
            } => {
                let mut store = self.store();
                let entry = match pinned {
                    true => store.pin_scene(&label, version),
                    false => store.unpin_scene(&label, version),
                };
                entry
                    .map(|entry| ControlReply::Scene(translate::scene_summary(&label, entry)))
                    .map_err(refuse)
            }
            ControlRequest::Describe { label } => {
                let store = self.store();
                let entry = store.robot(&label).map_err(refuse)?;
                Ok(ControlReply::Robot(Box::new(translate::describe(
                    &label, entry,
                ))))
            }
            ControlRequest::List => {
                let store = self.store();
                let robots = store.robots().iter();
                let scenes = store.scenes().iter();
                Ok(ControlReply::Listing(Listing {
                    robots: robots
                        .map(|(label, entry)| translate::robot_summary(label, entry))
                        .collect(),
                    scenes: scenes
                        .map(|(label, entry)| translate::scene_summary(label, entry))
                        .collect(),
                }))
            }
            other => {
                let text = format!(
                    "{other:?} is for a daemon; there is none, requests are answered in this process"
                );
                Err(Refusal::new(Code::MalformedRequest, text))
            }
        }
    }

    fn take_robot(
        &self,
        label: &str,
        read: ReadRobot,
        replace: bool,
    ) -> Result<ControlReply, Refusal> {
        let ReadRobot {
            robot,
            weights,
            alone,
            is_new,
        } = read;
        let mut store = self.store();
        store
            .insert_robot(label, robot, weights, replace)
            .map_err(|error| store_refusal(&error))?;
        store.take_alone(alone, is_new);
        let entry = store.robot(label).map_err(|error| store_refusal(&error))?;
        Ok(ControlReply::Robot(Box::new(translate::describe(
            label, entry,
        ))))
    }

    fn summary(&self, label: &str) -> Result<ControlReply, Refusal> {
        let store = self.store();
        let entry = store.scene(label).map_err(|error| store_refusal(&error))?;
        Ok(ControlReply::Scene(translate::scene_summary(label, entry)))
    }

    fn show(
        &self,
        label: String,
        version: u64,
        base_version: u64,
    ) -> Result<ControlReply, Refusal> {
        let store = self.store();
        let at = |version| {
            store
                .scene_at(&label, version)
                .cloned()
                .map_err(|error| store_refusal(&error))
        };
        let newest = store
            .scene(&label)
            .map_err(|error| store_refusal(&error))?
            .version;
        let scene = at(version)?;
        let base = (base_version != 0).then(|| at(base_version)).transpose()?;
        drop(store);
        Ok(ControlReply::SceneText(SceneText {
            version: if version == 0 { newest } else { version },
            scene_hash: scene.hash(),
            base_version,
            json: translate::scene_text(&scene, base.as_deref())?,
            label,
        }))
    }
}

/// What messages call a text: its label. Meshes are found beside it.
fn file_of(label: &str, base_dir: Option<PathBuf>) -> PathBuf {
    base_dir.unwrap_or_else(|| PathBuf::from("/")).join(label)
}
