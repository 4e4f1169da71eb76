//! Diffs as they are applied: changes that know where their objects have to be, and in what frame
//! their poses are.

use super::frames::{Reading, is_world, product, readings};
use super::object::is_same;
use super::{AttachedObject, Obstacle, Scene, SceneChange, SceneError, comma_separated};
use crate::math::Pose;
use crate::shape::PlacedShape;
use crate::warning::Warning;

/// A diff whose poses are checked and whose meshes are read; what depends on the scene shows when
/// it is applied.
#[derive(Clone, Debug)]
pub struct SceneDiff {
    pub(super) steps: Vec<Step>,
    /// What is odd about its text, a line each.
    pub(super) warnings: Vec<Warning>,
}

/// One change, and what it is said of.
#[derive(Clone, Debug)]
pub(super) struct Step {
    pub(super) change: SceneChange,
    pub(super) place: Place,
    /// Frame of a pose in the world.
    pub(super) frame: String,
    /// Frames on the object that it brings.
    pub(super) subframes: Vec<(String, Pose)>,
}

impl Step {
    /// A change that names no frame.
    pub(super) fn plain(change: SceneChange, place: Place) -> Self {
        Self {
            change,
            place,
            frame: String::new(),
            subframes: Vec::new(),
        }
    }
}

/// Where the object of a change has to be.
#[derive(Clone, Debug)]
pub(super) enum Place {
    /// In the world.
    World,
    /// On this link, or with an empty name on any.
    Link(String),
    /// Wherever it is.
    Anywhere,
}

impl SceneDiff {
    /// The scene that the diff makes of this one.
    ///
    /// # Errors
    /// What [`Scene::with`] refuses; an object that is not in the world, or not on the link, that
    /// the diff says; a frame that the scene does not know.
    pub fn apply(&self, scene: &Scene) -> Result<Scene, SceneError> {
        self.apply_among(scene, &[])
    }

    /// The same where robots call the world by these names too.
    ///
    /// # Errors
    /// As [`Self::apply`].
    pub fn apply_among(&self, scene: &Scene, worlds: &[String]) -> Result<Scene, SceneError> {
        let made = self.steps.iter().try_fold(scene.clone(), |scene, step| {
            scene.with(step.changes(&scene, worlds)?)
        })?;
        Ok(made.with_warnings(&self.warnings))
    }

    /// Whether there is something to say of it, or may be: it brings shapes.
    pub fn may_be_odd(&self) -> bool {
        !self.warnings.is_empty()
            || self.steps.iter().any(|step| {
                matches!(
                    step.change,
                    SceneChange::Add(_) | SceneChange::Append { .. }
                )
            })
    }

    /// Links that it attaches objects to.
    pub fn links(&self) -> impl Iterator<Item = &str> {
        self.steps.iter().filter_map(|step| match &step.change {
            SceneChange::Attach { link_name, .. } => Some(link_name.as_str()),
            _ => None,
        })
    }

    /// Names of links or objects that it enters: in touch links, pairs, paddings and scales.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.steps.iter().flat_map(|step| match &step.change {
            SceneChange::Attach { touch_links, .. } => {
                touch_links.iter().map(String::as_str).collect()
            }
            SceneChange::Allow(a, b) | SceneChange::Forbid(a, b) => vec![a.as_str(), b.as_str()],
            SceneChange::Pad { name, padding } if *padding != 0.0 => vec![name.as_str()],
            SceneChange::Scale { name, scale } if *scale != 1.0 => vec![name.as_str()],
            _ => Vec::new(),
        })
    }
}

