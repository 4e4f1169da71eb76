//! Limits of velocity and acceleration: MoveIt's `joint_limits.yaml`, and what a robot's own file says.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use serde::Deserialize;

use super::{FileError, read_text, yaml};
use crate::robot::{Drive, RobotModel};
use crate::timing::{ColumnLimits, Limits, Range};

/// Limits of joints by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LimitsFile {
    file: PathBuf,
    joints: BTreeMap<String, JointLimits>,
    /// Whether it has scaling factors, which only a request of MoveIt's uses.
    pub has_scaling: bool,
}

/// A joint's limits as MoveIt's file has them; what it says of positions and jerk is not read here.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub(super) struct JointLimits {
    has_velocity_limits: bool,
    max_velocity: Option<f64>,
    min_velocity: Option<f64>,
    has_acceleration_limits: bool,
    max_acceleration: Option<f64>,
    min_acceleration: Option<f64>,
}

/// What a file says.
#[derive(Clone, Debug, Default, Deserialize)]
pub(super) struct Written {
    pub default_velocity_scaling_factor: Option<f64>,
    pub default_acceleration_scaling_factor: Option<f64>,
    pub joint_limits: Option<BTreeMap<String, JointLimits>>,
}

/// Where a column's accelerations come from that no file limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Acceleration {
    /// So many (m or rad per s²).
    Of(f64),
    /// As many as the greatest velocity, this many times a second.
    Times(f64),
}

impl FromStr for Acceleration {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (number, of): (&str, fn(f64) -> Self) = match text.strip_suffix("/s") {
            Some(number) => (number, Self::Times),
            None => (text, Self::Of),
        };
        let size = number
            .trim()
            .parse()
            .ok()
            .filter(|size: &f64| *size > 0.0 && size.is_finite());
        size.map(of).ok_or_else(|| {
            format!("acceleration {text:?}; give 2/s (twice the velocity limit per second) or 1.5 (rad/s² or m/s²), above 0")
        })
    }
}

impl fmt::Display for Acceleration {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Of(size) => write!(f, "{size}"),
            Self::Times(times) => write!(f, "{times}/s"),
        }
    }
}

/// The text of a file of limits, which may be JSON or YAML whatever its name.
///
/// # Errors
/// A file that cannot be read.
pub fn limits_text(file: &Path) -> Result<String, FileError> {
    read_text(file)
}

impl LimitsFile {
    /// Reads a file, YAML or JSON.
    ///
    /// # Errors
    /// A file that cannot be read, or is none of limits.
    pub fn read(file: &Path) -> Result<Self, FileError> {
        let text = read_text(file)?;
        Self::parse(&text, file).map_err(|text| FileError::content(file, text))
    }

    pub(super) fn parse(text: &str, file: &Path) -> Result<Self, String> {
        let written = match yaml::is_yaml(file) {
            true => yaml::documents(text)?
                .into_iter()
                .next()
                .ok_or("it is empty")?,
            false => serde_json::from_str(text).map_err(|error| error.to_string())?,
        };
        Self::of(written, file)
    }

    /// What is written in a file.
    pub(super) fn of(written: Written, file: &Path) -> Result<Self, String> {
        let joints = written.joint_limits.ok_or(
            "no joint_limits; expected MoveIt's joint_limits.yaml: joint_limits: {NAME: {has_velocity_limits: true, max_velocity: 1.0, …}}",
        )?;
        for (name, limits) in &joints {
            limits.check(name)?;
        }
        let factors = [
            written.default_velocity_scaling_factor,
            written.default_acceleration_scaling_factor,
        ];
        Ok(Self {
            file: file.to_owned(),
            joints,
            has_scaling: factors
                .iter()
                .flatten()
                .any(|factor| *factor != 1.0),
        })
    }

    /// The limits of a robot's columns; of those that do not move, what there is.
    ///
    /// # Errors
    /// A column that moves and has no limit: which, where it was looked for, and what would give one; a
    /// joint that the robot does not have.
    pub fn limits(
        &self,
        robot: &RobotModel,
        moves: impl Fn(usize) -> bool,
        acceleration: Option<Acceleration>,
    ) -> Result<Limits, String> {
        self.check_names(robot)?;
        let columns = robot.variables().iter().enumerate();
        let limits = columns.map(|(column, variable)| {
            let own = self.of_column(robot, column, acceleration);
            if !moves(column) {
                return Ok(own.ok().flatten().unwrap_or(FREE));
            }
            own?.ok_or_else(|| self.missing(&variable.name))
        });
        Ok(Limits::new(limits.collect::<Result<_, String>>()?))
    }

