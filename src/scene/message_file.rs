//! What MoveIt's planning scenes have besides collision objects.

use std::fmt;

use serde::de::{Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use super::SceneError;
use super::object_file::{AttachedObjectFile, ObjectFile};
use super::octomap_file::{OCTOMAP, OctomapFile};

/// `moveit_msgs/PlanningSceneWorld`.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WorldFile {
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) collision_objects: Vec<ObjectFile>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) octomap: Option<OctomapFile>,
}

/// `moveit_msgs/RobotState`. Where its joints are is the path's to say.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RobotStateFile {
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) attached_collision_objects: Vec<AttachedObjectFile>,
    #[serde(default, rename = "joint_state", skip_serializing)]
    _joint_state: IgnoredAny,
    #[serde(default, rename = "multi_dof_joint_state", skip_serializing)]
    _multi_dof_joint_state: IgnoredAny,
    #[serde(default, rename = "is_diff", skip_serializing)]
    _is_diff: IgnoredAny,
}

/// `moveit_msgs/AllowedCollisionMatrix`.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MatrixFile {
    #[serde(default)]
    entry_names: Vec<String>,
    #[serde(default)]
    entry_values: Vec<Row>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    default_entry_names: Vec<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    default_entry_values: Vec<bool>,
}

/// A row of the matrix: a bare list, or a message with `enabled`.
#[derive(Clone, Debug, Serialize)]
#[serde(transparent)]
struct Row(Vec<bool>);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RowMessage {
    enabled: Vec<bool>,
}

impl<'de> Deserialize<'de> for Row {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
        struct RowVisitor;
        impl<'de> Visitor<'de> for RowVisitor {
            type Value = Row;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a list of booleans or { enabled: […] }")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Row, A::Error> {
                Vec::deserialize(SeqAccessDeserializer::new(list)).map(Row)
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Row, A::Error> {
                RowMessage::deserialize(MapAccessDeserializer::new(map)).map(|row| Row(row.enabled))
            }
        }
        deserializer.deserialize_any(RowVisitor)
    }
}

/// What a matrix says of pairs of names.
#[derive(Default)]
pub(super) struct MatrixPairs {
    pub(super) allowed: Vec<(String, String)>,
    pub(super) forbidden: Vec<(String, String)>,
}

impl MatrixFile {
    pub(super) fn is_empty(&self) -> bool {
        self.entry_names.is_empty()
            && self.entry_values.is_empty()
            && self.default_entry_names.is_empty()
    }

    /// The pairs that may touch, and those that are checked: a matrix goes before what an SRDF
    /// disables. Every matrix of MoveIt's speaks of its octomap, which a scene need not have.
    pub(super) fn pairs(&self, has_octomap: bool) -> Result<MatrixPairs, SceneError> {
        let names = &self.entry_names;
        let mut pairs = MatrixPairs::default();
        let refuse =
            |text: String| SceneError::Syntax(format!("allowed_collision_matrix has {text}"));
        if self.entry_values.len() != names.len() {
            return Err(refuse(format!(
                "{} rows for {} names",
                self.entry_values.len(),
                names.len()
            )));
        }
        for (index, Row(row)) in self.entry_values.iter().enumerate() {
            if row.len() != names.len() {
                let text = format!(
                    "{} entries in the row of {}, {} names",
                    row.len(),
                    names[index],
                    names.len()
                );
                return Err(refuse(text));
            }
            for (other, is_allowed) in names.iter().zip(row).take(index) {
                if !has_octomap && [other, &names[index]].contains(&&OCTOMAP.to_owned()) {
                    continue;
                }
                let list = if *is_allowed {
                    &mut pairs.allowed
                } else {
                    &mut pairs.forbidden
                };
                list.push((other.clone(), names[index].clone()));
            }
        }
        Ok(pairs)
    }

    /// What it says and is not followed: it could only leave pairs unchecked.
    pub(super) fn warning(&self, has_octomap: bool) -> Option<String> {
        let defaults = self
            .default_entry_names
            .iter()
            .zip(&self.default_entry_values);
        let allowed: Vec<&str> = defaults
            .filter(|(name, value)| **value && (has_octomap || *name != OCTOMAP))
            .map(|(name, _)| name.as_str())
            .collect();
        (!allowed.is_empty()).then(|| {
            let names = allowed.join(", ");
            format!(
                "allowed_collision_matrix lets {names} touch anything by default, which is not followed: their pairs are checked; allow pairs one by one"
            )
        })
    }
}

/// Whether a text has anything in a place: not nothing, zero, `false`, or lists and maps of such.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Filled(pub bool);

impl Filled {
    /// Whether it is empty.
    pub fn is_empty(&self) -> bool {
        !self.0
    }
}

impl<'de> Deserialize<'de> for Filled {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(FilledVisitor)
    }
}

struct FilledVisitor;

impl<'de> Visitor<'de> for FilledVisitor {
    type Value = Filled;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("anything")
    }
    fn visit_bool<E: Error>(self, value: bool) -> Result<Filled, E> {
        Ok(Filled(value))
    }
    fn visit_i64<E: Error>(self, value: i64) -> Result<Filled, E> {
        Ok(Filled(value != 0))
    }
    fn visit_u64<E: Error>(self, value: u64) -> Result<Filled, E> {
        Ok(Filled(value != 0))
    }
    fn visit_f64<E: Error>(self, value: f64) -> Result<Filled, E> {
        Ok(Filled(value != 0.0))
    }
    fn visit_str<E: Error>(self, value: &str) -> Result<Filled, E> {
        Ok(Filled(!value.is_empty()))
    }
    fn visit_bytes<E: Error>(self, value: &[u8]) -> Result<Filled, E> {
        Ok(Filled(!value.is_empty()))
    }
    fn visit_unit<E: Error>(self) -> Result<Filled, E> {
        Ok(Filled(false))
    }
    fn visit_none<E: Error>(self) -> Result<Filled, E> {
        Ok(Filled(false))
    }
    fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<Filled, D::Error> {
        Filled::deserialize(deserializer)
    }
    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Filled, A::Error> {
        let mut is_filled = false;
        while list.next_element::<IgnoredAny>()?.is_some() {
            is_filled = true;
        }
        Ok(Filled(is_filled))
    }
    /// A message's name and header say nothing.
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Filled, A::Error> {
        let mut is_filled = false;
        while let Some(name) = map.next_key::<String>()? {
            let value: Filled = map.next_value()?;
            is_filled |= value.0 && !["name", "header"].contains(&name.as_str());
        }
        Ok(Filled(is_filled))
    }
}
