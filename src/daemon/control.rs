//! Control messages: what changes the store, or asks about it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use taut::scene::diff_file::SceneDiff;
use taut::store::{Change, RobotEntry, SceneEntry, StoreError};
use taut_ipc::control::{ControlReply, ControlRequest, Listing, Refusal, SceneSummary, Stats};
use taut_ipc::monotonic_ns;
use taut_ipc::server::{IncomingControl, ServerError};
use taut_ipc::wire::{Code, SceneEvent, SceneEventKind, label_id};

use super::event::{Content, Loaded, Purpose};
use super::event_loop::{EventLoop, ROUND};
use super::keep::{refuse, reply};
use super::keeping::{Acknowledgement, Changed};
use super::loader::{Source, Work};
use super::metrics;
use super::reading::Reading;
use super::translate::{
    ReadRobot, describe, frame_refusal, model_states, robot_files, robot_summary, scene_state,
    scene_summary, selected_label, store_refusal,
};

/// Longest label, in bytes.
const LABEL_MAX: usize = 256;

impl EventLoop {
    /// Takes control messages; tells whether more may be waiting.
    pub(super) fn receive_controls(&mut self) -> Result<bool, ServerError> {
        for _ in 0..ROUND {
            match self.server.receive_control()? {
                Some(control) => self.received_control(control)?,
                None => return Ok(false),
            }
        }
        Ok(true)
    }

    fn received_control(&mut self, control: IncomingControl) -> Result<(), ServerError> {
        match control.message() {
            Ok(message) => self.obey(control, message)?,
            Err(refusal) => refuse(control, refusal),
        }
        Ok(())
    }

    fn obey(
        &mut self,
        control: IncomingControl,
        message: ControlRequest,
    ) -> Result<(), ServerError> {
        match message {
            ControlRequest::LoadRobot {
                label,
                source,
                replace,
            } => {
                let source = Source::Robot(robot_files(source));
                self.load(control, label, Purpose::Load { replace }, source);
            }
            ControlRequest::SelectVariables { label, variables } => {
                self.select_variables(control, &label, variables);
            }
            ControlRequest::LoadScene {
                label,
                json,
                base_dir,
                replace,
            } => {
                let source = Source::Scene(json, file_of(&label, base_dir));
                self.load(control, label, Purpose::Load { replace }, source);
            }
            ControlRequest::DiffScene {
                label,
                json,
                base_dir,
                base_version,
            } => {
                let file = file_of(&label, base_dir);
                self.diff_scene(control, label, base_version, json, file)?;
            }
            ControlRequest::ShowScene {
                label,
                version,
                base_version,
            } => {
                self.show_scene(control, &label, version, base_version);
            }
            ControlRequest::Record { file } => self.record(control, file),
            ControlRequest::EndRecording => self.end_recording(control),
            ControlRequest::Bundle { id, file } => self.bundle(control, &id, file),
            ControlRequest::UnloadRobot { label } => self.unload_robot(control, label)?,
            ControlRequest::UnloadScene { label } => self.unload_scene(control, label)?,
            message => {
                let answer = self.control(message);
                reply(control, &answer.unwrap_or_else(ControlReply::Refused));
            }
        }
        Ok(())
    }

