//! What a robot calls the world.

use super::{JointKind, RobotModel};
use crate::math::Pose;

impl RobotModel {
    /// Names that the robot has for the world: the parent frame of its virtual joint, and every
    /// link that stands still where the world's origin is, such as a fixed root.
    pub fn worlds(&self) -> Vec<String> {
        let parent = self
            .description()
            .virtual_joint
            .iter()
            .map(|joint| joint.parent_frame.clone());
        let links =
            (0..self.links().len()).filter(|&link| self.fixed_pose(link) == Some(Pose::identity()));
        let links = links.map(|link| self.links()[link].name.clone());
        let mut names: Vec<String> = parent
            .filter(|name| !name.is_empty())
            .chain(links)
            .collect();
        names.dedup();
        names
    }

    /// Pose in the world of a link that no joint moves; `None` for any other.
    pub fn fixed_pose(&self, link: usize) -> Option<Pose> {
        let mut pose = Pose::identity();
        let mut at = Some(link);
        while let Some(link) = at {
            let joint = &self.joints()[link];
            if joint.kind != JointKind::Fixed {
                return None;
            }
            pose = joint.origin * pose;
            at = joint.parent;
        }
        Some(pose)
    }
}
