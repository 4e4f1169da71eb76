//! An answer as MCAP: what Foxglove and other viewers show without ROS. Messages are JSON.
//!
//! A trajectory has its times. A path has none: it is shown over [`SHOWN_S`] seconds, at an even pace along
//! its columns.

use std::collections::BTreeMap;
use std::io::Cursor;

use mcap::records::MessageHeader;
use mcap::{WriteOptions, Writer};
use serde_json::{Value, json};
use taut::files::ResultFile;
use taut::files::result::{ResultCorridor, ResultTrajectory};
use taut::path::Path;
use taut::robot::{Kinematics, RobotModel};
use taut::validation::timed::Curve;

use super::picture::{scene, timestamp, transforms};
use super::surroundings::Surroundings;
use super::trajectory;
use crate::cli::error::CliError;

/// How long a path is shown (s).
const SHOWN_S: f64 = 10.0;
/// Frames in a second.
const FRAMES_PER_S: f64 = 30.0;

/// Bytes of the file. Without surroundings it has the joints only.
pub(super) fn bytes(
    result: &ResultFile,
    around: Option<&Surroundings>,
) -> Result<Vec<u8>, CliError> {
    recorded(result, around).map_err(failed)
}

/// The recording of an answer, with the robot and the picture of the scene where both are known.
fn recorded(result: &ResultFile, around: Option<&Surroundings>) -> mcap::McapResult<Vec<u8>> {
    let mut recording = Recording::new()?;
    recording.joints_and_corridor(result)?;
    if let Some(around) = around {
        let picture = scene(&around.robot, &around.scene);
        recording.moving_robot(result, &around.robot, &picture)?;
    }
    recording.finish()
}

fn failed(error: mcap::McapError) -> CliError {
    CliError::Output {
        file: "MCAP".to_owned(),
        source: std::io::Error::other(error.to_string()),
    }
}

struct Recording {
    writer: Writer<Cursor<Vec<u8>>>,
    sequence: u32,
}

impl Recording {
    fn new() -> mcap::McapResult<Self> {
        // Neither compression nor anything of the machine: the same answer makes the same bytes.
        let options = WriteOptions::new()
            .compression(None)
            .library(concat!("taut ", env!("CARGO_PKG_VERSION")));
        Ok(Self {
            writer: options.create(Cursor::new(Vec::new()))?,
            sequence: 0,
        })
    }

    fn joints_and_corridor(&mut self, result: &ResultFile) -> mcap::McapResult<()> {
        match trajectory::of(result) {
            Some(found) => self.trajectory(result, found)?,
            None => self.joints("/joints", result, &result.path)?,
        }
        self.joints("/joints/before", result, &result.path_before)?;
        match &result.corridor {
            Some(corridor) => self.corridor(corridor, &times(&result.path)),
            None => Ok(()),
        }
    }

    fn corridor(&mut self, corridor: &ResultCorridor, times: &[u64]) -> mcap::McapResult<()> {
        let channel = self.channel("/corridor", "taut.Corridor", &corridor_schema())?;
        for (segment, slack) in corridor.slack_m.iter().enumerate() {
            let time = times[segment];
            let floor = corridor.floor_m;
            let message = json!({
                "timestamp": timestamp(time), "segment": segment, "slack_m": slack, "floor_m": floor
            });
            self.write(channel, time, &message)?;
        }
        Ok(())
    }

    fn moving_robot(
        &mut self,
        result: &ResultFile,
        robot: &RobotModel,
        picture: &Value,
    ) -> mcap::McapResult<()> {
        let channel = self.channel("/scene", "foxglove.SceneUpdate", &scene_schema())?;
        self.write(channel, 0, picture)?;
        let Some(motion) = Motion::of(result, robot) else {
            return Ok(());
        };
        let schema = transforms_schema();
        let channel = self.channel("/transforms", "foxglove.FrameTransforms", &schema)?;
        let mut kinematics = Kinematics::default();
        let shown_s = motion.duration_s();
        let frames = (shown_s * FRAMES_PER_S).ceil().max(1.0) as u32;
        for frame in 0..=frames {
            let time = (shown_s * 1e9 * f64::from(frame) / f64::from(frames)) as u64;
            kinematics.update(robot, &motion.at(time), &motion.held);
            self.write(channel, time, &transforms(robot, &kinematics, time))?;
        }
        Ok(())
    }

