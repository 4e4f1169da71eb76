//! `taut view`: an answer as a page to look at.

use std::io::Write;
use std::path::PathBuf;

use taut::files::{self, FileError, Packages, Reader, ResultFile, RobotFiles};
use taut::robot::RobotModel;
use taut::scene::Scene;
use taut::shape::MeshError;

use super::error::{CliError, stdout};
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
    let result = ResultFile::read(&arguments.file)?;
    let mut reader = Reader::new(Packages::with_environment(quantity::packages(
        &arguments.packages,
    )));
    let files = robot_files(arguments, &result)?;
    let (visuals, missing) = reader.visuals(&files)?;
    let mut notes = Vec::from_iter(missing.first().map(|first| {
        let count = missing.len();
        format!("{count} links show their collision shapes, since visual ones are missing; the first: {first}")
    }));
    let robot = RobotModel::new(reader.robot_of(&files)?).map_err(|source| FileError::Robot {
        file: files.urdf.clone(),
        source,
    })?;
    let scene = scene(arguments, &result, &mut reader)?;
    for (kind, own, wanted) in [
        ("robot", robot.hash(), &result.subject.robot.hash),
        ("scene", scene.hash(), &result.subject.scene.hash),
    ] {
        let own = format!("{own:016x}");
        if own != *wanted {
            notes.push(format!(
                "this {kind} has hash {own}, the answer is about {wanted}: it is not the same one"
            ));
        }
    }
    for note in &notes {
        eprintln!("warning: {note}");
    }
    let picture = Picture::of(Sight {
        result,
        robot: &robot,
        scene: &scene,
        visuals,
        notes,
    });
    let file = arguments
        .out
        .clone()
        .unwrap_or_else(|| arguments.file.with_extension("html"));
    let text = page(&picture);
    std::fs::write(&file, &text).map_err(|source| CliError::Output {
        file: file.display().to_string(),
        source,
    })?;
    let size = text.len() as f64 / 1e6;
    writeln!(
        std::io::stdout(),
        "{}   {size:.1} MB   open it in a browser",
        file.display()
    )
    .map_err(stdout)?;
    Ok(0)
}

fn robot_files(arguments: &Arguments, result: &ResultFile) -> Result<RobotFiles, CliError> {
    if let Some(urdf) = &arguments.robot {
        return Ok(RobotFiles {
            urdf: urdf.clone(),
            srdf: arguments.srdf.clone().or_else(|| files::srdf_of(urdf)),
            variables: Some(result.variables.clone()),
            ..RobotFiles::default()
        });
    }
    let robot = &result.subject.robot;
    robot.files.clone().ok_or_else(|| {
        let label = robot.label.as_deref().unwrap_or_default();
        let text =
            format!("the answer names its robot by the daemon's label {label:?}, not by files");
        CliError::Usage(format!(
            "{text}; give --robot ROBOT.urdf, or look at it on the page of `taut serve --http`"
        ))
    })
}

fn scene(
    arguments: &Arguments,
    result: &ResultFile,
    reader: &mut Reader,
) -> Result<Scene, CliError> {
    if let Some(file) = &arguments.scene {
        return Ok(reader.scene(file)?);
    }
    let content = result.subject.scene.content.clone().ok_or_else(|| {
        CliError::Usage("the answer does not hold its scene; give --scene SCENE.json".to_owned())
    })?;
    let mut none = |name: &str, _| {
        let reason = "the answer holds no such mesh; give --scene SCENE.json".to_owned();
        Err(MeshError::Unreadable {
            name: name.to_owned(),
            reason,
        })
    };
    let refuse = |source| FileError::Scene {
        file: arguments.file.clone(),
        source,
    };
    Ok(content.build(&mut none).map_err(refuse)?)
}
