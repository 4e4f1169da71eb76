//! What a cloud shows of the robot itself, left out by the robot's exact bodies.

use std::path::PathBuf;
use std::sync::Arc;

use taut::collision::{CollisionModel, OwnBodies};
use taut::files::{Packages, Reader, RobotFiles, srdf_of};
use taut::math::Pose;
use taut::robot::{Kinematics, RobotModel, StandError, stand};
use taut::scene::Scene;
use taut::shape::sensed::{Draft, Seen};
use taut::warning::{Warning, grouped};

use crate::cli::error::CliError;
use crate::cli::load::robot_in;
use crate::cli::quantity;

/// Where the robot stood when the sensor looked, and how much around it is left out.
#[derive(clap::Args)]
pub(super) struct SelfFilter {
    /// Where each joint stood when the sensor looked, as 'NAME=VALUE …' (rad or m): points on the robot are left out
    #[arg(long, value_name = "VALUES", requires_all = ["robot", "self_padding"])]
    at: Option<String>,
    /// Leave out what is no farther than this from the robot's bodies as well: the sensor's noise
    #[arg(long, value_name = "LENGTH", value_parser = quantity::metres, requires = "at")]
    self_padding: Option<f64>,
    /// URDF of the robot
    #[arg(long, value_name = "URDF", requires = "at")]
    robot: Option<PathBuf>,
    /// SRDF of the robot, where it is not beside the URDF
    #[arg(long, value_name = "SRDF", requires = "robot")]
    srdf: Option<PathBuf>,
    /// Scene file with what the robot carries, and the frame of the pose
    #[arg(long = "carried", value_name = "FILE", requires = "robot")]
    scene: Option<PathBuf>,
    /// Folder of a package that the robot names as package://NAME/
    #[arg(long = "package", value_name = "NAME=FOLDER", value_parser = quantity::package)]
    packages: Vec<(String, PathBuf)>,
}

/// The robot as it stood, in the cloud's frame.
pub(super) struct Own {
    bodies: OwnBodies,
    /// Of the cloud's frame, in the world.
    pose: Pose,
    padding: f64,
}

impl SelfFilter {
    /// The robot as it stood, where that is given. The cloud's frame has `pose` in `frame`.
    pub(super) fn own(&self, frame: &str, pose: &Pose) -> Result<Option<Own>, CliError> {
        let (Some(at), Some(urdf), Some(padding)) = (&self.at, &self.robot, self.self_padding)
        else {
            return Ok(None);
        };
        let packages = quantity::packages(&self.packages);
        let mut reader = Reader::new(Packages::with_environment(packages.clone()));
        let files = RobotFiles {
            urdf: urdf.clone(),
            srdf: self.srdf.clone().or_else(|| srdf_of(urdf)),
            packages,
            ..RobotFiles::default()
        };
        let robot = Arc::new(robot_in(&mut reader, &files)?);
        let scene = match &self.scene {
            Some(file) => reader.scene(file)?,
            None => Scene::default(),
        };
        let kinematics = stood(&robot, at)?;
        let placed = scene.in_world(frame, pose);
        let pose = placed.map_err(|error| {
            CliError::Choice(format!(
                "{error}; give the scene that has it: --carried FILE"
            ))
        })?;
        let model = CollisionModel::new(robot, Arc::new(scene));
        let model = model.map_err(|source| CliError::Model {
            name: urdf.display().to_string(),
            source: Box::new(source),
        })?;
        Ok(Some(Own {
            bodies: OwnBodies::of(&model, &kinematics),
            pose,
            padding,
        }))
    }
}

/// Where the joints stood, each by its name.
fn stood(robot: &RobotModel, text: &str) -> Result<Kinematics, CliError> {
    let values = text
        .split([' ', ','])
        .filter(|part| !part.is_empty())
        .map(|part| quantity::value(part).map_err(|said| format!("{part:?}: {said}")))
        .collect::<Result<Vec<_>, String>>()
        .map_err(|reason| CliError::Usage(format!("--at {reason}")))?;
    stand(robot, &values).map_err(|error| {
        CliError::Choice(match error {
            StandError::Missing(names) => format!(
                "--at does not say where {names} stood; what a sensor sees of the robot depends on every joint"
            ),
            error => format!("--at: {error}"),
        })
    })
}

impl Own {
    /// Leaves out what is the robot's, and says how much that is.
    pub(super) fn leave_out(&mut self, draft: &mut Draft) {
        let mut beside = 0;
        let left_out = draft.leave_out(|seen: &Seen| {
            let pose = self.pose * Pose::from_translation(seen.center);
            let distance = self
                .bodies
                .within(&pose, seen.half, self.padding);
            beside += usize::from(distance.is_some_and(|distance| distance > 0.0));
            distance.is_some()
        });
        let text = words(left_out, beside, self.padding);
        eprintln!("{text}");
        draft.warn(Warning::uncovered(text));
    }
}

fn words([seen, unknown]: [usize; 2], beside: usize, padding: f64) -> String {
    let unknown = match unknown {
        0 => String::new(),
        unknown => format!(" and {} unknown cells", grouped(unknown)),
    };
    format!(
        "{} points or cells{unknown} on the robot, or within {:.1} mm of it, are left out; {} of them do not touch it: the padding may hide as many that are something else",
        grouped(seen),
        padding * 1e3,
        grouped(beside)
    )
}
