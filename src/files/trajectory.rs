//! Trajectories as ROS has them: JointTrajectory as YAML or JSON, also inside of MoveIt's
//! RobotTrajectory and DisplayTrajectory, and planning requests, whose path is the straight line
//! from start to goal.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::columns::{self, Names};
use super::constraints::{check_constraints, check_goal, path_constraints};
use super::{FileError, read_text, yaml};
use crate::constraint::ConstraintsFile;
use crate::robot::{RobotModel, Variable};
use crate::scene::Filled;

/// A trajectory as a file has it: columns in the file's order.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    /// The file.
    pub file: PathBuf,
    /// Names of its columns.
    pub joint_names: Vec<String>,
    /// Its points, in the file's order.
    pub points: Vec<TrajectoryPoint>,
    /// What its request asks a path to keep besides clearance.
    pub constraints: ConstraintsFile,
}

/// One point of a trajectory; lists that the file leaves out are empty.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct TrajectoryPoint {
    /// m or rad.
    #[serde(default)]
    pub positions: Vec<f64>,
    /// Per second.
    #[serde(default)]
    pub velocities: Vec<f64>,
    /// Per second squared.
    #[serde(default)]
    pub accelerations: Vec<f64>,
    /// When (s).
    #[serde(default, rename = "time_from_start", deserialize_with = "time")]
    pub time_s: Option<f64>,
}

/// Any message that holds a trajectory, by the fields that tell which it is.
#[derive(Deserialize)]
struct Message {
    joint_names: Option<Vec<String>>,
    points: Option<Vec<TrajectoryPoint>>,
    joint_trajectory: Option<Box<Message>>,
    trajectory: Option<Inner>,
    multi_dof_joint_trajectory: Option<MultiDof>,
    start_state: Option<StartState>,
    /// Where a displayed trajectory starts.
    trajectory_start: Option<StartState>,
    goal_constraints: Option<Vec<Goal>>,
    world: Option<serde::de::IgnoredAny>,
    path_constraints: Option<serde_json::Value>,
    #[serde(default)]
    trajectory_constraints: Filled,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Inner {
    Several(Vec<Message>),
    One(Box<Message>),
}

#[derive(Deserialize)]
struct MultiDof {
    #[serde(default)]
    joint_names: Vec<String>,
    #[serde(default)]
    points: Vec<serde::de::IgnoredAny>,
}

#[derive(Default, Deserialize)]
struct StartState {
    #[serde(default)]
    joint_state: JointState,
    #[serde(default)]
    multi_dof_joint_state: MultiDofState,
    #[serde(default)]
    attached_collision_objects: Vec<serde_json::Value>,
}

#[derive(Default, Deserialize)]
struct MultiDofState {
    #[serde(default)]
    joint_names: Vec<String>,
    #[serde(default)]
    transforms: Vec<Transform>,
}

#[derive(Default, Deserialize)]
struct Transform {
    #[serde(default)]
    translation: Parts,
    #[serde(default)]
    rotation: Parts,
}

#[derive(Default, Deserialize)]
struct Parts {
    #[serde(default)]
    x: f64,
    #[serde(default)]
    y: f64,
    #[serde(default)]
    z: f64,
}

impl StartState {
    /// What it says of the robot that a path does not: refused, since nobody would be told that it
    /// was left out.
    fn refuse(&self, of: &str) -> Result<(), String> {
        if !self.attached_collision_objects.is_empty() {
            let id = |object: &serde_json::Value| {
                Some(
                    object
                        .get("object")?
                        .get("id")?
                        .as_str()?
                        .to_owned(),
                )
            };
            let ids: Vec<String> = self
                .attached_collision_objects
                .iter()
                .filter_map(id)
                .collect();
            let text = "a path does not bring them: put them into the scene and take them out here";
            return Err(format!(
                "{of} has attached_collision_objects ({}); {text}",
                ids.join(", ")
            ));
        }
        let MultiDofState {
            joint_names,
            transforms,
        } = &self.multi_dof_joint_state;
        let moves = |parts: &Parts| [parts.x, parts.y, parts.z] != [0.0; 3];
        let is_moved =
            |transform: &Transform| moves(&transform.translation) || moves(&transform.rotation);
        match joint_names
            .iter()
            .zip(transforms)
            .find(|(_, transform)| is_moved(transform))
        {
            None => Ok(()),
            Some((name, _)) => {
                let text = format!(
                    "give it to the path as columns, or hold it there: --hold {name}/x=VALUE"
                );
                Err(format!(
                    "{of} moves {name} by its multi_dof_joint_state, which is not read; {text}"
                ))
            }
        }
    }
}

#[derive(Default, Deserialize)]
struct JointState {
    #[serde(default)]
    name: Vec<String>,
    #[serde(default)]
    position: Vec<f64>,
}

#[derive(Deserialize)]
struct Goal {
    #[serde(default)]
    joint_constraints: Vec<JointConstraint>,
    #[serde(default)]
    position_constraints: Filled,
    #[serde(default)]
    orientation_constraints: Filled,
    #[serde(default)]
    visibility_constraints: Filled,
}

#[derive(Deserialize)]
struct JointConstraint {
    joint_name: String,
    position: f64,
}

/// ROS 1's and ROS 2's words for a duration, or a number of seconds.
fn time<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Time {
        Seconds(f64),
        Parts(Parts),
    }
    #[derive(Deserialize)]
    struct Parts {
        #[serde(default, alias = "secs")]
        sec: i64,
        #[serde(default, alias = "nsec", alias = "nsecs")]
        nanosec: i64,
    }
    Ok(Some(match Time::deserialize(deserializer)? {
        Time::Seconds(seconds) => seconds,
        // Rounded once, as controllers do, and those that write such times.
        Time::Parts(Parts { sec, nanosec }) => {
            (1_000_000_000 * i128::from(sec) + i128::from(nanosec)) as f64 / 1e9
        }
    }))
}

