//! Objects of a scene: what stands in the world, and what a link carries.

use std::sync::Arc;

use super::{SceneError, Sensing};
use crate::math::{Pose, Quat, Vec3};
use crate::shape::PlacedShape;

/// Quaternions may differ from unit length by this much: a pose that stretches what it places
/// proves nothing.
const NORM_TOLERANCE: f64 = 1e-9;

/// The identity as a pose that is set, by its other quaternion: MoveIt takes 0 0 0 1 for one that
/// nobody has set.
pub(super) fn set_identity() -> Pose {
    Pose::from_parts(Vec3::ZERO, Quat::from_xyzw(0.0, 0.0, 0.0, -1.0))
}

/// A solid object of the scene, made of one shape or several (MoveIt's collision object).
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle {
    /// Name, unique in the scene.
    pub id: String,
    /// Pose of the object's frame: in the world, or in the frame of the link that carries the
    /// object.
    pub pose: Pose,
    /// Its shapes, in the object's frame. Shared by all scenes in which the object has the same
    /// shapes.
    pub shapes: Arc<[PlacedShape]>,
    /// Where its shape comes from a sensor. One that has no shapes then is not empty: what is there
    /// is not known yet.
    pub sensed: Option<Arc<Sensing>>,
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
        Self {
            id: id.into(),
            pose: Pose::identity(),
            shapes: shapes.into(),
            sensed: None,
        }
    }

    /// The same object with its shape from a sensor.
    #[must_use]
    pub fn sensed_by(self, sensing: Sensing) -> Self {
        Self {
            sensed: Some(sensing.into()),
            ..self
        }
    }

    /// The same object before its sensor has seen anything.
    pub(super) fn unseen(&self) -> Self {
        match &self.sensed {
            None => self.clone(),
            Some(sensing) => Self::new(&*self.id, Vec::new())
                .at(self.pose)
                .sensed_by(sensing.blind()),
        }
    }

    /// The same object with its frame elsewhere.
    #[must_use]
    pub fn at(self, pose: Pose) -> Self {
        Self { pose, ..self }
    }

    /// Its shapes in the frame that its pose is given in.
    pub fn placed_shapes(&self) -> impl Iterator<Item = PlacedShape> + '_ {
        self.shapes.iter().map(|placed| PlacedShape {
            pose: self.pose * placed.pose,
            shape: placed.shape.clone(),
        })
    }

    /// The pose of the object's frame, by which others are placed and which MOVE places. It is
    /// `pose`, but where that is not set (the identity) and the object has one shape, that shape's,
    /// as MoveIt has it.
    pub fn frame(&self) -> Pose {
        match &*self.shapes {
            [only] if self.pose == Pose::identity() => only.pose,
            _ => self.pose,
        }
    }

    /// Whether its frame is not where `pose` is.
    pub(super) fn is_framed_by_shape(&self) -> bool {
        self.frame() != self.pose
    }

    /// The same object with `pose` as its frame.
    pub(super) fn settled(&self) -> Self {
        match &*self.shapes {
            [only] if self.is_framed_by_shape() => {
                let shapes = [PlacedShape {
                    pose: Pose::identity(),
                    shape: only.shape.clone(),
                }];
                Self {
                    pose: only.pose,
                    shapes: shapes.into(),
                    ..self.clone()
                }
            }
            _ => self.clone(),
        }
    }

    /// The same object with its frame elsewhere.
    pub(super) fn with_frame_at(&self, pose: Pose) -> Self {
        self.settled().set_at(pose)
    }

    /// The same shapes in a frame whose pose is set, be it the identity.
    pub(super) fn set_at(self, pose: Pose) -> Self {
        let placed = self.at(pose);
        if placed.is_framed_by_shape() {
            placed.at(set_identity())
        } else {
            placed.told_plainly()
        }
    }

    /// The same object with the plain identity as its pose where only one shape would make a
    /// difference of that.
    pub(super) fn told_plainly(self) -> Self {
        let is_plain = self.shapes.len() == 1 || !is_same(&self.pose, &set_identity());
        if is_plain {
            self
        } else {
            self.at(Pose::identity())
        }
    }

    /// The same object with more shapes in its frame. Of several shapes none makes the frame.
    pub(super) fn with_more(&self, shapes: Vec<PlacedShape>) -> Self {
        if shapes.is_empty() {
            return self.clone();
        }
        let settled = self.settled();
        let pose = settled.pose;
        settled.appended(shapes).set_at(pose)
    }

    /// The same with these shapes after its own.
    pub(super) fn appended(&self, more: Vec<PlacedShape>) -> Self {
        let own = self.shapes.iter().cloned();
        Self {
            shapes: own.chain(more).collect(),
            ..self.clone()
        }
    }

    pub(super) fn check(&self) -> Result<(), SceneError> {
        check_pose(&self.pose)
            .and_then(|()| check_shapes(&self.shapes))
            .map_err(|error| error.of_object(&self.id))?;
        match &self.sensed {
            Some(sensing) => sensing.check(&self.id),
            None => Ok(()),
        }
    }
}

