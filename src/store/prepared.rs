//! A robot and a scene, and their collision model once somebody has asked for it.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use super::objects::PreparedScene;
use crate::collision::{CollisionModel, CollisionModelError, Count};
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
    scene: Arc<PreparedScene>,
    model: OnceLock<Result<Arc<CollisionModel>, CollisionModelError>>,
    given_up: AtomicBool,
    claimed: AtomicBool,
    /// When somebody began to make it, on that one's clock (ns); 0 = nobody yet.
    begun_ns: AtomicU64,
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
    /// A robot of the same shapes, of which other joints are variables.
    Shapes(Arc<PreparedModel>),
}

/// What is made next of a model that is not there yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Missing {
    /// What.
    pub step: Step,
    /// When that began, by the clock of who makes it (ns); `None` while it waits for its turn.
    pub begun_ns: Option<u64>,
}

/// A step on the way to a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// The solids of the robot's links.
    Links(Count),
    /// The solids of the scene's objects.
    Objects(Count),
    /// These are there, or what they are soonest made from: robot and scene, with so many objects,
    /// are put together.
    Together(usize),
}

/// Least time (ns) in which the solid of a mesh is made, for each of its triangles: a quarter of
/// what was measured (1.1 µs), so that it takes no less anywhere.
const LEAST_NS_A_TRIANGLE: u64 = 250;

impl Missing {
    /// Least time (ns) from `now_ns` until it is made.
    pub fn least_left_ns(&self, now_ns: u64) -> u64 {
        let least_ns = match self.step {
            Step::Links(count) | Step::Objects(count) => {
                count.triangles as u64 * LEAST_NS_A_TRIANGLE
            }
            Step::Together(_) => 0,
        };
        let passed_ns = self
            .begun_ns
            .map_or(0, |begun_ns| now_ns.saturating_sub(begun_ns));
        least_ns.saturating_sub(passed_ns)
    }
}

impl PreparedModel {
    /// A robot and a scene that nothing is made of yet.
    pub fn new(robot: Arc<RobotModel>, scene: Arc<Scene>) -> Self {
        Self::from(
            robot,
            Arc::new(PreparedScene::new(scene)),
            Earlier::Nothing,
            Arc::default(),
        )
    }

    fn from(
        robot: Arc<RobotModel>,
        scene: Arc<PreparedScene>,
        earlier: Earlier,
        made: Arc<Made>,
    ) -> Self {
        Self {
            robot,
            scene,
            model: OnceLock::new(),
            given_up: AtomicBool::new(false),
            claimed: AtomicBool::new(false),
            begun_ns: AtomicU64::new(0),
            earlier: Mutex::new(earlier),
            made,
        }
    }

    /// A robot with nothing around it that is made when somebody first needs its solids; counted in
    /// `made`.
    pub fn alone(robot: Arc<RobotModel>, made: Arc<Made>) -> Self {
        let nothing = Arc::new(PreparedScene::new(Arc::default()));
        Self::from(robot, nothing, Earlier::Nothing, made)
    }

    /// A robot with nothing around it, of the solids of another one with the same shapes.
    pub fn of_shapes(alone: Arc<Self>, robot: Arc<RobotModel>) -> Self {
        let nothing = alone.scene.clone();
        let made = alone.made.clone();
        Self::from(robot, nothing, Earlier::Shapes(alone), made)
    }

    /// One that is made already.
    pub fn ready(model: Arc<CollisionModel>, made: Arc<Made>) -> Self {
        let robot = model.robot().clone();
        let scene = Arc::new(PreparedScene::new(model.scene().clone()));
        Self {
            model: OnceLock::from(Ok(model)),
            ..Self::from(robot, scene, Earlier::Nothing, made)
        }
    }

    /// The same robot with a later version of the scene. It is made from the previous one's model
    /// if that is ready by now, else from what that one would be made from, else anew: always to
    /// the same bits. However many versions follow each other, each holds one model of an earlier
    /// one at most, and none once its own is made.
    pub fn after(previous: &Self, scene: Arc<PreparedScene>) -> Self {
        let earlier = match previous.model.get() {
            Some(Ok(model)) => Earlier::Scene(model.clone()),
            _ => previous.earlier().clone(),
        };
        Self::from(
            previous.robot.clone(),
            scene,
            earlier,
            previous.made.clone(),
        )
    }

    /// The robot of a model with nothing around it, and a scene.
    pub fn of(alone: Arc<Self>, scene: Arc<PreparedScene>) -> Self {
        let robot = alone.robot.clone();
        let made = alone.made.clone();
        Self::from(robot, scene, Earlier::Alone(alone), made)
    }

    /// The robot.
    pub fn robot(&self) -> &Arc<RobotModel> {
        &self.robot
    }

