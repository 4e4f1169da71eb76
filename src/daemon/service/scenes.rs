//! Scenes that live: diffs, texts of versions, pins.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use taut::scene::diff_file::{DiffFile, SceneDiff};
use taut::scene::{Scene, SceneError};
use taut::store::StoreError;
use taut_ipc::control::{ControlReply, Files, Refusal, SceneText};

use super::Service;
use super::control::Replied;
use super::effect::{Source, Work};
use super::event::{Content, Purpose, Ticket};
use crate::daemon::translate::{name_refusal, scene_refusal, scene_summary, store_refusal, worlds};

/// Longest diff (bytes) that is read at once. That takes less than a hop to
/// another thread and back takes on a busy machine, and a MOVE, of which there may be hundreds a
/// second, never waits behind a diff that reads meshes.
const SHORT_DIFF: usize = 16 * 1024;

impl Service {
    /// Changes a scene: at once where the diff is short and names no mesh file, else when the
    /// loader has read it.
    pub(super) fn diff_scene(
        &mut self,
        ticket: Ticket,
        label: String,
        purpose: Purpose,
        (json, file): (String, PathBuf),
        files: Option<&Files>,
    ) -> Replied {
        match short_diff(&json).transpose() {
            Some(diff) => {
                let diff = diff.map_err(|error| refusal_in(&file, &error))?;
                self.take(ticket, &label, purpose, Content::Diff(diff))
            }
            None => self.load_from(ticket, label, purpose, Source::Diff(json, file), files),
        }
    }

    /// The scene that a diff makes of the newest version; nothing is changed yet.
    pub(crate) fn changed_scene(
        &self,
        label: &str,
        base_version: u64,
        diff: &SceneDiff,
    ) -> Result<Arc<Scene>, Refusal> {
        let base = self.store.base_scene(label, base_version);
        let base = base.map_err(|error| store_refusal(&error))?;
        let changed = diff.apply_among(base, &worlds(&self.store));
        let scene = changed.map_err(|error| scene_refusal(&error))?;
        name_refusal(diff, &scene, &self.store)?;
        Ok(Arc::new(scene))
    }

    /// Pins a version or lets it go.
    pub(crate) fn pin_scene(
        &mut self,
        label: &str,
        version: u64,
        pinned: bool,
    ) -> Result<ControlReply, Refusal> {
        let entry = match pinned {
            true => self.store.pin_scene(label, version),
            false => self.store.unpin_scene(label, version),
        };
        match entry {
            Ok(entry) => Ok(ControlReply::Scene(scene_summary(
                label,
                entry,
                self.now_ns,
            ))),
            Err(error) => Err(store_refusal(&error)),
        }
    }

    /// Has a version written as text, or what leads to it from another one.
    pub(super) fn show_scene(
        &mut self,
        ticket: Ticket,
        label: &str,
        version: u64,
        base_version: u64,
    ) -> Replied {
        let work = self.shown_scenes(label, version, base_version);
        self.have_done(ticket, work.map_err(|error| store_refusal(&error))?);
        Ok(None)
    }

    fn shown_scenes(
        &self,
        label: &str,
        version: u64,
        base_version: u64,
    ) -> Result<Work, StoreError> {
        let newest = self.store.scene(label)?.version;
        let scene = self.store.scene_at(label, version)?.clone();
        let base = (base_version != 0)
            .then(|| {
                self.store
                    .scene_at(label, base_version)
                    .cloned()
            })
            .transpose()?;
        let answer = SceneText {
            label: label.to_owned(),
            version: if version == 0 { newest } else { version },
            scene_hash: scene.hash(),
            base_version,
            ..SceneText::default()
        };
        Ok(Work::Write {
            answer,
            scene,
            base,
        })
    }
}

/// The diff of a short text that names no mesh file.
fn short_diff(json: &str) -> Result<Option<SceneDiff>, SceneError> {
    match json.len() {
        ..=SHORT_DIFF => without_files(json),
        _ => Ok(None),
    }
}

fn without_files(json: &str) -> Result<Option<SceneDiff>, SceneError> {
    let file = DiffFile::parse(json)?;
    match file.names_files() {
        true => Ok(None),
        false => SceneDiff::try_from(file).map(Some),
    }
}

/// Why a scene is refused, with the file that messages call it.
fn refusal_in(file: &Path, error: &SceneError) -> Refusal {
    let refusal = scene_refusal(error);
    Refusal {
        message: format!("{}: {}", file.display(), refusal.message),
        ..refusal
    }
}
