//! Diffs as they are applied: changes that know where their objects have to be, and in what frame their poses are.

use super::{Obstacle, Scene, SceneChange, SceneError, comma_separated};
use crate::math::Pose;

/// A diff whose poses are checked and whose meshes are read; what depends on the scene shows when it is applied.
#[derive(Clone, Debug)]
pub struct SceneDiff(pub(super) Vec<Step>);

/// One change, and what it is said of.
#[derive(Clone, Debug)]
pub(super) struct Step {
    pub(super) change: SceneChange,
    pub(super) place: Place,
    /// Frame of a pose in the world.
    pub(super) frame: String,
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
    /// What [`Scene::with`] refuses; an object that is not in the world, or not on the link, that the diff says.
    pub fn apply(&self, scene: &Scene) -> Result<Scene, SceneError> {
        self.0.iter().try_fold(scene.clone(), |scene, step| scene.with(step.change(&scene)?))
    }

    /// Whether it brings shapes, of which there may be something to say.
    pub fn brings_shapes(&self) -> bool {
        self.0.iter().any(|step| matches!(step.change, SceneChange::Add(_) | SceneChange::Append { .. }))
    }

    /// Links that it attaches objects to.
    pub fn links(&self) -> impl Iterator<Item = &str> {
        self.0.iter().filter_map(|step| match &step.change {
            SceneChange::Attach { link_name, .. } => Some(link_name.as_str()),
            _ => None,
        })
    }

    /// Names of links or objects that it enters: in touch links, pairs, paddings and scales.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.iter().flat_map(|step| match &step.change {
            SceneChange::Attach { touch_links, .. } => touch_links.iter().map(String::as_str).collect(),
            SceneChange::Allow(a, b) | SceneChange::Forbid(a, b) => vec![a.as_str(), b.as_str()],
            SceneChange::Pad { name, padding } if *padding != 0.0 => vec![name.as_str()],
            SceneChange::Scale { name, scale } if *scale != 1.0 => vec![name.as_str()],
            _ => Vec::new(),
        })
    }
}

impl Step {
    /// The change that this step is for a scene, if it is one.
    fn change(&self, scene: &Scene) -> Result<Option<SceneChange>, SceneError> {
        self.check_place(scene)?;
        let stands = |id: &str| scene.obstacles().get(id).is_some();
        let in_world = |pose: &Pose| match scene.in_world(&self.frame, pose) {
            // MoveIt's planning frame by its usual name.
            Err(_) if self.frame == "world" => Ok(*pose),
            placed => placed,
        };
        let is_carried = |id: &str, touching: Option<&[String]>| match (scene.attached().get(id), &self.place) {
            (Some(carried), Place::Link(link)) => {
                carried.link_name == *link && touching.is_none_or(|names| names == carried.touch_links)
            }
            _ => false,
        };
        Ok(Some(match (self.change.clone(), &self.place) {
            // The link has it already, with other shapes until now.
            (SceneChange::Add(object), _) if is_carried(&object.id, None) => SceneChange::Replace(object),
            (SceneChange::Attach { id, touch_links, .. }, _) if is_carried(&id, Some(&touch_links)) => return Ok(None),
            (SceneChange::Add(object), _) => {
                let pose = in_world(&object.pose)?;
                let object = object.at(pose);
                if stands(&object.id) { SceneChange::Replace(object) } else { SceneChange::Add(object) }
            }
            (SceneChange::Append { id, shapes }, Place::World) if !stands(&id) => {
                SceneChange::Add(Obstacle::new(id, shapes).at(in_world(&Pose::identity())?))
            }
            (SceneChange::Move { id, pose }, Place::World) => SceneChange::Move { id, pose: in_world(&pose)? },
            (SceneChange::Detach { id, pose }, _) => SceneChange::Detach { id, pose: in_world(&pose)? },
            (change, _) => change,
        }))
    }

    fn check_place(&self, scene: &Scene) -> Result<(), SceneError> {
        let (SceneChange::Append { id, .. } | SceneChange::Move { id, .. } | SceneChange::Detach { id, .. }) =
            &self.change
        else {
            return Ok(());
        };
        let carrier = scene.attached().get(id).map(|attached| attached.link_name.clone());
        match (&self.place, carrier) {
            (Place::World, Some(link_name)) => Err(SceneError::Carried { id: id.clone(), link_name }),
            (Place::Link(wanted), Some(link_name)) if !wanted.is_empty() && *wanted != link_name => {
                Err(SceneError::OtherLink { id: id.clone(), link_name, wanted: wanted.clone() })
            }
            (Place::Link(_), None) if scene.obstacles().get(id).is_some() => {
                let known = comma_separated(scene.attached().iter().map(|attached| attached.object.id.as_str()));
                Err(SceneError::NotAttached { id: id.clone(), known })
            }
            _ => Ok(()),
        }
    }
}