    /// The scene.
    pub fn scene(&self) -> &Arc<Scene> {
        self.scene.scene()
    }

    /// The scene and the solids of its objects.
    pub fn prepared_scene(&self) -> &Arc<PreparedScene> {
        &self.scene
    }

    /// The model.
    ///
    /// # Errors
    /// What [`CollisionModel::new`] refuses.
    pub fn get(&self) -> Result<&Arc<CollisionModel>, &CollisionModelError> {
        if let Some(model) = self.model.get() {
            return model.as_ref();
        }
        let model = self
            .model
            .get_or_init(|| self.make().map(Arc::new));
        *self.earlier() = Earlier::Nothing;
        model.as_ref()
    }

    fn make(&self) -> Result<CollisionModel, CollisionModelError> {
        // Left where it is: what follows this one while it is made is made from the same.
        let earlier = self.earlier().clone();
        match earlier {
            Earlier::Nothing => {
                self.made.robots.fetch_add(1, Ordering::Relaxed);
                CollisionModel::new(self.robot.clone(), self.scene().clone())
            }
            Earlier::Scene(model) => self.put_into_scene(&model),
            Earlier::Alone(alone) => self.put_into_scene(alone.get().map_err(Clone::clone)?),
            Earlier::Shapes(alone) => {
                let model = alone.get().map_err(Clone::clone)?;
                model.with_robot(self.robot.clone())
            }
        }
    }

    fn put_into_scene(
        &self,
        model: &CollisionModel,
    ) -> Result<CollisionModel, CollisionModelError> {
        self.made.models.fetch_add(1, Ordering::Relaxed);
        model.with_scene_of(self.scene().clone(), || self.scene.solids().clone())
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

    /// Whether its solids are to be made from shapes, by whoever asks for it.
    pub fn is_bare(&self) -> bool {
        !self.is_ready() && matches!(*self.earlier(), Earlier::Nothing)
    }

    /// Nobody makes the model before it is asked for: who tried could not.
    pub fn give_up(&self) {
        self.given_up.store(true, Ordering::Relaxed);
    }

    /// Whether the caller is the first who wants to have it made ahead of a request.
    pub fn claim(&self) -> bool {
        !self.is_ready() && !self.claimed.swap(true, Ordering::Relaxed)
    }

    /// The caller begins to make it now, by its clock (ns).
    pub fn begin(&self, now_ns: u64) {
        self.begun_ns.store(now_ns, Ordering::Relaxed);
    }

    /// What is made next; `None` once the model is ready.
    pub fn missing(&self) -> Option<Missing> {
        if self.is_ready() {
            return None;
        }
        let begun_ns =
            Some(self.begun_ns.load(Ordering::Relaxed)).filter(|begun_ns| *begun_ns != 0);
        let step = match &*self.earlier() {
            Earlier::Nothing => Step::Links(self.links()),
            Earlier::Alone(alone) | Earlier::Shapes(alone) => match alone.missing() {
                None => self.step_in_scene(),
                // Who makes this one may be the one who makes that one.
                Some(missing) => {
                    return Some(Missing {
                        begun_ns: missing.begun_ns.or(begun_ns),
                        ..missing
                    });
                }
            },
            Earlier::Scene(_) => self.step_in_scene(),
        };
        Some(Missing { step, begun_ns })
    }

    fn step_in_scene(&self) -> Step {
        match self.scene.is_bare() {
            true => Step::Objects(self.scene.count()),
            false => Step::Together(self.scene().obstacles().len() + self.scene().attached().len()),
        }
    }

    /// What the solids of the robot's links are made of.
    pub fn links(&self) -> Count {
        let links = self.robot.links().iter();
        Count::of(links.map(|link| &*link.shapes))
    }

    /// Memory (bytes) that the model takes besides the solids of links and objects, which others
    /// share.
    pub fn own_bytes(&self) -> usize {
        self.made_model()
            .map_or(0, |model| model.own_bytes())
    }

    /// Memory (bytes) of the links' meshes, and of their solids as far as they are made.
    pub fn link_bytes(&self) -> usize {
        let solids = self
            .made_model()
            .map_or(0, |model| model.link_bytes());
        self.links().mesh_bytes + solids
    }

    fn made_model(&self) -> Option<&Arc<CollisionModel>> {
        self.model.get()?.as_ref().ok()
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
        let next = |before: &PreparedModel, scene| {
            let scene = PreparedScene::after(before.prepared_scene(), scene);
            PreparedModel::after(before, Arc::new(scene))
        };
        let second = next(&first, moved(&scene, 1.0));
        let third = next(&second, moved(&scene, 2.0));
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
        let scene = Arc::new(PreparedScene::new(scene));
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