    /// The limits of a column and of the joints that follow it; `Ok(None)` where it has none of velocity.
    fn of_column(
        &self,
        robot: &RobotModel,
        column: usize,
        acceleration: Option<Acceleration>,
    ) -> Result<Option<ColumnLimits>, String> {
        let name = &robot.variables()[column].name;
        let Some(velocity) = self.velocity(robot, name) else {
            return Ok(None);
        };
        let own = self.joints.get(name);
        let given = own.and_then(JointLimits::acceleration);
        let most = velocity.most.min(-velocity.least);
        let asked = acceleration.map(|acceleration| match acceleration {
            Acceleration::Of(size) => Range::symmetric(size),
            Acceleration::Times(times) => Range::symmetric(times * most),
        });
        let acceleration = given
            .or(asked)
            .ok_or_else(|| self.no_acceleration(name))?;
        let limits = ColumnLimits {
            velocity,
            acceleration,
        };
        Ok(Some(self.with_followers(robot, column, limits)))
    }

    /// What a file or the robot's own says.
    fn velocity(&self, robot: &RobotModel, joint: &str) -> Option<Range> {
        let given = self
            .joints
            .get(joint)
            .and_then(JointLimits::velocity);
        let motors = &robot.description().motors;
        let own = motors
            .iter()
            .find(|motor| motor.joint == joint)
            .and_then(|motor| motor.velocity);
        given.or(own.map(Range::symmetric))
    }

    /// No follower of a column is faster than it may be.
    fn with_followers(
        &self,
        robot: &RobotModel,
        column: usize,
        mut limits: ColumnLimits,
    ) -> ColumnLimits {
        for joint in robot.joints() {
            let Drive::Mimic {
                master, multiplier, ..
            } = joint.drive
            else {
                continue;
            };
            let follows =
                matches!(robot.joints()[master].drive, Drive::Variable { q, .. } if q == column);
            if !follows || multiplier == 0.0 {
                continue;
            }
            let given = self.joints.get(&joint.name);
            let accelerations = given.and_then(JointLimits::acceleration);
            if let Some(range) = self.velocity(robot, &joint.name) {
                limits.velocity = limits
                    .velocity
                    .within(range.divided(multiplier));
            }
            if let Some(range) = accelerations {
                limits.acceleration = limits
                    .acceleration
                    .within(range.divided(multiplier));
            }
        }
        limits
    }

    /// The same, called by the name of another file.
    pub(super) fn named(self, file: &Path) -> Self {
        let file = file.to_owned();
        Self { file, ..self }
    }

    fn check_names(&self, robot: &RobotModel) -> Result<(), String> {
        let has = |name: &str| {
            robot
                .joints()
                .iter()
                .any(|joint| joint.name == name)
        };
        let known = robot
            .variables()
            .iter()
            .any(|variable| self.joints.contains_key(&variable.name));
        let unknown = self.joints.keys().find(|name| !has(name));
        match unknown {
            // A file may be of a robot with a hand more or less, but not of another robot.
            Some(name) if !known => Err(format!(
                "{}: {name:?} is no joint of {}, nor is any other of the file; its columns: {}",
                self.file.display(),
                robot.name(),
                names(robot)
            )),
            _ => Ok(()),
        }
    }

    fn missing(&self, name: &str) -> String {
        format!(
            "{name} moves and has no velocity limit: {}the URDF's <limit velocity> says none; give --limits FILE with max_velocity for it",
            self.silent_file()
        )
    }

    fn no_acceleration(&self, name: &str) -> String {
        format!(
            "{name} moves and has no acceleration limit: {}a URDF has none; give --limits FILE (MoveIt's joint_limits.yaml with has_acceleration_limits and max_acceleration) or --acceleration 2/s (twice the velocity limit per second)",
            self.silent_file()
        )
    }

    fn silent_file(&self) -> String {
        match self.file.as_os_str().is_empty() {
            true => String::new(),
            false => format!("{} gives none, ", self.file.display()),
        }
    }
}

/// What stands still.
const FREE: ColumnLimits = ColumnLimits {
    velocity: Range::FREE,
    acceleration: Range::FREE,
};

pub(super) fn names(robot: &RobotModel) -> String {
    let variables = robot.variables().iter();
    let names: Vec<&str> = variables
        .map(|variable| variable.name.as_str())
        .collect();
    names.join(", ")
}

impl JointLimits {
    fn velocity(&self) -> Option<Range> {
        range(
            self.has_velocity_limits,
            self.max_velocity,
            self.min_velocity,
        )
    }

