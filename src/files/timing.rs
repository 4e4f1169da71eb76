//! What is asked of a trajectory, as a text: MoveIt's `joint_limits.yaml` with our words beside it, the
//! same in JSON, or few words such as `acceleration=2/s speed=0.5`.

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

use serde::Deserialize;
use serde::de::{Deserializer, Error, Visitor};

use super::limits::{Acceleration, JointLimits, LimitsFile, Written, names};
use super::yaml;
use crate::path;
use crate::robot::RobotModel;
use crate::timing::{self, Controller, Settings};

/// The words of a text, for people.
pub const TIMING_WORDS: &str = "joint_limits (as in MoveIt's joint_limits.yaml), content (such a file's), file (its name, for messages), acceleration (2/s, 1.5), speed (0.5), start_velocity ({joint1: 0.2}), controller (cubic, quintic, linear@100), clearance (m), work";

/// What is asked of a trajectory.
#[derive(Clone, Debug, PartialEq)]
pub struct Timing {
    /// Limits by joints.
    pub limits: LimitsFile,
    /// Of joints of which these say none.
    pub acceleration: Option<Acceleration>,
    /// Part of full speed, above 0 and up to 1.
    pub speed: f64,
    /// How fast joints move at the start (rad or m per s); the others stand still.
    pub start_velocity: BTreeMap<String, f64>,
    /// What goes from point to point.
    pub controller: Controller,
    /// Clearance to keep where it is executed (m); `None` = that of the path.
    pub clearance_m: Option<f64>,
    /// Work after which nothing faster is looked for.
    pub work: u64,
}

/// The words as they are written.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Words {
    file: Option<String>,
    content: Option<String>,
    default_velocity_scaling_factor: Option<f64>,
    default_acceleration_scaling_factor: Option<f64>,
    joint_limits: Option<BTreeMap<String, JointLimits>>,
    acceleration: Option<Quantity>,
    speed: Option<f64>,
    start_velocity: BTreeMap<String, f64>,
    controller: Option<String>,
    clearance: Option<f64>,
    work: Option<u64>,
}

/// A number, or one with a unit.
struct Quantity(String);

impl<'de> Deserialize<'de> for Quantity {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;
        impl Visitor<'_> for Either {
            type Value = Quantity;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a number, or one with a unit such as \"2/s\"")
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Quantity, E> {
                Ok(Quantity(text.to_owned()))
            }

            fn visit_f64<E: Error>(self, number: f64) -> Result<Quantity, E> {
                Ok(Quantity(number.to_string()))
            }

            fn visit_u64<E: Error>(self, number: u64) -> Result<Quantity, E> {
                Ok(Quantity(number.to_string()))
            }

            fn visit_i64<E: Error>(self, number: i64) -> Result<Quantity, E> {
                Ok(Quantity(number.to_string()))
            }
        }
        deserializer.deserialize_any(Either)
    }
}

impl Timing {
    /// What a text asks for; `None` of an empty one.
    ///
    /// # Errors
    /// What it says wrongly, and the valid words.
    pub fn parse(text: &str) -> Result<Option<Self>, String> {
        if text.trim().is_empty() {
            return Ok(None);
        }
        let words = match is_short(text) {
            true => short(text),
            false => document(text),
        };
        let told = |error| format!("timing: {error}; valid words: {TIMING_WORDS}");
        words.and_then(Self::of).map(Some).map_err(told)
    }

    fn of(words: Words) -> Result<Self, String> {
        let acceleration = words.acceleration.as_ref();
        let acceleration = acceleration.map(|text| text.0.parse());
        let speed = words.speed.unwrap_or(1.0);
        if !(speed > 0.0 && speed <= 1.0) {
            return Err(format!("speed {speed}; give a number above 0 and up to 1"));
        }
        if let Some(metres) = words.clearance
            && !(metres.is_finite() && metres > 0.0)
        {
            return Err(format!("clearance {metres}; give metres above 0"));
        }
        Ok(Self {
            acceleration: acceleration.transpose()?,
            speed,
            clearance_m: words.clearance,
            work: words.work.unwrap_or(Settings::DEFAULT_WORK),
            controller: words
                .controller
                .as_deref()
                .map_or(Ok(Controller::default()), controller)?,
            limits: limits(&words)?,
            start_velocity: words.start_velocity,
        })
    }

