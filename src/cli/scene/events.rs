//! `taut scene watch`.

use std::io::Write;
use std::time::Duration;

use serde_json::json;
use taut_ipc::client::Loss;
use taut_ipc::planner::Planner;
use taut_ipc::wire::{SceneEvent, SceneEventKind, label_id};
use taut_ipc::{Client, ClientError, DaemonState};

use crate::cli::error::{CliError, stdout};
use crate::cli::format::Format;
use crate::cli::instance::InstanceChoice;

/// How often it looks for events, which do not wake who listens; nothing is lost in between.
const LOOK: Duration = Duration::from_millis(50);

/// Prints changes of one scene, or of all, as they happen.
pub(super) fn watch(
    instance: &InstanceChoice,
    label: Option<&str>,
    count: Option<u64>,
    format: Format,
) -> Result<u8, CliError> {
    let mut watched = Watched::connect(instance)?;
    let feed = watched.client.scene_event_feed()?;
    let mut seen = 0;
    while count.is_none_or(|count| seen < count) {
        let event = watched.next(|| feed.next())?;
        if label.is_some_and(|label| label_id(label) != event.scene_id) {
            continue;
        }
        print(&event, &watched.name(event.scene_id)?, format)?;
        seen += 1;
    }
    Ok(0)
}

/// The scenes of a daemon as long as it lives.
struct Watched {
    client: Client,
    planner: Planner,
    /// The daemon that was found first.
    daemon: DaemonState,
    /// Where that daemon is.
    root: String,
    labels: Vec<String>,
}

impl Watched {
    fn connect(instance: &InstanceChoice) -> Result<Self, CliError> {
        let instance = instance.instance()?;
        let client = Client::connect(&instance)?;
        let planner = Planner::new(client.clone());
        Ok(Self {
            daemon: client.daemon_state(),
            root: instance.root().display().to_string(),
            labels: labels(&planner)?,
            planner,
            client,
        })
    }

    /// Waits for what happens next.
    fn next(
        &self,
        look: impl Fn() -> Result<Option<SceneEvent>, ClientError>,
    ) -> Result<SceneEvent, CliError> {
        loop {
            if let Some(event) = look()? {
                return Ok(event);
            }
            self.check_daemon()?;
            std::thread::sleep(LOOK);
        }
    }

    fn check_daemon(&self) -> Result<(), CliError> {
        if self.client.daemon_state() == self.daemon {
            return Ok(());
        }
        Err(CliError::Client(ClientError::DaemonLost {
            root: self.root.clone(),
            loss: Loss::Unsubscribed,
        }))
    }

    /// The label of a scene, or its id where it is gone.
    fn name(&mut self, scene_id: u64) -> Result<String, CliError> {
        if self.label(scene_id).is_none() {
            self.labels = labels(&self.planner)?;
        }
        let known = self.label(scene_id).cloned();
        Ok(known.unwrap_or_else(|| format!("{scene_id:016x}")))
    }

    fn label(&self, scene_id: u64) -> Option<&String> {
        self.labels
            .iter()
            .find(|label| label_id(label) == scene_id)
    }
}

fn labels(planner: &Planner) -> Result<Vec<String>, CliError> {
    let scenes = planner.list()?.scenes;
    Ok(scenes
        .into_iter()
        .map(|scene| scene.label)
        .collect())
}

fn print(event: &SceneEvent, label: &str, format: Format) -> Result<(), CliError> {
    let line = match format {
        Format::Json => json_of(event, label).to_string(),
        Format::Table => line_of(event, label),
    };
    let mut out = std::io::stdout().lock();
    writeln!(out, "{line}")
        .and_then(|()| out.flush())
        .map_err(stdout)
}

fn kind_of(event: &SceneEvent) -> &'static str {
    match SceneEventKind::try_from(event.kind) {
        Ok(SceneEventKind::Created) => "created",
        Ok(SceneEventKind::Changed) => "changed",
        Ok(SceneEventKind::Deleted) => "deleted",
        Ok(SceneEventKind::PathUnsafe) => "path unsafe",
        Err(_) => "unknown event",
    }
}

fn is_of_a_path(event: &SceneEvent) -> bool {
    event.kind == u32::from(SceneEventKind::PathUnsafe)
}

fn json_of(event: &SceneEvent, label: &str) -> serde_json::Value {
    let mut value = json!({
        "event": kind_of(event),
        "scene": label,
        "version": event.scene_version,
        "hash": format!("{:016x}", event.scene_hash),
    });
    if is_of_a_path(event) {
        value["request"] = format!("{:016x}", event.subscription).into();
        value["segment"] = event.segment.into();
    } else {
        value["parent_hash"] = format!("{:016x}", event.parent_hash).into();
    }
    value
}

fn line_of(event: &SceneEvent, label: &str) -> String {
    let head = format!(
        "scene {label} v{}   {}",
        event.scene_version,
        kind_of(event)
    );
    if is_of_a_path(event) {
        let segment = event.segment + 1;
        return format!(
            "{head}: request {:016x}, segment {segment}",
            event.subscription
        );
    }
    format!("{head}   hash {:016x}", event.scene_hash)
}
