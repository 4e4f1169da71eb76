//! Control messages: what changes the store, or asks about it.

use std::path::PathBuf;

use taut::store::{Change, StoreError};
use taut_ipc::control::{ControlReply, ControlRequest, Listing, Refusal, Stats};
use taut_ipc::server::{IncomingControl, ServerError};
use taut_ipc::wire::{Code, SceneEvent, SceneEventKind, label_id};

use super::event::{Content, Loaded};
use super::event_loop::{EventLoop, ROUND};
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
                Ok(message) => {
                    let answer = self.control(message)?.unwrap_or_else(ControlReply::Refused);
                    reply(control, &answer);
                }
                Err(refusal) => reply(control, &ControlReply::Refused(refusal)),
            }
        }
        Ok(true)
    }

    /// Answers what needs no reading of files.
    fn control(&mut self, message: ControlRequest) -> Result<Result<ControlReply, Refusal>, ServerError> {
        let refuse = |error: StoreError| store_refusal(&error);
        Ok(match message {
            ControlRequest::Describe { label } => {
                let robot = self.store.robot(&label).map_err(refuse);
                robot.map(|entry| ControlReply::Robot(Box::new(describe(&label, entry))))
            }
            ControlRequest::List => Ok(ControlReply::Listing(self.listing())),
            ControlRequest::Stats => Ok(ControlReply::Stats(self.stats())),
            ControlRequest::UnloadRobot { label } => {
                self.store.remove_robot(&label).map_err(refuse).map(|_| ControlReply::Done)
            }
            ControlRequest::UnloadScene { label } => match self.store.remove_scene(&label) {
                Err(error) => Err(refuse(error)),
                Ok(entry) => {
                    let (scene_hash, scene_version) = (entry.scene.hash(), entry.version);
                    self.publish(SceneEventKind::Deleted, entry.id, scene_hash, scene_version)?;
                    Ok(ControlReply::Done)
                }
            },
            ControlRequest::Shutdown => {
                self.drain();
                Ok(ControlReply::Done)
            }
            _ => {
                let text = "this daemon does not change scenes in place or pin them; load the whole scene with replace";
                Err(Refusal::new(Code::MalformedRequest, text))
            }
        })
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
        let answer = match content {
            Err(refusal) => Err(refusal),
            Ok(Content::Robot(robot, weights)) => {
                let inserted = self.store.insert_robot(&label, robot, weights, replace);
                let entry = inserted.and_then(|_| self.store.robot(&label)).map_err(|error| store_refusal(&error));
                entry.map(|entry| ControlReply::Robot(Box::new(describe(&label, entry))))
            }
            Ok(Content::Scene(scene)) => match self.store.insert_scene(&label, scene, replace) {
                Err(error) => Err(store_refusal(&error)),
                Ok(change) => {
                    let entry = &self.store.scenes()[&label];
                    let (id, hash, version) = (entry.id, entry.scene.hash(), entry.version);
                    let summary = scene_summary(&label, entry);
                    match change {
                        Change::Created => self.publish(SceneEventKind::Created, id, hash, version)?,
                        Change::Replaced => self.publish(SceneEventKind::Changed, id, hash, version)?,
                        Change::Unchanged => {}
                    }
                    Ok(ControlReply::Scene(summary))
                }
            },
        };
        if let Err(refusal) = &answer {
            tracing::info!(label, code = refusal.code, "not loaded: {}", refusal.message);
        }
        if let Some(control) = self.loads.remove(&token) {
            reply(control, &answer.unwrap_or_else(ControlReply::Refused));
        }
        Ok(())
    }

    fn publish(&self, kind: SceneEventKind, id: u64, hash: u64, version: u64) -> Result<(), ServerError> {
        self.server.publish_scene_event(&SceneEvent {
            kind: kind.into(),
            scene_id: id,
            scene_hash: hash,
            scene_version: version,
            ..SceneEvent::default()
        })
    }

    fn listing(&self) -> Listing {
        let (robots, scenes) = (self.store.robots().iter(), self.store.scenes().iter());
        Listing {
            robots: robots.map(|(label, entry)| robot_summary(label, entry)).collect(),
            scenes: scenes.map(|(label, entry)| scene_summary(label, entry)).collect(),
        }
    }

    fn stats(&mut self) -> Stats {
        Stats {
            boot_id: self.server.boot_id(),
            pid: std::process::id(),
            daemon_version: env!("CARGO_PKG_VERSION").to_owned(),
            uptime_ns: self.metrics.uptime_ns(),
            numbers: metrics::numbers(&self.status()),
        }
    }
}

/// A reply that is too large, or has no room, becomes a refusal; a client that is gone needs none.
fn reply(control: IncomingControl, reply: &ControlReply) {
    if let Err(error) = control.reply(reply) {
        tracing::warn!("a control reply was not sent: {error}");
    }
}
