//! Frames of sensors: the head of a message whose body is the points.

use super::few;
use serde::{Deserialize, Serialize};

/// What a frame is, besides its points.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CloudFrame {
    /// When the sensor saw it, in nanoseconds of `CLOCK_MONOTONIC`; not in the future.
    pub taken_ns: u64,
    /// Position (m) and unit quaternion x, y, z, w of the frame in which the points are given: in
    /// the frame of `link`, or in the world.
    pub pose: [f64; 7],
    /// Label of the robot that may be in the picture, whose points are left out; empty = there is
    /// none.
    pub robot: String,
    /// The robot's link that carries the sensor; empty = it stands in the world.
    pub link: String,
    /// Where the robot's variables were at that moment (m or rad), by name; each one exactly once.
    #[serde(deserialize_with = "few::list")]
    pub joints: Vec<(String, f64)>,
    /// How the points lie in the body.
    pub layout: PointLayout,
}

/// How points lie in bytes: the fields of ROS's `PointCloud2` that say so.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PointLayout {
    /// Rows.
    pub height: u32,
    /// Points of a row.
    pub width: u32,
    /// Bytes from a point to the next.
    pub point_step: u32,
    /// Bytes from a row to the next.
    pub row_step: u32,
    /// Whether numbers begin with their highest byte.
    pub is_bigendian: bool,
    /// What a point has: `x`, `y` and `z` at least.
    #[serde(deserialize_with = "few::list")]
    pub fields: Vec<PointField>,
}

/// A field of each point.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PointField {
    /// Its name.
    pub name: String,
    /// Where it begins in a point (bytes).
    pub offset: u32,
    /// Its type, by `PointField`'s numbers: 7 = f32, 8 = f64.
    pub datatype: u8,
    /// How many of them there are.
    pub count: u32,
}

impl PointField {
    /// `PointField::FLOAT32`.
    pub const FLOAT32: u8 = 7;
    /// `PointField::FLOAT64`.
    pub const FLOAT64: u8 = 8;
}

impl PointLayout {
    /// Of points that are three numbers x, y, z each, one after the other.
    pub fn packed(points: u32, datatype: u8) -> Self {
        let size = if datatype == PointField::FLOAT64 {
            8
        } else {
            4
        };
        let field = |(index, name): (u32, &str)| PointField {
            name: name.to_owned(),
            offset: index * size,
            datatype,
            count: 1,
        };
        Self {
            height: 1,
            width: points,
            point_step: 3 * size,
            row_step: 3 * size * points,
            is_bigendian: false,
            fields: [(0, "x"), (1, "y"), (2, "z")].map(field).into(),
        }
    }
}

/// What came of a frame.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct FrameSummary {
    /// The scene's label.
    pub label: String,
    /// The sensed object.
    pub object: String,
    /// The scene's version with it.
    pub scene_version: u64,
    /// Content of that version.
    pub scene_hash: u64,
    /// Points that came.
    pub came: u32,
    /// Points that are not finite.
    pub not_finite: u32,
    /// Points left out as the robot's or of what it carries.
    pub on_robot: u32,
    /// Of these, points that only the padding holds: the world may be there.
    pub in_padding: u32,
    /// Points that stand for others in their cells.
    pub thinned: u32,
    /// Points of the shape.
    pub points: u32,
    /// What a person should know, one line each.
    pub warnings: Vec<String>,
}
