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
        let poses = std::iter::once(&self.pose).chain(self.shapes.iter().map(|placed| &placed.pose));
        for pose in poses {
            let bad = |what, value, rule| SceneError::BadPose { id: self.id.clone(), what, value, rule };
            if !pose.is_finite() {
                return Err(bad("pose", format!("{pose:?}"), "it must be finite"));
            }
            if (pose.rotation.length() - 1.0).abs() > NORM_TOLERANCE {
                return Err(bad("orientation", pose.rotation.to_string(), "it must be a unit quaternion"));
            }
        }
        Ok(())
    }
}
