//! Diffs as they are applied: changes that know where their objects have to be, and in what frame
//! their poses are.

use super::frames::{Reading, is_world, product, readings};
use super::object::is_same;
use super::{AttachedObject, Obstacle, Scene, SceneChange, SceneError};
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
        let made = self
            .steps
            .iter()
            .try_fold(scene.clone(), |scene, step| {
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
        self.steps
            .iter()
            .filter_map(|step| match &step.change {
                SceneChange::Attach { link_name, .. } => Some(link_name.as_str()),
                _ => None,
            })
    }

    /// Names of links or objects that it enters: in touch links, pairs, paddings and scales.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.steps
            .iter()
            .flat_map(|step| step.change.entered())
    }
}

impl Step {
    /// The changes that this step is for a scene.
    fn changes(&self, scene: &Scene, worlds: &[String]) -> Result<Vec<SceneChange>, SceneError> {
        self.check_place(scene)?;
        Ok(match self.change.clone() {
            SceneChange::Add(object) => self.added(object, scene, worlds)?,
            SceneChange::Append { id, shapes } => self.appended(id, shapes, scene, worlds)?,
            SceneChange::Move { id, pose } => self.moved(id, pose, scene, worlds)?,
            SceneChange::Detach { id, pose } => self.detached(id, pose, scene, worlds)?,
            SceneChange::Attach {
                id,
                touch_links,
                link_name,
                pose,
            } => {
                let object = Obstacle::new(id, Vec::new()).at(pose);
                self.attached(
                    scene,
                    AttachedObject {
                        object,
                        link_name,
                        touch_links,
                    },
                )
            }
            change => vec![change],
        })
    }

    /// An object whose frame goes elsewhere.
    fn moved(
        &self,
        id: String,
        pose: Pose,
        scene: &Scene,
        worlds: &[String],
    ) -> Result<Vec<SceneChange>, SceneError> {
        let Some(object) = scene.object(&id) else {
            return Ok(vec![SceneChange::Move { id, pose }]);
        };
        if !matches!(self.place, Place::World) {
            return Ok(moved_to(object, object.with_frame_at(pose)));
        }
        let frame = Frame::of(scene, &self.frame, worlds)?;
        let moved = object.with_frame_at(frame.place(&pose));
        Ok([moved_to(object, moved), frame.called(&id, scene)].concat())
    }

    /// An object that a link puts down.
    fn detached(
        &self,
        id: String,
        pose: Pose,
        scene: &Scene,
        worlds: &[String],
    ) -> Result<Vec<SceneChange>, SceneError> {
        let frame = Frame::of(scene, &self.frame, worlds)?;
        let pose = frame.place(&pose);
        let Some(carried) = scene.attached().get(&id) else {
            return Ok(vec![SceneChange::Detach { id, pose }]);
        };
        let called = frame.called(&id, scene);
        let pose = carried.object.with_frame_at(pose).pose;
        let put = SceneChange::Detach { id, pose };
        Ok([reshaped(&carried.object), vec![put], called].concat())
    }

    /// An object that is new, or takes the place of one of its name.
    fn added(
        &self,
        object: Obstacle,
        scene: &Scene,
        worlds: &[String],
    ) -> Result<Vec<SceneChange>, SceneError> {
        let id = object.id.clone();
        let subframes = [gone(&id, scene), self.brought(&id)].concat();
        // The link has it already, with other shapes until now.
        let carried = scene.attached().get(&id);
        if carried.is_some_and(|held| self.is_on(&held.link_name)) {
            return Ok([vec![SceneChange::Replace(object)], subframes].concat());
        }
        self.check_own_frame(&id)?;
        let frame = Frame::of(scene, &self.frame, worlds)?;
        let called = frame.called(&id, scene);
        let change = stood(frame.stand(object), scene);
        Ok([vec![change], subframes, called].concat())
    }

    /// Whether the step is said of what this link carries.
    fn is_on(&self, link_name: &str) -> bool {
        matches!(&self.place, Place::Link(link) if link == link_name)
    }

    /// Refuses an object in a frame of its own.
    fn check_own_frame(&self, id: &str) -> Result<(), SceneError> {
        let is_own =
            |reading| matches!(reading, Reading::Whole(of) | Reading::Of(of, _) if of == id);
        if readings(&self.frame).any(is_own) {
            let circle = format!("object {id:?} and itself");
            return Err(SceneError::FrameCircle(circle));
        }
        Ok(())
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
        let brought = self.brought(&id);
        let change = match (scene.object(&id), &self.place) {
            (Some(object), _) => lengthened(object, shapes),
            (None, Place::World) => return self.added(Obstacle::new(id, shapes), scene, worlds),
            (None, _) => SceneChange::Append { id, shapes },
        };
        Ok([vec![change], brought].concat())
    }

