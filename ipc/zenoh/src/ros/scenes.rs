//! Scenes that nodes say.

use super::refusal::Refusal;
use std::sync::{Mutex, MutexGuard, PoisonError};
use taut_ipc::control::SceneSummary;
use taut_ipc::planner::Planner;
use taut_ipc::wire::Code;
use taut_ros::messages::moveit_msgs::PlanningScene;

/// The scene of the daemon that nodes change.
#[derive(Debug)]
pub(super) struct Scenes {
    planner: Planner,
    label: String,
    /// One change after another, as they came.
    order: Mutex<()>,
    /// How it differs from the one that is followed.
    behind: Mutex<Option<String>>,
}

impl Scenes {
    pub fn new(planner: Planner, label: &str) -> Self {
        Self {
            planner,
            label: label.to_owned(),
            order: Mutex::default(),
            behind: Mutex::default(),
        }
    }

    /// Takes a whole scene, or makes a diff's changes, all or none.
    ///
    /// # Errors
    /// What the daemon says against it.
    pub fn take(&self, scene: &PlanningScene) -> Result<SceneSummary, Refusal> {
        // MoveIt's message as JSON is what scene files are: numbers that are none become null there,
        // which the daemon refuses by name.
        let json = serde_json::to_string(scene)
            .map_err(|error| Refusal::new(Code::MalformedRequest, error.to_string()))?;
        let _one = self
            .order
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let (planner, label) = (&self.planner, &self.label);
        let summary = match scene.is_diff {
            true => planner.change_scene(label, &json, None, 0)?,
            false => planner.load_scene(label, &json, None, true)?,
        };
        let (version, objects) = (summary.version, summary.objects);
        tracing::info!(version, objects, "scene {label}");
        Ok(summary)
    }

    /// What answers have to say while the scene is not the one that is followed.
    pub fn behind(&self) -> Option<String> {
        self.lock().clone()
    }

    /// Says why it is not, or that it is.
    pub fn set_behind(&self, why: Option<String>) {
        let mut behind = self.lock();
        if let Some(why) = why
            .as_ref()
            .filter(|why| behind.as_ref() != Some(why))
        {
            tracing::warn!("{why}");
        }
        *behind = why;
    }

    fn lock(&self) -> MutexGuard<'_, Option<String>> {
        self.behind
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}
