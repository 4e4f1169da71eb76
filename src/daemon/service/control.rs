//! Control messages: what changes the store, or asks about it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use taut::files::GivenFiles;
use taut::scene::diff_file::SceneDiff;
use taut::store::{Change, RobotEntry, SceneEntry, StoreError};
use taut_ipc::control::{ControlReply, ControlRequest, Listing, Refusal, SceneSummary, Stats};
use taut_ipc::wire::{Code, SceneEvent, SceneEventKind, label_id};

use super::Service;
use super::client::Client;
use super::effect::{Effect, InOrder, Source, Task, Work};
use super::event::{Content, Loaded, Purpose, Surroundings, Ticket};
use super::keeping::{Acknowledgement, Changed};
use super::reading::Reading;
use crate::daemon::observe::metrics;
use crate::daemon::translate::{
    ReadRobot, Unread, describe, frame_refusal, model_states, robot_files, robot_summary,
    scene_state, scene_summary, selected_label, store_refusal,
};

/// Longest label, in bytes.
const LABEL_MAX: usize = 256;
/// Longest name that a client gives itself, in bytes.
const NAME_MAX: usize = 128;

/// The reply to a control message; `None` where it comes later.
pub(super) type Replied = Result<Option<ControlReply>, Refusal>;

impl Service {
    /// Does what a control message asks for.
    pub(super) fn controlled(
        &mut self,
        ticket: Ticket,
        client: Client,
        message: Result<Box<ControlRequest>, Refusal>,
        around: Surroundings,
    ) {
        let replied = message.and_then(|message| match *message {
            ControlRequest::Introduce { name } => self.introduced(client, name),
            message => self.obey(ticket, message, around),
        });
        self.tell_reply(ticket, replied);
    }

    fn introduced(&mut self, client: Client, name: String) -> Replied {
        check_name(&name)?;
        self.clients.introduced(client.id, name);
        Ok(Some(ControlReply::Done))
    }

    pub(super) fn tell_reply(&mut self, ticket: Ticket, replied: Replied) {
        let reply = replied.unwrap_or_else(|refusal| Some(ControlReply::Refused(refusal)));
        if let Some(reply) = reply {
            self.effects
                .push(Effect::Reply(ticket, Box::new(reply)));
        }
    }

    fn obey(&mut self, ticket: Ticket, message: ControlRequest, around: Surroundings) -> Replied {
        match message {
            ControlRequest::LoadRobot {
                label,
                source,
                replace,
                files,
            } => {
                let purpose = Purpose::Load {
                    replace,
                    version: None,
                };
                let source = Source::Robot(robot_files(source));
                self.load_from(ticket, label, purpose, source, files.as_ref())
            }
            ControlRequest::SelectVariables { label, variables } => {
                self.select_variables(ticket, &label, variables)
            }
            ControlRequest::LoadScene {
                label,
                json,
                base_dir,
                replace,
                files,
                version,
            } => {
                let purpose = Purpose::Load { replace, version };
                let source = Source::Scene(json, file_of(&label, base_dir));
                self.load_from(ticket, label, purpose, source, files.as_ref())
            }
            ControlRequest::DiffScene {
                label,
                json,
                base_dir,
                base_version,
                files,
                version,
            } => {
                let purpose = Purpose::Change {
                    base_version,
                    version,
                };
                let file = file_of(&label, base_dir);
                self.diff_scene(ticket, label, purpose, (json, file), files.as_ref())
            }
            ControlRequest::Frame {
                label,
                object,
                frame,
            } => self.frame(ticket, label, object, frame),
            ControlRequest::Give {
                file,
                offset,
                bytes,
            } => self.give(ticket, file, offset, bytes),
            ControlRequest::ShowScene {
                label,
                version,
                base_version,
            } => self.show_scene(ticket, &label, version, base_version),
            ControlRequest::Record { file } => self.record(ticket, file),
            ControlRequest::EndRecording => self.end_recording(ticket),
            ControlRequest::Bundle { id, file } => self.bundle(ticket, &id, file),
            ControlRequest::UnloadRobot { label } => self.unload_robot(ticket, label),
            ControlRequest::UnloadScene { label } => self.unload_scene(ticket, label),
            message => self.control(message, around).map(Some),
        }
    }

    /// Answers what changes nothing in the store.
    fn control(
        &mut self,
        message: ControlRequest,
        around: Surroundings,
    ) -> Result<ControlReply, Refusal> {
        match message {
            ControlRequest::Describe { label } => self.describe(&label),
            ControlRequest::List => Ok(ControlReply::Listing(self.listing())),
            ControlRequest::Stats => Ok(ControlReply::Stats(self.stats(around))),
            ControlRequest::Clients => {
                let summaries = self.clients.summaries(self.now_ns);
                Ok(ControlReply::Clients(summaries))
            }
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
            other => Err(unknown(&other)),
        }
    }

    fn describe(&self, label: &str) -> Result<ControlReply, Refusal> {
        match self.store.robot(label) {
            Ok(entry) => Ok(ControlReply::Robot(Box::new(describe(label, entry)))),
            Err(error) => {
                let reading = self.loading.labels().get(&label_id(label));
                Err(reading.map_or_else(
                    || store_refusal(&error),
                    |reading| reading.refusal(self.now_ns),
                ))
            }
        }
    }

