//! What the name of a frame in a constraint means.

use super::ConstraintError;
use crate::math::Pose;
use crate::robot::RobotModel;
use crate::scene::{AttachedObject, Scene, is_world};

/// A frame: a pose in a link, or in the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// The link that carries it; `None` = it stands in the world.
    pub link: Option<usize>,
    /// Where it is in that.
    pub pose: Pose,
}

impl Place {
    const WORLD: Self = Self {
        link: None,
        pose: Pose::IDENTITY,
    };

    /// Of a link, which may stand still.
    fn of_link(robot: &RobotModel, link: usize, pose: Pose) -> Self {
        match robot.fixed_pose(link) {
            Some(fixed) => Self {
                link: None,
                pose: fixed * pose,
            },
            None => Self {
                link: Some(link),
                pose,
            },
        }
    }

    /// What a constraint calls so: the world, a link, an attached object, a frame on one of these
    /// (OBJECT/FRAME), or a frame of the scene.
    pub(super) fn named(
        robot: &RobotModel,
        scene: &Scene,
        constraint: &str,
        name: &str,
    ) -> Result<Self, ConstraintError> {
        // Older ROS begins names with a slash.
        let plain = name.strip_prefix('/');
        let mut readings = [Some(name), plain].into_iter().flatten();
        readings
            .find_map(|name| Self::of_name(robot, scene, name))
            .ok_or_else(|| unknown(robot, scene, constraint, name))
    }

    /// The same of what must be there to be watched: the world is nothing that a path keeps somewhere.
    pub(super) fn watched(
        robot: &RobotModel,
        scene: &Scene,
        constraint: &str,
        name: &str,
    ) -> Result<Self, ConstraintError> {
        match name {
            "" => Err(unknown(robot, scene, constraint, name)),
            _ => Self::named(robot, scene, constraint, name),
        }
    }

    fn of_name(robot: &RobotModel, scene: &Scene, name: &str) -> Option<Self> {
        if is_world(name) || robot.worlds().iter().any(|world| world == name) {
            return Some(Self::WORLD);
        }
        if let Some(link) = robot.link_index(name) {
            return Some(Self::of_link(robot, link, Pose::identity()));
        }
        Self::carried(robot, scene, name).or_else(|| Self::standing(scene, name))
    }

    /// An attached object, or a frame on one.
    fn carried(robot: &RobotModel, scene: &Scene, name: &str) -> Option<Self> {
        let at = |object: &AttachedObject, pose: Pose| {
            let link = robot.link_index(&object.link_name)?;
            Some(Self::of_link(robot, link, object.object.frame() * pose))
        };
        if let Some(object) = scene.attached().get(name) {
            return at(object, Pose::identity());
        }
        name.match_indices('/').find_map(|(slash, _)| {
            let id = &name[..slash];
            let object = scene.attached().get(id)?;
            at(object, *scene.subframe(id, &name[slash + 1..])?)
        })
    }

    fn standing(scene: &Scene, name: &str) -> Option<Self> {
        scene
            .known_frame(name)
            .map(|pose| Self { link: None, pose })
    }
}

fn unknown(robot: &RobotModel, scene: &Scene, constraint: &str, name: &str) -> ConstraintError {
    let links: Vec<&str> = robot
        .links()
        .iter()
        .map(|link| link.name.as_str())
        .collect();
    let attached: Vec<&str> = scene
        .attached()
        .iter()
        .map(|attached| attached.object.id.as_str())
        .collect();
    let attached = match attached.is_empty() {
        true => "attached: none".to_owned(),
        false => format!("attached: {}", attached.join(", ")),
    };
    let others = match name {
        "" => attached,
        _ => format!("{attached}; {}", scene.unknown_frame(name, &robot.worlds())),
    };
    ConstraintError::UnknownFrame {
        constraint: constraint.to_owned(),
        frame: name.to_owned(),
        links: links.join(", "),
        others,
    }
}
