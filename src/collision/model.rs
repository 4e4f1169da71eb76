//! Robot × scene: the bodies, and the pairs of them that are checked.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::body::Body;
use super::contact::Contact;
use super::filter::Filter;
use super::query;
use crate::robot::{Kinematics, RobotModel, kinematics};
use crate::scene::Scene;

/// Everything that can collide, built once per robot and scene version and never changed.
#[derive(Clone, Debug)]
pub struct CollisionModel {
    robot: Arc<RobotModel>,
    scene: Arc<Scene>,
    bodies: Vec<Body>,
    pairs: Vec<BodyPair>,
    static_pairs: Vec<BodyPair>,
    filter: Filter,
}

/// Two bodies that are checked against each other. `a` belongs to the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BodyPair {
    /// First body.
    pub a: usize,
    /// Second body.
    pub b: usize,
    /// Nearest link that carries both; `None` is the world.
    pub ancestor: Option<usize>,
    /// How many motions of each body's chain act at or above the ancestor.
    pub motions_above: [usize; 2],
}

/// A robot and a scene that do not go together.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CollisionModelError {
    /// An allowed pair names nothing.
    #[error(
        "the scene allows {a} × {b}, but {name:?} is neither a link nor an object; links: {links}; objects: {objects}"
    )]
    UnknownName {
        /// First name of the pair.
        a: String,
        /// Second name.
        b: String,
        /// The one that is unknown.
        name: String,
        /// Valid links.
        links: String,
        /// Valid objects.
        objects: String,
    },
}

impl CollisionModel {
    /// Pairs every body of the robot with every other that can come near it.
    ///
    /// Left out are: pairs that the robot's SRDF or description allows, pairs that the scene allows, and
    /// pairs of the robot's own bodies that no moving joint separates. Obstacles that no joint brings
    /// nearer or farther are [static pairs](Self::static_contact), looked at once per request.
    ///
    /// # Errors
    /// An allowed pair of the scene that names neither a link nor an object.
    pub fn new(robot: Arc<RobotModel>, scene: Arc<Scene>) -> Result<Self, CollisionModelError> {
        let mut bodies = Vec::new();
        for (link, shapes) in robot.links().iter().enumerate().map(|(i, l)| (i, &l.shapes)) {
            if !shapes.is_empty() {
                bodies.push(Body::of_link(&robot, link));
            }
        }
        let robot_bodies = bodies.len();
        bodies.extend(scene.obstacles().iter().filter(|o| !o.shapes.is_empty()).map(Body::of_obstacle));
        let allowed = scene_allowed(&robot, &scene)?;
        let filter = Filter::new(&robot, &bodies, robot_bodies, &[]);
        let mut model = Self { robot, scene, bodies, pairs: Vec::new(), static_pairs: Vec::new(), filter };
        for a in 0..robot_bodies {
            for b in a + 1..model.bodies.len() {
                model.consider(a, b, &allowed);
            }
        }
        model.filter = Filter::new(&model.robot, &model.bodies, robot_bodies, &model.pairs);
        Ok(model)
    }

    fn consider(&mut self, a: usize, b: usize, allowed: &BTreeSet<(String, String)>) {
        let (body_a, body_b) = (&self.bodies[a], &self.bodies[b]);
        let names = sorted(&body_a.name, &body_b.name);
        if allowed.contains(&names) {
            return;
        }
        if let (Some(link_a), Some(link_b)) = (body_a.link, body_b.link)
            && self.robot.is_allowed(link_a, link_b)
        {
            return;
        }
        let ancestor = common_ancestor(&self.robot, body_a.link, body_b.link);
        let motions_above = [body_a.motions_up_to(ancestor), body_b.motions_up_to(ancestor)];
        let pair = BodyPair { a, b, ancestor, motions_above };
        let moves = moves_below(&self.robot, body_a.link, ancestor) || moves_below(&self.robot, body_b.link, ancestor);
        match (moves, body_b.link) {
            (true, _) => self.pairs.push(pair),
            (false, None) => self.static_pairs.push(pair),
            (false, Some(_)) => {}
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
    /// Links with shapes first, then obstacles.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }
    /// Pairs that some joint of the robot moves against each other.
    pub fn pairs(&self) -> &[BodyPair] {
        &self.pairs
    }
    /// What the filter sees of the model.
    pub fn filter(&self) -> &Filter {
        &self.filter
    }
    /// Names of the two bodies of pair `index`.
    pub fn pair_names(&self, index: usize) -> [String; 2] {
        let pair = self.pairs[index];
        [self.bodies[pair.a].name.clone(), self.bodies[pair.b].name.clone()]
    }

    /// First link × obstacle pair that no joint moves and that overlaps, with its names and contact.
    pub fn static_contact(&self, kinematics: &Kinematics) -> Option<([String; 2], Contact)> {
        self.static_pairs.iter().find_map(|pair| {
            let (a, b) = (&self.bodies[pair.a], &self.bodies[pair.b]);
            let contact = query::overlap(a, &a.placed(kinematics), b, &b.placed(kinematics))?;
            Some(([a.name.clone(), b.name.clone()], contact))
        })
    }
}

fn sorted(a: &str, b: &str) -> (String, String) {
    if a <= b { (a.to_owned(), b.to_owned()) } else { (b.to_owned(), a.to_owned()) }
}

fn scene_allowed(robot: &RobotModel, scene: &Scene) -> Result<BTreeSet<(String, String)>, CollisionModelError> {
    let known =
        |name: &str| robot.links().iter().any(|l| l.name == name) || scene.obstacles().iter().any(|o| o.id == name);
    for (a, b) in scene.allowed() {
        if let Some(name) = [a, b].into_iter().find(|name| !known(name)) {
            let links: Vec<_> = robot.links().iter().map(|l| l.name.as_str()).collect();
            let objects: Vec<_> = scene.obstacles().iter().map(|o| o.id.as_str()).collect();
            return Err(CollisionModelError::UnknownName {
                a: a.clone(),
                b: b.clone(),
                name: name.clone(),
                links: links.join(", "),
                objects: objects.join(", "),
            });
        }
    }
    Ok(scene.allowed().iter().map(|(a, b)| sorted(a, b)).collect())
}

/// Nearest link that both hang on (it may be one of them); `None` is the world, where obstacles are.
fn common_ancestor(robot: &RobotModel, a: Option<usize>, b: Option<usize>) -> Option<usize> {
    let (mut a, mut b) = (a?, b?);
    // Parents come before children, so the later of the two is never above the other.
    while a != b {
        if a > b {
            a = robot.joints()[a].parent?;
        } else {
            b = robot.joints()[b].parent?;
        }
    }
    Some(a)
}

/// Whether a variable moves some joint between `ancestor` (excluded) and `link`.
fn moves_below(robot: &RobotModel, link: Option<usize>, ancestor: Option<usize>) -> bool {
    let mut at = link;
    while at != ancestor {
        let Some(link) = at else { return false };
        let joint = &robot.joints()[link];
        if kinematics::rate(robot.joints(), joint).is_some() {
            return true;
        }
        at = joint.parent;
    }
    false
}