impl Step {
    /// The changes that this step is for a scene.
    fn changes(&self, scene: &Scene, worlds: &[String]) -> Result<Vec<SceneChange>, SceneError> {
        self.check_place(scene)?;
        let change = self.change.clone();
        Ok(match (change, &self.place) {
            (SceneChange::Add(object), _) => self.added(object, scene, worlds)?,
            (SceneChange::Append { id, shapes }, _) => self.appended(id, shapes, scene, worlds)?,
            (SceneChange::Move { id, pose }, place) => {
                let Some(object) = scene.object(&id) else {
                    return Ok(vec![SceneChange::Move { id, pose }]);
                };
                match place {
                    Place::World => {
                        let frame = Frame::of(scene, &self.frame, worlds)?;
                        let moved = object.with_frame_at(frame.place(&pose));
                        [moved_to(object, moved), frame.called(&id, scene)].concat()
                    }
                    _ => moved_to(object, object.with_frame_at(pose)),
                }
            }
            (
                SceneChange::Attach {
                    id,
                    touch_links,
                    link_name,
                    pose,
                },
                place,
            ) => self.attached(
                scene,
                place,
                AttachedObject {
                    object: Obstacle::new(id, Vec::new()).at(pose),
                    link_name,
                    touch_links,
                },
            ),
            (SceneChange::Detach { id, pose }, _) => {
                let frame = Frame::of(scene, &self.frame, worlds)?;
                let pose = frame.place(&pose);
                let Some(carried) = scene.attached().get(&id) else {
                    return Ok(vec![SceneChange::Detach { id, pose }]);
                };
                let placed = carried.object.with_frame_at(pose);
                let called = frame.called(&id, scene);
                let put = SceneChange::Detach {
                    id,
                    pose: placed.pose,
                };
                [reshaped(&carried.object), vec![put], called].concat()
            }
            (change, _) => vec![change],
        })
    }

    /// An object that is new, or takes the place of one of its name.
    fn added(
        &self,
        object: Obstacle,
        scene: &Scene,
        worlds: &[String],
    ) -> Result<Vec<SceneChange>, SceneError> {
        let id = object.id.clone();
        let gone = scene
            .subframes_of(&id)
            .map(|(name, _)| SceneChange::Subframe {
                object: id.clone(),
                name: name.to_owned(),
                pose: None,
            });
        let gone: Vec<_> = gone.collect();
        let carried = scene.attached().get(&id);
        // The link has it already, with other shapes until now.
        let is_carried = carried.is_some_and(
            |held| matches!(&self.place, Place::Link(link) if *link == held.link_name),
        );
        if is_carried {
            return Ok([vec![SceneChange::Replace(object)], gone, self.brought(&id)].concat());
        }
        if readings(&self.frame)
            .any(|reading| matches!(reading, Reading::Whole(of) | Reading::Of(of, _) if of == id))
        {
            let circle = format!("object {id:?} and itself");
            return Err(SceneError::FrameCircle(circle));
        }
        let frame = Frame::of(scene, &self.frame, worlds)?;
        let called = frame.called(&id, scene);
        let object = match &frame {
            Frame::Known(pose) => object.in_frame(pose),
            Frame::World | Frame::Called(_) => object,
        };
        let stands = scene.obstacles().get(&id).is_some();
        let change = if stands {
            SceneChange::Replace(object)
        } else {
            SceneChange::Add(object)
        };
        Ok([vec![change], gone, self.brought(&id), called].concat())
    }

    /// Frames on the object that the step brings.
    fn brought(&self, id: &str) -> Vec<SceneChange> {
        let frames = self.subframes.iter().cloned();
        frames
            .map(|(name, pose)| SceneChange::Subframe {
                object: id.to_owned(),
                name,
                pose: Some(pose),
            })
            .collect()
    }

    fn appended(
        &self,
        id: String,
        shapes: Vec<PlacedShape>,
        scene: &Scene,
        worlds: &[String],
    ) -> Result<Vec<SceneChange>, SceneError> {
        // Shapes come in the object's own frame, but one that is named has to be there.
        Frame::of(scene, &self.frame, worlds)?;
        let change = match (scene.object(&id), &self.place) {
            (Some(object), _) => {
                let longer = object.with_more(shapes.clone());
                // What only gets more shapes keeps those that it has, one by one.
                match object.is_framed_by_shape()
                    || !is_same(&longer.pose, &object.pose)
                    || object.shapes.is_empty()
                {
                    true => vec![SceneChange::Replace(longer)],
                    false => vec![SceneChange::Append {
                        id: id.clone(),
                        shapes,
                    }],
                }
            }
            (None, Place::World) => return self.added(Obstacle::new(id, shapes), scene, worlds),
            (None, _) => vec![SceneChange::Append {
                id: id.clone(),
                shapes,
            }],
        };
        Ok([change, self.brought(&id)].concat())
    }

