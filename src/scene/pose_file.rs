//! Poses and named frames as JSON has them.

use serde::{Deserialize, Serialize};

use super::SceneError;
use crate::math::{Pose, Quat, Vec3};

/// Norms of quaternions may differ from 1 by this much; they are then normalised.
const NORM_TOLERANCE: f64 = 1e-3;
/// Quaternions nearer to unit length than this stay as they are, so that a pose that was written reads back bit by
/// bit: normalising once more could change the last one.
const ROUNDING: f64 = 1e-14;

/// A pose; what is missing is that of the identity.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct PoseFile {
    #[serde(default, alias = "translation")]
    position: [f64; 3],
    #[serde(default, alias = "rotation", skip_serializing_if = "QuaternionFile::is_identity")]
    orientation: QuaternionFile,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct QuaternionFile {
    x: f64,
    y: f64,
    z: f64,
    w: f64,
}

impl QuaternionFile {
    /// Bit by bit: -0 is another content.
    fn is_identity(&self) -> bool {
        [self.x, self.y, self.z, self.w].map(f64::to_bits) == [0.0_f64, 0.0, 0.0, 1.0].map(f64::to_bits)
    }
}

impl Default for QuaternionFile {
    fn default() -> Self {
        Self { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }
    }
}

/// A named frame: MoveIt's `TransformStamped` from the world to `child_frame_id`.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FrameFile {
    pub(super) child_frame_id: String,
    /// `null` takes the frame away.
    #[serde(deserialize_with = "Option::deserialize")]
    pub(super) transform: Option<PoseFile>,
}

impl FrameFile {
    pub(super) fn of(name: &str, pose: Option<&Pose>) -> Self {
        Self { child_frame_id: name.to_owned(), transform: pose.map(PoseFile::of) }
    }

    pub(super) fn pose(&self) -> Result<Option<Pose>, SceneError> {
        let built = self.transform.map(|transform| transform.build(&self.child_frame_id)).transpose();
        built.map_err(|error| match error {
            SceneError::BadPose { id: name, what, value, rule } => SceneError::BadFrame { name, what, value, rule },
            other => other,
        })
    }
}

impl PoseFile {
    pub(super) fn of(pose: &Pose) -> Self {
        let [x, y, z, w] = pose.rotation.to_array();
        Self { position: pose.translation.to_array(), orientation: QuaternionFile { x, y, z, w } }
    }

    pub(super) fn build(&self, id: &str) -> Result<Pose, SceneError> {
        let QuaternionFile { x, y, z, w } = self.orientation;
        checked_pose(id, self.position, [x, y, z, w])
    }
}

/// The pose of a position (m) and a quaternion (x, y, z, w) that is of unit length but for rounding.
///
/// # Errors
/// A number that is not finite, or a quaternion that is no rotation; `id` is the object whose pose it is.
pub(super) fn checked_pose(id: &str, position: [f64; 3], [x, y, z, w]: [f64; 4]) -> Result<Pose, SceneError> {
    let bad = |what, value, rule| SceneError::BadPose { id: id.to_owned(), what, value, rule };
    let position = Vec3::from_array(position);
    if !position.is_finite() {
        return Err(bad("position", position.to_string(), "it must be finite"));
    }
    let rotation = Quat::from_xyzw(x, y, z, w);
    let norm = rotation.length();
    if !norm.is_finite() || (norm - 1.0).abs() > NORM_TOLERANCE {
        let value = format!("x {x}, y {y}, z {z}, w {w} (norm {norm})");
        return Err(bad("orientation", value, "it must be a unit quaternion"));
    }
    let rotation = if (norm - 1.0).abs() <= ROUNDING { rotation } else { rotation.normalize() };
    Ok(Pose::from_parts(position, rotation))
}
