//! From the arguments to what a run needs: a collision model and a path.

use std::path::{Path as FilePath, PathBuf};
use std::sync::Arc;

use taut::collision::CollisionModel;
use taut::files::result::{ResultSubject, RobotSource, SceneSource};
use taut::files::{
    self, FileError, Geometry, Kind, Packages, PathTable, Problem, Reader, RobotFiles,
};
use taut::path::Path;
use taut::robot::{HeldVariable, RobotDescription, RobotModel};
use taut::scene::Scene;
use taut::scene::scene_file::SceneFile;
use taut::warning::Warning;

use super::error::CliError;
use super::quantity;
use super::source::{GeometryChoice, Source};

/// Everything that a run needs.
pub(super) struct Loaded {
    /// Label of the problem, or the file's name.
    pub name: String,
    /// Which of the robot's models it is.
    pub geometry: Geometry,
    /// The robot.
    pub robot: Arc<RobotModel>,
    /// Its files.
    pub robot_files: RobotFiles,
    /// The scene.
    pub scene: Arc<Scene>,
    /// Its file, or the problem's; `None` where there is no obstacle.
    pub scene_file: Option<PathBuf>,
    /// Which of several problems in that file it is.
    pub selected: Option<String>,
    /// The planner's path.
    pub path: Path,
    /// The problem's weights.
    pub weights: Option<Vec<f64>>,
    /// What the request leaves to be known, besides what robot and scene tell.
    pub notes: Vec<Warning>,
}

impl Loaded {
    /// Robot and scene together.
    pub(super) fn model(&self) -> Result<CollisionModel, CliError> {
        let model = CollisionModel::new(self.robot.clone(), self.scene.clone());
        model.map_err(|source| CliError::Model {
            name: self.name.clone(),
            source: Box::new(source),
        })
    }

    /// Which of a problem's models of the robot it is, in results.
    pub(super) fn geometry_name(&self) -> &'static str {
        match self.geometry {
            Geometry::Given => "given",
            Geometry::Spheres => "spheres",
        }
    }

    /// What the scene is called: its name, else that of what it was read for.
    pub(super) fn scene_name(&self) -> &str {
        match self.scene.name() {
            "" => &self.name,
            name => name,
        }
    }

    /// Where robot and scene come from, with the packages of the command line.
    pub(super) fn source(&self, packages: &[(String, PathBuf)]) -> ResultSubject {
        let files = Some(self.robot_files.absolute(&quantity::packages(packages)));
        ResultSubject {
            robot: RobotSource {
                label: None,
                hash: format!("{:016x}", self.robot.hash()),
                files,
            },
            scene: SceneSource {
                label: None,
                version: None,
                hash: format!("{:016x}", self.scene.hash()),
                file: self
                    .scene_file
                    .as_ref()
                    .and_then(|file| std::path::absolute(file).ok()),
                content: Some(SceneFile::of(&self.scene, true)),
            },
            ..ResultSubject::default()
        }
    }
}

/// A reader that knows the packages of the arguments and of the environment.
pub(super) fn reader(source: &Source) -> Reader {
    Reader::new(Packages::with_environment(quantity::packages(
        &source.packages,
    )))
}

/// Reads a problem file, or a bare path with the robot and the scene of the arguments.
///
/// `prefer_spheres` decides what `--geometry auto` means for a problem with both models.
pub(super) fn load(
    reader: &mut Reader,
    file: &FilePath,
    source: &Source,
    prefer_spheres: bool,
) -> Result<Loaded, CliError> {
    load_holding(reader, file, source, prefer_spheres, &[])
}

/// The same where the request says for some joints, by name, where they stand if the path has no
/// column for them.
pub(super) fn load_holding(
    reader: &mut Reader,
    file: &FilePath,
    source: &Source,
    prefer_spheres: bool,
    held: &[(String, f64)],
) -> Result<Loaded, CliError> {
    if let Kind::Problem { .. } = Kind::of(file)? {
        if source.robot.is_some() || source.problem.is_some() {
            let text = "is a problem file and brings its own robot and scene; leave out --robot and --problem";
            return Err(CliError::Usage(format!("{} {text}", file.display())));
        }
        return of_problem(
            problem(reader, file, source.geometry, prefer_spheres)?,
            None,
        );
    }
    let several = Kind::of(file)? == Kind::Several;
    let table = if several {
        PathTable::of_vamp(file, source.select.as_deref())?
    } else {
        PathTable::read(file)?
    };
    // One of several problems is in its own scene unless another is given.
    let scene_file = source
        .scene
        .clone()
        .or_else(|| several.then(|| file.to_owned()));
    let name = file
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    match (&source.problem, &source.robot) {
        (Some(file), _) => of_problem(
            problem(reader, file, source.geometry, prefer_spheres)?,
            Some((name, table)),
        ),
        (None, Some(urdf)) => bare(reader, urdf, source, scene_file, held, name, table),
        (None, None) => {
            let text = "is a bare path; give --robot ROBOT.urdf and --scene SCENE.json, or --problem PROBLEM.json";
            Err(CliError::Usage(format!("{} {text}", file.display())))
        }
    }
}

fn problem(
    reader: &mut Reader,
    file: &FilePath,
    choice: GeometryChoice,
    prefer_spheres: bool,
) -> Result<Problem, CliError> {
    let spheres = match choice {
        GeometryChoice::Given => false,
        GeometryChoice::Spheres => true,
        GeometryChoice::Auto => {
            prefer_spheres && Kind::of(file)? == Kind::Problem { has_spheres: true }
        }
    };
    Ok(reader.problem(
        file,
        if spheres {
            Geometry::Spheres
        } else {
            Geometry::Given
        },
    )?)
}

