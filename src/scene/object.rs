//! Objects of a scene: what stands in the world, and what a link carries.

use std::sync::Arc;

use super::SceneError;
use crate::math::Pose;
use crate::shape::PlacedShape;

/// Quaternions may differ from unit length by this much: a pose that stretches what it places proves nothing.
const NORM_TOLERANCE: f64 = 1e-9;

/// A solid object of the scene, made of one shape or several (MoveIt's collision object).
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle {
    /// Name, unique in the scene.
    pub id: String,
    /// Pose of the object's frame: in the world, or in the frame of the link that carries the object.
    pub pose: Pose,
    /// Its shapes, in the object's frame. Shared by all scenes in which the object has the same shapes.
    pub shapes: Arc<[PlacedShape]>,
}

/// An object that a link carries (MoveIt's attached collision object).
#[derive(Clone, Debug, PartialEq)]
pub struct AttachedObject {
    /// The link that carries it; the two may touch.
    pub link_name: String,
    /// The object; its pose is in the link's frame.
    pub object: Obstacle,
    /// Links and objects that it may touch besides.
    pub touch_links: Vec<String>,
}

impl Obstacle {
    /// An object whose frame is the world's.
    pub fn new(id: impl Into<String>, shapes: Vec<PlacedShape>) -> Self {
        Self { id: id.into(), pose: Pose::identity(), shapes: shapes.into() }
    }

    /// The same object with its frame elsewhere.
    #[must_use]
    pub fn at(self, pose: Pose) -> Self {
        Self { pose, ..self }
    }

    /// Its shapes in the frame that its pose is given in.
    pub fn placed_shapes(&self) -> impl Iterator<Item = PlacedShape> + '_ {
        self.shapes.iter().map(|placed| PlacedShape { pose: self.pose * placed.pose, shape: placed.shape.clone() })
    }

    pub(super) fn check(&self) -> Result<(), SceneError> {
        check_pose(&self.pose).and_then(|()| check_shapes(&self.shapes)).map_err(|error| error.of_object(&self.id))
    }
}

impl AsRef<Obstacle> for Obstacle {
    fn as_ref(&self) -> &Obstacle {
        self
    }
}

impl AsRef<Obstacle> for AttachedObject {
    fn as_ref(&self) -> &Obstacle {
        &self.object
    }
}

/// Why a pose is none.
pub(super) struct BadPose {
    what: &'static str,
    value: String,
    rule: &'static str,
}

impl BadPose {
    pub(super) fn of_object(self, id: &str) -> SceneError {
        let Self { what, value, rule } = self;
        SceneError::BadPose { id: id.to_owned(), what, value, rule }
    }

    pub(super) fn of_frame(self, name: &str) -> SceneError {
        let Self { what, value, rule } = self;
        SceneError::BadFrame { name: name.to_owned(), what, value, rule }
    }
}

pub(super) fn check_shapes(shapes: &[PlacedShape]) -> Result<(), BadPose> {
    shapes.iter().try_for_each(|placed| check_pose(&placed.pose))
}

pub(super) fn check_pose(pose: &Pose) -> Result<(), BadPose> {
    if !pose.is_finite() {
        return Err(BadPose { what: "pose", value: format!("{pose:?}"), rule: "it must be finite" });
    }
    if (pose.rotation.length() - 1.0).abs() > NORM_TOLERANCE {
        let (what, value) = ("orientation", pose.rotation.to_string());
        return Err(BadPose { what, value, rule: "it must be a unit quaternion" });
    }
    Ok(())
}
