//! Frames of sensors: each makes its scene's next version, the newest of an object first.
//!
//! Nobody here touches a point: a thread reads a frame, and makes solids of it, while requests go
//! on with the version before. Frames are not kept on the disk; a daemon that is started again waits
//! for the next one, as requests in that scene do.

use std::sync::Arc;

use taut::scene::{Scene, SceneError, SensedFrame};
use taut::store::{PreparedScene, Snapshot};
use taut_ipc::control::{CloudFrame, ControlReply, FrameSummary, Refusal};
use taut_ipc::wire::{Code, SceneEventKind, label_id};

use super::Service;
use super::control::{Replied, scene_event};
use super::effect::{FrameTask, InOrder};
use super::event::{Framed, Ticket};
use super::keeping::{Acknowledgement, Changed};
use crate::daemon::translate::{Scenery, TakenFrame, scene_refusal, store_refusal, wanted_newest};

/// Versions by frames of which one is written down, so that no version is named twice after a
/// restart.
pub(crate) const FRAMES_PER_ENTRY: u64 = 1000;

impl Service {
    /// Has a frame read; the reply comes then.
    pub(super) fn frame(
        &mut self,
        ticket: Ticket,
        label: String,
        object: String,
        frame: Box<CloudFrame>,
    ) -> Replied {
        let scenery = self.scenery(&label, &object, &frame)?;
        let task = FrameTask {
            ticket,
            label,
            object,
            frame,
            scenery,
        };
        self.in_order(InOrder::Frame(Box::new(task)));
        Ok(None)
    }

    /// What a frame is seen among.
    fn scenery(
        &mut self,
        label: &str,
        object: &str,
        frame: &CloudFrame,
    ) -> Result<Scenery, Refusal> {
        let entry = self
            .store
            .scene(label)
            .map_err(|error| store_refusal(&error))?;
        let scene = entry.scene.clone();
        let sensing = scene
            .sensing(object)
            .map_err(|error| scene_refusal(&error))?;
        let sensing = sensing.clone();
        Ok(Scenery {
            scene: self.prepared(&scene),
            sensing,
            robot: self.robot_in_view(label, &frame.robot)?,
            now_ns: self.now_ns,
        })
    }

    fn prepared(&self, scene: &Arc<Scene>) -> Arc<PreparedScene> {
        let known = self.store.prepared_scene(scene).cloned();
        known.unwrap_or_else(|| Arc::new(PreparedScene::new(scene.clone())))
    }

    /// The robot that may be in a picture, with what it carries.
    fn robot_in_view(&mut self, scene: &str, robot: &str) -> Result<Option<Snapshot>, Refusal> {
        if robot.is_empty() {
            return Ok(None);
        }
        self.store
            .robot(robot)
            .map_err(|error| store_refusal(&error))?;
        let snapshot = self
            .store
            .snapshot(&wanted_newest(robot, scene));
        snapshot
            .map(Some)
            .map_err(|error| store_refusal(&error))
    }

    /// Takes a frame that was read into its scene, which may have changed meanwhile.
    pub(super) fn framed(&mut self, framed: Framed) {
        let Framed {
            ticket,
            label,
            object,
            taken,
        } = framed;
        let replied = taken.and_then(|taken| self.take_frame(ticket, &label, &object, taken));
        if let Err(Refusal { code, message, .. }) = &replied {
            tracing::info!(label, object, code, "frame not taken: {message}");
        }
        self.tell_reply(ticket, replied);
    }

    fn take_frame(
        &mut self,
        ticket: Ticket,
        label: &str,
        object: &str,
        taken: TakenFrame,
    ) -> Replied {
        let parent_hash = self.hash_named(label);
        let prepared = self.with_frame(label, object, &taken)?;
        let hash = prepared.scene().hash();
        let change = self
            .store
            .insert_prepared_scene(label, prepared, true);
        change.map_err(|error| store_refusal(&error))?;
        self.have_made_in(hash);
        self.recheck_watches(label_id(label));
        let entry = self
            .store
            .scene(label)
            .map_err(|error| store_refusal(&error))?;
        let told = Acknowledgement {
            ticket,
            answer: ControlReply::Framed(Box::new(summary(label, object, entry, &taken))),
            event: Some(scene_event(SceneEventKind::Changed, entry, parent_hash)),
        };
        match entry.version.is_multiple_of(FRAMES_PER_ENTRY) {
            true => self.keep(&Changed::Scene(label.to_owned()), told),
            false => self.keeping.pass(told),
        }
        Ok(None)
    }

    /// The scene as it is now with the frame in it.
    fn with_frame(
        &self,
        label: &str,
        object: &str,
        taken: &TakenFrame,
    ) -> Result<Arc<PreparedScene>, Refusal> {
        let entry = self
            .store
            .scene(label)
            .map_err(|error| store_refusal(&error))?;
        let refused = |error: SceneError| scene_refusal(&error);
        let sensing = entry.scene.sensing(object).map_err(refused)?;
        check_newer(object, sensing.frame.as_ref(), &taken.frame)?;
        if entry.scene.hash() == taken.before {
            return Ok(taken.prepared.clone());
        }
        let scene = entry
            .scene
            .with_frame(object, taken.pose, taken.shapes.clone(), taken.frame)
            .map_err(refused)?;
        let after = PreparedScene::after(&taken.prepared, Arc::new(scene));
        Ok(Arc::new(after))
    }

    /// Has the models made of robots in this scene, before somebody asks for them.
    fn have_made_in(&mut self, scene: u64) {
        let models: Vec<_> = self.store.models_in(scene).cloned().collect();
        for model in models {
            self.have_made(&model);
        }
    }
}

/// Refuses a frame that is not newer than the last.
fn check_newer(
    object: &str,
    last: Option<&SensedFrame>,
    frame: &SensedFrame,
) -> Result<(), Refusal> {
    match last {
        Some(last) if frame.taken_ns <= last.taken_ns => {
            let text = format!(
                "object {object:?}: a frame of {} ns is not newer than its last, of {} ns; send the next",
                frame.taken_ns, last.taken_ns
            );
            Err(Refusal::new(Code::Preempted, text))
        }
        _ => Ok(()),
    }
}

fn summary(
    label: &str,
    object: &str,
    entry: &taut::store::SceneEntry,
    taken: &TakenFrame,
) -> FrameSummary {
    let SensedFrame {
        taken_ns: _,
        came,
        not_finite,
        on_robot,
        in_padding,
        thinned,
        points,
    } = taken.frame;
    FrameSummary {
        label: label.to_owned(),
        object: object.to_owned(),
        scene_version: entry.version,
        scene_hash: entry.scene.hash(),
        came,
        not_finite,
        on_robot,
        in_padding,
        thinned,
        points,
        warnings: taken.warnings.clone(),
    }
}