/// The problem's own path, or another one for its robot and scene.
fn of_problem(problem: Problem, other: Option<(String, PathTable)>) -> Result<Loaded, CliError> {
    let robot = problem.model()?;
    let (name, path) = match other {
        None => (problem.name, problem.path),
        Some((name, table)) => (
            name,
            table
                .for_robot(&problem.robot)?
                .into_path(robot.variables())?,
        ),
    };
    Ok(Loaded {
        robot: Arc::new(robot),
        robot_files: problem.robot_files,
        scene: Arc::new(problem.scene),
        scene_file: Some(problem.file),
        selected: None,
        name,
        geometry: problem.geometry,
        path,
        weights: problem.weights,
        notes: Vec::new(),
    })
}

/// A bare path: its columns are the robot's variables, every other joint is held at 0 unless `held`
/// says where.
fn bare(
    reader: &mut Reader,
    urdf: &FilePath,
    source: &Source,
    scene_file: Option<PathBuf>,
    held: &[(String, f64)],
    name: String,
    table: PathTable,
) -> Result<Loaded, CliError> {
    let mut files = robot_files(urdf, source);
    let description = reader.robot_of(&files)?;
    let table = table.for_robot(&description)?;
    files.variables = Some(table.variables().to_vec());
    let robot = robot_of(description, &files)?;
    let scene = scene_of(reader, scene_file.as_deref(), source)?;
    let mut notes = table.warnings().to_vec();
    notes.extend(srdf_elsewhere(&files, source));
    notes.extend(held_at_zero(&robot, held, &name)?);
    check_held(&table, &robot, held)?;
    let path = table.into_path(robot.variables())?;
    Ok(Loaded {
        robot: Arc::new(robot),
        robot_files: files,
        scene: Arc::new(scene),
        scene_file,
        selected: source.select.clone(),
        name,
        geometry: Geometry::Given,
        path,
        weights: None,
        notes,
    })
}

fn robot_files(urdf: &FilePath, source: &Source) -> RobotFiles {
    RobotFiles {
        urdf: urdf.to_owned(),
        srdf: source.srdf.clone().or_else(|| files::srdf_of(urdf)),
        packages: quantity::packages(&source.packages),
        ..RobotFiles::default()
    }
}

/// The robot with the columns of a path only.
fn robot_of(description: RobotDescription, files: &RobotFiles) -> Result<RobotModel, CliError> {
    let description = RobotDescription {
        variables: files.variables.clone(),
        ..description
    };
    let robot = RobotModel::new(description).map_err(|source| FileError::Robot {
        file: files.urdf.clone(),
        source,
    })?;
    Ok(robot)
}

fn scene_of(
    reader: &mut Reader,
    file: Option<&FilePath>,
    source: &Source,
) -> Result<Scene, CliError> {
    match file {
        None => Ok(Scene::default()),
        Some(file) => Ok(reader.selected_scene(file, source.select.as_deref())?),
    }
}

/// That the SRDF was found in another folder than the URDF's.
fn srdf_elsewhere(files: &RobotFiles, source: &Source) -> Option<Warning> {
    let srdf = files.srdf.as_ref()?;
    let is_elsewhere = source.srdf.is_none() && srdf.parent() != files.urdf.parent();
    is_elsewhere.then(|| Warning::cosmetic("SRDF", format!("the SRDF is {}", srdf.display())))
}

/// That joints without a column stand at 0.
///
/// # Errors
/// One that cannot.
fn held_at_zero(
    robot: &RobotModel,
    held: &[(String, f64)],
    name: &str,
) -> Result<Option<Warning>, FileError> {
    let is_given = |variable: &HeldVariable| held.iter().any(|(name, _)| *name == variable.name);
    let at_zero: Vec<&HeldVariable> = robot
        .held()
        .iter()
        .filter(|variable| !is_given(variable))
        .collect();
    let cannot = |variable: &HeldVariable| variable.hard_lower > 0.0 || variable.hard_upper < 0.0;
    if let Some(variable) = at_zero.iter().find(|variable| cannot(variable)) {
        return Err(never_at_zero(variable, name));
    }
    let names: Vec<&str> = at_zero
        .iter()
        .map(|variable| variable.name.as_str())
        .collect();
    Ok(taut_ipc::planner::held_at_zero(&names).map(Warning::uncovered))
}

fn never_at_zero(variable: &HeldVariable, name: &str) -> FileError {
    let missing = &variable.name;
    let lower = variable.hard_lower;
    let upper = variable.hard_upper;
    let text = format!(
        "column {missing:?} is missing, and the joint cannot be held at 0, outside [{lower}, {upper}]; add it, or give --hold {missing}=VALUE"
    );
    FileError::Content {
        file: name.into(),
        text,
    }
}

/// Checks what the path's file says of held joints by where these stand.
fn check_held(
    table: &PathTable,
    robot: &RobotModel,
    held: &[(String, f64)],
) -> Result<(), FileError> {
    let given = |name: &str| held.iter().rev().find(|(known, _)| known == name);
    let stands = |variable: &HeldVariable| {
        given(&variable.name).map_or(variable.default, |(_, value)| *value)
    };
    let held = robot.held().iter();
    table.check_held(held.map(|variable| (variable.name.as_str(), stands(variable))))
}