    fn acceleration(&self) -> Option<Range> {
        range(
            self.has_acceleration_limits,
            self.max_acceleration,
            self.min_acceleration,
        )
    }

    fn check(&self, name: &str) -> Result<(), String> {
        for (what, has, most, least) in [
            (
                "velocity",
                self.has_velocity_limits,
                self.max_velocity,
                self.min_velocity,
            ),
            (
                "acceleration",
                self.has_acceleration_limits,
                self.max_acceleration,
                self.min_acceleration,
            ),
        ] {
            let is_good = |size: f64| size > 0.0 && size.is_finite();
            let is_missing = most.is_none_or(|most| !is_good(most));
            if has && (is_missing || least.is_some_and(|least| !is_good(-least))) {
                return Err(format!(
                    "joint {name:?} has {what} limits, but max_{what} is {} and min_{what} {}; the first must be above 0, the second below 0 or left out",
                    shown(most),
                    shown(least)
                ));
            }
        }
        Ok(())
    }
}

fn shown(value: Option<f64>) -> String {
    value.map_or("missing".to_owned(), |value| value.to_string())
}

fn range(has: bool, most: Option<f64>, least: Option<f64>) -> Option<Range> {
    let most = most.filter(|_| has)?;
    Some(Range {
        least: least.unwrap_or(-most),
        most,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROBOT: &str = r#"<robot name="gripper"><link name="base"/><link name="arm"/><link name="left"/><link name="right"/>
<joint name="lift" type="prismatic"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/><limit lower="0" upper="1" velocity="0.5" effort="9"/></joint>
<joint name="finger" type="prismatic"><parent link="arm"/><child link="left"/><axis xyz="0 1 0"/><limit lower="0" upper="1" velocity="0.4" effort="0"/></joint>
<joint name="other" type="prismatic"><parent link="arm"/><child link="right"/><axis xyz="0 1 0"/><limit lower="-1" upper="0" velocity="0.1" effort="1"/><mimic joint="finger" multiplier="-0.5"/></joint></robot>"#;

    fn robot() -> RobotModel {
        let mut none = |_: &str, _| unreachable!("there is no mesh");
        RobotModel::new(crate::robot::urdf::parse(ROBOT, &mut none).unwrap()).unwrap()
    }

    fn file(text: &str) -> Result<LimitsFile, String> {
        LimitsFile::parse(text, Path::new("joint_limits.yaml"))
    }

    #[test]
    fn a_file_goes_before_the_robots_own_and_followers_count() {
        let limits = file("joint_limits: {finger: {has_velocity_limits: true, max_velocity: 0.3, min_velocity: -0.25, has_acceleration_limits: true, max_acceleration: 2.0}}").unwrap();
        let found = limits
            .limits(&robot(), |_| true, Some(Acceleration::Times(4.0)))
            .unwrap();
        let [lift, finger] = found.columns() else {
            panic!("{found:?}")
        };
        assert_eq!(
            (lift.velocity, lift.acceleration),
            (Range::symmetric(0.5), Range::symmetric(2.0))
        );
        // The other finger goes half as fast, the other way: 0.1 of it are 0.2 of this one.
        assert_eq!(
            (finger.velocity, finger.acceleration),
            (
                Range {
                    least: -0.2,
                    most: 0.2
                },
                Range::symmetric(2.0)
            )
        );
    }

    #[test]
    fn what_is_missing_is_named() {
        let robot = robot();
        let refusal = |text: &str| {
            file(text)
                .and_then(|limits| {
                    limits
                        .limits(&robot, |_| true, None)
                        .map(|_| String::new())
                })
                .unwrap_err()
        };
        let missing = refusal(
            "joint_limits: {finger: {has_acceleration_limits: true, max_acceleration: 2.0}}",
        );
        assert!(
            missing.starts_with(
                "lift moves and has no acceleration limit: joint_limits.yaml gives none"
            ),
            "{missing}"
        );
        assert!(
            refusal("joint_limits: {elbow: {has_velocity_limits: false}}")
                .contains("is no joint of gripper")
        );
        assert!(
            refusal("joint_limits: {lift: {has_velocity_limits: true}}")
                .contains("max_velocity is missing")
        );
        assert!(refusal("limits: {}").contains("no joint_limits"));
        // What does not move needs none.
        let still = file("joint_limits: {}")
            .unwrap()
            .limits(&robot, |_| false, None)
            .unwrap();
        assert_eq!(still.columns(), [FREE, FREE]);
    }
}
