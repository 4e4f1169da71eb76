//! Control messages: what changes the store, or asks about it.

use std::path::PathBuf;
use std::sync::Arc;

use taut::scene::Scene;
use taut::store::{Change, SceneEntry, StoreError};
use taut_ipc::control::{ControlReply, ControlRequest, Listing, Refusal, SceneSummary, Stats};
use taut_ipc::monotonic_ns;
use taut_ipc::server::{IncomingControl, ServerError};
use taut_ipc::wire::{Code, SceneEvent, SceneEventKind, label_id};

use super::admission::being_loaded;
use super::event::{Content, Loaded, Purpose};
use super::event_loop::{EventLoop, ROUND};
use super::keep::reply;
use super::keeping::{Acknowledgement, Changed};
use super::loader::{Source, Task, Work};
use super::metrics;
use super::translate::{
    ReadRobot, describe, frame_refusal, robot_files, robot_summary, scene_state, scene_summary,
    selected_label, store_refusal,
};

/// Longest label, in bytes.
const LABEL_MAX: usize = 256;

impl EventLoop {
    /// Takes control messages; tells whether more may be waiting.
    pub(super) fn receive_controls(&mut self) -> Result<bool, ServerError> {
        for _ in 0..ROUND {
            let Some(control) = self.server.receive_control()? else {
                return Ok(false);
            };
            match control.message() {
                Ok(ControlRequest::LoadRobot {
                    label,
                    source,
                    replace,
                }) => {
                    self.load(
                        control,
                        label,
                        Purpose::Load { replace },
                        Source::Robot(robot_files(source)),
                    );
                }
                Ok(ControlRequest::SelectVariables { label, variables }) => {
                    self.select_variables(control, &label, variables);
                }
                Ok(ControlRequest::LoadScene {
                    label,
                    json,
                    base_dir,
                    replace,
                }) => {
                    let file = file_of(&label, base_dir);
                    self.load(
                        control,
                        label,
                        Purpose::Load { replace },
                        Source::Scene(json, file),
                    );
                }
                Ok(ControlRequest::DiffScene {
                    label,
                    json,
                    base_dir,
                    base_version,
                }) => {
                    let file = file_of(&label, base_dir);
                    self.diff_scene(control, label, base_version, json, file)?;
                }
                Ok(ControlRequest::ShowScene {
                    label,
                    version,
                    base_version,
                }) => {
                    self.show_scene(control, &label, version, base_version);
                }
                Ok(ControlRequest::Record { file }) => self.record(control, file),
                Ok(ControlRequest::EndRecording) => self.end_recording(control),
                Ok(ControlRequest::Bundle { id, file }) => self.bundle(control, &id, file),
                Ok(ControlRequest::UnloadRobot { label }) => self.unload_robot(control, label)?,
                Ok(ControlRequest::UnloadScene { label }) => self.unload_scene(control, label)?,
                Ok(message) => reply(
                    control,
                    &self.control(message).unwrap_or_else(ControlReply::Refused),
                ),
                Err(refusal) => reply(control, &ControlReply::Refused(refusal)),
            }
        }
        Ok(true)
    }

    /// Answers what changes nothing in the store.
    fn control(&mut self, message: ControlRequest) -> Result<ControlReply, Refusal> {
        match message {
            ControlRequest::Describe { label } => {
                let robot = self.store.robot(&label).map_err(|error| {
                    match self.loading.contains(&label_id(&label)) {
                        true => being_loaded(),
                        false => store_refusal(&error),
                    }
                });
                robot.map(|entry| ControlReply::Robot(Box::new(describe(&label, entry))))
            }
            ControlRequest::List => Ok(ControlReply::Listing(self.listing())),
            ControlRequest::Stats => Ok(ControlReply::Stats(self.stats())),
            ControlRequest::Clients => Ok(ControlReply::Clients(
                self.clients.summaries(monotonic_ns()),
            )),
            ControlRequest::Stories { id } => Ok(ControlReply::Stories(self.stories.find(&id))),
            ControlRequest::Shutdown => {
                self.drain();
                Ok(ControlReply::Done)
            }
            ControlRequest::PinScene {
                label,
                version,
                pinned,
            } => self.pin_scene(&label, version, pinned),
            other => {
                let text = format!(
                    "this daemon does not know {other:?}; use client and daemon of the same release"
                );
                Err(Refusal::new(Code::MalformedRequest, text))
            }
        }
    }

