//! Constraints as texts have them: MoveIt's `moveit_msgs/Constraints` in JSON, and one form of ours.

use serde::de::{Error as _, IgnoredAny};
use serde::{Deserialize, Deserializer, Serialize};

use crate::scene::Filled;
use crate::scene::words::{Finite, HeaderFile, Point, PoseFile, PrimitiveFile, Quaternion};
use crate::warning::Warning;

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

    /// How many constraints it makes at most: what is said of an orientation may be two.
    pub fn most(&self) -> usize {
        self.joint_constraints.len()
            + self.position_constraints.len()
            + 2 * self.orientation_constraints.len()
    }

    /// What messages call a constraint about this: the name in the text, where it has one, and what it
    /// is about.
    pub(super) fn name_of(&self, about: &str) -> String {
        match self.name.as_str() {
            "" => about.to_owned(),
            name => format!("{name}: {about}"),
        }
    }

    /// What each of what it asks for is about, and its weight.
    fn weighed(&self) -> impl Iterator<Item = (&str, Weight)> {
        let joints = self.joint_constraints.iter();
        let positions = self.position_constraints.iter();
        let orientations = self.orientation_constraints.iter();
        joints
            .map(|joint| (joint.joint_name.as_str(), joint.weight))
            .chain(positions.map(|position| (position.link_name.as_str(), position.weight)))
            .chain(orientations.map(OrientationFile::weighed))
    }

    /// What messages call each of what it asks for.
    pub fn names(&self) -> Vec<String> {
        self.weighed()
            .map(|(about, _)| self.name_of(about))
            .collect()
    }

    /// What it says that changes nothing, a line each.
    pub fn warnings(&self) -> Vec<Warning> {
        self.weighed()
            .filter(|(_, weight)| !weight.is_one())
            .map(|(about, weight)| weight.warning(&self.name_of(about)))
            .collect()
    }

    /// The first thing that it asks for and another one does not, as messages call it.
    pub fn first_beyond(&self, other: &Self) -> Option<String> {
        let joints = beyond(&self.joint_constraints, &other.joint_constraints);
        let joint = || joints.map(|joint| joint.joint_name.as_str());
        let positions = beyond(&self.position_constraints, &other.position_constraints);
        let position = || positions.map(|position| position.link_name.as_str());
        let orientations = beyond(
            &self.orientation_constraints,
            &other.orientation_constraints,
        );
        let orientation = || orientations.map(|orientation| orientation.weighed().0);
        joint()
            .or_else(position)
            .or_else(orientation)
            .map(|about| self.name_of(about))
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

/// The first of some that is not among others.
fn beyond<'a, T: PartialEq>(some: &'a [T], others: &[T]) -> Option<&'a T> {
    some.iter().find(|one| !others.contains(one))
}

/// MoveIt's weight of a constraint, which samplers use and what must hold does not.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub(super) struct Weight(Finite);

impl Default for Weight {
    fn default() -> Self {
        Self(Finite(1.0))
    }
}

impl Weight {
    fn is_one(&self) -> bool {
        *self == Self::default()
    }

    fn warning(self, constraint: &str) -> Warning {
        let weight = self.0.0;
        let text = format!(
            "constraint {constraint:?}: its weight {weight} changes nothing, all of it must hold"
        );
        Warning::cosmetic("weights of constraints", text)
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
    #[serde(default, skip_serializing_if = "Weight::is_one")]
    weight: Weight,
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
    #[serde(default, skip_serializing_if = "Weight::is_one")]
    weight: Weight,
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

impl OrientationFile {
    /// What it is about, and its weight.
    fn weighed(&self) -> (&str, Weight) {
        match self {
            Self::Tilt(tilt) => (&tilt.link_name, tilt.weight),
            Self::Euler(euler) => (&euler.link_name, euler.weight),
        }
    }
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
    #[serde(default, skip_serializing_if = "Weight::is_one")]
    weight: Weight,
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
    #[serde(default, skip_serializing_if = "Weight::is_one")]
    weight: Weight,
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
