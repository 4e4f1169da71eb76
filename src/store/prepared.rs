//! A robot and a scene, and their collision model once somebody has asked for it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

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
    /// One of an earlier scene, from which this one is soonest made; let go once it is.
    earlier: Mutex<Option<Arc<CollisionModel>>>,
}

impl PreparedModel {
    /// A robot and a scene that nothing is made of yet.
    pub fn new(robot: Arc<RobotModel>, scene: Arc<Scene>) -> Self {
        Self { robot, scene, model: OnceLock::new(), given_up: AtomicBool::new(false), earlier: Mutex::new(None) }
    }

    /// The same robot with a later version of the scene. It is made from the previous one's model if that is ready by
    /// now, else from what that one would be made from, else anew: always to the same bits. However many versions
    /// follow each other, each holds one model of an earlier one at most, and none once its own is made.
    pub fn after(previous: &Self, scene: Arc<Scene>) -> Self {
        let ready = previous.model.get().and_then(|made| made.as_ref().ok()).cloned();
        let earlier = ready.or_else(|| previous.earlier.lock().unwrap_or_else(PoisonError::into_inner).clone());
        Self { earlier: Mutex::new(earlier), ..Self::new(previous.robot.clone(), scene) }
    }

    /// The robot of a model that is made already, and a scene.
    pub fn of(alone: Arc<CollisionModel>, scene: Arc<Scene>) -> Self {
        Self { earlier: Mutex::new(Some(alone.clone())), ..Self::new(alone.robot().clone(), scene) }
    }

    /// The scene.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// The model.
    ///
    /// # Errors
    /// What [`CollisionModel::new`] refuses.
    pub fn get(&self) -> Result<&Arc<CollisionModel>, &CollisionModelError> {
        let make = || {
            let earlier = self.earlier.lock().unwrap_or_else(PoisonError::into_inner).take();
            let made = match earlier {
                Some(earlier) => earlier.with_scene(self.scene.clone()),
                None => CollisionModel::new(self.robot.clone(), self.scene.clone()),
            };
            made.map(Arc::new)
        };
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Pose, Vec3};
    use crate::scene::SceneChange;
    use crate::testing;

    #[test]
    fn versions_are_made_from_the_nearest_that_is_ready_and_let_it_go() {
        let (robot, scene, _) = testing::two_scenes(&mut fastrand::Rng::with_seed(8));
        let id = scene.objects().next().expect("an object").id.clone();
        let moved = |scene: &Scene, x: f64| {
            let pose = Pose::from_translation(Vec3::X * x);
            Arc::new(scene.with([SceneChange::Move { id: id.clone(), pose }]).unwrap())
        };
        let first = PreparedModel::new(robot.clone(), scene.clone());
        let solid = |model: &PreparedModel| model.get().unwrap().bodies()[0].solid.clone();
        let of_first = solid(&first);
        let held = Arc::downgrade(first.get().unwrap());
        let second = PreparedModel::after(&first, moved(&scene, 1.0));
        let third = PreparedModel::after(&second, moved(&scene, 2.0));
        drop((first, second));
        assert!(held.upgrade().is_some() && !third.is_ready());
        assert!(Arc::ptr_eq(&solid(&third), &of_first), "it is made from the first");
        assert!(held.upgrade().is_none(), "the first is let go");
        let anew = CollisionModel::new(robot, moved(&scene, 2.0)).unwrap();
        assert_eq!(format!("{:?}", third.get().unwrap().bodies()), format!("{:?}", anew.bodies()));
    }
}
