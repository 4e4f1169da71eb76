//! Robot × scene: the bodies, and the pairs of them that are checked.

use std::sync::Arc;

use super::body::{Body, BodyKind, Size};
use super::error::CollisionModelError;
use super::filter::Filter;
use super::pairs::{BodyPair, Pairs, Rules};
use super::solids::Solids;
use crate::robot::{Kinematics, RobotModel};
use crate::scene::Scene;
use crate::shape::{PlacedShape, ScaleError};
use crate::solid::penetration::penetration;
use crate::solid::{Contact, Solid, Transform, query};

/// Everything that can collide, built once per robot and scene version and never changed.
#[derive(Clone, Debug)]
pub struct CollisionModel {
    robot: Arc<RobotModel>,
    scene: Arc<Scene>,
    solids: Arc<Solids>,
    bodies: Vec<Body>,
    pairs: Pairs,
    filter: Filter,
}

impl CollisionModel {
    /// Pairs every body that moves with the robot with every other that can come near it.
    ///
    /// Left out are: pairs that the robot's SRDF or description allows, pairs that the scene
    /// allows, an attached object with its own link and its touch links, and pairs of the robot's
    /// own links that no moving joint separates; what the scene forbids is checked whatever allows
    /// it. Pairs with an object that no joint brings nearer or farther are [static
    /// pairs](Self::static_contact), looked at once per request. Padding and scale count between
    /// robot and obstacles only.
    ///
    /// # Errors
    /// A name in the scene that is neither a link nor an object; a scale that leaves nothing of a
    /// mesh.
    pub fn new(robot: Arc<RobotModel>, scene: Arc<Scene>) -> Result<Self, CollisionModelError> {
        let solids = Solids::of_links(&robot);
        let links = link_bodies(&robot, &solids);
        Self::build(robot, scene, links, &[&solids])
    }