impl AsRef<Obstacle> for Obstacle {
    fn as_ref(&self) -> &Obstacle {
        self
    }
}

impl AttachedObject {
    /// Whether one of its touch links has this name.
    pub(super) fn may_touch(&self, name: &str) -> bool {
        self.touch_links
            .iter()
            .any(|known| known == name)
    }

    /// The same without a touch link.
    pub(super) fn not_touching(mut self, name: &str) -> Self {
        self.touch_links.retain(|known| known != name);
        self
    }

    /// The same link with its object changed.
    pub(super) fn with_object(&self, change: impl FnOnce(&Obstacle) -> Obstacle) -> Self {
        Self {
            object: change(&self.object),
            ..self.clone()
        }
    }
}

impl AsRef<Obstacle> for AttachedObject {
    fn as_ref(&self) -> &Obstacle {
        &self.object
    }
}

/// Why a pose is none.
pub(super) struct BadPose {
    what: String,
    value: String,
    rule: &'static str,
}

impl BadPose {
    pub(super) fn of_object(self, id: &str) -> SceneError {
        let Self { what, value, rule } = self;
        SceneError::BadPose {
            id: id.to_owned(),
            what,
            value,
            rule,
        }
    }

    pub(super) fn of_frame(self, name: &str) -> SceneError {
        let Self { what, value, rule } = self;
        SceneError::BadFrame {
            name: name.to_owned(),
            what,
            value,
            rule,
        }
    }
}

/// Whether two poses are the same bit by bit.
pub(super) fn is_same(a: &Pose, b: &Pose) -> bool {
    let bits = |pose: &Pose| {
        (
            pose.translation.to_array().map(f64::to_bits),
            pose.rotation.to_array().map(f64::to_bits),
        )
    };
    bits(a) == bits(b)
}

pub(super) fn check_shapes(shapes: &[PlacedShape]) -> Result<(), BadPose> {
    if shapes.len() > 1
        && shapes
            .iter()
            .any(|placed| placed.shape.cloud().is_some())
    {
        return Err(BadPose {
            what: "the number of its shapes".to_owned(),
            value: shapes.len().to_string(),
            rule: "a cloud is an object of its own: give the others another id",
        });
    }
    shapes
        .iter()
        .try_for_each(|placed| check_pose(&placed.pose))
}

pub(super) fn check_pose(pose: &Pose) -> Result<(), BadPose> {
    if !pose.is_finite() {
        return Err(BadPose {
            what: "pose".to_owned(),
            value: format!("{pose:?}"),
            rule: "it must be finite",
        });
    }
    if (pose.rotation.length() - 1.0).abs() > NORM_TOLERANCE {
        let what = "orientation".to_owned();
        let value = pose.rotation.to_string();
        return Err(BadPose {
            what,
            value,
            rule: "it must be a unit quaternion",
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Scene, SceneChange};
    use crate::shape::{Cloud, Shape};

    #[test]
    fn a_cloud_is_an_object_of_its_own() {
        let at_origin = |shape| PlacedShape {
            pose: Pose::identity(),
            shape,
        };
        let cloud = Cloud::of_points([[0.0; 3]], 0.01).unwrap();
        let scan = at_origin(Shape::Cloud(Arc::new(cloud)));
        let ball = at_origin(Shape::sphere(0.1).unwrap());
        let both = Obstacle::new("scan", vec![scan.clone(), ball.clone()]);
        let refused = Scene::new("scene", vec![both], vec![], vec![]).unwrap_err();
        let line = "object \"scan\": the number of its shapes is 2; a cloud is an object of its own: give the others another id";
        assert_eq!(refused.to_string(), line);
        let alone = Obstacle::new("scan", vec![scan]);
        let scene = Scene::new("scene", vec![alone], vec![], vec![]).unwrap();
        let append = SceneChange::Append {
            id: "scan".into(),
            shapes: vec![ball],
        };
        assert_eq!(scene.with([append]).unwrap_err().to_string(), line);
    }
}