    fn unload_robot(&mut self, ticket: Ticket, label: String) -> Replied {
        self.store
            .remove_robot(&label)
            .map_err(refused)?;
        self.recheck_watches(label_id(&label));
        let told = Acknowledgement::done(ticket, None);
        self.keep(&Changed::Robot(label), told);
        Ok(None)
    }

    fn unload_scene(&mut self, ticket: Ticket, label: String) -> Replied {
        let entry = self
            .store
            .remove_scene(&label)
            .map_err(refused)?;
        self.recheck_watches(entry.id);
        let event = scene_event(SceneEventKind::Deleted, &entry, entry.scene.hash());
        let told = Acknowledgement::done(ticket, Some(event));
        self.keep(&Changed::Scene(label), told);
        Ok(None)
    }

    /// Has something read; the reply comes then.
    pub(super) fn load(
        &mut self,
        ticket: Ticket,
        label: String,
        purpose: Purpose,
        source: Source,
        given: Option<GivenFiles>,
    ) -> Replied {
        check_load(&label, &source, given.is_some())?;
        let reading = Reading::new(&label, source.is_robot(), self.now_ns);
        let reading = Arc::new(reading);
        if matches!(purpose, Purpose::Load { .. }) {
            self.loading.begin(&label, reading.clone());
        }
        let work = Work::Read {
            label,
            purpose,
            source: Box::new(source),
            given,
            reading,
        };
        self.have_done(ticket, work);
        Ok(None)
    }

    /// Has a loaded robot made with these variables only.
    fn select_variables(&mut self, ticket: Ticket, label: &str, variables: Vec<String>) -> Replied {
        let alone = self.store.whole(label).map_err(refused)?;
        let selected = selected_label(label, &variables);
        let purpose = Purpose::Load {
            replace: true,
            version: None,
        };
        let source = Source::Variables(alone, variables);
        self.load(ticket, selected, purpose, source, None)
    }

    /// Gives work to the loader.
    pub(super) fn have_done(&mut self, ticket: Ticket, work: Work) {
        self.in_order(InOrder::Load(Task { ticket, work }));
    }

    /// Takes what the loader has read into the store.
    pub(super) fn loaded(&mut self, loaded: Loaded) {
        let Loaded {
            ticket,
            label,
            purpose,
            content,
        } = loaded;
        if matches!(purpose, Purpose::Load { .. }) {
            self.loading.end(&label);
        }
        let replied = match content {
            Ok(content) => self.take(ticket, &label, purpose, content),
            Err(unread) => told(unread),
        };
        if let Err(Refusal { code, message, .. }) = &replied {
            tracing::info!(label, code, "not taken: {message}");
        }
        self.tell_reply(ticket, replied);
    }

    /// Takes what was read into the store and tells of it.
    pub(super) fn take(
        &mut self,
        ticket: Ticket,
        label: &str,
        purpose: Purpose,
        content: Content,
    ) -> Replied {
        let taken = self.insert(label, purpose, content)?;
        if taken.event.is_some() || matches!(taken.changed, Changed::Robot(_)) {
            self.recheck_watches(label_id(label));
        }
        let told = Acknowledgement {
            ticket,
            answer: taken.answer,
            event: taken.event,
        };
        self.keep(&taken.changed, told);
        Ok(None)
    }

    fn insert(
        &mut self,
        label: &str,
        purpose: Purpose,
        content: Content,
    ) -> Result<Taken, Refusal> {
        match content {
            Content::Robot(robot) => self.insert_robot(label, robot, purpose.place().replace),
            Content::Diff(diff) => {
                let scene = self.changed_scene(label, purpose.base_version(), &diff)?;
                let parent_hash = self.hash_named(label);
                let change = self
                    .store
                    .insert_scene(label, scene, purpose.place());
                self.taken_scene(label, change, parent_hash, summary_after(&diff))
            }
            Content::Scene(scene) => {
                frame_refusal(scene.scene(), &self.store)?;
                let parent_hash = self.hash_named(label);
                let change = self
                    .store
                    .insert_prepared_scene(label, scene, purpose.place());
                self.taken_scene(label, change, parent_hash, scene_summary)
            }
        }
    }

    fn insert_robot(
        &mut self,
        label: &str,
        read: ReadRobot,
        replace: bool,
    ) -> Result<Taken, Refusal> {
        let ReadRobot {
            robot,
            weights,
            alone,
            is_new,
        } = read;
        self.store
            .insert_robot(label, robot, weights, replace)
            .map_err(refused)?;
        self.store.take_alone(alone, is_new);
        let described = describe(label, self.store.robot(label).map_err(refused)?);
        Ok(Taken {
            changed: Changed::Robot(label.to_owned()),
            answer: ControlReply::Robot(Box::new(described)),
            event: None,
        })
    }

