//! What the name of a frame means, and where the objects of a whole scene stand by it.

#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::pose_file::FrameFile;
use super::{Obstacle, Scene, SceneError};
use crate::math::Pose;

/// One way to read the name of a frame.
pub(super) enum Reading<'a> {
    /// An object's, or that of a fixed frame.
    Whole(&'a str),
    /// A frame on an object.
    Of(&'a str, &'a str),
}

/// The ways to read a name, the first that is there counts. Older ROS begins names with a slash;
/// ids may hold some.
pub(super) fn readings(name: &str) -> impl Iterator<Item = Reading<'_>> {
    let names = [Some(name), name.strip_prefix('/')]
        .into_iter()
        .flatten();
    names.flat_map(|name| {
        let parts = name
            .match_indices('/')
            .map(|(at, _)| Reading::Of(&name[..at], &name[at + 1..]));
        std::iter::once(Reading::Whole(name)).chain(parts)
    })
}

/// Whether every robot calls the world so.
pub fn is_world(name: &str) -> bool {
    name.is_empty() || name.strip_prefix('/').unwrap_or(name) == "world"
}

/// The frames of a text by name, with their poses in the world.
pub(super) fn fixed(files: &[FrameFile]) -> Result<BTreeMap<String, Pose>, SceneError> {
    let mut frames = BTreeMap::new();
    let worlds: Vec<&str> = files
        .iter()
        .filter(|file| file.given_in() == Some(file.name()))
        .map(FrameFile::name)
        .collect();
    for file in files {
        check_given_in(file, |name| worlds.contains(&name))?;
        let Some(pose) = file.pose()? else { continue };
        let is_itself = file.given_in() == Some(file.name());
        if is_itself && pose != Pose::identity() {
            return Err(SceneError::FrameCircle(format!("{:?}", file.name())));
        }
        // The world's own entry, which every message of MoveIt has.
        if is_world(file.name()) && pose == Pose::identity() {
            continue;
        }
        if frames
            .insert(file.name().to_owned(), pose)
            .is_some()
        {
            let text = format!(
                "fixed_frame_transforms has {:?} twice; keep one of them",
                file.name()
            );
            return Err(SceneError::Syntax(text));
        }
    }
    Ok(frames)
}

/// Refuses a frame that is given in another one than the world.
pub(super) fn check_given_in(
    file: &FrameFile,
    is_known: impl Fn(&str) -> bool,
) -> Result<(), SceneError> {
    match file.given_in() {
        Some(world) if !is_world(world) && !is_known(world) => {
            let text = format!(
                "fixed_frame_transforms: {:?} is given in {world:?}, which is not the world",
                file.name()
            );
            let advice = "a header has the frame's name and child_frame_id the world's, as in MoveIt's messages; without \
                          a header child_frame_id has the frame's name";
            Err(SceneError::Syntax(format!("{text}; {advice}")))
        }
        _ => Ok(()),
    }
}

/// An object as a whole scene gives it.
pub(super) struct Given {
    pub(super) object: Obstacle,
    /// Frame of its pose.
    pub(super) frame: String,
    /// Frames on it, in its own.
    pub(super) subframes: Vec<(String, Pose)>,
}

/// Objects where they stand in the world.
pub(super) struct Placed {
    pub(super) obstacles: Vec<Obstacle>,
    /// What the world is called by those whose frame the text does not know.
    pub(super) worlds: BTreeMap<String, String>,
}

/// What a pose is given in.
enum Parent {
    World,
    /// A frame that the text does not know.
    Called(String),
    Fixed(Pose),
    /// An object, or the pose of a frame on it.
    Object(usize, Option<Pose>),
}

/// Places each object by its frame, whichever comes first in the text.
pub(super) fn place<'a>(
    frames: &BTreeMap<String, Pose>,
    given: Vec<Given>,
    attached: impl Iterator<Item = &'a str>,
) -> Result<Placed, SceneError> {
    let attached: BTreeSet<&str> = attached.collect();
    let index: HashMap<&str, usize> = given
        .iter()
        .enumerate()
        .map(|(index, given)| (given.object.id.as_str(), index))
        .collect();
    let parents: Vec<Parent> = given
        .iter()
        .map(|one| parent(one, frames, &given, &index, &attached))
        .collect::<Result<_, _>>()?;
    let order = order(&parents).map_err(|circle| {
        let ids: Vec<String> = circle
            .iter()
            .map(|&index| format!("{:?}", given[index].object.id))
            .collect();
        SceneError::FrameCircle(ids.join(" → "))
    })?;
    let mut obstacles: Vec<Obstacle> = given
        .into_iter()
        .map(|given| given.object)
        .collect();
    let mut worlds = BTreeMap::new();
    for index in order {
        let frame = match &parents[index] {
            Parent::World => continue,
            Parent::Called(name) => {
                worlds.insert(obstacles[index].id.clone(), name.clone());
                continue;
            }
            Parent::Fixed(frame) => *frame,
            Parent::Object(parent, None) => obstacles[*parent].frame(),
            Parent::Object(parent, Some(on_it)) => product(&obstacles[*parent].frame(), on_it),
        };
        obstacles[index] = obstacles[index].in_frame(&frame);
    }
    Ok(Placed { obstacles, worlds })
}