impl Trajectory {
    /// Reads the one trajectory of a YAML or JSON file.
    ///
    /// # Errors
    /// A file that cannot be read, holds no trajectory or several, or has a point of the wrong
    /// length.
    pub fn read(file: &Path) -> Result<Self, FileError> {
        let parsed = parse(&read_text(file)?, yaml::is_yaml(file));
        let parsed = parsed.map_err(|text| FileError::content(file, text))?;
        let (joint_names, points) = parsed.path;
        Ok(Self {
            file: file.to_owned(),
            joint_names,
            points,
            constraints: parsed.constraints,
        })
    }
}

impl Trajectory {
    /// The same with its columns in the robot's order; columns of fixed joints are left out.
    ///
    /// # Errors
    /// A column that the robot does not have, one that is missing, or one that is there twice.
    pub fn for_robot(&self, robot: &RobotModel) -> Result<Vec<TrajectoryPoint>, FileError> {
        self.of_names(&Names::of_model(robot), robot.variables())
    }

    /// The same for variables of which only the names are known.
    ///
    /// # Errors
    /// As [`Self::for_robot`].
    pub fn ordered(&self, variables: &[Variable]) -> Result<Vec<TrajectoryPoint>, FileError> {
        self.of_names(&Names::of_variables(variables, &[]), variables)
    }

    fn of_names(
        &self,
        names: &Names,
        variables: &[Variable],
    ) -> Result<Vec<TrajectoryPoint>, FileError> {
        let refuse = |text: String| FileError::content(&self.file, text);
        let (found, _) = names
            .columns(&self.joint_names)
            .map_err(refuse)?;
        let (places, names): (Vec<usize>, Vec<String>) = found.into_iter().unzip();
        let order = columns::order(&names, variables).map_err(refuse)?;
        let list = |list: &Vec<f64>| match list.is_empty() {
            true => Vec::new(),
            false => order
                .iter()
                .map(|&column| list[places[column]])
                .collect(),
        };
        let point = |point: &TrajectoryPoint| TrajectoryPoint {
            positions: list(&point.positions),
            velocities: list(&point.velocities),
            accelerations: list(&point.accelerations),
            time_s: point.time_s,
        };
        Ok(self.points.iter().map(point).collect())
    }
}

/// Columns and points.
type Points = (Vec<String>, Vec<TrajectoryPoint>);
type Parsed = Result<Points, String>;

/// Where the joints stand before a path, by name.
pub(super) type Start = Vec<(String, f64)>;

/// The one trajectory of a text, and what its message says besides.
pub(super) struct Said {
    /// Columns and points.
    pub path: Points,
    /// Where the robot stands.
    pub start: Start,
    /// What must be kept.
    pub constraints: ConstraintsFile,
}

/// Reads the one trajectory of a text.
pub(super) fn parse(text: &str, is_yaml: bool) -> Result<Said, String> {
    let mut messages: Vec<Message> = match is_yaml {
        true => yaml::documents(text)?,
        false => {
            vec![serde_json::from_str(text).map_err(|error| format!("not a trajectory: {error}"))?]
        }
    };
    let mut found = Vec::new();
    let is_scene = messages
        .iter()
        .any(|message| message.world.is_some());
    let start = messages
        .iter()
        .flat_map(Message::start)
        .collect();
    let mut constraints = ConstraintsFile::default();
    for message in &mut messages {
        constraints = constraints.and(message.constraints()?);
    }
    for message in messages {
        message.collect(&mut found)?;
    }
    match found.len() {
        1 => Ok(Said {
            path: checked(found.swap_remove(0))?,
            start,
            constraints,
        }),
        0 if is_scene => Err("it is a planning scene, not a path; give it as --scene".to_owned()),
        0 => {
            Err("no trajectory: a trajectory has joint_names and points with positions".to_owned())
        }
        many => Err(format!("it holds {many} trajectories; keep one of them")),
    }
}

