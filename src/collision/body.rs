//! A body: a link's or an obstacle's solid, and how far each joint swings it.

use super::piece::{Piece, Transform};
use super::tree::BallTree;
use crate::math::Vec3;
use crate::robot::{Component, Drive, JointKind, Kinematics, RobotModel};
use crate::scene::Obstacle;
use crate::shape::Shape;

/// A rigid solid that is checked as a whole.
#[derive(Clone, Debug)]
pub struct Body {
    /// Name of the link or obstacle.
    pub name: String,
    /// The link that carries it; `None` for an obstacle, which stands still in the world.
    pub link: Option<usize>,
    /// Its pieces, in the link's (or world's) frame.
    pub tree: BallTree,
    /// A point of every connected part of its surface, for asking whether the part is inside a mesh.
    pub anchors: Vec<Vec3>,
    /// Pieces that belong to closed surfaces (mesh triangles): only these can hide something inside.
    pub hollow: bool,
    /// The motions that carry it, from the root to it.
    pub chain: Vec<ChainMotion>,
}

/// One elementary motion of a joint and how far it swings a body.
#[derive(Clone, Copy, Debug)]
pub struct ChainMotion {
    /// Joint (= link) whose motion it is.
    pub joint: usize,
    /// What moves.
    pub kind: MotionKind,
    /// First velocity coordinate, `None` for a joint that holds still.
    pub coordinate: Option<usize>,
    /// Where its value comes from.
    pub source: Source,
    /// Factor on value and velocity (a mimic's multiplier).
    pub factor: f64,
    /// Added to the value (a mimic's offset).
    pub offset: f64,
    /// For a rotation: distance from its axis (ball: centre) to the body's farthest point (m), whatever
    /// the joints in between do, as long as translations in between stay at `rest`.
    pub reach: f64,
    /// For a translation: the value that `reach` of the motions above counts on (m).
    pub rest: Vec3,
}

/// Where the value of a motion is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// First of its columns in the configuration.
    Column(usize),
    /// First of its held values.
    Held(usize),
}

/// An elementary motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionKind {
    /// Translation of `n` coordinates, which are mutually perpendicular.
    Translation(usize),
    /// Rotation by one coordinate about a fixed axis.
    Axis,
    /// Rotation by a rotation vector about a fixed centre.
    Ball,
}

impl Body {
    /// The body of a link that has shapes.
    pub fn of_link(robot: &RobotModel, link: usize) -> Self {
        let shapes = &robot.links()[link].shapes;
        let mut body = Self::of_shapes(robot.links()[link].name.clone(), shapes);
        body.link = Some(link);
        body.chain = chain(robot, link, &body.tree);
        body
    }

    /// The body of an obstacle.
    pub fn of_obstacle(obstacle: &Obstacle) -> Self {
        Self::of_shapes(obstacle.id.clone(), &obstacle.shapes)
    }

    fn of_shapes(name: String, shapes: &[crate::shape::PlacedShape]) -> Self {
        let (mut pieces, mut anchors, mut hollow) = (Vec::new(), Vec::new(), false);
        for placed in shapes {
            let first = pieces.len();
            Piece::append_of(placed, &mut pieces);
            match &placed.shape {
                Shape::Mesh(mesh) => {
                    hollow = true;
                    anchors.extend(mesh.parts().into_iter().map(|vertex| placed.pose.transform_point(vertex)));
                }
                _ => anchors.extend(pieces[first..].iter().map(Piece::center)),
            }
        }
        Self { name, link: None, tree: BallTree::new(pieces), anchors, hollow, chain: Vec::new() }
    }

    /// Where the body's frame is.
    pub fn placed(&self, kinematics: &Kinematics) -> Transform {
        self.link.map_or(Transform::IDENTITY, |link| Transform::from(&kinematics.poses()[link]))
    }

    /// Motions of the chain that act at or above `ancestor`: the relative motion begins after them.
    pub fn motions_up_to(&self, ancestor: Option<usize>) -> usize {
        ancestor.map_or(0, |link| self.chain.iter().take_while(|motion| motion.joint <= link).count())
    }
}

/// A ball that encloses a body as seen from somewhere up its chain.
struct Swept {
    center: Vec3,
    radius: f64,
}