    /// The model of the same robot with another scene: the same as [`Self::new`] makes, bit for
    /// bit, but solids that this model has already are shared. Moving, attaching or allowing
    /// rebuilds none; where nothing but places of obstacles tells a scene from the one that it was
    /// made of, pairs are shared too.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_scene(&self, scene: Arc<Scene>) -> Result<Self, CollisionModelError> {
        self.with_scene_of(scene, Arc::default)
    }

    /// The same, with [solids of the scene's objects](Solids::of_objects) that are taken over where
    /// this model has none; they are asked for only if they may be needed.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_scene_of(
        &self,
        scene: Arc<Scene>,
        objects: impl FnOnce() -> Arc<Solids>,
    ) -> Result<Self, CollisionModelError> {
        if let Some(moved) = self.moved_bodies(&scene) {
            return Ok(self.with_moved(scene, &moved));
        }
        let links = self.link_bodies().to_vec();
        let robot = self.robot.clone();
        Self::build(robot, scene, links, &[&self.solids, &objects()])
    }

    /// The bodies of links as their shapes are, which are the same in every scene.
    fn link_bodies(&self) -> &[Body] {
        let is_own = |body: &&Body| body.kind == BodyKind::Link && body.size == Size::OWN;
        let count = self.bodies.iter().take_while(is_own).count();
        &self.bodies[..count]
    }

    /// Memory (bytes) that it takes besides the plain solids of links and objects, which other
    /// models share.
    pub fn own_bytes(&self) -> usize {
        let chains = self
            .bodies
            .iter()
            .map(|body| size_of_val(&*body.chain));
        size_of_val(&*self.bodies)
            + chains.sum::<usize>()
            + self.pairs.bytes()
            + self.filter.bytes()
            + self.solids.sized_bytes()
    }

    /// Memory (bytes) of the plain solids of links.
    pub fn link_bytes(&self) -> usize {
        self.solids.link_bytes()
    }

    /// Bodies that stand elsewhere in a scene that differs in nothing else; `None` where it may
    /// differ.
    fn moved_bodies(&self, scene: &Scene) -> Option<Vec<(usize, Transform)>> {
        if !self.scene.lines_up_with(scene) {
            return None;
        }
        let mut moved = Vec::new();
        let mut body = self.carried_bodies().len();
        for (before, now) in self
            .scene
            .obstacles()
            .iter()
            .zip(scene.obstacles())
        {
            let has_body = !before.shapes.is_empty();
            if !std::ptr::eq(before, now) {
                if !Arc::ptr_eq(&before.shapes, &now.shapes) {
                    return None;
                }
                let place = Transform::from(&now.pose);
                moved.extend(has_body.then(|| (body, self.bodies[body].solid.placed(place))));
            }
            body += usize::from(has_body);
        }
        Some(moved)
    }

    fn with_moved(&self, scene: Arc<Scene>, moved: &[(usize, Transform)]) -> Self {
        let mut bodies = self.bodies.clone();
        for &(body, place) in moved {
            bodies[body].place = place;
        }
        let pairs = self.pairs.placed(&self.robot, &bodies);
        let filter = self
            .filter
            .with_moved(&bodies, moved.iter().map(|(body, _)| *body));
        Self {
            robot: self.robot.clone(),
            scene,
            solids: self.solids.clone(),
            bodies,
            pairs,
            filter,
        }
    }

    /// The model of a robot with nothing around it, of [link solids](Self::link_solids) that were
    /// made of it before; `None` if they are not this robot's.
    pub fn of_links(robot: Arc<RobotModel>, links: Vec<Option<Solid>>) -> Option<Self> {
        let solids = Solids::with_links(&robot, links)?;
        let bodies = link_bodies(&robot, &solids);
        Self::build(robot, Arc::new(Scene::default()), bodies, &[&solids]).ok()
    }

    /// The model of a robot with the same links, of which other joints are variables, with nothing
    /// around it: solids are shared.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_robot(&self, robot: Arc<RobotModel>) -> Result<Self, CollisionModelError> {
        let links = link_bodies(&robot, &self.solids);
        Self::build(robot, Arc::new(Scene::default()), links, &[&self.solids])
    }

    /// The solids of the robot's links, in their order; `None` where a link has no shapes.
    pub fn link_solids(&self) -> impl Iterator<Item = Option<&Solid>> {
        self.solids.links().iter().map(Option::as_deref)
    }

    /// Of the bodies of links, and solids that were made before, the links' first.
    fn build(
        robot: Arc<RobotModel>,
        scene: Arc<Scene>,
        links: Vec<Body>,
        before: &[&Solids],
    ) -> Result<Self, CollisionModelError> {
        let rules = Rules::new(&robot, &scene)?;
        let mut solids = before[0].links_only();
        let mut bodies = links;
        attach_bodies(&robot, &scene, &mut bodies, &mut solids, before);
        let facing = add_sized(&robot, &scene, &mut bodies, &mut solids, before)?;
        let robot_bodies = bodies.len();
        for obstacle in scene
            .obstacles()
            .iter()
            .filter(|obstacle| !obstacle.shapes.is_empty())
        {
            let bare = solids.object(&obstacle.shapes, before);
            let size = Size::of(&scene, &obstacle.id);
            let solid = solids.sized(&bare, &obstacle.shapes, size, before);
            bodies.push(Body::of_obstacle(
                obstacle,
                size,
                solid.map_err(no_solid(&obstacle.id, size))?,
            ));
        }
        let pairs = rules.pairs(&bodies, &facing, robot_bodies);
        let filter = Filter::new(&robot, &bodies, robot_bodies, &pairs.moving);
        Ok(Self {
            robot,
            scene,
            solids: Arc::new(solids),
            bodies,
            pairs,
            filter,
        })
    }

    /// The robot.
    pub fn robot(&self) -> &Arc<RobotModel> {
        &self.robot
    }
    /// The scene.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }
    /// Links with shapes, then attached objects, then those of both that are padded or scaled once
    /// more at that size, then obstacles.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }
    /// The first of [`Self::bodies`]: those that links carry.
    pub fn carried_bodies(&self) -> &[Body] {
        &self.bodies[..self.filter.bodies.len()]
    }
    /// Pairs that some joint of the robot moves against each other.
    pub fn pairs(&self) -> &[BodyPair] {
        &self.pairs.moving
    }
    /// Pairs that are checked though no joint of the robot moves them against each other.
    pub fn static_pairs(&self) -> &[BodyPair] {
        &self.pairs.standing
    }
    /// Of [`Self::pairs`], those with a mesh, in which the other body may be hidden.
    pub fn hollow_pairs(&self) -> &[usize] {
        &self.pairs.hollow
    }
    /// Of [`Self::static_pairs`], those that are not far apart for good.
    pub fn close_pairs(&self) -> &[usize] {
        &self.pairs.close
    }
    /// What the filter sees of the model.
    pub fn filter(&self) -> &Filter {
        &self.filter
    }
    /// Names of the two bodies of pair `index`.
    pub fn pair_names(&self, index: usize) -> [String; 2] {
        let pair = self.pairs.moving[index];
        [pair.a, pair.b].map(|body| self.bodies[body].name.to_string())
    }

    /// First pair that is checked, that no joint moves and that overlaps, with its names and
    /// contact.
    pub fn static_contact(&self, kinematics: &Kinematics) -> Option<([String; 2], Contact)> {
        self.pairs.close.iter().find_map(|&index| {
            let pair = &self.pairs.standing[index];
            let a = &self.bodies[pair.a];
            let b = &self.bodies[pair.b];
            let [at_a, at_b] = [a, b].map(|body| body.placed(kinematics));
            query::overlap(&a.solid, &at_a, &b.solid, &at_b)?;
            let contact = penetration(&a.solid, &at_a, &b.solid, &at_b);
            Some(([a, b].map(|body| body.name.to_string()), contact))
        })
    }
}

