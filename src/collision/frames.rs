//! Names of frames where robot and scene meet: what the scene leaves to the robot, and what both
//! have names for.

use super::error::CollisionModelError;
use crate::math::Pose;
use crate::robot::RobotModel;
use crate::scene::Scene;
use crate::warning::Warning;

/// Checks that what a scene does not know of its frames is the robot's world, and that no name of a
/// frame means two places.
///
/// # Errors
/// A frame that neither knows, one that moves with the robot, or a fixed frame that the robot has
/// elsewhere.
pub fn check_frames(robot: &RobotModel, scene: &Scene) -> Result<(), CollisionModelError> {
    // Most scenes have nothing to ask.
    if scene.worlds().next().is_none() && scene.frames().next().is_none() {
        return Ok(());
    }
    let worlds = robot.worlds();
    let is_world = |name: &str| worlds.iter().any(|world| world == plain(name));
    if let Some((object, frame)) = scene
        .worlds()
        .find(|(_, frame)| !is_world(frame))
    {
        let object = object.to_owned();
        let link = plain(frame).to_owned();
        return Err(match robot.link_index(&link) {
            Some(_) => CollisionModelError::FrameOfLink { object, link },
            None => {
                let source = Box::new(scene.unknown_frame(frame, &worlds));
                CollisionModelError::UnknownFrame { object, source }
            }
        });
    }
    for (name, pose) in scene.frames() {
        let is_elsewhere = match robot.link_index(plain(name)) {
            Some(link) => robot
                .fixed_pose(link)
                .is_none_or(|fixed| fixed != *pose),
            None => is_world(name) && *pose != Pose::identity(),
        };
        if is_elsewhere {
            return Err(CollisionModelError::FrameTaken {
                name: name.to_owned(),
            });
        }
    }
    Ok(())
}

/// Objects that have the name of a link, a line each: which of the two a name then means is not the
/// same everywhere.
pub fn shared_names(robot: &RobotModel, scene: &Scene) -> Vec<Warning> {
    let shared = scene
        .objects()
        .filter(|object| robot.link_index(&object.id).is_some());
    shared
        .map(|object| shared_name(&object.id))
        .collect()
}

fn shared_name(id: &str) -> Warning {
    Warning::uncovered(format!(
        "object {id:?} has the name of a link: in pairs of names both are meant, as a frame the object (MoveIt takes the link); rename the object"
    ))
}

fn plain(name: &str) -> &str {
    name.strip_prefix('/').unwrap_or(name)
}
