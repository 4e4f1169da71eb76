//! Taking objects up and putting them down: where robot and scene stand decides which pose an
//! object gets.

use super::error::CollisionModelError;
use super::model::CollisionModel;
use crate::math::Pose;
use crate::robot::Kinematics;
use crate::scene::{SceneChange, SceneError};

impl CollisionModel {
    /// The change by which a link takes an obstacle up where both are; `kinematics` says where the
    /// link is.
    ///
    /// # Errors
    /// A link or an obstacle that is not there; an object that is attached already.
    pub fn attach(
        &self,
        id: &str,
        link_name: &str,
        touch_links: Vec<String>,
        kinematics: &Kinematics,
    ) -> Result<SceneChange, CollisionModelError> {
        let id = id.to_owned();
        let link_name = link_name.to_owned();
        let link = self
            .robot()
            .link_index(&link_name)
            .ok_or_else(|| CollisionModelError::UnknownLink {
                object: id.clone(),
                link: link_name.clone(),
                links: self
                    .robot()
                    .links()
                    .iter()
                    .map(|link| link.name.as_str())
                    .collect::<Vec<_>>()
                    .join(", "),
            })?;
        let standing = self.scene().obstacles().get(&id);
        // What does not stand gets its error from the scene, whatever the pose.
        let world = standing.map_or(Pose::identity(), |obstacle| obstacle.pose);
        let pose = unit(kinematics.poses()[link].inverse() * world);
        let change = SceneChange::Attach {
            id,
            link_name,
            touch_links,
            pose,
        };
        self.scene().with([change.clone()])?;
        Ok(change)
    }

    /// The change by which a link leaves an attached object in the world where both are.
    ///
    /// # Errors
    /// An object that is not there or not attached.
    pub fn detach(&self, id: &str, kinematics: &Kinematics) -> Result<SceneChange, SceneError> {
        let attached = self.scene().attached().get(id);
        let carrier = attached.and_then(|attached| self.robot().link_index(&attached.link_name));
        let pose = attached
            .zip(carrier)
            .map_or(Pose::identity(), |(attached, link)| {
                unit(kinematics.poses()[link] * attached.object.pose)
            });
        let change = SceneChange::Detach {
            id: id.to_owned(),
            pose,
        };
        self.scene().with([change.clone()])?;
        Ok(change)
    }
}

/// Products of many rotations would in time leave unit length.
fn unit(pose: Pose) -> Pose {
    Pose::from_parts(pose.translation, pose.rotation.normalize())
}
