//! Robots and scenes of the daemon: load, change, look.

use super::PlannerError;
use super::connection::Planner;
use crate::control::{
    ControlReply, ControlRequest, Listing, RobotDescription, RobotSource, SceneSummary, SceneText,
};
use std::path::Path;
use std::sync::{Arc, PoisonError};

/// Label of the scene with nothing in it, which requests without a scene are computed with.
pub const EMPTY_SCENE: &str = "empty@00000000";

impl Planner {
    /// What is loaded.
    ///
    /// # Errors
    /// As [`Self::control`], like all of these.
    pub fn list(&self) -> Result<Listing, PlannerError> {
        match self.control(&ControlRequest::List)? {
            ControlReply::Listing(listing) => Ok(listing),
            other => Err(PlannerError::unexpected(&other)),
        }
    }

    /// Loads a robot under a label; with `replace`, even if that names another one.
    ///
    /// # Errors
    /// A file that is none or that the daemon cannot read, a label that is taken.
    pub fn load_robot(
        &self,
        label: &str,
        source: &RobotSource,
        replace: bool,
    ) -> Result<Arc<RobotDescription>, PlannerError> {
        let label = label.to_owned();
        let source = source.clone();
        self.robot_after(&ControlRequest::LoadRobot {
            label,
            source,
            replace,
            files: None,
        })
    }

    /// What a control message about a robot comes back with; from then on it is the robot that its
    /// label names.
    ///
    /// # Errors
    /// As [`Self::control`].
    pub fn robot_after(
        &self,
        message: &ControlRequest,
    ) -> Result<Arc<RobotDescription>, PlannerError> {
        match self.control(message)? {
            ControlReply::Robot(robot) => Ok(Arc::new(*robot)),
            other => Err(PlannerError::unexpected(&other)),
        }
    }

    /// Forgets a robot; running requests keep it.
    ///
    /// # Errors
    /// An unknown label.
    pub fn unload_robot(&self, label: &str) -> Result<(), PlannerError> {
        self.known().remove(label);
        self.control(&ControlRequest::UnloadRobot {
            label: label.to_owned(),
        })
        .map(drop)
    }

    /// Loads a scene (JSON, as scene files are) under a label. Mesh files in it start from
    /// `base_dir`.
    ///
    /// # Errors
    /// A text that is no scene, a label that is taken.
    pub fn load_scene(
        &self,
        label: &str,
        json: &str,
        base_dir: Option<&Path>,
        replace: bool,
    ) -> Result<SceneSummary, PlannerError> {
        let label = label.to_owned();
        let json = json.to_owned();
        let base_dir = base_dir.map(Path::to_owned);
        self.scene_after(&ControlRequest::LoadScene {
            label,
            json,
            base_dir,
            replace,
            files: None,
            version: None,
        })
    }

    /// Forgets a scene with its versions; running requests keep theirs.
    ///
    /// # Errors
    /// An unknown label, a pinned version.
    pub fn unload_scene(&self, label: &str) -> Result<(), PlannerError> {
        self.control(&ControlRequest::UnloadScene {
            label: label.to_owned(),
        })
        .map(drop)
    }

    /// Makes a diff's changes (JSON, see [`super::words`]), all or none: the scene's next version.
    /// The scene has to have `base_version`, 0 being any.
    ///
    /// # Errors
    /// A text that is no diff, unknown objects and links, another base.
    pub fn change_scene(
        &self,
        label: &str,
        json: &str,
        base_dir: Option<&Path>,
        base_version: u64,
    ) -> Result<SceneSummary, PlannerError> {
        let label = label.to_owned();
        let json = json.to_owned();
        let base_dir = base_dir.map(Path::to_owned);
        self.scene_after(&ControlRequest::DiffScene {
            label,
            json,
            base_dir,
            base_version,
            files: None,
            version: None,
        })
    }

    /// The text of a version, 0 being the newest; as a diff against `base_version` where that is
    /// not 0.
    ///
    /// # Errors
    /// An unknown label or version.
    pub fn show_scene(
        &self,
        label: &str,
        version: u64,
        base_version: u64,
    ) -> Result<SceneText, PlannerError> {
        match self.control(&ControlRequest::ShowScene {
            label: label.to_owned(),
            version,
            base_version,
        })? {
            ControlReply::SceneText(text) => Ok(text),
            other => Err(PlannerError::unexpected(&other)),
        }
    }

    /// Keeps a version, 0 being the newest, until it is let go.
    ///
    /// # Errors
    /// An unknown label or version.
    pub fn pin_scene(
        &self,
        label: &str,
        version: u64,
        pinned: bool,
    ) -> Result<SceneSummary, PlannerError> {
        self.scene_after(&ControlRequest::PinScene {
            label: label.to_owned(),
            version,
            pinned,
        })
    }

    /// What a control message about a scene comes back with.
    ///
    /// # Errors
    /// As [`Self::control`].
    pub fn scene_after(&self, message: &ControlRequest) -> Result<SceneSummary, PlannerError> {
        match self.control(message)? {
            ControlReply::Scene(scene) => Ok(scene),
            other => Err(PlannerError::unexpected(&other)),
        }
    }

    /// The scene with nothing in it, loaded if it is not.
    ///
    /// # Errors
    /// As [`Self::control`].
    pub fn empty_scene(&self) -> Result<&'static str, PlannerError> {
        let mut loaded = self
            .empty_scene
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let boot = self.link.boot_id();
        if boot.is_none() || *loaded != boot {
            self.load_scene(EMPTY_SCENE, r#"{"objects": []}"#, None, false)?;
            *loaded = boot;
        }
        Ok(EMPTY_SCENE)
    }
}
