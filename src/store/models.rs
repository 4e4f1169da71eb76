//! What is made of robots and scenes: each solid once, each robot and scene once.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use super::{Made, ModelStore, PreparedModel, PreparedScene, StoreError};
use crate::collision::CollisionModel;
use crate::robot::RobotModel;
use crate::scene::Scene;

impl ModelStore {
    /// Takes the model of a robot with nothing around it; models with scenes then take its solids
    /// over. `is_new` if its solids were made for this.
    pub fn take_alone(&mut self, model: Arc<CollisionModel>, is_new: bool) {
        self.made
            .robots
            .fetch_add(u64::from(is_new), Ordering::Relaxed);
        let key = (model.robot().hash(), self.nothing);
        let ready = Arc::new(PreparedModel::ready(model, self.made.clone()));
        self.models.insert(key, ready);
    }

    /// A loaded robot with nothing around it.
    pub fn alone(&self, robot: &RobotModel) -> Option<&Arc<PreparedModel>> {
        self.models.get(&(robot.hash(), self.nothing))
    }

    /// A loaded scene of this content, and the solids of its objects.
    pub fn prepared_scene(&self, scene: &Scene) -> Option<&Arc<PreparedScene>> {
        self.prepared_scenes.get(&scene.hash())
    }

    /// Everything that is made of a robot.
    pub fn models_of(&self, robot: &RobotModel) -> impl Iterator<Item = &Arc<PreparedModel>> {
        let hash = robot.hash();
        let models = self.models.iter();
        models
            .filter(move |((robot, _), _)| *robot == hash)
            .map(|(_, model)| model)
    }

    /// Everything that is put together in a scene of this hash.
    pub fn models_in(&self, scene: u64) -> impl Iterator<Item = &Arc<PreparedModel>> {
        let models = self.models.iter();
        models
            .filter(move |((_, hash), _)| *hash == scene)
            .map(|(_, model)| model)
    }

    /// The robot of a label with nothing around it.
    ///
    /// # Errors
    /// [`StoreError::UnknownRobot`].
    pub fn whole(&self, label: &str) -> Result<Arc<PreparedModel>, StoreError> {
        let robot = &self.robot(label)?.robot;
        let made = || Arc::new(PreparedModel::alone(robot.clone(), self.made.clone()));
        Ok(self.alone(robot).cloned().unwrap_or_else(made))
    }

    /// How often models were made.
    pub fn made(&self) -> &Made {
        &self.made
    }

    /// A robot with nothing around it, of the solids of one that is loaded where that has the same
    /// shapes.
    pub(super) fn new_alone(&self, robot: &Arc<RobotModel>) -> PreparedModel {
        let shapes = robot.shapes_hash();
        let others = self.robots.values();
        let same = others
            .filter(|entry| entry.robot.shapes_hash() == shapes)
            .find_map(|entry| self.alone(&entry.robot));
        match same {
            Some(alone) => PreparedModel::of_shapes(alone.clone(), robot.clone()),
            None => PreparedModel::alone(robot.clone(), self.made.clone()),
        }
    }

    /// Of a scene and one of the same content that is loaded, the one that is made.
    pub(super) fn ready_one(&self, prepared: Arc<PreparedScene>) -> Arc<PreparedScene> {
        match self.prepared_scene(prepared.scene()) {
            Some(known) if known.is_ready() || !prepared.is_ready() => known.clone(),
            _ => prepared,
        }
    }

    /// A robot and a scene that somebody asks for first; `newest` is the scene's newest version.
    pub(super) fn put_together(
        &self,
        robot: &Arc<RobotModel>,
        scene: &Arc<Scene>,
        newest: &Scene,
    ) -> Arc<PreparedModel> {
        let after = || match self.prepared_scene(newest) {
            Some(newest) => PreparedScene::after(newest, scene.clone()),
            None => PreparedScene::new(scene.clone()),
        };
        let prepared = self.prepared_scene(scene).cloned();
        let prepared = prepared.unwrap_or_else(|| Arc::new(after()));
        let alone = || Arc::new(PreparedModel::alone(robot.clone(), self.made.clone()));
        let alone = self.alone(robot).cloned().unwrap_or_else(alone);
        Arc::new(PreparedModel::of(alone, prepared))
    }

    /// Whoever asks for a model of the next version gets it from the one before, where there is
    /// one.
    pub(super) fn follow(&mut self, before: u64, scene: &Arc<PreparedScene>) {
        let of_before = self
            .models
            .iter()
            .filter(|((_, hash), _)| *hash == before);
        let next = of_before.map(|((robot, _), model)| {
            (*robot, Arc::new(PreparedModel::after(model, scene.clone())))
        });
        for (robot, model) in next.collect::<Vec<_>>() {
            self.models
                .entry((robot, scene.scene().hash()))
                .or_insert(model);
        }
    }
}
