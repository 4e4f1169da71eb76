//! Poses and named frames as texts have them.

use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};

use super::SceneError;
use super::numbers::{Point, Quaternion};
use super::object::set_identity;
use crate::math::{Pose, Quat, Vec3};

/// Norms of quaternions may differ from 1 by this much; they are then normalised.
const NORM_TOLERANCE: f64 = 1e-3;
/// Quaternions nearer to unit length than this stay as they are, so that a pose that was written
/// reads back bit by bit: normalising once more could change the last one.
const ROUNDING: f64 = 1e-14;

/// A pose; what is missing is that of the identity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PoseFile {
    #[serde(default, alias = "translation")]
    position: Point,
    #[serde(
        default,
        alias = "rotation",
        skip_serializing_if = "Quaternion::is_identity"
    )]
    orientation: Quaternion,
}

/// A message's header.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct HeaderFile {
    #[serde(default)]
    pub(crate) frame_id: String,
    #[serde(default, rename = "stamp", skip_serializing)]
    _stamp: IgnoredAny,
    #[serde(default, rename = "seq", skip_serializing)]
    _seq: IgnoredAny,
}

impl HeaderFile {
    pub(crate) fn is_empty(&self) -> bool {
        self.frame_id.is_empty()
    }

    pub(super) fn of(frame: &str) -> Self {
        Self {
            frame_id: frame.to_owned(),
            ..Self::default()
        }
    }
}

/// A named frame: by its name alone, or as MoveIt's messages have it, where the header has the
/// frame's name and `child_frame_id` the world's.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FrameFile {
    #[serde(default, skip_serializing_if = "HeaderFile::is_empty")]
    header: HeaderFile,
    child_frame_id: String,
    /// `null` takes the frame away.
    #[serde(deserialize_with = "Option::deserialize")]
    transform: Option<PoseFile>,
}

impl FrameFile {
    pub(super) fn of(name: &str, pose: Option<&Pose>) -> Self {
        let header = HeaderFile::default();
        Self {
            header,
            child_frame_id: name.to_owned(),
            transform: pose.map(PoseFile::of),
        }
    }

    /// Its name.
    pub(super) fn name(&self) -> &str {
        if self.header.is_empty() {
            &self.child_frame_id
        } else {
            &self.header.frame_id
        }
    }

    /// What it is given in, where it says so: a name of the world.
    pub(super) fn given_in(&self) -> Option<&str> {
        (!self.header.is_empty()).then_some(self.child_frame_id.as_str())
    }

    pub(super) fn pose(&self) -> Result<Option<Pose>, SceneError> {
        let built = self
            .transform
            .map(|transform| transform.build(self.name(), "transform"))
            .transpose();
        built.map_err(|error| match error {
            SceneError::BadPose {
                id: name,
                what,
                value,
                rule,
            } => SceneError::BadFrame {
                name,
                what,
                value,
                rule,
            },
            other => other,
        })
    }

    /// What is odd about it.
    pub(super) fn warning(&self) -> Option<String> {
        let is_unset = self
            .transform
            .is_some_and(|transform| transform.is_unturned());
        is_unset.then(|| format!("frame {:?}: {}", self.name(), not_set("transform")))
    }
}

/// What is said of a quaternion of zeros.
pub(super) fn not_set(what: &str) -> String {
    format!(
        "the orientation of its {what} is 0 0 0 0, which is no rotation: read as not set (no turn), as MoveIt does"
    )
}

impl PoseFile {
    pub(super) fn of(pose: &Pose) -> Self {
        let [x, y, z, w] = pose.rotation.to_array();
        Self {
            position: Point(pose.translation.to_array()),
            orientation: Quaternion { x, y, z, w },
        }
    }

    /// Whether its quaternion is 0 0 0 0, as a message's that nobody has set.
    pub(super) fn is_unturned(&self) -> bool {
        is_unturned(self.orientation.to_array())
    }

    /// Whether it says nothing, as MoveIt takes it.
    pub(super) fn is_identity(&self) -> bool {
        self.position.0 == [0.0; 3] && self.orientation == Quaternion::default()
    }

    /// The pose of `what` of the object `id`.
    pub(crate) fn build(&self, id: &str, what: &str) -> Result<Pose, SceneError> {
        checked_pose(id, what, self.position.0, self.orientation.to_array())
    }

    /// An object's own pose. MoveIt takes zeros for a pose that is set.
    pub(super) fn build_own(&self, id: &str) -> Result<Pose, SceneError> {
        let pose = self.build(id, "pose")?;
        Ok(if self.is_unturned() && pose == Pose::identity() {
            set_identity()
        } else {
            pose
        })
    }
}

pub(super) fn is_unturned(quaternion: [f64; 4]) -> bool {
    quaternion == [0.0; 4]
}

/// The pose of a position (m) and a quaternion (x, y, z, w) that is of unit length but for
/// rounding, or not set.
///
/// # Errors
/// A number that is not finite, or a quaternion that is no rotation; `what` of the object `id` it
/// is.
pub(crate) fn checked_pose(
    id: &str,
    what: &str,
    position: [f64; 3],
    [x, y, z, w]: [f64; 4],
) -> Result<Pose, SceneError> {
    let bad = |part: &str, value, rule| {
        let what = format!("the {part} of its {what}");
        SceneError::BadPose {
            id: id.to_owned(),
            what,
            value,
            rule,
        }
    };
    let position = Vec3::from_array(position);
    if !position.is_finite() {
        return Err(bad("position", position.to_string(), "it must be finite"));
    }
    if is_unturned([x, y, z, w]) {
        return Ok(Pose::from_translation(position));
    }
    let rotation = Quat::from_xyzw(x, y, z, w);
    let norm = rotation.length();
    if !norm.is_finite() || (norm - 1.0).abs() > NORM_TOLERANCE {
        let value = format!("x {x}, y {y}, z {z}, w {w} (norm {norm})");
        return Err(bad("orientation", value, "it must be a unit quaternion"));
    }
    let rotation = if (norm - 1.0).abs() <= ROUNDING {
        rotation
    } else {
        rotation.normalize()
    };
    Ok(Pose::from_parts(position, rotation))
}
