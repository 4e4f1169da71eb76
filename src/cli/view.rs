//! `taut view`: an answer as a page to look at.

use std::path::{Path, PathBuf};

use taut::files::{self, FileError, Packages, Reader, ResultFile, RobotFiles};
use taut::robot::RobotModel;
use taut::scene::Scene;
use taut::shape::MeshError;

use super::error::CliError;
use super::format::print_line;
use super::load::robot_in;
use super::quantity;
use crate::view::{Picture, Sight, page};

/// Write a page that shows an answer: robot, scene, the path before and after, contacts, and how it
/// came about
///
/// The page is one file and needs no network; any browser with WebGL shows it.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Answer: what `taut shorten … --out RESULT.json` writes, or `--format json` prints
    file: PathBuf,
    /// Page to write; the default is the answer's name with .html
    #[arg(long, short, value_name = "HTML")]
    out: Option<PathBuf>,
    /// URDF to show in place of the one that the answer names
    #[arg(long, value_name = "URDF")]
    robot: Option<PathBuf>,
    /// SRDF of --robot, where it is not beside it
    #[arg(long, value_name = "SRDF", requires = "robot")]
    srdf: Option<PathBuf>,
    /// Scene to show in place of the one that is in the answer
    #[arg(long, value_name = "FILE")]
    scene: Option<PathBuf>,
    /// Folder of a package that a robot names as package://NAME/
    #[arg(long = "package", value_name = "NAME=FOLDER", value_parser = quantity::package)]
    packages: Vec<(String, PathBuf)>,
}

/// Writes the page.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    let text = page(&picture(arguments)?);
    let file = arguments
        .out
        .clone()
        .unwrap_or_else(|| arguments.file.with_extension("html"));
    std::fs::write(&file, &text).map_err(CliError::output(&file))?;
    tell(&file, text.len())?;
    Ok(0)
}

fn tell(file: &Path, bytes: usize) -> Result<(), CliError> {
    let size = bytes as f64 / 1e6;
    print_line(&format!(
        "{}   {size:.1} MB   open it in a browser",
        file.display()
    ))
}

/// The answer with its robot and its scene; warns of what is not shown as it was.
fn picture(arguments: &Arguments) -> Result<Picture, CliError> {
    let result = ResultFile::read(&arguments.file)?;
    let mut reader = Reader::new(Packages::with_environment(quantity::packages(
        &arguments.packages,
    )));
    let files = robot_files(arguments, &result)?;
    let (visuals, missing) = reader.visuals(&files)?;
    let robot = robot_in(&mut reader, &files)?;
    let scene = scene(arguments, &result, &mut reader)?;
    let mut notes = Vec::from_iter(missing_visuals(&missing));
    notes.extend(other_models(&result, &robot, &scene));
    for note in &notes {
        eprintln!("warning: {note}");
    }
    Ok(Picture::of(Sight {
        result,
        robot: &robot,
        scene: &scene,
        visuals,
        notes,
    }))
}

fn missing_visuals(missing: &[String]) -> Option<String> {
    let first = missing.first()?;
    let count = missing.len();
    Some(format!(
        "{count} links show their collision shapes, since visual ones are missing; the first: {first}"
    ))
}

/// Which of robot and scene are not those that the answer is about.
fn other_models(result: &ResultFile, robot: &RobotModel, scene: &Scene) -> Vec<String> {
    let subject = &result.subject;
    [
        other_model("robot", robot.hash(), &subject.robot.hash),
        other_model("scene", scene.hash(), &subject.scene.hash),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn other_model(kind: &str, own: u64, wanted: &str) -> Option<String> {
    let own = format!("{own:016x}");
    (own != wanted).then(|| {
        format!("this {kind} has hash {own}, the answer is about {wanted}: it is not the same one")
    })
}

fn robot_files(arguments: &Arguments, result: &ResultFile) -> Result<RobotFiles, CliError> {
    if let Some(urdf) = &arguments.robot {
        return Ok(RobotFiles {
            urdf: urdf.clone(),
            srdf: arguments
                .srdf
                .clone()
                .or_else(|| files::srdf_of(urdf)),
            variables: Some(result.variables.clone()),
            ..RobotFiles::default()
        });
    }
    let robot = &result.subject.robot;
    let label = robot.label.as_deref().unwrap_or_default();
    robot
        .files
        .clone()
        .ok_or_else(|| no_files(label))
}

fn no_files(label: &str) -> CliError {
    CliError::Usage(format!(
        "the answer names its robot by the daemon's label {label:?}, not by files; \
         give --robot ROBOT.urdf, or look at it on the page of `taut serve --http`"
    ))
}

fn scene(
    arguments: &Arguments,
    result: &ResultFile,
    reader: &mut Reader,
) -> Result<Scene, CliError> {
    if let Some(file) = &arguments.scene {
        return Ok(reader.scene(file)?);
    }
    let content = result
        .subject
        .scene
        .content
        .clone()
        .ok_or_else(|| {
            CliError::Usage(
                "the answer does not hold its scene; give --scene SCENE.json".to_owned(),
            )
        })?;
    let refuse = |source| FileError::Scene {
        file: arguments.file.clone(),
        source,
    };
    let mut no_mesh = |name: &str, _| Err(mesh_not_held(name));
    Ok(content.build(&mut no_mesh).map_err(refuse)?)
}

fn mesh_not_held(name: &str) -> MeshError {
    MeshError::Unreadable {
        name: name.to_owned(),
        reason: "the answer holds no such mesh; give --scene SCENE.json".to_owned(),
    }
}
