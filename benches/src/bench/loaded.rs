//! From a file to what a run needs: robot, scene and path.

use std::collections::BTreeMap;
use std::path::{Path as File, PathBuf};
use std::sync::Arc;

use taut::collision::CollisionModel;
use taut::constraint::ConstraintsFile;
use taut::files::{
    FileError, Geometry, Kind, PathTable, Peer, Problem, Reader, RobotFiles, srdf_of,
};
use taut::path::Path;
use taut::robot::{RobotDescription, RobotModel};
use taut::scene::Scene;

use super::source::{GeometryChoice, Source};
use crate::error::Error;

/// Everything that a run needs.
pub(super) struct Loaded {
    /// Label of the problem, or the file's name.
    pub name: String,
    /// Which of the robot's models it is.
    pub geometry: Geometry,
    /// The robot.
    pub robot: Arc<RobotModel>,
    /// The scene.
    scene: Arc<Scene>,
    /// The planner's path.
    pub path: Path,
    /// What it must keep besides clearance.
    pub constraints: ConstraintsFile,
    /// The problem's weights.
    pub weights: Option<Vec<f64>>,
    /// Recorded answers of others, by name.
    pub peers: BTreeMap<String, Peer>,
    /// The best honest one of them.
    pub best_honest_peer: Option<(String, Peer)>,
    /// Recorded checks of their paths with exact meshes, as the file has them.
    pub mesh_check: serde_json::Value,
}

/// A path by its file's name, in the columns that the file has.
struct Named {
    name: String,
    table: PathTable,
}

impl Loaded {
    /// Reads a problem file, or a path with the robot and the scene of the arguments.
    pub(super) fn read(reader: &mut Reader, file: &File, source: &Source) -> Result<Self, Error> {
        let kind = Kind::of(file)?;
        if matches!(kind, Kind::Problem { .. }) {
            return Self::of_problem_file(reader, file, source);
        }
        let is_several = kind == Kind::Several;
        let named = Named::read(file, is_several.then_some(source))?;
        match (&source.problem, &source.robot) {
            (Some(file), _) => Self::of_path(problem(reader, file, source.geometry)?, named),
            (None, Some(urdf)) => {
                // One of several problems is in its own scene unless another is given.
                let own = is_several.then(|| file.to_owned());
                let scene = source.scene.clone().or(own);
                Self::of_bare(reader, urdf, source, scene, named)
            }
            (None, None) => Err(usage(
                file,
                "is a bare path; give --robot ROBOT.urdf and --scene SCENE.json, or --problem PROBLEM.json",
            )),
        }
    }

    /// Robot and scene together.
    pub(super) fn model(&self) -> Result<CollisionModel, Error> {
        CollisionModel::new(self.robot.clone(), self.scene.clone()).map_err(|source| Error::Model {
            name: self.name.clone(),
            source: Box::new(source),
        })
    }