/// Links with shapes, without padding.
fn link_bodies(robot: &RobotModel, solids: &Solids) -> Vec<Body> {
    let links = 0..robot.links().len();
    links
        .filter_map(|link| Some(Body::of_link(robot, link, solids.link(link)?)))
        .collect()
}

/// Appends what links carry, without padding.
fn attach_bodies(
    robot: &RobotModel,
    scene: &Scene,
    bodies: &mut Vec<Body>,
    solids: &mut Solids,
    before: &[&Solids],
) {
    for attached in scene
        .attached()
        .iter()
        .filter(|attached| !attached.object.shapes.is_empty())
    {
        // The rules know every link that carries something.
        let Some(link) = robot.link_index(&attached.link_name) else {
            continue;
        };
        let solid = solids.object(&attached.object.shapes, before);
        bodies.push(Body::of_attached(robot, link, &attached.object, solid));
    }
}

/// Appends a body of another size for each that the scene pads or scales; gives for each body the
/// one that faces obstacles.
fn add_sized(
    robot: &RobotModel,
    scene: &Scene,
    bodies: &mut Vec<Body>,
    solids: &mut Solids,
    before: &[&Solids],
) -> Result<Vec<usize>, CollisionModelError> {
    let mut facing: Vec<_> = (0..bodies.len()).collect();
    for (index, facing) in facing.iter_mut().enumerate() {
        let body = &bodies[index];
        let size = Size::of(scene, &body.name);
        if size == Size::OWN {
            continue;
        }
        let shapes: &[PlacedShape] = match (body.kind, body.link) {
            (BodyKind::Link, Some(link)) => &robot.links()[link].shapes,
            _ => scene
                .attached()
                .get(&body.name)
                .map_or(&[], |attached| &attached.object.shapes),
        };
        let solid = solids
            .sized(&body.solid, shapes, size, before)
            .map_err(no_solid(&body.name, size))?;
        let sized = body.sized(robot, size, solid);
        *facing = bodies.len();
        bodies.push(sized);
    }
    Ok(facing)
}

fn no_solid(name: &str, size: Size) -> impl FnOnce(ScaleError) -> CollisionModelError {
    move |source| CollisionModelError::Scale {
        name: name.to_owned(),
        scale: size.scale,
        source,
    }
}
