//! Numbers, points and quaternions as texts have them. A number that is not finite is refused where
//! it stands.

use std::fmt;

use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

/// A finite number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[serde(transparent)]
pub(crate) struct Finite(pub f64);

impl<'de> Deserialize<'de> for Finite {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let number = f64::deserialize(deserializer)?;
        match number.is_finite() {
            true => Ok(Self(number)),
            false => Err(D::Error::custom(format!("{number} is no finite number"))),
        }
    }
}

/// A point (m): a list, or ROS's message.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[serde(transparent)]
pub(crate) struct Point(pub [f64; 3]);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PointMessage {
    x: Finite,
    y: Finite,
    z: Finite,
}

impl<'de> Deserialize<'de> for Point {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct PointVisitor;
        impl<'de> Visitor<'de> for PointVisitor {
            type Value = Point;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a list [x, y, z] or { x, y, z }")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Point, A::Error> {
                let list = <[Finite; 3]>::deserialize(SeqAccessDeserializer::new(list))?;
                Ok(Point(list.map(|number| number.0)))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Point, A::Error> {
                let PointMessage { x, y, z } =
                    PointMessage::deserialize(MapAccessDeserializer::new(map))?;
                Ok(Point([x.0, y.0, z.0]))
            }
        }
        deserializer.deserialize_any(PointVisitor)
    }
}

/// A quaternion: ROS's message, or a list x, y, z, w.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Quaternion {
    pub x: f64,
    pub y: f64,
    pub z: f64,
    pub w: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct QuaternionMessage {
    x: Finite,
    y: Finite,
    z: Finite,
    w: Finite,
}

impl Default for Quaternion {
    fn default() -> Self {
        Self {
            x: 0.0,
            y: 0.0,
            z: 0.0,
            w: 1.0,
        }
    }
}

impl Quaternion {
    pub fn to_array(self) -> [f64; 4] {
        [self.x, self.y, self.z, self.w]
    }

    /// Bit by bit: -0 is another content.
    pub fn is_identity(&self) -> bool {
        self.to_array().map(f64::to_bits) == Self::default().to_array().map(f64::to_bits)
    }
}

impl<'de> Deserialize<'de> for Quaternion {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct QuaternionVisitor;
        impl<'de> Visitor<'de> for QuaternionVisitor {
            type Value = Quaternion;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("{ x, y, z, w } or a list [x, y, z, w]")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Quaternion, A::Error> {
                let list = <[Finite; 4]>::deserialize(SeqAccessDeserializer::new(list))?;
                let [x, y, z, w] = list.map(|number| number.0);
                Ok(Quaternion { x, y, z, w })
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Quaternion, A::Error> {
                let QuaternionMessage { x, y, z, w } =
                    QuaternionMessage::deserialize(MapAccessDeserializer::new(map))?;
                Ok(Quaternion {
                    x: x.0,
                    y: y.0,
                    z: z.0,
                    w: w.0,
                })
            }
        }
        deserializer.deserialize_any(QuaternionVisitor)
    }
}

/// A triangle's corners: a list, or ROS's message.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub(super) struct Corners(pub [u32; 3]);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TriangleMessage {
    vertex_indices: [u32; 3],
}

impl<'de> Deserialize<'de> for Corners {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct CornersVisitor;
        impl<'de> Visitor<'de> for CornersVisitor {
            type Value = Corners;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a list of three vertices or { vertex_indices: […] }")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Corners, A::Error> {
                <[u32; 3]>::deserialize(SeqAccessDeserializer::new(list)).map(Corners)
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Corners, A::Error> {
                let message = TriangleMessage::deserialize(MapAccessDeserializer::new(map))?;
                Ok(Corners(message.vertex_indices))
            }
        }
        deserializer.deserialize_any(CornersVisitor)
    }
}