    /// Name of the robot's model in results.
    pub(super) fn geometry_name(&self) -> &'static str {
        match self.geometry {
            Geometry::Given => "given",
            Geometry::Spheres => "spheres",
        }
    }

    fn of_problem_file(reader: &mut Reader, file: &File, source: &Source) -> Result<Self, Error> {
        if source.robot.is_some() || source.problem.is_some() {
            return Err(usage(
                file,
                "is a problem file and brings its own robot and scene; leave out --robot and --problem",
            ));
        }
        let problem = problem(reader, file, source.geometry)?;
        Ok(Self::of_problem(problem.model()?, problem))
    }

    fn of_problem(robot: RobotModel, problem: Problem) -> Self {
        Self {
            robot: Arc::new(robot),
            scene: Arc::new(problem.scene),
            name: problem.name,
            geometry: problem.geometry,
            path: problem.path,
            constraints: problem.constraints,
            weights: problem.weights,
            peers: problem.peers,
            best_honest_peer: problem.best_honest_peer,
            mesh_check: problem.mesh_check,
        }
    }

    /// Another path for a problem's robot and scene.
    fn of_path(problem: Problem, other: Named) -> Result<Self, Error> {
        let robot = problem.model()?;
        let (path, own) = other
            .table
            .for_robot(&problem.robot)?
            .into_path(robot.variables())?;
        Ok(Self {
            name: other.name,
            path,
            constraints: problem.constraints.clone().and(own),
            ..Self::of_problem(robot, problem)
        })
    }

    /// A bare path: its columns are the robot's variables, every other joint is held at 0.
    fn of_bare(
        reader: &mut Reader,
        urdf: &File,
        source: &Source,
        scene_file: Option<PathBuf>,
        named: Named,
    ) -> Result<Self, Error> {
        let (robot, table) = with_columns(reader, urdf, source, named.table)?;
        let scene = match &scene_file {
            None => Scene::default(),
            Some(file) => reader.selected_scene(file, source.select.as_deref())?,
        };
        check_held(&named.name, &robot, &table)?;
        let (path, constraints) = table.into_path(robot.variables())?;
        Ok(Self {
            name: named.name,
            geometry: Geometry::Given,
            constraints,
            path,
            robot: Arc::new(robot),
            scene: Arc::new(scene),
            weights: None,
            peers: BTreeMap::new(),
            best_honest_peer: None,
            mesh_check: serde_json::Value::Null,
        })
    }
}

impl Named {
    /// `several` is given where the file has several problems.
    fn read(file: &File, several: Option<&Source>) -> Result<Self, Error> {
        let table = match several {
            Some(source) => PathTable::of_vamp(file, source.select.as_deref())?,
            None => PathTable::read(file)?,
        };
        Ok(Self {
            name: file_name(file),
            table,
        })
    }
}

fn file_name(file: &File) -> String {
    file.file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

fn usage(file: &File, text: &str) -> Error {
    Error::Usage(format!("{} {text}", file.display()))
}

fn problem(reader: &mut Reader, file: &File, choice: GeometryChoice) -> Result<Problem, Error> {
    let has_spheres = || Ok::<_, Error>(Kind::of(file)? == Kind::Problem { has_spheres: true });
    let spheres = match choice {
        GeometryChoice::Given => false,
        GeometryChoice::Spheres => true,
        GeometryChoice::Auto => has_spheres()?,
    };
    let geometry = match spheres {
        true => Geometry::Spheres,
        false => Geometry::Given,
    };
    Ok(reader.problem(file, geometry)?)
}

/// The robot whose variables are the path's columns.
fn with_columns(
    reader: &mut Reader,
    urdf: &File,
    source: &Source,
    table: PathTable,
) -> Result<(RobotModel, PathTable), Error> {
    let mut files = RobotFiles {
        urdf: urdf.to_owned(),
        srdf: source.srdf.clone().or_else(|| srdf_of(urdf)),
        packages: source.packages(),
        ..RobotFiles::default()
    };
    let mut robot: RobotDescription = reader.robot_of(&files)?;
    let table = table.for_robot(&robot)?;
    files.variables = Some(table.variables().to_vec());
    robot.variables = files.variables;
    let robot = RobotModel::new(robot).map_err(|source| FileError::Robot {
        file: urdf.to_owned(),
        source,
    })?;
    Ok((robot, table))
}

/// Joints without a column are held at 0, where their limits let them.
fn check_held(name: &str, robot: &RobotModel, table: &PathTable) -> Result<(), Error> {
    let mut held = robot.held().iter();
    if let Some(outside) = held.find(|joint| joint.hard_lower > 0.0 || joint.hard_upper < 0.0) {
        return Err(Error::File(FileError::Content {
            file: name.into(),
            text: format!(
                "column {:?} is missing, and the joint cannot be held at 0, outside [{}, {}]; add it",
                outside.name, outside.hard_lower, outside.hard_upper
            ),
        }));
    }
    let defaults = robot
        .held()
        .iter()
        .map(|joint| (joint.name.as_str(), joint.default));
    Ok(table.check_held(defaults)?)
}
