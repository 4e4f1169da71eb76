//! MoveIt's octomap as its messages have it.

use std::fmt;

use serde::de::{SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use super::SceneError;
use super::cloud_file::{CloudFile, unknown};
use super::object_file::{ObjectFile, Operation};
use super::pose_file::{HeaderFile, PoseFile};
use crate::shape::Cloud;
use crate::shape::cloud::{Making, Source};
use crate::shape::sensed::{Draft, Octomap, Stream};

/// The id of the object that the octomap is, by which collision matrices, paddings and messages name it.
pub(super) const OCTOMAP: &str = "<octomap>";

/// `octomap_msgs/OctomapWithPose`, or the octomap itself. `unknown` is ours.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct OctomapFile {
    #[serde(default, skip_serializing_if = "HeaderFile::is_empty")]
    header: HeaderFile,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    origin: Option<PoseFile>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    octomap: Option<Box<OctomapFile>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    unknown: Option<String>,
    #[serde(default)]
    binary: bool,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    id: String,
    #[serde(default)]
    resolution: f64,
    #[serde(default)]
    data: Bytes,
}

impl OctomapFile {
    /// The object that it is; none where it holds nothing.
    pub(super) fn object(self, place: &str) -> Result<Option<ObjectFile>, SceneError> {
        let map = self.octomap.as_deref().unwrap_or(&self);
        if map.data.0.is_empty() {
            return Ok(None);
        }
        let said = self
            .unknown
            .as_deref()
            .or(map.unknown.as_deref());
        let cloud = map
            .cloud(place, said)
            .map_err(|reason| SceneError::Cloud {
                id: OCTOMAP.to_owned(),
                reason,
            })?;
        Ok(Some(ObjectFile {
            id: OCTOMAP.to_owned(),
            operation: Some(Operation::Add),
            header: self.header,
            pose: self.origin,
            octomap: Some(CloudFile::made(cloud)),
            ..ObjectFile::default()
        }))
    }

    fn cloud(&self, place: &str, said: Option<&str>) -> Result<Cloud, String> {
        let stream = match self.binary {
            true => Stream::Binary,
            false => Stream::Full,
        };
        let map = Octomap::of_stream(stream, &self.id, self.resolution, &self.data.0)
            .map_err(|reason| format!("{place}: {reason}"))?;
        let unknown = unknown(said, place, &map)?;
        let source = Source {
            file: place.to_owned(),
            making: Making::Map { unknown },
        };
        Draft::of_map(source, &map, unknown)?
            .without_source()
            .cloud()
    }
}

/// Bytes, which ROS writes as numbers from −128 to 127.
#[derive(Clone, Debug, Default)]
struct Bytes(Vec<u8>);

impl Serialize for Bytes {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.iter().map(|byte| *byte as i8))
    }
}

impl<'de> Deserialize<'de> for Bytes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct BytesVisitor;
        impl<'de> Visitor<'de> for BytesVisitor {
            type Value = Bytes;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a list of whole numbers from -128 to 127")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Bytes, A::Error> {
                let mut bytes = Vec::with_capacity(list.size_hint().unwrap_or_default());
                while let Some(number) = list.next_element::<i16>()? {
                    bytes.push(byte(number).ok_or_else(|| {
                        let found = serde::de::Unexpected::Signed(number.into());
                        serde::de::Error::invalid_value(found, &self)
                    })?);
                }
                Ok(Bytes(bytes))
            }
        }
        deserializer.deserialize_seq(BytesVisitor)
    }
}

/// A byte by its number, signed or not.
fn byte(number: i16) -> Option<u8> {
    (-128..256)
        .contains(&number)
        .then_some(number as u8)
}