    fn joints(
        &mut self,
        topic: &str,
        result: &ResultFile,
        rows: &[Vec<f64>],
    ) -> mcap::McapResult<()> {
        let channel = self.channel(topic, "taut.JointState", &joint_state_schema())?;
        for (row, time) in rows.iter().zip(times(rows)) {
            let message =
                json!({ "timestamp": timestamp(time), "name": result.variables, "position": row });
            self.write(channel, time, &message)?;
        }
        Ok(())
    }

    /// The points of a trajectory, at their times.
    fn trajectory(
        &mut self,
        result: &ResultFile,
        found: &ResultTrajectory,
    ) -> mcap::McapResult<()> {
        let channel = self.channel("/joints", "taut.MovingJointState", &moving_schema())?;
        for (point, ns) in found.times_ns.iter().enumerate() {
            let time = ns.unsigned_abs();
            let message = json!({
                "timestamp": timestamp(time), "name": result.variables,
                "position": found.positions[point], "velocity": found.velocities.get(point).unwrap_or(&Vec::new()),
            });
            self.write(channel, time, &message)?;
        }
        Ok(())
    }

    fn channel(&mut self, topic: &str, name: &str, schema: &Value) -> mcap::McapResult<u16> {
        let schema = self
            .writer
            .add_schema(name, "jsonschema", schema.to_string().as_bytes())?;
        self.writer
            .add_channel(schema, topic, "json", &BTreeMap::new())
    }

    fn write(&mut self, channel_id: u16, time: u64, message: &Value) -> mcap::McapResult<()> {
        let header = MessageHeader {
            channel_id,
            sequence: self.sequence,
            log_time: time,
            publish_time: time,
        };
        self.sequence += 1;
        self.writer
            .write_to_known_channel(&header, message.to_string().as_bytes())
    }

    fn finish(mut self) -> mcap::McapResult<Vec<u8>> {
        self.writer.finish()?;
        Ok(self.writer.into_inner().into_inner())
    }
}

/// A robot on its path, as it is shown.
struct Motion<'a> {
    robot: &'a RobotModel,
    path: Path,
    /// When each waypoint is shown (ns).
    times: Vec<u64>,
    /// What is executed, where that is known.
    curve: Option<Curve>,
    /// Where each held joint stands.
    held: Vec<f64>,
}

impl<'a> Motion<'a> {
    /// `None` where the path is empty.
    fn of(result: &ResultFile, robot: &'a RobotModel) -> Option<Self> {
        Some(Self {
            path: Path::from_rows(result.variables.len(), in_order(result, robot))?,
            times: times(&result.path),
            curve: trajectory::of(result).and_then(|found| {
                trajectory::curve(found, robot, &columns_of(robot, &result.variables))
            }),
            held: held(result, robot),
            robot,
        })
    }

    /// How long it is shown (s).
    fn duration_s(&self) -> f64 {
        self.curve.as_ref().map_or(SHOWN_S, |curve| {
            let last = curve.segments() - 1;
            curve.time(last) + curve.duration(last)
        })
    }

    /// Where the robot is at a time (ns).
    fn at(&self, time: u64) -> Vec<f64> {
        if let Some(curve) = &self.curve {
            return trajectory::at(curve, self.path.nq(), time as f64 / 1e9);
        }
        let times = &self.times;
        let next = times
            .partition_point(|known| *known <= time)
            .clamp(1, times.len().max(2) - 1);
        let from = self.path.waypoint(next - 1);
        let to = self
            .path
            .waypoint(next.min(self.path.len() - 1));
        let ratio = part_of(time, times[next - 1], times[next.min(times.len() - 1)]);
        self.robot.space().between(from, to, ratio)
    }
}

/// The part of an interval of time that is over at `time`, 1 after its end.
fn part_of(time: u64, begin: u64, end: u64) -> f64 {
    if end > begin {
        ((time - begin) as f64 / (end - begin) as f64).min(1.0)
    } else {
        0.0
    }
}

/// Where each held joint of an answer stands.
fn held(result: &ResultFile, robot: &RobotModel) -> Vec<f64> {
    let given = &result.subject.held;
    robot
        .held()
        .iter()
        .map(|variable| {
            given
                .get(&variable.name)
                .copied()
                .unwrap_or(variable.default)
        })
        .collect()
}