fn parent(
    one: &Given,
    frames: &BTreeMap<String, Pose>,
    given: &[Given],
    index: &HashMap<&str, usize>,
    attached: &BTreeSet<&str>,
) -> Result<Parent, SceneError> {
    let subframe = |object: &str, name: &str| {
        let parent = *index.get(object)?;
        let found = given[parent]
            .subframes
            .iter()
            .rev()
            .find(|(known, _)| known == name)?;
        Some(Parent::Object(parent, Some(found.1)))
    };
    let known = |reading| match reading {
        Reading::Whole(name) => match index.get(name) {
            Some(parent) => Some(Parent::Object(*parent, None)),
            None => frames
                .get(name)
                .map(|pose| Parent::Fixed(*pose)),
        },
        Reading::Of(object, name) => subframe(object, name),
    };
    if one.frame.is_empty() {
        return Ok(Parent::World);
    }
    if let Some(parent) = readings(&one.frame).find_map(known) {
        return Ok(parent);
    }
    let is_carried = |reading| matches!(reading, Reading::Whole(id) | Reading::Of(id, _) if attached.contains(id));
    if readings(&one.frame).any(is_carried) {
        let id = &one.object.id;
        let frame = &one.frame;
        let text = format!(
            "object {id:?} is placed by {frame:?}, which a link carries: where it is, the robot decides"
        );
        return Err(SceneError::Syntax(format!(
            "{text}; attach {id:?} too, or give its pose in the world"
        )));
    }
    Ok(if is_world(&one.frame) {
        Parent::World
    } else {
        Parent::Called(one.frame.clone())
    })
}

/// An order in which each comes after what it is placed by, or those that form a circle.
fn order(parents: &[Parent]) -> Result<Vec<usize>, Vec<usize>> {
    let mut order = Vec::with_capacity(parents.len());
    // Whether it is in the order, and if not, on which way it was met.
    let mut seen: Vec<Option<usize>> = vec![None; parents.len()];
    let mut done = vec![false; parents.len()];
    for start in 0..parents.len() {
        let mut way = Vec::new();
        let mut at = Some(start);
        while let Some(index) = at.filter(|&index| !done[index]) {
            if seen[index] == Some(start) {
                let first = way
                    .iter()
                    .position(|&met| met == index)
                    .unwrap_or_default();
                return Err(way.split_off(first));
            }
            seen[index] = Some(start);
            way.push(index);
            at = match parents[index] {
                Parent::Object(parent, _) => Some(parent),
                Parent::World | Parent::Called(_) | Parent::Fixed(_) => None,
            };
        }
        for index in way.into_iter().rev() {
            done[index] = true;
            order.push(index);
        }
    }
    Ok(order)
}

impl Obstacle {
    /// The same object where its pose is given in a frame, which has `frame` as its pose in the
    /// world.
    pub(super) fn in_frame(&self, frame: &Pose) -> Self {
        let settled = self.settled();
        settled.with_frame_at(product(frame, &settled.pose))
    }
}

/// A pose in a frame, in what that frame is in. Products of many rotations would in time leave unit
/// length.
pub(super) fn product(frame: &Pose, pose: &Pose) -> Pose {
    let placed = *frame * *pose;
    Pose::from_parts(placed.translation, placed.rotation.normalize())
}

impl Scene {
    /// The pose in the world of a frame that the scene has.
    pub(crate) fn known_frame(&self, name: &str) -> Option<Pose> {
        readings(name).find_map(|reading| match reading {
            Reading::Whole(name) => self
                .obstacles
                .get(name)
                .map(Obstacle::frame)
                .or_else(|| self.frames.get(name).copied()),
            Reading::Of(object, name) => {
                let on_it = self
                    .subframes_of(object)
                    .find(|(known, _)| *known == name)?
                    .1;
                Some(product(&self.obstacles.get(object)?.frame(), on_it))
            }
        })
    }
}