    /// What takes an object up, or nothing where the link has it already.
    fn attached(&self, scene: &Scene, place: &Place, given: AttachedObject) -> Vec<SceneChange> {
        let AttachedObject {
            object,
            link_name,
            touch_links,
        } = given;
        let id = object.id;
        let pose = object.pose;
        let is_carried = |held: &AttachedObject| {
            matches!(place, Place::Link(link) if *link == held.link_name)
                && held.touch_links == touch_links
        };
        if scene.attached().get(&id).is_some_and(is_carried) {
            return Vec::new();
        }
        match (place, scene.obstacles().get(&id)) {
            // Its frame is given, whatever makes it.
            (Place::Anywhere, Some(standing)) => {
                let pose = standing.with_frame_at(pose).pose;
                [
                    reshaped(standing),
                    vec![SceneChange::Attach {
                        id,
                        link_name,
                        touch_links,
                        pose,
                    }],
                ]
                .concat()
            }
            _ => vec![SceneChange::Attach {
                id,
                link_name,
                touch_links,
                pose,
            }],
        }
    }

    fn check_place(&self, scene: &Scene) -> Result<(), SceneError> {
        let (SceneChange::Append { id, .. }
        | SceneChange::Move { id, .. }
        | SceneChange::Detach { id, .. }) = &self.change
        else {
            return Ok(());
        };
        let carrier = scene
            .attached()
            .get(id)
            .map(|attached| attached.link_name.clone());
        match (&self.place, carrier) {
            (Place::World, Some(link_name)) => Err(SceneError::Carried {
                id: id.clone(),
                link_name,
            }),
            (Place::Link(wanted), Some(link_name))
                if !wanted.is_empty() && *wanted != link_name =>
            {
                Err(SceneError::OtherLink {
                    id: id.clone(),
                    link_name,
                    wanted: wanted.clone(),
                })
            }
            (Place::Link(_), None) if scene.obstacles().get(id).is_some() => {
                let known = comma_separated(
                    scene
                        .attached()
                        .iter()
                        .map(|attached| attached.object.id.as_str()),
                );
                Err(SceneError::NotAttached {
                    id: id.clone(),
                    known,
                })
            }
            _ => Ok(()),
        }
    }
}

/// The frame of a pose in the world.
enum Frame {
    World,
    /// One that the scene knows, with its pose in the world.
    Known(Pose),
    /// One that only robots know, for the world.
    Called(String),
}

impl Frame {
    fn of(scene: &Scene, name: &str, worlds: &[String]) -> Result<Self, SceneError> {
        let plain = name.strip_prefix('/').unwrap_or(name);
        match scene.known_frame(name) {
            Some(pose) => Ok(Self::Known(pose)),
            None if is_world(name) => Ok(Self::World),
            None if worlds.iter().any(|world| world == plain)
                || scene.worlds().any(|(_, world)| world == name) =>
            {
                Ok(Self::Called(name.to_owned()))
            }
            None => Err(scene.unknown_frame(name, worlds)),
        }
    }

    fn place(&self, pose: &Pose) -> Pose {
        match self {
            Self::Known(frame) => product(frame, pose),
            Self::World | Self::Called(_) => *pose,
        }
    }

    /// What has to be said of the frame of an object.
    fn called(&self, id: &str, scene: &Scene) -> Vec<SceneChange> {
        let frame = match self {
            Self::Called(name) => Some(name.clone()),
            Self::World | Self::Known(_) => None,
        };
        let is_said = scene.world_of(id) == frame.as_deref();
        if is_said {
            Vec::new()
        } else {
            vec![SceneChange::World {
                id: id.to_owned(),
                frame,
            }]
        }
    }
}

/// What makes an object stand as `moved` does.
fn moved_to(object: &Obstacle, moved: Obstacle) -> Vec<SceneChange> {
    match object.is_framed_by_shape() {
        true => vec![SceneChange::Replace(moved)],
        false => vec![SceneChange::Move {
            id: moved.id,
            pose: moved.pose,
        }],
    }
}

/// What makes an object's pose that of its frame.
fn reshaped(object: &Obstacle) -> Vec<SceneChange> {
    let settled = || SceneChange::Replace(object.settled());
    object
        .is_framed_by_shape()
        .then(settled)
        .into_iter()
        .collect()
}
