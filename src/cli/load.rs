//! From the arguments to what a run needs: a collision model and a path.

use std::path::{Path as FilePath, PathBuf};
use std::sync::Arc;

use taut::collision::CollisionModel;
use taut::constraint::ConstraintsFile;
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
    /// What the files ask the path to keep besides clearance.
    pub constraints: ConstraintsFile,
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
        let files = self
            .robot_files
            .absolute(&quantity::packages(packages));
        ResultSubject {
            robot: RobotSource {
                label: None,
                hash: format!("{:016x}", self.robot.hash()),
                files: Some(files),
            },
            scene: self.scene_source(),
            ..ResultSubject::default()
        }
    }

    fn scene_source(&self) -> SceneSource {
        let file = self.scene_file.as_ref();
        SceneSource {
            label: None,
            version: None,
            hash: format!("{:016x}", self.scene.hash()),
            file: file.and_then(|file| std::path::absolute(file).ok()),
            content: Some(SceneFile::of(&self.scene, true)),
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
        check_alone(file, source)?;
        return of_problem(
            problem(reader, file, source.geometry, prefer_spheres)?,
            None,
        );
    }
    let given = GivenPath::read(file, source)?;
    match (&source.problem, &source.robot) {
        (Some(file), _) => of_problem(
            problem(reader, file, source.geometry, prefer_spheres)?,
            Some(given),
        ),
        (None, Some(urdf)) => bare(reader, urdf, source, held, given),
        (None, None) => Err(without_robot(file)),
    }
}

/// Checks that nothing besides a problem file says which robot it is.
fn check_alone(file: &FilePath, source: &Source) -> Result<(), CliError> {
    if source.robot.is_none() && source.problem.is_none() {
        return Ok(());
    }
    Err(CliError::Usage(format!(
        "{} is a problem file and brings its own robot and scene; leave out --robot and --problem",
        file.display()
    )))
}

fn without_robot(file: &FilePath) -> CliError {
    CliError::Usage(format!(
        "{} is a bare path; give --robot ROBOT.urdf and --scene SCENE.json, or --problem PROBLEM.json",
        file.display()
    ))
}

/// A path that comes without its robot.
struct GivenPath {
    /// The file's name.
    name: String,
    table: PathTable,
    /// The scene of the arguments; one of several problems is in its own unless another is given.
    scene_file: Option<PathBuf>,
}

impl GivenPath {
    fn read(file: &FilePath, source: &Source) -> Result<Self, FileError> {
        let name = file
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy();
        let given = source.scene.clone();
        let is_one_of_several = Kind::of(file)? == Kind::Several;
        let (table, scene_file) = match is_one_of_several {
            true => (
                PathTable::of_vamp(file, source.select.as_deref())?,
                given.or_else(|| Some(file.to_owned())),
            ),
            false => (PathTable::read(file)?, given),
        };
        Ok(Self {
            name: name.into_owned(),
            table,
            scene_file,
        })
    }
}

fn problem(
    reader: &mut Reader,
    file: &FilePath,
    choice: GeometryChoice,
    prefer_spheres: bool,
) -> Result<Problem, CliError> {
    let has_spheres = || Ok::<_, FileError>(Kind::of(file)? == Kind::Problem { has_spheres: true });
    let geometry = match choice {
        GeometryChoice::Spheres => Geometry::Spheres,
        GeometryChoice::Auto if prefer_spheres && has_spheres()? => Geometry::Spheres,
        GeometryChoice::Given | GeometryChoice::Auto => Geometry::Given,
    };
    Ok(reader.problem(file, geometry)?)
}

