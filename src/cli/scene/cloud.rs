//! `taut scene cloud`: a cloud or an octomap as an object of a scene.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use taut::files::FileError;
use taut::math::Pose;
use taut::scene::Obstacle;
use taut::scene::SceneChange;
use taut::scene::diff_file;
use taut::shape::cloud::{Making, Source, Unknown};
use taut::shape::sensed::Draft;
use taut::shape::{PlacedShape, Shape};

use super::common::{Common, change};
use super::own::{Own, SelfFilter};
use super::values;
use crate::cli::error::CliError;
use crate::cli::quantity;
use crate::cli::source::folder_of;

/// Id of an octomap's object, as MoveIt has it.
const OCTOMAP: &str = "<octomap>";

#[derive(clap::Args)]
#[command(group = clap::ArgGroup::new("sensed").required(true).args(["file", "octomap"]))]
pub(super) struct Arguments {
    /// Label of the scene
    label: String,
    /// Points of a sensor (PCD, npy or xyz)
    #[arg(requires = "radius")]
    file: Option<PathBuf>,
    /// Radius of each point; half of the points' spacing closes the surface between them
    #[arg(long, value_name = "LENGTH", value_parser = quantity::metres, conflicts_with = "octomap")]
    radius: Option<f64>,
    /// Keep one point for each cell of a grid with this edge; points become thicker by what that leaves out
    #[arg(long, value_name = "LENGTH", value_parser = quantity::metres, conflicts_with = "octomap")]
    thin: Option<f64>,
    /// An octomap (.bt or .ot) in place of points
    #[arg(long, value_name = "FILE", requires = "unknown")]
    octomap: Option<PathBuf>,
    /// What the octomap's unknown space is: nobody has seen it
    #[arg(long, value_parser = unknown, requires = "octomap")]
    unknown: Option<Unknown>,
    /// The object; one of this name is replaced [default: cloud, or <octomap>]
    #[arg(long, value_name = "NAME")]
    id: Option<String>,
    /// Where the file's frame is: x y z (m), or x y z qx qy qz qw
    #[arg(long, value_name = "NUMBER", num_args = 3..=7, allow_negative_numbers = true)]
    pose: Vec<f64>,
    /// Frame of the scene, or an object, that the pose is in; the world where it is missing
    #[arg(long, value_name = "NAME", default_value = "")]
    frame: String,
    #[command(flatten)]
    own: SelfFilter,
    /// Write the diff to a file, for `taut scene apply`, and send nothing
    #[arg(long, value_name = "FILE")]
    write: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

fn unknown(word: &str) -> Result<Unknown, String> {
    Unknown::named(word)
        .ok_or_else(|| "give free (paths may cross it) or obstacle (they may not)".to_owned())
}

/// Adds the object, or writes the diff that does.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    let (diff, folder) = arguments.diff()?;
    match &arguments.write {
        None => change(&arguments.common, &arguments.label, diff, folder, 0),
        Some(file) => {
            std::fs::write(file, diff).map_err(|error| unwritable(file, &error))?;
            Ok(0)
        }
    }
}

impl Arguments {
    fn file(&self) -> &Path {
        let file = self.file.as_ref().or(self.octomap.as_ref());
        file.expect("clap asks for one of them")
    }

    fn id(&self) -> &str {
        let default = match self.octomap {
            Some(_) => OCTOMAP,
            None => "cloud",
        };
        self.id.as_deref().unwrap_or(default)
    }

    fn making(&self) -> Making {
        match self.unknown {
            Some(unknown) => Making::Map { unknown },
            None => Making::Points {
                radius: self.radius.unwrap_or(f64::NAN),
                thin: self.thin,
            },
        }
    }

    /// The text of the diff, and the folder that its file is found from.
    fn diff(&self) -> Result<(String, Option<PathBuf>), CliError> {
        let object = match self.own.own(&self.frame, &self.given_pose()?)? {
            None => self.object()?,
            Some(own) => self.left_out(own)?,
        };
        let diff = json!({ "is_diff": true, "objects": [object] });
        Ok((diff.to_string(), folder_of(self.file())))
    }

    fn given_pose(&self) -> Result<Pose, CliError> {
        values::pose(&self.pose)
    }

    /// The object with the words that make its cloud of the file.
    fn object(&self) -> Result<Value, CliError> {
        let path = std::path::absolute(self.file());
        let path = path.map_err(|error| unreadable(self.file(), &error))?;
        let file = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy();
        let mut words = json!({ "file": file });
        match self.making() {
            Making::Points { radius, thin } => {
                words["radius"] = radius.into();
                words["thin"] = thin.into();
            }
            Making::Map { unknown } => words["unknown"] = unknown.word().into(),
        }
        let word = match self.octomap {
            Some(_) => "octomap",
            None => "cloud",
        };
        let mut object = self.placed(json!({}));
        object[word] = words;
        Ok(object)
    }

    /// The object with the cells that are not the robot's.
    fn left_out(&self, mut own: Own) -> Result<Value, CliError> {
        let bytes = std::fs::read(self.file()).map_err(|error| unreadable(self.file(), &error))?;
        let source = Source {
            file: self.file().display().to_string(),
            making: self.making(),
        };
        let refuse = |text| CliError::File(FileError::content(self.file(), text));
        let mut draft = Draft::read(source, &bytes).map_err(refuse)?;
        own.leave_out(&mut draft);
        let cloud = draft.cloud().map_err(refuse)?;
        let shape = Shape::Cloud(cloud.into());
        let pose = Pose::identity();
        let object = Obstacle::new(self.id(), vec![PlacedShape { pose, shape }]);
        let text = diff_file::text(&Default::default(), &[SceneChange::Add(object)], true);
        let text = text.map_err(|error| refuse(error.to_string()))?;
        let diff: Value = serde_json::from_str(&text).map_err(|error| refuse(error.to_string()))?;
        Ok(self.placed(diff["objects"][0].clone()))
    }

    fn placed(&self, mut object: Value) -> Value {
        object["id"] = self.id().into();
        object["operation"] = "ADD".into();
        if !self.frame.is_empty() {
            object["header"] = json!({ "frame_id": self.frame });
        }
        if let [x, y, z, turn @ ..] = &self.pose[..] {
            object["pose"] = json!({ "position": [x, y, z] });
            if let [qx, qy, qz, qw] = turn {
                object["pose"]["orientation"] = json!({ "x": qx, "y": qy, "z": qz, "w": qw });
            }
        }
        object
    }
}

fn unreadable(file: &Path, error: &std::io::Error) -> CliError {
    CliError::File(FileError::Unreadable {
        file: file.to_owned(),
        reason: error.to_string(),
    })
}

fn unwritable(file: &Path, error: &std::io::Error) -> CliError {
    unreadable(file, error)
}