/// The path's rows end to end, columns in the robot's order: the robot was made for them.
fn in_order(result: &ResultFile, robot: &RobotModel) -> Vec<f64> {
    let columns = columns_of(robot, &result.variables);
    result
        .path
        .iter()
        .flat_map(|row| columns.iter().map(|&column| row[column]))
        .collect()
}

/// Where each variable of the robot stands among these.
fn columns_of(robot: &RobotModel, variables: &[String]) -> Vec<usize> {
    robot
        .variables()
        .iter()
        .filter_map(|variable| {
            variables
                .iter()
                .position(|name| *name == variable.name)
        })
        .collect()
}

/// When each waypoint is shown (ns).
fn times(rows: &[Vec<f64>]) -> Vec<u64> {
    let mut reached = vec![0.0];
    reached.extend(rows.windows(2).scan(0.0, |sum, ends| {
        *sum += distance(&ends[0], &ends[1]);
        Some(*sum)
    }));
    let whole = reached[reached.len() - 1].max(f64::MIN_POSITIVE);
    reached
        .iter()
        .map(|part| (SHOWN_S * 1e9 * part / whole) as u64)
        .collect()
}

fn distance(from: &[f64], to: &[f64]) -> f64 {
    from.iter()
        .zip(to)
        .map(|(a, b)| (b - a).powi(2))
        .sum::<f64>()
        .sqrt()
}

fn object(properties: Value) -> Value {
    json!({ "type": "object", "properties": properties })
}

fn list(items: Value) -> Value {
    json!({ "type": "array", "items": items })
}

fn time_schema() -> Value {
    object(json!({ "sec": { "type": "integer" }, "nsec": { "type": "integer" } }))
}

fn vector_schema() -> Value {
    object(
        json!({ "x": { "type": "number" }, "y": { "type": "number" }, "z": { "type": "number" } }),
    )
}

fn rotation_schema() -> Value {
    let number = json!({ "type": "number" });
    object(json!({ "x": number, "y": number, "z": number, "w": number }))
}

fn joint_state_schema() -> Value {
    let names = list(json!({ "type": "string" }));
    let positions = list(json!({ "type": "number" }));
    object(json!({ "timestamp": time_schema(), "name": names, "position": positions }))
}

fn moving_schema() -> Value {
    let numbers = list(json!({ "type": "number" }));
    let mut schema = joint_state_schema();
    schema["properties"]["velocity"] = numbers;
    schema
}

fn corridor_schema() -> Value {
    let number = json!({ "type": "number" });
    let segment = json!({ "type": "integer" });
    object(
        json!({ "timestamp": time_schema(), "segment": segment, "slack_m": number, "floor_m": number }),
    )
}

fn transforms_schema() -> Value {
    let name = json!({ "type": "string" });
    let transform = object(json!({
        "timestamp": time_schema(), "parent_frame_id": name, "child_frame_id": name,
        "translation": vector_schema(), "rotation": rotation_schema(),
    }));
    object(json!({ "transforms": list(transform) }))
}

fn scene_schema() -> Value {
    let name = json!({ "type": "string" });
    let number = json!({ "type": "number" });
    let flag = json!({ "type": "boolean" });
    let pose = object(json!({ "position": vector_schema(), "orientation": rotation_schema() }));
    let color = object(json!({ "r": number, "g": number, "b": number, "a": number }));
    let sized = object(json!({ "pose": pose, "size": vector_schema(), "color": color }));
    let cylinder = object(json!({
        "pose": pose, "size": vector_schema(), "bottom_scale": number, "top_scale": number, "color": color
    }));
    let triangles = object(json!({
        "pose": pose, "points": list(vector_schema()), "color": color, "colors": list(color.clone()),
        "indices": list(json!({ "type": "integer" })),
    }));
    let any = list(object(json!({})));
    let entity = object(json!({
        "timestamp": time_schema(), "frame_id": name, "id": name, "lifetime": time_schema(), "frame_locked": flag,
        "metadata": any, "arrows": any, "cubes": list(sized.clone()), "spheres": list(sized),
        "cylinders": list(cylinder), "lines": any, "triangles": list(triangles), "texts": any, "models": any,
    }));
    object(json!({ "deletions": any, "entities": list(entity) }))
}
