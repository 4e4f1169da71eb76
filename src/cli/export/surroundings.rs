//! Robot and scene around a path that is exported.

use std::path::Path;
use std::sync::Arc;

use taut::files::{Packages, Reader, ResultFile};
use taut::robot::RobotModel;
use taut::scene::Scene;

use crate::cli::error::CliError;
use crate::cli::load;
use crate::cli::source::Source;

/// Robot and scene around a path.
pub(super) struct Surroundings {
    pub(super) robot: Arc<RobotModel>,
    pub(super) scene: Arc<Scene>,
}

impl Surroundings {
    /// Those that the arguments name, for the path in an answer.
    pub(super) fn given(answer: &Path, source: &Source) -> Result<Self, CliError> {
        let loaded = load::load(&mut load::reader(source), answer, source, false)?;
        Ok(Self {
            robot: loaded.robot,
            scene: loaded.scene,
        })
    }

    /// Those that an answer tells of; `None`, and a warning, where only a daemon has them.
    pub(super) fn of(result: &ResultFile) -> Result<Option<Self>, CliError> {
        let robot = &result.subject.robot;
        let scene = &result.subject.scene;
        let (Some(files), Some(content)) = (&robot.files, &scene.content) else {
            eprintln!(
                "warning: the answer has no files of robot and scene, so that they are not in the recording"
            );
            return Ok(None);
        };
        let mut reader = Reader::new(Packages::with_environment(files.packages.clone()));
        let robot = load::robot_in(&mut reader, files)?;
        let text =
            serde_json::to_string(content).expect("a scene holds only names and finite numbers");
        let scene = reader.scene_of_text(
            &text,
            scene
                .file
                .as_deref()
                .unwrap_or(Path::new("scene")),
        )?;
        Ok(Some(Self {
            robot: Arc::new(robot),
            scene: Arc::new(scene),
        }))
    }
}