    /// The same of a robot that goes along a path.
    ///
    /// # Errors
    /// A joint that moves and has no limit: which, where it was looked for, and what would give one; a
    /// joint that the robot does not have.
    pub fn settings(&self, robot: &RobotModel, path: &path::Path) -> Result<Settings, String> {
        let moves = |column| timing::moves(path, column) || self.starts(robot, column);
        let limits = self
            .limits
            .limits(robot, moves, self.acceleration)?;
        Ok(Settings {
            most_work: self.work,
            start_velocity: self.velocities(robot)?,
            controller: self.controller,
            ..Settings::new(limits.at_speed(self.speed))
        })
    }

    /// The velocity of each column at the start; `None` at rest.
    fn velocities(&self, robot: &RobotModel) -> Result<Option<Vec<f64>>, String> {
        let mut velocities = vec![0.0; robot.variables().len()];
        for (name, velocity) in &self.start_velocity {
            let mut variables = robot.variables().iter();
            let column = variables.position(|variable| variable.name == *name);
            let column = column.ok_or_else(|| {
                format!(
                    "start_velocity: {name:?} is no column of {}; valid: {}",
                    robot.name(),
                    names(robot)
                )
            })?;
            velocities[column] = *velocity;
        }
        Ok((!self.start_velocity.is_empty()).then_some(velocities))
    }

    fn starts(&self, robot: &RobotModel, column: usize) -> bool {
        let name = &robot.variables()[column].name;
        self.start_velocity.contains_key(name)
    }
}

/// Whether a text is of few words, each with its value.
fn is_short(text: &str) -> bool {
    text.split_whitespace()
        .all(|word| word.contains('=') && !word.starts_with(['{', '[', '"']))
}

fn document(text: &str) -> Result<Words, String> {
    if text.trim_start().starts_with('{') {
        return serde_json::from_str(text).map_err(|error| error.to_string());
    }
    let documents = yaml::documents(text)?;
    documents
        .into_iter()
        .next()
        .ok_or_else(|| "it is empty".to_owned())
}

fn limits(words: &Words) -> Result<LimitsFile, String> {
    let file = Path::new(words.file.as_deref().unwrap_or_default());
    match (&words.content, &words.joint_limits) {
        (Some(_), Some(_)) => Err("give joint_limits or content, not both".to_owned()),
        (Some(content), None) => {
            let named = match content.trim_start().starts_with('{') {
                true => Path::new("content.json"),
                false => Path::new("content.yaml"),
            };
            let read = LimitsFile::parse(content, named)?;
            Ok(read.named(file))
        }
        (None, Some(joints)) => {
            let written = Written {
                default_velocity_scaling_factor: words.default_velocity_scaling_factor,
                default_acceleration_scaling_factor: words.default_acceleration_scaling_factor,
                joint_limits: Some(joints.clone()),
            };
            LimitsFile::of(written, file)
        }
        (None, None) => Ok(LimitsFile::default()),
    }
}

/// `acceleration=2/s speed=0.5 start_velocity=joint1:0.2,joint2:-0.1`.
fn short(text: &str) -> Result<Words, String> {
    let mut words = Words::default();
    for word in text.split_whitespace() {
        let Some((name, value)) = word.split_once('=') else {
            return Err(format!("{word:?} has no value"));
        };
        enter(&mut words, name, value)?;
    }
    Ok(words)
}

fn enter(words: &mut Words, name: &str, value: &str) -> Result<(), String> {
    match name {
        "acceleration" => words.acceleration = Some(Quantity(value.to_owned())),
        "speed" => words.speed = Some(number(name, value)?),
        "clearance" => words.clearance = Some(number(name, value)?),
        "work" => words.work = Some(number(name, value)?),
        "controller" => words.controller = Some(value.to_owned()),
        "start_velocity" => words.start_velocity = named(value)?,
        _ => return Err(format!("no word {name:?}")),
    }
    Ok(())
}

fn controller(text: &str) -> Result<Controller, String> {
    let parsed = text.parse();
    parsed.map_err(|error: timing::controller::NoController| error.to_string())
}

fn number<T: std::str::FromStr>(name: &str, value: &str) -> Result<T, String> {
    let wrong = |_| format!("{name}={value} is no number");
    value.parse().map_err(wrong)
}

