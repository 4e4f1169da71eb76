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
        let plain = name.strip_prefix('/').unwrap_or(name);
        if is_world(plain)
            || robot
                .worlds()
                .iter()
                .any(|world| world == plain)
        {
            return Ok(Self::WORLD);
        }
        if let Some(link) = robot.link_index(plain) {
            return Ok(Self::of_link(robot, link, Pose::identity()));
        }
        Self::carried(robot, scene, plain)
            .or_else(|| Self::standing(scene, plain))
            .ok_or_else(|| unknown(robot, scene, constraint, name))
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
    let worlds = robot.worlds();
    ConstraintError::UnknownFrame {
        constraint: constraint.to_owned(),
        frame: name.to_owned(),
        links: links.join(", "),
        others: format!(
            "attached: {}; {}",
            attached.join(", "),
            scene.unknown_frame(name, &worlds)
        ),
    }
}
