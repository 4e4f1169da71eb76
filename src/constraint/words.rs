//! Constraints as texts have them: MoveIt's `moveit_msgs/Constraints` in JSON, and one form of ours.

use serde::de::{Error as _, IgnoredAny};
use serde::{Deserialize, Deserializer, Serialize};

use crate::scene::Filled;
use crate::scene::words::{Finite, HeaderFile, Point, PoseFile, PrimitiveFile, Quaternion};

/// MoveIt's message. What is ignored by name changes nothing that must hold. What is derived reads and
/// writes it as a message; it is also read from few words.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(remote = "Self", deny_unknown_fields, default)]
pub struct ConstraintsFile {
    #[serde(deserialize_with = "one_line")]
    pub(super) name: String,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) joint_constraints: Vec<JointFile>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) position_constraints: Vec<PositionFile>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) orientation_constraints: Vec<OrientationFile>,
    /// Read only to be refused.
    #[serde(skip_serializing_if = "Filled::is_empty")]
    pub(super) visibility_constraints: Filled,
}

/// A name that messages can have in their one line.
fn one_line<'de, D: Deserializer<'de>>(deserializer: D) -> Result<String, D::Error> {
    let name = String::deserialize(deserializer)?;
    match name.chars().any(char::is_control) {
        true => Err(D::Error::custom(format!(
            "the name {name:?} has a control character; give one line of text"
        ))),
        false => Ok(name),
    }
}

impl ConstraintsFile {
    /// Whether it asks for nothing.
    pub fn is_empty(&self) -> bool {
        self.joint_constraints.is_empty()
            && self.position_constraints.is_empty()
            && self.orientation_constraints.is_empty()
            && self.visibility_constraints.is_empty()
    }

    /// The same, and what another one asks for; under a name that both have.
    #[must_use]
    pub fn and(mut self, mut other: Self) -> Self {
        if self.is_empty() {
            return other;
        }
        if self == other {
            return self;
        }
        if !other.is_empty() && self.name != other.name {
            self.name.clear();
        }
        self.joint_constraints
            .append(&mut other.joint_constraints);
        self.position_constraints
            .append(&mut other.position_constraints);
        self.orientation_constraints
            .append(&mut other.orientation_constraints);
        self.visibility_constraints.0 |= other.visibility_constraints.0;
        self
    }
}

/// MoveIt's joint constraint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct JointFile {
    pub(super) joint_name: String,
    pub(super) position: Finite,
    pub(super) tolerance_above: Finite,
    pub(super) tolerance_below: Finite,
    #[serde(default, rename = "weight", skip_serializing)]
    _weight: IgnoredAny,
}

/// MoveIt's position constraint: a point of a link is in one of the regions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PositionFile {
    #[serde(default, skip_serializing_if = "HeaderFile::is_empty")]
    pub(super) header: HeaderFile,
    pub(super) link_name: String,
    #[serde(default)]
    pub(super) target_point_offset: Point,
    pub(super) constraint_region: VolumeFile,
    #[serde(default, rename = "weight", skip_serializing)]
    _weight: IgnoredAny,
}

/// MoveIt's bounding volume: a union.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct VolumeFile {
    #[serde(default)]
    pub(super) primitives: Vec<PrimitiveFile>,
    #[serde(default)]
    pub(super) primitive_poses: Vec<PoseFile>,
    /// Read only to be refused.
    #[serde(default, skip_serializing_if = "Filled::is_empty")]
    pub(super) meshes: Filled,
    #[serde(default, rename = "mesh_poses", skip_serializing)]
    _mesh_poses: IgnoredAny,
}

/// MoveIt's orientation constraint, or a direction of a link that is within an angle of another.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub(super) enum OrientationFile {
    Tilt(TiltFile),
    Euler(EulerFile),
}

impl<'de> Deserialize<'de> for OrientationFile {
    /// By the word that only ours has, so that what is then wrong is said of the right one.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = serde_json::Value::deserialize(deserializer)?;
        let read = match value.get("tolerance_rad").is_some() {
            true => serde_json::from_value(value).map(Self::Tilt),
            false => serde_json::from_value(value).map(Self::Euler),
        };
        read.map_err(D::Error::custom)
    }
}

/// An axis of a link, within an angle of a direction of the frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TiltFile {
    #[serde(default, skip_serializing_if = "HeaderFile::is_empty")]
    pub(super) header: HeaderFile,
    pub(super) link_name: String,
    pub(super) axis: Point,
    pub(super) reference: Reference,
    pub(super) tolerance_rad: Finite,
    #[serde(default, rename = "meaning", skip_serializing)]
    _meaning: IgnoredAny,
    #[serde(default, rename = "weight", skip_serializing)]
    _weight: IgnoredAny,
}

/// What a direction is compared with.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "a reference is a list [x, y, z], { x, y, z }, or \"start\""
)]
pub(super) enum Reference {
    Along(Point),
    Of(Moment),
}

/// When a direction is taken.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Moment {
    /// As it is at the path's first waypoint.
    Start,
}

/// MoveIt's own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EulerFile {
    #[serde(default, skip_serializing_if = "HeaderFile::is_empty")]
    pub(super) header: HeaderFile,
    pub(super) link_name: String,
    #[serde(default)]
    pub(super) orientation: Quaternion,
    pub(super) absolute_x_axis_tolerance: Finite,
    pub(super) absolute_y_axis_tolerance: Finite,
    pub(super) absolute_z_axis_tolerance: Finite,
    #[serde(default)]
    pub(super) parameterization: Parameterization,
    #[serde(default, rename = "weight", skip_serializing)]
    _weight: IgnoredAny,
}

/// How tolerances are meant: by MoveIt's number or name.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "a parameterization is 0 or XYZ_EULER_ANGLES, in MoveIt also 1, ROTATION_VECTOR"
)]
pub(super) enum Parameterization {
    #[default]
    Unsaid,
    Number(u8),
    Name(String),
}

impl Parameterization {
    /// Whether it is XYZ_EULER_ANGLES, which is what is meant where nothing is said.
    pub(super) fn is_euler(&self) -> bool {
        match self {
            Self::Unsaid | Self::Number(0) => true,
            Self::Number(_) => false,
            Self::Name(name) => name == "XYZ_EULER_ANGLES",
        }
    }
}

impl std::fmt::Display for Parameterization {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Unsaid => f.write_str("XYZ_EULER_ANGLES"),
            Self::Number(number) => number.fmt(f),
            Self::Name(name) => name.fmt(f),
        }
    }
}
