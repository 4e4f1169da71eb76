//! A robot and a scene, and their collision model once somebody has asked for it.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use crate::collision::{CollisionModel, CollisionModelError};
use crate::robot::RobotModel;
use crate::scene::Scene;

/// How often models were made, whoever asked for them.
#[derive(Debug, Default)]
pub struct Made {
    /// Robots whose solids were made from their shapes.
    pub robots: AtomicU64,
    /// Robots and scenes that were put together.
    pub models: AtomicU64,
}

/// The collision model of a robot and a scene, made when it is first asked for.
///
/// The store's owner never computes, so it hands out the promise; of several threads that ask at
/// once, one makes the model and the others wait for it.
#[derive(Debug)]
pub struct PreparedModel {
    robot: Arc<RobotModel>,
    scene: Arc<Scene>,
    model: OnceLock<Result<Arc<CollisionModel>, CollisionModelError>>,
    given_up: AtomicBool,
    /// What this one is soonest made from; let go once it is.
    earlier: Mutex<Earlier>,
    made: Arc<Made>,
}

/// What a model is made from.
#[derive(Clone, Debug, Default)]
enum Earlier {
    /// Nothing.
    #[default]
    Nothing,
    /// The model of the same robot with another scene.
    Scene(Arc<CollisionModel>),
    /// The robot with nothing around it, which somebody may be making.
    Alone(Arc<PreparedModel>),
}

impl PreparedModel {
    /// A robot and a scene that nothing is made of yet.
    pub fn new(robot: Arc<RobotModel>, scene: Arc<Scene>) -> Self {
        Self {
            robot,
            scene,
            model: OnceLock::new(),
            given_up: AtomicBool::new(false),
            earlier: Mutex::default(),
            made: Arc::default(),
        }
    }

    /// A robot with nothing around it that is made when somebody first needs its solids; counted in
    /// `made`.
    pub fn alone(robot: Arc<RobotModel>, made: Arc<Made>) -> Self {
        Self {
            made,
            ..Self::new(robot, Arc::new(Scene::default()))
        }
    }

    /// One that is made already.
    pub fn ready(model: Arc<CollisionModel>, made: Arc<Made>) -> Self {
        let robot = model.robot().clone();
        let scene = model.scene().clone();
        Self {
            model: OnceLock::from(Ok(model)),
            made,
            ..Self::new(robot, scene)
        }
    }

    /// The same robot with a later version of the scene. It is made from the previous one's model
    /// if that is ready by now, else from what that one would be made from, else anew: always to
    /// the same bits. However many versions follow each other, each holds one model of an earlier
    /// one at most, and none once its own is made.
    pub fn after(previous: &Self, scene: Arc<Scene>) -> Self {
        let ready = previous
            .model
            .get()
            .and_then(|made| made.as_ref().ok())
            .cloned();
        let earlier = ready.map_or_else(|| previous.earlier().clone(), Earlier::Scene);
        let made = previous.made.clone();
        Self {
            earlier: Mutex::new(earlier),
            made,
            ..Self::new(previous.robot.clone(), scene)
        }
    }

    /// The robot of a model with nothing around it, and a scene.
    pub fn of(alone: Arc<Self>, scene: Arc<Scene>) -> Self {
        let robot = alone.robot.clone();
        let made = alone.made.clone();
        Self {
            earlier: Mutex::new(Earlier::Alone(alone)),
            made,
            ..Self::new(robot, scene)
        }
    }

    /// The robot.
    pub fn robot(&self) -> &Arc<RobotModel> {
        &self.robot
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
        self.model
            .get_or_init(|| self.make().map(Arc::new))
            .as_ref()
    }

    fn make(&self) -> Result<CollisionModel, CollisionModelError> {
        let earlier = std::mem::take(&mut *self.earlier());
        let count = |made: &AtomicU64| made.fetch_add(1, Ordering::Relaxed);
        match earlier {
            Earlier::Nothing => {
                count(&self.made.robots);
                CollisionModel::new(self.robot.clone(), self.scene.clone())
            }
            Earlier::Scene(model) => {
                count(&self.made.models);
                model.with_scene(self.scene.clone())
            }
            Earlier::Alone(alone) => {
                let model = alone.get().map_err(Clone::clone)?;
                count(&self.made.models);
                model.with_scene(self.scene.clone())
            }
        }
    }

    fn earlier(&self) -> MutexGuard<'_, Earlier> {
        self.earlier
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
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
        let id = scene
            .objects()
            .next()
            .expect("an object")
            .id
            .clone();
        let moved = |scene: &Scene, x: f64| {
            let pose = Pose::from_translation(Vec3::X * x);
            Arc::new(
                scene
                    .with([SceneChange::Move {
                        id: id.clone(),
                        pose,
                    }])
                    .unwrap(),
            )
        };
        let first = PreparedModel::new(robot.clone(), scene.clone());
        let solid = |model: &PreparedModel| model.get().unwrap().bodies()[0].solid.clone();
        let of_first = solid(&first);
        let held = Arc::downgrade(first.get().unwrap());
        let second = PreparedModel::after(&first, moved(&scene, 1.0));
        let third = PreparedModel::after(&second, moved(&scene, 2.0));
        drop((first, second));
        assert!(held.upgrade().is_some() && !third.is_ready());
        assert!(
            Arc::ptr_eq(&solid(&third), &of_first),
            "it is made from the first"
        );
        assert!(held.upgrade().is_none(), "the first is let go");
        let anew = CollisionModel::new(robot, moved(&scene, 2.0)).unwrap();
        assert_eq!(
            format!("{:?}", third.get().unwrap().bodies()),
            format!("{:?}", anew.bodies())
        );
    }

    #[test]
    fn the_solids_of_a_robot_are_made_once_however_many_scenes_it_is_in() {
        let (robot, scene, _) = testing::two_scenes(&mut fastrand::Rng::with_seed(9));
        let made = Arc::new(Made::default());
        let alone = Arc::new(PreparedModel::alone(robot, made.clone()));
        let models: Vec<_> = (0..3)
            .map(|_| PreparedModel::of(alone.clone(), scene.clone()))
            .collect();
        std::thread::scope(|threads| {
            models
                .iter()
                .for_each(|model| drop(threads.spawn(|| model.get().is_ok())))
        });
        let solid = |model: &PreparedModel| model.get().unwrap().bodies()[0].solid.clone();
        assert!(
            models
                .iter()
                .all(|model| Arc::ptr_eq(&solid(model), &solid(&alone)))
        );
        assert_eq!(
            [&made.robots, &made.models].map(|count| count.load(Ordering::Relaxed)),
            [1, 3]
        );
    }
}
