//! Control messages: what changes the store, or asks about it.

use std::path::PathBuf;

use taut::store::{Change, SceneEntry, StoreError};
use taut_ipc::control::{ControlReply, ControlRequest, Listing, Refusal, Stats};
use taut_ipc::monotonic_ns;
use taut_ipc::server::{IncomingControl, ServerError};
use taut_ipc::wire::{Code, SceneEvent, SceneEventKind, label_id};

use super::event::{Content, Loaded};
use super::event_loop::{EventLoop, ROUND};
use super::keep::{Acknowledgement, Changed, reply};
use super::loader::{Source, Task};
use super::metrics;
use super::translate::{describe, robot_files, robot_summary, scene_summary, store_refusal};

/// Longest label, in bytes.
const LABEL_MAX: usize = 256;

impl EventLoop {
    /// Takes control messages; tells whether more may be waiting.
    pub(super) fn receive_controls(&mut self) -> Result<bool, ServerError> {
        for _ in 0..ROUND {
            let Some(control) = self.server.receive_control()? else { return Ok(false) };
            match control.message() {
                Ok(ControlRequest::LoadRobot { label, source, replace }) => {
                    self.load(control, label, replace, Source::Robot(robot_files(source)));
                }
                Ok(ControlRequest::LoadScene { label, json, base_dir, replace }) => {
                    // Messages call the scene by its label; meshes are found beside it.
                    let file = base_dir.unwrap_or_else(|| PathBuf::from("/")).join(&label);
                    self.load(control, label, replace, Source::Scene(json, file));
                }
                Ok(ControlRequest::UnloadRobot { label }) => self.unload_robot(control, label)?,
                Ok(ControlRequest::UnloadScene { label }) => self.unload_scene(control, label)?,
                Ok(message) => reply(control, &self.control(message).unwrap_or_else(ControlReply::Refused)),
                Err(refusal) => reply(control, &ControlReply::Refused(refusal)),
            }
        }
        Ok(true)
    }

    /// Answers what changes nothing in the store.
    fn control(&mut self, message: ControlRequest) -> Result<ControlReply, Refusal> {
        match message {
            ControlRequest::Describe { label } => {
                let robot = self.store.robot(&label).map_err(|error| store_refusal(&error));
                robot.map(|entry| ControlReply::Robot(Box::new(describe(&label, entry))))
            }
            ControlRequest::List => Ok(ControlReply::Listing(self.listing())),
            ControlRequest::Stats => Ok(ControlReply::Stats(self.stats())),
            ControlRequest::Clients => Ok(ControlReply::Clients(self.clients.summaries(monotonic_ns()))),
            ControlRequest::Stories { id } => Ok(ControlReply::Stories(self.stories.find(&id))),
            ControlRequest::Shutdown => {
                self.drain();
                Ok(ControlReply::Done)
            }
            _ => {
                let text = "this daemon does not change scenes in place or pin them; load the whole scene with replace";
                Err(Refusal::new(Code::MalformedRequest, text))
            }
        }
    }

    fn unload_robot(&mut self, control: IncomingControl, label: String) -> Result<(), ServerError> {
        if let Err(error) = self.store.remove_robot(&label) {
            reply(control, &ControlReply::Refused(store_refusal(&error)));
            return Ok(());
        }
        let told = Acknowledgement { control: Some(control), answer: ControlReply::Done, event: None };
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
        let event = Some(scene_event(SceneEventKind::Deleted, &entry));
        let told = Acknowledgement { control: Some(control), answer: ControlReply::Done, event };
        self.keep(&Changed::Scene(label), told)
    }

    /// Gives something to the loader; the reply comes when it is read.
    fn load(&mut self, control: IncomingControl, label: String, replace: bool, source: Source) {
        if label.is_empty() || label.len() > LABEL_MAX {
            let text = format!("a label of {} bytes; valid: 1 to {LABEL_MAX}", label.len());
            return reply(control, &ControlReply::Refused(Refusal::new(Code::MalformedRequest, text)));
        }
        if let Source::Robot(files) = &source
            && !files.urdf.is_absolute()
        {
            let text = format!("{}: name files by absolute paths", files.urdf.display());
            return reply(control, &ControlReply::Refused(Refusal::new(Code::MalformedRequest, text)));
        }
        let token = self.next_number();
        self.loading.insert(label_id(&label));
        self.loads.insert(token, control);
        if let Some(loader) = &self.loader {
            // It reads until the sender is dropped, when nobody waits for it any more.
            let _ = loader.send(Task { token, label, replace, source });
        }
    }

    /// Takes what the loader has read into the store.
    pub(super) fn finish_load(&mut self, loaded: Loaded) -> Result<(), ServerError> {
        let Loaded { token, label, replace, content } = loaded;
        self.loading.remove(&label_id(&label));
        let control = self.loads.remove(&token);
        match content.and_then(|content| self.insert(&label, replace, content)) {
            Ok((changed, answer, event)) => self.keep(&changed, Acknowledgement { control, answer, event }),
            Err(refusal) => {
                tracing::info!(label, code = refusal.code, "not loaded: {}", refusal.message);
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
        replace: bool,
        content: Content,
    ) -> Result<(Changed, ControlReply, Option<SceneEvent>), Refusal> {
        let refuse = |error: StoreError| store_refusal(&error);
        match content {
            Content::Robot(robot, weights) => {
                self.store.insert_robot(label, robot, weights, replace).map_err(refuse)?;
                let described = describe(label, self.store.robot(label).map_err(refuse)?);
                Ok((Changed::Robot(label.to_owned()), ControlReply::Robot(Box::new(described)), None))
            }
            Content::Scene(scene) => {
                let change = self.store.insert_scene(label, scene, replace).map_err(refuse)?;
                let entry = &self.store.scenes()[label];
                let event = match change {
                    Change::Created => Some(scene_event(SceneEventKind::Created, entry)),
                    Change::Replaced => Some(scene_event(SceneEventKind::Changed, entry)),
                    Change::Unchanged => None,
                };
                Ok((Changed::Scene(label.to_owned()), ControlReply::Scene(scene_summary(label, entry)), event))
            }
        }
    }

    fn listing(&self) -> Listing {
        let (robots, scenes) = (self.store.robots().iter(), self.store.scenes().iter());
        Listing {
            robots: robots.map(|(label, entry)| robot_summary(label, entry)).collect(),
            scenes: scenes.map(|(label, entry)| scene_summary(label, entry)).collect(),
        }
    }

    fn stats(&mut self) -> Stats {
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

fn scene_event(kind: SceneEventKind, entry: &SceneEntry) -> SceneEvent {
    SceneEvent {
        kind: kind.into(),
        scene_id: entry.id,
        scene_hash: entry.scene.hash(),
        scene_version: entry.version,
        ..SceneEvent::default()
    }
}
