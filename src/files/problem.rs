//! Problem files, `taut-problem/1`: a robot, a scene, a planner's path, and what others made of it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::constraints::{check_constraints, path_constraints};
use super::{FileError, Reader, RobotFiles, RootJoint, folder_of, read_text};
use crate::constraint::ConstraintsFile;
use crate::path;
use crate::robot::{JointKind, RobotDescription, RobotModel, VirtualJoint};
use crate::scene::scene_file::SceneFile;
use crate::scene::{Filled, Scene};

const FORMAT: &str = "taut-problem/1";

/// Which model of the robot to take.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Geometry {
    /// `urdf`: the robot's own collision shapes.
    #[default]
    Given,
    /// `spherized_urdf`: the robot as spheres.
    Spheres,
}

/// A problem, read and checked, except that the path may still be refused against the robot's
/// limits.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The file it was read from.
    pub file: PathBuf,
    /// Label.
    pub name: String,
    /// The robot's own files and what the problem says about it.
    pub robot_files: RobotFiles,
    /// The robot, with the problem's variables, virtual joint and allowed pairs.
    pub robot: RobotDescription,
    /// Which of the robot's models it is.
    pub geometry: Geometry,
    /// Whether the problem has a sphere model too.
    pub has_spheres: bool,
    /// The scene.
    pub scene: Scene,
    /// The planner's path, columns in the order of the robot's variables.
    pub path: path::Path,
    /// What paths must keep besides clearance.
    pub constraints: ConstraintsFile,
    /// Weights of the problem's metric, one per velocity coordinate; `None` where it gives none.
    pub weights: Option<Vec<f64>>,
    /// Length of the path as the file says, in the problem's metric.
    pub path_length: Option<f64>,
    /// Distance of the ends as the file says.
    pub lower_bound: Option<f64>,
    /// Recorded answers of other optimizers, by name.
    pub peers: BTreeMap<String, Peer>,
    /// The shortest answer that every check found valid: its name and figures.
    pub best_honest_peer: Option<(String, Peer)>,
    /// Recorded checks of the peers' paths with exact meshes, as the file has them.
    pub mesh_check: serde_json::Value,
}

/// A recorded answer of another optimizer.
#[derive(Clone, Debug, Default, Deserialize)]
pub struct Peer {
    /// Length in the problem's metric.
    pub length: f64,
    /// CPU time (s).
    pub cpu_s: f64,
    /// Whether every check found it valid.
    #[serde(default)]
    pub honest: bool,
    /// Its waypoints, where recorded.
    #[serde(default)]
    pub path: Option<Vec<Vec<f64>>>,
}

#[derive(Deserialize)]
struct ProblemFile {
    format: String,
    path_constraints: Option<serde_json::Value>,
    #[serde(default)]
    trajectory_constraints: Filled,
    #[serde(default)]
    goal_constraints: Filled,
    name: String,
    robot: RobotPart,
    variables: Vec<String>,
    metric: Option<MetricPart>,
    scene: SceneFile,
    path: Vec<Vec<f64>>,
    path_length: Option<f64>,
    lower_bound: Option<f64>,
    #[serde(default)]
    peers: BTreeMap<String, Peer>,
    best_honest_peer: Option<BestPeer>,
    #[serde(default)]
    mesh_check: serde_json::Value,
}

#[derive(Deserialize)]
struct RobotPart {
    name: Option<String>,
    urdf: PathBuf,
    srdf: Option<PathBuf>,
    spherized_urdf: Option<PathBuf>,
    #[serde(default)]
    allowed_collisions: Vec<(String, String)>,
    #[serde(default)]
    spherized_allowed_collisions: Vec<(String, String)>,
    #[serde(default)]
    packages: BTreeMap<String, PathBuf>,
    virtual_joint: Option<VirtualJointPart>,
}

#[derive(Deserialize)]
struct VirtualJointPart {
    name: String,
    #[serde(rename = "type")]
    kind: String,
    #[serde(default)]
    position_bounds: Vec<(f64, f64)>,
    #[serde(default)]
    parent_frame: String,
}

#[derive(Deserialize)]
struct MetricPart {
    weights_per_dof: Vec<f64>,
}

#[derive(Deserialize)]
struct BestPeer {
    name: String,
    #[serde(flatten)]
    figures: Peer,
}

/// What a file holds, by a first look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A problem: it has a `format`.
    Problem {
        /// Whether it has a sphere model of its robot.
        has_spheres: bool,
    },
    /// Several problems of VAMP's: scenes with starts and goals.
    Several,
    /// Anything else, so that it can only be a bare path; a result is one too.
    BarePath,
}

impl Kind {
    /// Looks at a file.
    ///
    /// # Errors
    /// A file that cannot be read, or that is neither CSV, YAML nor JSON.
    pub fn of(file: &Path) -> Result<Self, FileError> {
        #[derive(Deserialize)]
        struct Probe {
            format: Option<String>,
            robot: Option<ProbeRobot>,
            problems: Option<serde::de::IgnoredAny>,
        }
        /// A problem's robot, or the name of VAMP's.
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum ProbeRobot {
            Files { spherized_urdf: Option<PathBuf> },
            Other(serde::de::IgnoredAny),
        }
        if super::table::is_csv(file) || super::yaml::is_yaml(file) {
            return Ok(Self::BarePath);
        }
        let refuse = |error| FileError::Content {
            file: file.to_owned(),
            text: format!("not a JSON file: {error}"),
        };
        let probe: Probe = serde_json::from_str(&read_text(file)?).map_err(refuse)?;
        if probe.problems.is_some() {
            return Ok(Self::Several);
        }
        let has_spheres = matches!(
            probe.robot,
            Some(ProbeRobot::Files {
                spherized_urdf: Some(_)
            })
        );
        // An answer is a path for whoever goes on with it.
        let is_problem = probe
            .format
            .is_some_and(|format| format != super::result::RESULT_FORMAT);
        Ok(if is_problem {
            Self::Problem { has_spheres }
        } else {
            Self::BarePath
        })
    }
}