    /// Answers what changes nothing in the store.
    fn control(&mut self, message: ControlRequest) -> Result<ControlReply, Refusal> {
        match message {
            ControlRequest::Describe { label } => self.describe(&label),
            ControlRequest::List => Ok(ControlReply::Listing(self.listing())),
            ControlRequest::Stats => Ok(ControlReply::Stats(self.stats())),
            ControlRequest::Clients => {
                let summaries = self.clients.summaries(monotonic_ns());
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
                    |reading| reading.refusal(monotonic_ns()),
                ))
            }
        }
    }

    fn unload_robot(&mut self, control: IncomingControl, label: String) -> Result<(), ServerError> {
        if let Err(error) = self.store.remove_robot(&label) {
            refuse(control, store_refusal(&error));
            return Ok(());
        }
        self.recheck_watches(label_id(&label));
        let told = Acknowledgement::done(control, None);
        self.keep(&Changed::Robot(label), told)
    }

    fn unload_scene(&mut self, control: IncomingControl, label: String) -> Result<(), ServerError> {
        let entry = match self.store.remove_scene(&label) {
            Ok(entry) => entry,
            Err(error) => {
                refuse(control, store_refusal(&error));
                return Ok(());
            }
        };
        self.recheck_watches(entry.id);
        let event = scene_event(SceneEventKind::Deleted, &entry);
        let told = Acknowledgement::done(control, Some(event));
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
        if let Err(refusal) = check_load(&label, &source) {
            return refuse(control, refusal);
        }
        let reading = Reading::new(&label, source.is_robot(), monotonic_ns());
        let reading = Arc::new(reading);
        if matches!(purpose, Purpose::Load { .. }) {
            self.loading.begin(&label, reading.clone());
        }
        let work = Work::Read {
            label,
            purpose,
            source,
            reading,
        };
        self.hand_over(control, work);
    }

    /// Has a loaded robot made with these variables only.
    fn select_variables(&mut self, control: IncomingControl, label: &str, variables: Vec<String>) {
        match self.store.whole(label) {
            Ok(alone) => {
                let selected = selected_label(label, &variables);
                let purpose = Purpose::Load { replace: true };
                self.load(
                    control,
                    selected,
                    purpose,
                    Source::Variables(alone, variables),
                );
            }
            Err(error) => refuse(control, store_refusal(&error)),
        }
    }

    /// Gives work to the loader; the control request waits for it.
    pub(super) fn hand_over(&mut self, control: IncomingControl, work: Work) {
        let token = self.next_number();
        self.loading.wait(control, token);
        self.loading.send(token, work);
    }

    /// Answers a control request with what the loader has made for it.
    pub(super) fn answer_control(&mut self, token: u64, answer: &ControlReply) {
        if let Some(control) = self.loading.take(token) {
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
            self.loading.end(&label);
        }
        let control = self.loading.take(token);
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
            Ok(taken) => self.tell_taken(control, label, taken),
            Err(refusal) => {
                tell_not_taken(control, label, refusal);
                Ok(())
            }
        }
    }

    fn tell_taken(
        &mut self,
        control: Option<IncomingControl>,
        label: &str,
        taken: Taken,
    ) -> Result<(), ServerError> {
        let Taken {
            changed,
            answer,
            event,
        } = taken;
        if event.is_some() || matches!(changed, Changed::Robot(_)) {
            self.recheck_watches(label_id(label));
        }
        let told = Acknowledgement {
            control,
            answer,
            event,
        };
        self.keep(&changed, told)
    }

    fn insert(
        &mut self,
        label: &str,
        purpose: Purpose,
        content: Content,
    ) -> Result<Taken, Refusal> {
        match content {
            Content::Robot(robot) => self.insert_robot(label, robot, purpose.replaces()),
            Content::Diff(diff) => {
                let scene = self.changed_scene(label, purpose.base_version(), &diff)?;
                let change = self
                    .store
                    .insert_scene(label, scene, purpose.replaces());
                self.taken_scene(label, change, summary_after(&diff))
            }
            Content::Scene(scene) => {
                frame_refusal(scene.scene(), &self.store)?;
                let replace = purpose.replaces();
                let change = self
                    .store
                    .insert_prepared_scene(label, scene, replace);
                self.taken_scene(label, change, scene_summary)
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

    fn taken_scene(
        &self,
        label: &str,
        change: Result<Change, StoreError>,
        summary: Summary,
    ) -> Result<Taken, Refusal> {
        let change = change.map_err(refused)?;
        let entry = self.store.scene(label).map_err(refused)?;
        Ok(Taken {
            changed: Changed::Scene(label.to_owned()),
            answer: ControlReply::Scene(summary(label, entry)),
            event: kind_of(change).map(|kind| scene_event(kind, entry)),
        })
    }

    fn listing(&self) -> Listing {
        let robots = self.store.robots().iter();
        let scenes = self.store.scenes().iter();
        let robot = |(label, entry): (&String, &RobotEntry)| robot_summary(label, entry);
        let scene = |(label, entry): (&String, &SceneEntry)| scene_summary(label, entry);
        let now_ns = monotonic_ns();
        let reading = self.loading.labels().values();
        let mut models = model_states(&self.store, now_ns);
        models.extend(reading.map(|reading| reading.state(now_ns)));
        Listing {
            robots: robots.map(robot).collect(),
            scenes: scenes.map(scene).collect(),
            models,
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

/// What the store has taken, and what is told of it.
struct Taken {
    changed: Changed,
    answer: ControlReply,
    event: Option<SceneEvent>,
}

/// Sums up a scene.
type Summary = fn(&str, &SceneEntry) -> SceneSummary;

/// What is odd about shapes is known where they came, and looking at all of them takes its time.
fn summary_after(diff: &SceneDiff) -> Summary {
    if diff.may_be_odd() {
        scene_summary
    } else {
        scene_state
    }
}

fn tell_not_taken(control: Option<IncomingControl>, label: &str, refusal: Refusal) {
    tracing::info!(label, code = refusal.code, "not taken: {}", refusal.message);
    if let Some(control) = control {
        refuse(control, refusal);
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

/// Refuses a label that is too long, and files that are not named by absolute paths.
fn check_load(label: &str, source: &Source) -> Result<(), Refusal> {
    let bytes = label.len();
    if !(1..=LABEL_MAX).contains(&bytes) {
        let text = format!("a label of {bytes} bytes; valid: 1 to {LABEL_MAX}");
        return Err(malformed(text));
    }
    match source {
        Source::Robot(files) => check_absolute(&files.urdf),
        Source::Variables(..) | Source::Scene(..) | Source::Diff(..) => Ok(()),
    }
}

/// Refuses a relative path: the daemon has a folder of its own.
pub(super) fn check_absolute(file: &Path) -> Result<(), Refusal> {
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

fn scene_event(kind: SceneEventKind, entry: &SceneEntry) -> SceneEvent {
    SceneEvent {
        kind: kind.into(),
        scene_id: entry.id,
        scene_hash: entry.scene.hash(),
        scene_version: entry.version,
        ..SceneEvent::default()
    }
}