    /// What takes an object up, or nothing where the link has it already.
    fn attached(&self, scene: &Scene, given: AttachedObject) -> Vec<SceneChange> {
        let id = given.object.id.as_str();
        let is_carried = |held: &AttachedObject| {
            self.is_on(&held.link_name) && held.touch_links == given.touch_links
        };
        if scene.attached().get(id).is_some_and(is_carried) {
            return Vec::new();
        }
        match (&self.place, scene.obstacles().get(id)) {
            // Its frame is given, whatever makes it.
            (Place::Anywhere, Some(standing)) => {
                let pose = standing.with_frame_at(given.object.pose).pose;
                [reshaped(standing), vec![taken_up(given, pose)]].concat()
            }
            _ => {
                let pose = given.object.pose;
                vec![taken_up(given, pose)]
            }
        }
    }

    fn check_place(&self, scene: &Scene) -> Result<(), SceneError> {
        let (SceneChange::Append { id, .. }
        | SceneChange::Move { id, .. }
        | SceneChange::Detach { id, .. }) = &self.change
        else {
            return Ok(());
        };
        match scene.attached().get(id) {
            Some(held) => self.check_carried(id, &held.link_name),
            None => self.check_standing(id, scene),
        }
    }

    fn check_carried(&self, id: &str, link_name: &str) -> Result<(), SceneError> {
        match &self.place {
            Place::World => Err(SceneError::Carried {
                id: id.to_owned(),
                link_name: link_name.to_owned(),
            }),
            Place::Link(wanted) if !wanted.is_empty() && wanted != link_name => {
                Err(SceneError::OtherLink {
                    id: id.to_owned(),
                    link_name: link_name.to_owned(),
                    wanted: wanted.clone(),
                })
            }
            Place::Link(_) | Place::Anywhere => Ok(()),
        }
    }

    fn check_standing(&self, id: &str, scene: &Scene) -> Result<(), SceneError> {
        match (&self.place, scene.obstacles().get(id)) {
            (Place::Link(_), Some(_)) => Err(SceneError::not_attached(id, scene.attached_names())),
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
        let is_called = || is_called(scene, name, worlds);
        match scene.known_frame(name) {
            Some(pose) => Ok(Self::Known(pose)),
            None if is_world(name) => Ok(Self::World),
            None if is_called() => Ok(Self::Called(name.to_owned())),
            None => Err(scene.unknown_frame(name, worlds)),
        }
    }

    /// The object as it stands in the world.
    fn stand(&self, object: Obstacle) -> Obstacle {
        match self {
            Self::Known(pose) => object.in_frame(pose),
            Self::World | Self::Called(_) => object,
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
        if scene.world_of(id) == frame.as_deref() {
            return Vec::new();
        }
        let id = id.to_owned();
        vec![SceneChange::World { id, frame }]
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

impl SceneChange {
    /// Names of links or objects that it enters into the scene.
    fn entered(&self) -> Vec<&str> {
        match self {
            Self::Attach { touch_links, .. } => touch_links.iter().map(String::as_str).collect(),
            Self::Allow(a, b) | Self::Forbid(a, b) => vec![a, b],
            Self::Pad { name, padding } if *padding != 0.0 => vec![name],
            Self::Scale { name, scale } if *scale != 1.0 => vec![name],
            _ => Vec::new(),
        }
    }
}

/// What takes the frames of an object away.
fn gone(id: &str, scene: &Scene) -> Vec<SceneChange> {
    let names = scene
        .subframes_of(id)
        .map(|(name, _)| name.to_owned());
    let gone = names.map(|name| SceneChange::Subframe {
        object: id.to_owned(),
        name,
        pose: None,
    });
    gone.collect()
}

/// What makes an object stand that may be there already.
fn stood(object: Obstacle, scene: &Scene) -> SceneChange {
    match scene.obstacles().get(&object.id) {
        Some(_) => SceneChange::Replace(object),
        None => SceneChange::Add(object),
    }
}

/// What gives an object more shapes.
fn lengthened(object: &Obstacle, shapes: Vec<PlacedShape>) -> SceneChange {
    let longer = object.with_more(shapes.clone());
    // What only gets more shapes keeps those that it has, one by one.
    if object.is_framed_by_shape()
        || !is_same(&longer.pose, &object.pose)
        || object.shapes.is_empty()
    {
        return SceneChange::Replace(longer);
    }
    let id = object.id.clone();
    SceneChange::Append { id, shapes }
}

fn taken_up(given: AttachedObject, pose: Pose) -> SceneChange {
    SceneChange::Attach {
        id: given.object.id,
        link_name: given.link_name,
        touch_links: given.touch_links,
        pose,
    }
}

/// Whether robots call the world by this name.
fn is_called(scene: &Scene, name: &str, worlds: &[String]) -> bool {
    let plain = name.strip_prefix('/').unwrap_or(name);
    worlds.iter().any(|world| world == plain) || scene.worlds().any(|(_, world)| world == name)
}