impl Reader {
    /// Reads a problem file and the robot and meshes that it names, relative to its folder.
    ///
    /// # Errors
    /// A file that cannot be read or says something wrong; `Spheres` where the problem has none.
    pub fn problem(&mut self, file: &Path, geometry: Geometry) -> Result<Problem, FileError> {
        let refuse = |text: String| FileError::content(file, text);
        let text = read_text(file)?;
        let parsed: ProblemFile = serde_json::from_str(&text)
            .map_err(|error| refuse(format!("not a problem file: {error}")))?;
        if parsed.format != FORMAT {
            return Err(refuse(format!(
                "its format is {:?}; valid: {FORMAT:?}",
                parsed.format
            )));
        }
        check_constraints([
            ("trajectory_constraints", parsed.trajectory_constraints),
            ("goal_constraints", parsed.goal_constraints),
        ])
        .map_err(refuse)?;
        let constraints = path_constraints(parsed.path_constraints).map_err(refuse)?;
        let path = rows(&parsed.path, parsed.variables.len()).map_err(refuse)?;
        let folder = folder_of(file);
        let packages = parsed
            .robot
            .packages
            .iter()
            .map(|(name, dir)| (name.clone(), folder.join(dir)))
            .collect();
        let has_spheres = parsed.robot.spherized_urdf.is_some();
        let robot_files = robot_files(
            &parsed.robot,
            parsed.variables,
            geometry,
            folder,
            &packages,
            &refuse,
        )?;
        let mut robot = self.robot_of(&robot_files)?;
        if let Some(name) = parsed.robot.name {
            robot.name = name;
        }
        let scene = self.build_scene(parsed.scene, file, &packages)?;
        Ok(Problem {
            file: file.to_owned(),
            name: parsed.name,
            robot_files,
            robot,
            geometry,
            has_spheres,
            scene,
            path,
            constraints,
            weights: parsed
                .metric
                .map(|metric| metric.weights_per_dof),
            path_length: parsed.path_length,
            lower_bound: parsed.lower_bound,
            peers: parsed.peers,
            best_honest_peer: parsed
                .best_honest_peer
                .map(|best| (best.name, best.figures)),
            mesh_check: parsed.mesh_check,
        })
    }
}

fn robot_files(
    part: &RobotPart,
    variables: Vec<String>,
    geometry: Geometry,
    folder: &Path,
    packages: &BTreeMap<String, PathBuf>,
    refuse: &dyn Fn(String) -> FileError,
) -> Result<RobotFiles, FileError> {
    let mut allowed_collisions = part.allowed_collisions.clone();
    let urdf = match geometry {
        Geometry::Given => &part.urdf,
        Geometry::Spheres => {
            allowed_collisions.extend(
                part.spherized_allowed_collisions
                    .iter()
                    .cloned(),
            );
            let none = || refuse("it has no spherized_urdf; use the geometry given".to_owned());
            part.spherized_urdf.as_ref().ok_or_else(none)?
        }
    };
    Ok(RobotFiles {
        urdf: folder.join(urdf),
        srdf: part.srdf.as_ref().map(|srdf| folder.join(srdf)),
        packages: packages.clone(),
        // The problem decides, whatever the SRDF says.
        root: RootJoint::Given(
            part.virtual_joint
                .as_ref()
                .map(virtual_joint)
                .transpose()
                .map_err(refuse)?,
        ),
        variables: Some(variables),
        allowed_collisions,
    })
}

impl Problem {
    /// Builds the robot.
    ///
    /// # Errors
    /// What [`RobotModel::new`] refuses, with the robot's file.
    pub fn model(&self) -> Result<RobotModel, FileError> {
        RobotModel::new(self.robot.clone()).map_err(|source| FileError::Robot {
            file: self.robot_files.urdf.clone(),
            source,
        })
    }
}

fn virtual_joint(part: &VirtualJointPart) -> Result<VirtualJoint, String> {
    let name = &part.name;
    let (kind, translations) = match part.kind.as_str() {
        "planar" => (JointKind::Planar, 2),
        "floating" => (JointKind::Floating, 3),
        "fixed" => (JointKind::Fixed, 0),
        other => {
            let valid = "fixed, planar, floating";
            return Err(format!(
                "virtual joint {name:?} has the type {other:?}; valid types: {valid}"
            ));
        }
    };
    let bounds = part.position_bounds.len();
    if bounds != 0 && bounds != translations {
        let text = format!("virtual joint {name:?} has {bounds} position_bounds");
        return Err(format!(
            "{text}; a {} joint has {translations} translations",
            part.kind
        ));
    }
    let parent_frame = part.parent_frame.clone();
    Ok(VirtualJoint {
        name: name.clone(),
        kind,
        position_bounds: part.position_bounds.clone(),
        parent_frame,
    })
}

/// Rows of `columns` finite numbers as a path.
fn rows(rows: &[Vec<f64>], columns: usize) -> Result<path::Path, String> {
    if let Some((index, row)) = rows
        .iter()
        .enumerate()
        .find(|(_, row)| row.len() != columns)
    {
        return Err(format!(
            "path row {index} has {} numbers, \"variables\" names {columns} columns",
            row.len()
        ));
    }
    path::Path::from_rows(columns, rows.concat())
        .ok_or_else(|| "the path is empty; it needs a waypoint".to_owned())
}