/// The motions from the root to `link`. Going up from the body, a ball that encloses it is swept by each
/// joint: a rotation about an axis turns it into a ball about the nearest point of the axis.
fn chain(robot: &RobotModel, link: usize, tree: &BallTree) -> Vec<ChainMotion> {
    let root = tree.balls()[0];
    // Centres of the tree's balls count as points of the body: bounds on the body then hold for them.
    let centers = tree.balls().iter().map(|ball| ball.center.distance(root.center));
    let radius = centers.fold(root.radius, f64::max);
    let mut swept = Swept { center: root.center, radius };
    let mut motions = Vec::new();
    let mut at = Some(link);
    while let Some(index) = at {
        let joint = &robot.joints()[index];
        let (driver, factor, offset) = match joint.drive {
            Drive::Mimic { master, multiplier, offset } => (robot.joints()[master].drive, multiplier, offset),
            own => (own, 1.0, 0.0),
        };
        let motion = |kind, first: usize, reach, rest| {
            let (source, coordinate) = match driver {
                Drive::Variable { q, v } => (Source::Column(q + first), Some(v + first)),
                Drive::Held { first: value } => (Source::Held(value + first), None),
                Drive::Fixed | Drive::Mimic { .. } => unreachable!("a movable joint is driven by a variable or held"),
            };
            ChainMotion { joint: index, kind, coordinate, source, factor, offset, reach, rest }
        };
        match joint.kind {
            JointKind::Fixed => {}
            JointKind::Revolute | JointKind::Continuous => {
                motions.push(motion(MotionKind::Axis, 0, swept.turn_about(joint.axis), Vec3::ZERO));
            }
            JointKind::Prismatic => {
                let rest = Vec3::new(rest_value(robot, index), 0.0, 0.0);
                swept.center += joint.axis * rest.x;
                motions.push(motion(MotionKind::Translation(1), 0, 0.0, rest));
            }
            JointKind::Planar => {
                motions.push(motion(MotionKind::Axis, 2, swept.turn_about(Vec3::Z), Vec3::ZERO));
                motions.push(motion(MotionKind::Translation(2), 0, 0.0, Vec3::ZERO));
            }
            JointKind::Floating => {
                motions.push(motion(MotionKind::Ball, 3, swept.turn_about_center(), Vec3::ZERO));
                motions.push(motion(MotionKind::Translation(3), 0, 0.0, Vec3::ZERO));
            }
        }
        swept.center = joint.origin.transform_point(swept.center);
        at = joint.parent;
    }
    motions.reverse();
    motions
}

impl Swept {
    /// Sweeps the ball about an axis through the origin; returns the farthest that the axis has it.
    fn turn_about(&mut self, axis: Vec3) -> f64 {
        let on_axis = axis * self.center.dot(axis);
        self.radius += self.center.distance(on_axis);
        self.center = on_axis;
        self.radius
    }

    fn turn_about_center(&mut self) -> f64 {
        self.radius += self.center.length();
        self.center = Vec3::ZERO;
        self.radius
    }
}

/// Middle of a prismatic joint's range, where it has one; 0 otherwise.
pub(super) fn rest_value(robot: &RobotModel, joint: usize) -> f64 {
    let middle = |drive: Drive| match drive {
        Drive::Variable { q, .. } => {
            let middle = (robot.variables()[q].lower + robot.variables()[q].upper) / 2.0;
            if middle.is_finite() { middle } else { 0.0 }
        }
        _ => 0.0,
    };
    match robot.joints()[joint].drive {
        Drive::Mimic { master, multiplier, offset } => multiplier * middle(robot.joints()[master].drive) + offset,
        own => middle(own),
    }
}

/// Weights that make a path's length metres: 1 for a translation; for a rotation the farthest that any
/// body it carries can be from its axis. Never below 1 cm, so that every joint counts.
pub fn reach_weights(robot: &RobotModel, bodies: &[Body]) -> Vec<f64> {
    const LEAST: f64 = 0.01;
    let mut weights = vec![LEAST; robot.space().nv()];
    for body in bodies {
        // Translations between a rotation and the body push it out by up to half their range.
        let mut pushed = 0.0;
        for motion in body.chain.iter().rev() {
            if let MotionKind::Translation(_) = motion.kind {
                pushed += half_range(robot, motion);
            }
            let Some(first) = motion.coordinate else { continue };
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
            let most = weights[v..v + 3].iter().copied().fold(LEAST, f64::max);
            weights[v..v + 3].fill(most);
        }
    }
    weights
}

fn half_range(robot: &RobotModel, motion: &ChainMotion) -> f64 {
    let Source::Column(q) = motion.source else { return 0.0 };
    let half = (robot.variables()[q].upper - robot.variables()[q].lower) / 2.0 * motion.factor.abs();
    if half.is_finite() { half } else { 0.0 }
}