impl Message {
    /// Where its joints stand at first.
    fn start(&self) -> Start {
        let states = [&self.start_state, &self.trajectory_start]
            .into_iter()
            .flatten();
        let joints = states.flat_map(|state| {
            state
                .joint_state
                .name
                .iter()
                .zip(&state.joint_state.position)
        });
        joints
            .map(|(name, position)| (name.clone(), *position))
            .collect()
    }

    /// What it asks a path to keep, and the messages in it.
    fn constraints(&mut self) -> Result<ConstraintsFile, String> {
        let own = path_constraints(self.path_constraints.take())?;
        let inner = match &mut self.trajectory {
            Some(Inner::Several(messages)) => messages.as_mut_slice(),
            Some(Inner::One(message)) => std::slice::from_mut(&mut **message),
            None => &mut [],
        };
        let joints = self.joint_trajectory.as_deref_mut();
        let mut messages = inner.iter_mut().chain(joints);
        messages.try_fold(own, |all, message| Ok(all.and(message.constraints()?)))
    }

    fn collect(self, found: &mut Vec<Points>) -> Result<(), String> {
        check_constraints([("trajectory_constraints", self.trajectory_constraints)])?;
        if let Some(MultiDof {
            joint_names,
            points,
        }) = self.multi_dof_joint_trajectory
            && !points.is_empty()
        {
            let names = joint_names.join(", ");
            let text = format!("multi_dof_joint_trajectory moves {names}, which is not read here");
            return Err(format!(
                "{text}; give the path as CSV or JSON with columns such as {names}/trans_x"
            ));
        }
        for (state, name) in [
            (&self.start_state, "start_state"),
            (&self.trajectory_start, "trajectory_start"),
        ] {
            state
                .as_ref()
                .map_or(Ok(()), |state| state.refuse(name))?;
        }
        if let (Some(names), Some(points)) = (self.joint_names, self.points) {
            found.push((names, points));
        }
        if let (Some(start), Some(goals)) = (self.start_state, self.goal_constraints) {
            found.push(straight(&start.joint_state, &goals)?);
        }
        if let Some(inner) = self.joint_trajectory {
            inner.collect(found)?;
        }
        match self.trajectory {
            None => {}
            Some(Inner::One(message)) => message.collect(found)?,
            Some(Inner::Several(messages)) => messages
                .into_iter()
                .try_for_each(|message| message.collect(found))?,
        }
        Ok(())
    }
}

/// From the start to the first goal, in the goal's joints.
fn straight(start: &JointState, goals: &[Goal]) -> Parsed {
    goals.first().map_or(Ok(()), |goal| {
        check_goal([
            ("position_constraints", goal.position_constraints),
            ("orientation_constraints", goal.orientation_constraints),
            ("visibility_constraints", goal.visibility_constraints),
        ])
    })?;
    let constraints = goals
        .first()
        .map(|goal| goal.joint_constraints.as_slice())
        .unwrap_or_default();
    if constraints.is_empty() {
        let text =
            "its goal_constraints have no joint_constraints; only goals in joint space are read";
        return Err(text.to_owned());
    }
    let names: Vec<String> = constraints
        .iter()
        .map(|constraint| constraint.joint_name.clone())
        .collect();
    let position = |name: &String| {
        let found = start
            .name
            .iter()
            .position(|known| known == name)
            .and_then(|index| start.position.get(index));
        found.copied().ok_or_else(|| {
            format!("its start_state does not say where {name} is, which its goal moves")
        })
    };
    let from = names
        .iter()
        .map(position)
        .collect::<Result<_, _>>()?;
    let to = constraints
        .iter()
        .map(|constraint| constraint.position)
        .collect();
    let point = |positions| TrajectoryPoint {
        positions,
        ..TrajectoryPoint::default()
    };
    Ok((names, vec![point(from), point(to)]))
}

fn checked((names, points): (Vec<String>, Vec<TrajectoryPoint>)) -> Parsed {
    for (index, point) in points.iter().enumerate() {
        let lists = [
            ("positions", &point.positions),
            ("velocities", &point.velocities),
            ("accelerations", &point.accelerations),
        ];
        for (what, list) in lists {
            if list.len() != names.len() && (what == "positions" || !list.is_empty()) {
                let got = list.len();
                let columns = names.len();
                return Err(format!(
                    "point {index} has {got} {what}, joint_names names {columns} joints"
                ));
            }
            if let Some(value) = list.iter().find(|value| !value.is_finite()) {
                return Err(format!(
                    "point {index} has {value} in its {what}; numbers must be finite"
                ));
            }
        }
    }
    Ok((names, points))
}