    /// Hash of the scene that a label names; 0 = none.
    pub(super) fn hash_named(&self, label: &str) -> u64 {
        let entry = self.store.scenes().get(label);
        entry.map_or(0, |entry| entry.scene.hash())
    }

    fn taken_scene(
        &self,
        label: &str,
        change: Result<Change, StoreError>,
        parent_hash: u64,
        summary: Summary,
    ) -> Result<Taken, Refusal> {
        let change = change.map_err(refused)?;
        let entry = self.store.scene(label).map_err(refused)?;
        Ok(Taken {
            changed: Changed::Scene(label.to_owned()),
            answer: ControlReply::Scene(summary(label, entry, self.now_ns)),
            event: kind_of(change).map(|kind| scene_event(kind, entry, parent_hash)),
        })
    }

    fn listing(&self) -> Listing {
        let robots = self.store.robots().iter();
        let scenes = self.store.scenes().iter();
        let robot = |(label, entry): (&String, &RobotEntry)| robot_summary(label, entry);
        let now_ns = self.now_ns;
        let scene = |(label, entry): (&String, &SceneEntry)| scene_summary(label, entry, now_ns);
        let reading = self.loading.labels().values();
        let mut models = model_states(&self.store, self.now_ns);
        models.extend(reading.map(|reading| reading.state(self.now_ns)));
        Listing {
            robots: robots.map(robot).collect(),
            scenes: scenes.map(scene).collect(),
            models,
        }
    }

    pub(super) fn stats(&mut self, around: Surroundings) -> Stats {
        let mut numbers = metrics::numbers(&self.status(around));
        numbers.extend(self.metrics.more());
        Stats {
            boot_id: self.boot_id,
            pid: std::process::id(),
            daemon_version: env!("CARGO_PKG_VERSION").to_owned(),
            uptime_ns: self.metrics.uptime_ns(self.now_ns),
            numbers,
        }
    }
}

/// What a client hears of what could not be read.
pub(super) fn told(unread: Unread) -> Replied {
    match unread {
        Unread::Refused(refusal) => Err(refusal),
        Unread::Wanted(names) => Ok(Some(ControlReply::Wanted(names))),
    }
}

/// What the store has taken, and what is told of it.
struct Taken {
    changed: Changed,
    answer: ControlReply,
    event: Option<SceneEvent>,
}

/// Sums up a scene.
type Summary = fn(&str, &SceneEntry, u64) -> SceneSummary;

/// What is odd about shapes is known where they came, and looking at all of them takes its time.
fn summary_after(diff: &SceneDiff) -> Summary {
    if diff.may_be_odd() {
        scene_summary
    } else {
        scene_state
    }
}

fn refused(error: StoreError) -> Refusal {
    store_refusal(&error)
}

fn malformed(text: String) -> Refusal {
    Refusal::new(Code::MalformedRequest, text)
}

fn unknown(message: &ControlRequest) -> Refusal {
    malformed(format!(
        "this daemon does not know {message:?}; use client and daemon of the same release"
    ))
}

fn check_name(name: &str) -> Result<(), Refusal> {
    let bytes = name.len();
    if (1..=NAME_MAX).contains(&bytes) && !name.chars().any(char::is_control) {
        return Ok(());
    }
    let text = format!(
        "a client's name of {bytes} bytes; valid: 1 to {NAME_MAX} without control characters"
    );
    Err(malformed(text))
}

/// Refuses a label that is too long, and files of this machine that are not named by absolute paths.
fn check_load(label: &str, source: &Source, is_given: bool) -> Result<(), Refusal> {
    let bytes = label.len();
    if !(1..=LABEL_MAX).contains(&bytes) {
        let text = format!("a label of {bytes} bytes; valid: 1 to {LABEL_MAX}");
        return Err(malformed(text));
    }
    match source {
        Source::Robot(files) if !is_given => check_absolute(&files.urdf),
        Source::Robot(_) | Source::Variables(..) | Source::Scene(..) | Source::Diff(..) => Ok(()),
    }
}

/// Refuses a relative path: the daemon has a folder of its own.
pub(crate) fn check_absolute(file: &Path) -> Result<(), Refusal> {
    if file.is_absolute() {
        return Ok(());
    }
    let text = format!("{}: name files by absolute paths", file.display());
    Err(malformed(text))
}

fn kind_of(change: Change) -> Option<SceneEventKind> {
    match change {
        Change::Created => Some(SceneEventKind::Created),
        Change::Replaced => Some(SceneEventKind::Changed),
        Change::Unchanged => None,
    }
}

/// What messages call a text that was sent: its label. Meshes are found beside it.
fn file_of(label: &str, base_dir: Option<PathBuf>) -> PathBuf {
    base_dir
        .unwrap_or_else(|| PathBuf::from("/"))
        .join(label)
}

pub(super) fn scene_event(
    kind: SceneEventKind,
    entry: &SceneEntry,
    parent_hash: u64,
) -> SceneEvent {
    SceneEvent {
        kind: kind.into(),
        scene_id: entry.id,
        scene_hash: entry.scene.hash(),
        scene_version: entry.version,
        parent_hash,
        ..SceneEvent::default()
    }
}