/// The problem's own path, or another one for its robot and scene.
fn of_problem(problem: Problem, other: Option<GivenPath>) -> Result<Loaded, CliError> {
    let robot = problem.model()?;
    let (name, path, constraints) = match other {
        None => (problem.name, problem.path, problem.constraints),
        Some(GivenPath { name, table, .. }) => {
            let table = table.for_robot(&problem.robot)?;
            let (path, own) = table.into_path(robot.variables())?;
            (name, path, problem.constraints.and(own))
        }
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
        constraints,
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
    held: &[(String, f64)],
    given: GivenPath,
) -> Result<Loaded, CliError> {
    let mut files = robot_files(urdf, source);
    let description = reader.robot_of(&files)?;
    let table = given.table.for_robot(&description)?;
    files.variables = Some(table.variables().to_vec());
    let robot = robot_of(description, &files)?;
    let scene = scene_of(reader, given.scene_file.as_deref(), source)?;
    let mut notes = table.warnings().to_vec();
    notes.extend(srdf_elsewhere(&files, source));
    notes.extend(held_at_zero(&robot, held, &given.name)?);
    check_held(&table, &robot, held)?;
    let (path, constraints) = table.into_path(robot.variables())?;
    Ok(Loaded {
        robot: Arc::new(robot),
        robot_files: files,
        scene: Arc::new(scene),
        scene_file: given.scene_file,
        selected: source.select.clone(),
        name: given.name,
        geometry: Geometry::Given,
        path,
        constraints,
        weights: None,
        notes,
    })
}

fn robot_files(urdf: &FilePath, source: &Source) -> RobotFiles {
    RobotFiles {
        urdf: urdf.to_owned(),
        srdf: source
            .srdf
            .clone()
            .or_else(|| files::srdf_of(urdf)),
        packages: quantity::packages(&source.packages),
        ..RobotFiles::default()
    }
}

/// The robot with the columns of a path only.
fn robot_of(
    mut description: RobotDescription,
    files: &RobotFiles,
) -> Result<RobotModel, FileError> {
    description.variables = files.variables.clone();
    model_of(description, &files.urdf)
}

/// The robot of these files.
pub(super) fn robot_in(reader: &mut Reader, files: &RobotFiles) -> Result<RobotModel, FileError> {
    model_of(reader.robot_of(files)?, &files.urdf)
}

fn model_of(description: RobotDescription, urdf: &FilePath) -> Result<RobotModel, FileError> {
    RobotModel::new(description).map_err(|source| FileError::Robot {
        file: urdf.to_owned(),
        source,
    })
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
    let is_given = |variable: &&HeldVariable| {
        held.iter()
            .any(|(name, _)| *name == variable.name)
    };
    let at_zero = robot
        .held()
        .iter()
        .filter(|variable| !is_given(variable));
    if let Some(variable) = at_zero
        .clone()
        .find(|variable| !reaches_zero(variable))
    {
        return Err(never_at_zero(variable, name));
    }
    let names: Vec<&str> = at_zero
        .map(|variable| variable.name.as_str())
        .collect();
    Ok(taut_ipc::planner::held_at_zero(&names).map(Warning::uncovered))
}

fn reaches_zero(variable: &HeldVariable) -> bool {
    variable.hard_lower <= 0.0 && variable.hard_upper >= 0.0
}

fn never_at_zero(variable: &HeldVariable, name: &str) -> FileError {
    let missing = &variable.name;
    let lower = variable.hard_lower;
    let upper = variable.hard_upper;
    let text = format!(
        "column {missing:?} is missing, and the joint cannot be held at 0, outside [{lower}, {upper}]; add it, or give --hold {missing}=VALUE"
    );
    FileError::content(name.as_ref(), text)
}

/// Checks what the path's file says of held joints by where these stand.
fn check_held(
    table: &PathTable,
    robot: &RobotModel,
    held: &[(String, f64)],
) -> Result<(), FileError> {
    let stands = robot
        .held()
        .iter()
        .map(|variable| (variable.name.as_str(), where_held(variable, held)));
    table.check_held(stands)
}

/// Where a held joint stands: where the last that names it says, else at its default.
fn where_held(variable: &HeldVariable, given: &[(String, f64)]) -> f64 {
    given
        .iter()
        .rev()
        .find(|(known, _)| *known == variable.name)
        .map_or(variable.default, |(_, value)| *value)
}