    fn unload_robot(&mut self, control: IncomingControl, label: String) -> Result<(), ServerError> {
        if let Err(error) = self.store.remove_robot(&label) {
            reply(control, &ControlReply::Refused(store_refusal(&error)));
            return Ok(());
        }
        self.recheck_watches(label_id(&label));
        let told = Acknowledgement {
            control: Some(control),
            answer: ControlReply::Done,
            event: None,
        };
        self.keep(&Changed::Robot(label), told)
    }

    fn unload_scene(&mut self, control: IncomingControl, label: String) -> Result<(), ServerError> {
        let entry = match self.store.remove_scene(&label) {
            Ok(entry) => entry,
            Err(error) => {
                reply(control, &ControlReply::Refused(store_refusal(&error)));
                return Ok(());
            }
        };
        self.recheck_watches(entry.id);
        let event = Some(scene_event(SceneEventKind::Deleted, &entry));
        let told = Acknowledgement {
            control: Some(control),
            answer: ControlReply::Done,
            event,
        };
        self.keep(&Changed::Scene(label), told)
    }

    /// Gives something to the loader; the reply comes when it is read.
    pub(super) fn load(
        &mut self,
        control: IncomingControl,
        label: String,
        purpose: Purpose,
        source: Source,
    ) {
        if label.is_empty() || label.len() > LABEL_MAX {
            let text = format!("a label of {} bytes; valid: 1 to {LABEL_MAX}", label.len());
            return reply(
                control,
                &ControlReply::Refused(Refusal::new(Code::MalformedRequest, text)),
            );
        }
        if let Source::Robot(files) = &source
            && !files.urdf.is_absolute()
        {
            let text = format!("{}: name files by absolute paths", files.urdf.display());
            return reply(
                control,
                &ControlReply::Refused(Refusal::new(Code::MalformedRequest, text)),
            );
        }
        if matches!(purpose, Purpose::Load { .. }) {
            self.loading.insert(label_id(&label));
        }
        self.hand_over(
            control,
            Work::Read {
                label,
                purpose,
                source,
            },
        );
    }

    /// Has a loaded robot made with these variables only.
    fn select_variables(&mut self, control: IncomingControl, label: &str, variables: Vec<String>) {
        match self.store.whole(label) {
            Ok(alone) => {
                let selected = selected_label(label, &variables);
                self.load(
                    control,
                    selected,
                    Purpose::Load { replace: true },
                    Source::Variables(alone, variables),
                );
            }
            Err(error) => reply(control, &ControlReply::Refused(store_refusal(&error))),
        }
    }

    /// A control request that another thread answers, under this token.
    pub(super) fn wait_for_thread(&mut self, control: IncomingControl, token: u64) {
        self.loads.insert(token, control);
    }

    /// Gives work to the loader; the control request waits for it.
    pub(super) fn hand_over(&mut self, control: IncomingControl, work: Work) {
        let token = self.next_number();
        self.wait_for_thread(control, token);
        if let Some(loader) = &self.loader {
            loader.send(Task { token, work });
        }
    }

    /// Answers a control request with what the loader has made for it.
    pub(super) fn answer_control(&mut self, token: u64, answer: &ControlReply) {
        if let Some(control) = self.loads.remove(&token) {
            reply(control, answer);
        }
    }

    /// Takes what the loader has read into the store.
    pub(super) fn finish_load(&mut self, loaded: Loaded) -> Result<(), ServerError> {
        let Loaded {
            token,
            label,
            purpose,
            content,
        } = loaded;
        if matches!(purpose, Purpose::Load { .. }) {
            self.loading.remove(&label_id(&label));
        }
        let control = self.loads.remove(&token);
        self.take_content(control, &label, purpose, content)
    }

