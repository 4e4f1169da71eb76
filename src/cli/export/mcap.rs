//! An answer as MCAP: what Foxglove and other viewers show without ROS. Messages are JSON.
//!
//! A path has no times. It is shown over [`SHOWN_S`] seconds, at an even pace along its columns.

use std::collections::BTreeMap;
use std::io::Cursor;

use mcap::records::MessageHeader;
use mcap::{WriteOptions, Writer};
use serde_json::{Value, json};
use taut::files::ResultFile;
use taut::path::Path;
use taut::robot::{Kinematics, RobotModel};

use super::picture::{scene, timestamp, transforms};
use super::surroundings::Surroundings;
use crate::cli::error::CliError;

/// How long a path is shown (s).
const SHOWN_S: f64 = 10.0;
/// Frames in that time.
const FRAMES: u32 = 300;

/// Bytes of the file. Without surroundings it has the joints only.
pub(super) fn bytes(
    result: &ResultFile,
    around: Option<&Surroundings>,
) -> Result<Vec<u8>, CliError> {
    let picture = around
        .map(|around| scene(&around.robot, &around.scene))
        .transpose()?;
    let mut recording = Recording::new().map_err(failed)?;
    recording.joints_and_corridor(result).map_err(failed)?;
    if let (Some(around), Some(picture)) = (around, picture) {
        recording
            .moving_robot(result, &around.robot, &picture)
            .map_err(failed)?;
    }
    recording.finish().map_err(failed)
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
        let after = self.channel("/joints", "taut.JointState", &joint_state_schema())?;
        self.joints(after, result, &result.path)?;
        let before = self.channel("/joints/before", "taut.JointState", &joint_state_schema())?;
        self.joints(before, result, &result.path_before)?;
        if let Some(corridor) = &result.corridor {
            let channel = self.channel("/corridor", "taut.Corridor", &corridor_schema())?;
            let times = times(&result.path);
            for (segment, slack) in corridor.slack_m.iter().enumerate() {
                let time = times[segment];
                let floor = corridor.floor_m;
                let message = json!({
                    "timestamp": timestamp(time), "segment": segment, "slack_m": slack, "floor_m": floor
                });
                self.write(channel, time, &message)?;
            }
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
        let Some(path) = Path::from_rows(result.variables.len(), in_order(result, robot)) else {
            return Ok(());
        };
        let channel = self.channel(
            "/transforms",
            "foxglove.FrameTransforms",
            &transforms_schema(),
        )?;
        let given = |name: &String| result.subject.held.get(name).copied();
        let held = robot
            .held()
            .iter()
            .map(|variable| given(&variable.name).unwrap_or(variable.default));
        let held: Vec<f64> = held.collect();
        let mut kinematics = Kinematics::default();
        let times = times(&result.path);
        for frame in 0..=FRAMES {
            let time = (SHOWN_S * 1e9 * f64::from(frame) / f64::from(FRAMES)) as u64;
            let next = times
                .partition_point(|known| *known <= time)
                .clamp(1, times.len().max(2) - 1);
            let from = path.waypoint(next - 1);
            let to = path.waypoint(next.min(path.len() - 1));
            let begin = times[next - 1];
            let end = times[next.min(times.len() - 1)];
            let ratio = if end > begin {
                (time - begin) as f64 / (end - begin) as f64
            } else {
                0.0
            };
            kinematics.update(
                robot,
                &robot.space().between(from, to, ratio.min(1.0)),
                &held,
            );
            self.write(channel, time, &transforms(robot, &kinematics, time))?;
        }
        Ok(())
    }

    fn joints(
        &mut self,
        channel: u16,
        result: &ResultFile,
        rows: &[Vec<f64>],
    ) -> mcap::McapResult<()> {
        for (row, time) in rows.iter().zip(times(rows)) {
            let message =
                json!({ "timestamp": timestamp(time), "name": result.variables, "position": row });
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

/// The path's rows end to end, columns in the robot's order: the robot was made for them.
fn in_order(result: &ResultFile, robot: &RobotModel) -> Vec<f64> {
    let column = |variable: &taut::robot::Variable| {
        result
            .variables
            .iter()
            .position(|name| *name == variable.name)
    };
    let columns: Vec<usize> = robot.variables().iter().filter_map(column).collect();
    result
        .path
        .iter()
        .flat_map(|row| columns.iter().map(|&column| row[column]))
        .collect()
}

/// When each waypoint is shown (ns).
fn times(rows: &[Vec<f64>]) -> Vec<u64> {
    let step = |ends: &[Vec<f64>]| {
        ends[0]
            .iter()
            .zip(&ends[1])
            .map(|(a, b)| (b - a).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    let mut reached = vec![0.0];
    reached.extend(rows.windows(2).scan(0.0, |sum, ends| {
        *sum += step(ends);
        Some(*sum)
    }));
    let whole = reached[reached.len() - 1].max(f64::MIN_POSITIVE);
    reached
        .iter()
        .map(|part| (SHOWN_S * 1e9 * part / whole) as u64)
        .collect()
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
