//! A body: a link's or an object's solid, where it is, and how far each joint swings it.

use std::sync::Arc;

use super::chain::{self, ChainMotion, MotionKind, Source, SweptBall};
use crate::robot::{Component, Kinematics, RobotModel};
use crate::scene::{Obstacle, Scene};
use crate::solid::cover::Ball;
use crate::solid::tree::Tree;
use crate::solid::{Solid, Transform};

/// A solid that is checked as a whole, where it is and what carries it.
#[derive(Clone, Debug)]
pub struct Body {
    /// Name of the link or object.
    pub name: Arc<str>,
    /// Whose solid it is.
    pub kind: BodyKind,
    /// The link that carries it; `None` for an obstacle, which stands still in the world.
    pub link: Option<usize>,
    /// Where the solid's own frame is in the link's (or the world's).
    pub place: Transform,
    /// How it differs from its shapes.
    pub size: Size,
    /// The solid with its padding, shared by all models in which it is the same.
    pub solid: Arc<Solid>,
    /// The motions that carry it, from the root to it.
    pub chain: Vec<ChainMotion>,
}

/// How a body differs from its shapes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Size {
    /// How many times as large each of its shapes is, about its own centre.
    pub scale: f64,
    /// By how much it is thicker then (m).
    pub padding: f64,
}

impl Size {
    /// As its shapes are.
    pub const OWN: Self = Self {
        scale: 1.0,
        padding: 0.0,
    };

    /// What a scene gives a link or object.
    pub fn of(scene: &Scene, name: &str) -> Self {
        Self {
            scale: scene.scale(name),
            padding: scene.padding(name),
        }
    }
}

/// Whose solid a body is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BodyKind {
    /// A link's own.
    Link,
    /// An object's that a link carries.
    Attached,
    /// An object's that stands in the world.
    Obstacle,
}

impl Body {
    /// The body of a link's own solid.
    pub fn of_link(robot: &RobotModel, link: usize, solid: Arc<Solid>) -> Self {
        let name = robot.links()[link].name.as_str().into();
        Self {
            link: Some(link),
            ..Self::standing(name, BodyKind::Link, Transform::IDENTITY, solid)
        }
        .carried(robot)
    }

    /// The body of an object that a link carries.
    pub fn of_attached(
        robot: &RobotModel,
        link: usize,
        object: &Obstacle,
        solid: Arc<Solid>,
    ) -> Self {
        let place = solid.placed(Transform::from(&object.pose));
        let body = Self::standing(object.id.as_str().into(), BodyKind::Attached, place, solid);
        Self {
            link: Some(link),
            ..body
        }
        .carried(robot)
    }

    /// The body of an obstacle, with a solid of this size.
    pub fn of_obstacle(obstacle: &Obstacle, size: Size, solid: Arc<Solid>) -> Self {
        let place = solid.placed(Transform::from(&obstacle.pose));
        Self {
            size,
            ..Self::standing(
                obstacle.id.as_str().into(),
                BodyKind::Obstacle,
                place,
                solid,
            )
        }
    }

    fn standing(name: Arc<str>, kind: BodyKind, place: Transform, solid: Arc<Solid>) -> Self {
        Self {
            name,
            kind,
            link: None,
            place,
            size: Size::OWN,
            solid,
            chain: Vec::new(),
        }
    }

    fn carried(mut self, robot: &RobotModel) -> Self {
        self.chain = self.link.map_or(Vec::new(), |link| {
            chain(robot, link, &self.place, &self.solid.tree)
        });
        self
    }

    /// The same body with a solid of this size.
    #[must_use]
    pub fn sized(&self, robot: &RobotModel, size: Size, solid: Arc<Solid>) -> Self {
        Self {
            size,
            solid,
            ..self.clone()
        }
        .carried(robot)
    }

    /// Where the solid's frame is in the world.
    pub fn placed(&self, kinematics: &Kinematics) -> Transform {
        self.link.map_or(self.place, |link| {
            Transform::from(&kinematics.poses()[link]).of(&self.place)
        })
    }

    /// A ball that encloses it, in the frame of its link (or the world).
    pub fn ball(&self) -> Ball {
        let root = self.solid.tree.ball(0);
        Ball {
            center: self.place.point(root.center),
            radius: root.radius,
        }
    }

    /// Motions of the chain that act at or above `ancestor`: the relative motion begins after them.
    pub fn motions_up_to(&self, ancestor: Option<usize>) -> usize {
        ancestor.map_or(0, |link| {
            self.chain
                .iter()
                .take_while(|motion| motion.joint <= link)
                .count()
        })
    }
}

/// The motions from the root to `link`, and how far each swings the solid that stands there.
fn chain(robot: &RobotModel, link: usize, place: &Transform, tree: &Tree) -> Vec<ChainMotion> {
    let root = tree.ball(0);
    // Centres of the tree's balls count as points of the body: bounds on the body then hold for
    // them.
    let mut ball = SweptBall {
        center: place.point(root.center),
        radius: root.radius.max(tree.spread()),
    };
    chain::down_to(robot, link, None, &mut ball)
}

/// Weights that make a path's length metres: 1 for a translation; for a rotation the farthest that
/// any link's body it carries can be from its axis. Never below 1 cm, so that every joint counts.
/// Neither what links carry nor padding nor scale counts: lengths stay comparable from one scene to
/// the next.
pub fn reach_weights(robot: &RobotModel, bodies: &[Body]) -> Vec<f64> {
    const LEAST: f64 = 0.01;
    let mut weights = vec![LEAST; robot.space().nv()];
    for body in bodies
        .iter()
        .filter(|body| body.kind == BodyKind::Link && body.size == Size::OWN)
    {
        // Translations between a rotation and the body push it out by up to half their range.
        let mut pushed = 0.0;
        for motion in body.chain.iter().rev() {
            if let MotionKind::Translation(_) = motion.kind {
                pushed += half_range(robot, motion);
            }
            let Some(first) = motion.coordinate else {
                continue;
            };
            let (count, weight) = match motion.kind {
                MotionKind::Translation(n) => (n, 1.0),
                MotionKind::Axis => (1, motion.reach + pushed),
                MotionKind::Ball => (3, motion.reach + pushed),
            };
            for entry in &mut weights[first..first + count] {
                *entry = entry.max(weight * motion.factor.abs());
            }
        }
    }
    for component in robot.space().components() {
        if let Component::Rotation { v, .. } = *component {
            let most = weights[v..v + 3]
                .iter()
                .copied()
                .fold(LEAST, f64::max);
            weights[v..v + 3].fill(most);
        }
    }
    weights
}

fn half_range(robot: &RobotModel, motion: &ChainMotion) -> f64 {
    let Source::Column(q) = motion.source else {
        return 0.0;
    };
    // Soft limits are not walls: paths between them and the limits are checked too.
    let half = (robot.variables()[q].hard_upper - robot.variables()[q].hard_lower) / 2.0
        * motion.factor.abs();
    if half.is_finite() { half } else { 0.0 }
}