    /// Takes what was read into the store and tells of it.
    pub(super) fn take_content(
        &mut self,
        control: Option<IncomingControl>,
        label: &str,
        purpose: Purpose,
        content: Result<Content, Refusal>,
    ) -> Result<(), ServerError> {
        match content.and_then(|content| self.insert(label, purpose, content)) {
            Ok((changed, answer, event)) => {
                if event.is_some() || matches!(changed, Changed::Robot(_)) {
                    self.recheck_watches(label_id(label));
                }
                self.keep(
                    &changed,
                    Acknowledgement {
                        control,
                        answer,
                        event,
                    },
                )
            }
            Err(refusal) => {
                tracing::info!(label, code = refusal.code, "not taken: {}", refusal.message);
                if let Some(control) = control {
                    reply(control, &ControlReply::Refused(refusal));
                }
                Ok(())
            }
        }
    }

    fn insert(
        &mut self,
        label: &str,
        purpose: Purpose,
        content: Content,
    ) -> Result<(Changed, ControlReply, Option<SceneEvent>), Refusal> {
        let refuse = |error: StoreError| store_refusal(&error);
        let (replace, base_version) = match purpose {
            Purpose::Load { replace } => (replace, 0),
            Purpose::Change { base_version } => (true, base_version),
        };
        match content {
            Content::Robot(ReadRobot {
                robot,
                weights,
                alone,
                is_new,
            }) => {
                self.store
                    .insert_robot(label, robot, weights, replace)
                    .map_err(refuse)?;
                self.store.take_alone(alone, is_new);
                let described = describe(label, self.store.robot(label).map_err(refuse)?);
                Ok((
                    Changed::Robot(label.to_owned()),
                    ControlReply::Robot(Box::new(described)),
                    None,
                ))
            }
            Content::Diff(diff) => {
                let scene = self.changed_scene(label, base_version, &diff)?;
                // What is odd about shapes is known where they came, and looking at all of them
                // takes its time.
                let summary = if diff.may_be_odd() {
                    scene_summary
                } else {
                    scene_state
                };
                self.insert_scene(label, scene, replace, summary)
            }
            Content::Scene(scene) => {
                frame_refusal(&scene, &self.store)?;
                self.insert_scene(label, scene, replace, scene_summary)
            }
        }
    }

    fn insert_scene(
        &mut self,
        label: &str,
        scene: Arc<Scene>,
        replace: bool,
        summary: fn(&str, &SceneEntry) -> SceneSummary,
    ) -> Result<(Changed, ControlReply, Option<SceneEvent>), Refusal> {
        let change = self
            .store
            .insert_scene(label, scene, replace)
            .map_err(|error| store_refusal(&error))?;
        let entry = self
            .store
            .scene(label)
            .map_err(|error| store_refusal(&error))?;
        let event = match change {
            Change::Created => Some(scene_event(SceneEventKind::Created, entry)),
            Change::Replaced => Some(scene_event(SceneEventKind::Changed, entry)),
            Change::Unchanged => None,
        };
        Ok((
            Changed::Scene(label.to_owned()),
            ControlReply::Scene(summary(label, entry)),
            event,
        ))
    }

    fn listing(&self) -> Listing {
        let robots = self.store.robots().iter();
        let scenes = self.store.scenes().iter();
        Listing {
            robots: robots
                .map(|(label, entry)| robot_summary(label, entry))
                .collect(),
            scenes: scenes
                .map(|(label, entry)| scene_summary(label, entry))
                .collect(),
        }
    }

    pub(super) fn stats(&mut self) -> Stats {
        let mut numbers = metrics::numbers(&self.status());
        numbers.extend(self.metrics.more());
        Stats {
            boot_id: self.server.boot_id(),
            pid: std::process::id(),
            daemon_version: env!("CARGO_PKG_VERSION").to_owned(),
            uptime_ns: self.metrics.uptime_ns(),
            numbers,
        }
    }
}

/// What messages call a text that was sent: its label. Meshes are found beside it.
fn file_of(label: &str, base_dir: Option<PathBuf>) -> PathBuf {
    base_dir.unwrap_or_else(|| PathBuf::from("/")).join(label)
}

fn scene_event(kind: SceneEventKind, entry: &SceneEntry) -> SceneEvent {
    SceneEvent {
        kind: kind.into(),
        scene_id: entry.id,
        scene_hash: entry.scene.hash(),
        scene_version: entry.version,
        ..SceneEvent::default()
    }
}