fn named(text: &str) -> Result<BTreeMap<String, f64>, String> {
    let pairs = text.split(',').map(|pair| {
        let (name, value) = pair
            .rsplit_once(':')
            .ok_or_else(|| format!("start_velocity {pair:?}; give JOINT:VELOCITY"))?;
        Ok((name.to_owned(), number(name, value)?))
    });
    pairs.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::timing::Range;

    const ROBOT: &str = r#"<robot name="crane"><link name="base"/><link name="arm"/><link name="hook"/>
<joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="0.5" effort="1"/></joint>
<joint name="lift" type="prismatic"><parent link="arm"/><child link="hook"/><axis xyz="0 0 1"/><limit lower="0" upper="1" velocity="0.25" effort="1"/></joint></robot>"#;

    fn robot() -> RobotModel {
        let mut none = |_: &str, _| unreachable!("there is no mesh");
        RobotModel::new(crate::robot::urdf::parse(ROBOT, &mut none).unwrap()).unwrap()
    }

    fn parse(text: &str) -> Timing {
        Timing::parse(text).unwrap().unwrap()
    }

    #[test]
    fn few_words_json_yaml_and_the_content_of_a_file_say_the_same() {
        let words =
            parse("acceleration=2/s speed=0.5 start_velocity=turn:0.2 controller=linear@50");
        let json = r#"{"acceleration": "2/s", "speed": 0.5, "start_velocity": {"turn": 0.2}, "controller": "linear@50"}"#;
        assert_eq!(parse(json), words);
        let yaml =
            "acceleration: 2/s\nspeed: 0.5\nstart_velocity: {turn: 0.2}\ncontroller: linear@50\n";
        assert_eq!(parse(yaml), words);
        let limits = "joint_limits: {turn: {has_acceleration_limits: true, max_acceleration: 3}}\n";
        let file = serde_json::json!({ "content": limits, "file": "mine.yaml" }).to_string();
        let named = parse(&file).limits;
        assert_eq!(
            parse(limits)
                .limits
                .named(Path::new("mine.yaml")),
            named
        );
        assert_eq!(Timing::parse(" \n").unwrap(), None);
    }

    #[test]
    fn speed_scales_what_files_and_robot_say() {
        let asked = parse(
            "speed: 0.5\nacceleration: 1.5\njoint_limits: {turn: {has_acceleration_limits: true, max_acceleration: 4, min_acceleration: -2}}",
        );
        let path = path::Path::from_rows(2, vec![0.0, 0.0, 0.5, 0.5]).unwrap();
        let settings = asked.settings(&robot(), &path).unwrap();
        let [turn, lift] = settings.limits.columns() else {
            panic!("two columns")
        };
        let range = |least: f64, most: f64| Range { least, most };
        assert_eq!(
            (turn.velocity, turn.acceleration),
            (range(-0.25, 0.25), range(-0.5, 1.0))
        );
        assert_eq!(
            (lift.velocity, lift.acceleration),
            (range(-0.125, 0.125), range(-0.375, 0.375))
        );
    }

    #[test]
    fn what_stands_still_needs_no_limit_and_what_starts_does() {
        let path = path::Path::from_rows(2, vec![0.0, 0.0, 0.5, 0.0]).unwrap();
        let turn = "joint_limits: {turn: {has_acceleration_limits: true, max_acceleration: 4}}";
        assert!(parse(turn).settings(&robot(), &path).is_ok());
        let starts = format!("{turn}\nstart_velocity: {{lift: 0.1}}");
        let error = parse(&starts)
            .settings(&robot(), &path)
            .unwrap_err();
        assert!(
            error.starts_with("lift moves and has no acceleration limit"),
            "{error}"
        );
    }

    #[test]
    fn wrong_words_are_told_with_the_valid_ones() {
        for (text, word) in [
            ("acceleration=2/s sped=1", "sped"),
            ("{\"speeed\": 1}", "speeed"),
            ("speed=2", "above 0 and up to 1"),
            ("acceleration=-1", "above 0"),
            ("start_velocity=turn", "JOINT:VELOCITY"),
            ("controller=linear@0", "linear@250"),
            ("clearance=-1", "metres above 0"),
            ("fast", "expected"),
        ] {
            let error = Timing::parse(text).unwrap_err();
            assert!(
                error.contains(word) && error.contains("valid words"),
                "{text}: {error}"
            );
            assert!(!error.contains('\n'), "{error}");
        }
    }
}
