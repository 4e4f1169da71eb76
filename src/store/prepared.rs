//! A robot and a scene, and their collision model once somebody has asked for it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use crate::collision::{CollisionModel, CollisionModelError};
use crate::robot::RobotModel;
use crate::scene::Scene;

/// The collision model of a robot and a scene, made when it is first asked for.
///
/// The store's owner never computes, so it hands out the promise; of several threads that ask at once, one makes
/// the model and the others wait for it.
#[derive(Debug)]
pub struct PreparedModel {
    robot: Arc<RobotModel>,
    scene: Arc<Scene>,
    /// The robot with nothing around it, whose solids are taken over.
    alone: Option<Arc<CollisionModel>>,
    model: OnceLock<Result<Arc<CollisionModel>, CollisionModelError>>,
    given_up: AtomicBool,
}

impl PreparedModel {
    /// A robot and a scene that nothing is made of yet.
    pub fn new(robot: Arc<RobotModel>, scene: Arc<Scene>) -> Self {
        Self { robot, scene, alone: None, model: OnceLock::new(), given_up: AtomicBool::new(false) }
    }

    /// The robot of a model that is made already, and a scene.
    pub fn of(alone: Arc<CollisionModel>, scene: Arc<Scene>) -> Self {
        Self { alone: Some(alone.clone()), ..Self::new(alone.robot().clone(), scene) }
    }

    /// The model.
    ///
    /// # Errors
    /// What [`CollisionModel::new`] refuses.
    pub fn get(&self) -> Result<&Arc<CollisionModel>, &CollisionModelError> {
        let make = || match &self.alone {
            Some(alone) => alone.with_scene(self.scene.clone()),
            None => CollisionModel::new(self.robot.clone(), self.scene.clone()),
        };
        self.model.get_or_init(|| make().map(Arc::new)).as_ref()
    }

    /// Whether the model is made already, or nobody will make it before it is asked for.
    pub fn is_ready(&self) -> bool {
        self.model.get().is_some() || self.given_up.load(Ordering::Relaxed)
    }

    /// Nobody makes the model before it is asked for: who tried could not.
    pub fn give_up(&self) {
        self.given_up.store(true, Ordering::Relaxed);
    }
}
