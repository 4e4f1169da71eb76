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
    model: OnceLock<Result<Arc<CollisionModel>, CollisionModelError>>,
    given_up: AtomicBool,
}

impl PreparedModel {
    /// A robot and a scene that nothing is made of yet.
    pub fn new(robot: Arc<RobotModel>, scene: Arc<Scene>) -> Self {
        Self { robot, scene, model: OnceLock::new(), given_up: AtomicBool::new(false) }
    }

    /// The model.
    ///
    /// # Errors
    /// What [`CollisionModel::new`] refuses.
    pub fn get(&self) -> Result<&Arc<CollisionModel>, &CollisionModelError> {
        let make = || CollisionModel::new(self.robot.clone(), self.scene.clone()).map(Arc::new);
        self.model.get_or_init(make).as_ref()
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
