//! `taut scene watch`.

use std::io::Write;
use std::time::Duration;

use serde_json::json;
use taut_ipc::planner::Planner;
use taut_ipc::wire::{SceneEvent, SceneEventKind, label_id};
use taut_ipc::{Client, ClientError};

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
    let client = &Client::connect(&instance.instance()?)?;
    let planner = Planner::new(client.clone());
    let feed = client.scene_event_feed()?;
    let boot = client.daemon_state();
    let mut labels = labels(&planner)?;
    let mut seen = 0;
    while count.is_none_or(|count| seen < count) {
        let Some(event) = feed.next()? else {
            if client.daemon_state() != boot {
                let root = instance.instance()?.root().display().to_string();
                let reason = "it went away";
                return Err(CliError::Client(ClientError::DaemonLost { root, reason }));
            }
            std::thread::sleep(LOOK);
            continue;
        };
        if label.is_some_and(|label| label_id(label) != event.scene_id) {
            continue;
        }
        if !labels.iter().any(|label| label_id(label) == event.scene_id) {
            labels = self::labels(&planner)?;
        }
        let known = labels
            .iter()
            .find(|label| label_id(label) == event.scene_id);
        let name = known
            .cloned()
            .unwrap_or_else(|| format!("{:016x}", event.scene_id));
        print(&event, &name, format)?;
        seen += 1;
    }
    Ok(0)
}

fn labels(planner: &Planner) -> Result<Vec<String>, CliError> {
    let scenes = planner.list()?.scenes;
    Ok(scenes.into_iter().map(|scene| scene.label).collect())
}

fn print(event: &SceneEvent, label: &str, format: Format) -> Result<(), CliError> {
    let what = match SceneEventKind::try_from(event.kind) {
        Ok(SceneEventKind::Created) => "created",
        Ok(SceneEventKind::Changed) => "changed",
        Ok(SceneEventKind::Deleted) => "deleted",
        Ok(SceneEventKind::PathUnsafe) => "path unsafe",
        Err(_) => "unknown event",
    };
    let version = event.scene_version;
    let hash = format!("{:016x}", event.scene_hash);
    let is_path = event.kind == u32::from(SceneEventKind::PathUnsafe);
    let mut out = std::io::stdout().lock();
    match format {
        Format::Json => {
            let mut value =
                json!({ "event": what, "scene": label, "version": version, "hash": hash });
            if is_path {
                value["request"] = format!("{:016x}", event.subscription).into();
                value["segment"] = event.segment.into();
            }
            writeln!(out, "{value}")
        }
        Format::Table if is_path => {
            let request = event.subscription;
            let segment = event.segment + 1;
            writeln!(
                out,
                "scene {label} v{version}   {what}: request {request:016x}, segment {segment}"
            )
        }
        Format::Table => writeln!(out, "scene {label} v{version}   {what}   hash {hash}"),
    }
    .and_then(|()| out.flush())
    .map_err(stdout)
}
