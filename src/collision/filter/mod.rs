//! What the filter sees of a collision model: balls around the robot's bodies, boxes and cylinders
//! around the obstacles. It may prove that two bodies keep apart, never that they touch.

pub mod cover;
pub mod objects;

use super::body::{Body, MotionKind};
use super::pairs::BodyPair;
use super::piece::Core;
use crate::robot::lane_kinematics::Skeleton;
use crate::robot::{Drive, JointKind, RobotModel};
use cover::Ball;
pub use objects::{FilterObject, Hull, HullCore, ObjectNode, SolidHulls};

/// Obstacles that stay farther than this (m) from a body in every configuration are not looked at for
/// clearances below it.
pub const REMOTE_M: f64 = 0.1;

/// A ball in its frame.
#[derive(Clone, Copy, Debug)]
pub struct FilterBall {
    /// Centre (m).
    pub center: [f32; 3],
    /// Radius (m), with the rounding of where the lanes see the centre.
    pub radius: f32,
}

/// A joint that carries a body.
#[derive(Clone, Copy, Debug)]
pub struct Hop {
    /// Its motion in the lanes.
    pub motion: usize,
    /// Distance from its axis (ball: centre) to the farthest point of the body (m), translations below at rest.
    pub reach: f32,
}

/// A body of the robot.
#[derive(Clone, Debug)]
pub struct FilterBody {
    /// Frame that carries it.
    pub frame: usize,
    /// Ball around all of it.
    pub root: FilterBall,
    /// Balls around parts: each with the range of `balls` in it.
    pub clusters: Vec<(FilterBall, std::ops::Range<usize>)>,
    /// Balls that enclose it together.
    pub balls: Vec<FilterBall>,
    /// Joints that carry it, from the body down to the root.
    pub hops: Vec<Hop>,
    /// The body is made of these balls.
    pub is_exact: bool,
}

/// Whom a body of the robot is checked against.
#[derive(Clone, Copy, Debug)]
pub enum Partner {
    /// An obstacle, by index among the objects.
    Object(usize),
    /// Another body of the robot.
    Body {
        /// By index.
        body: usize,
        /// How many hops of each of the two bodies lie below the link that carries both.
        hops: [usize; 2],
    },
}

/// A pair, by the index that it has in the collision model.
#[derive(Clone, Copy, Debug)]
pub struct FilterPair {
    /// Body of the robot.
    pub body: usize,
    /// Whom it is checked against.
    pub partner: Partner,
}

/// The filter's model.
#[derive(Clone, Debug)]
pub struct Filter {
    /// Frames of the robot.
    pub skeleton: Skeleton,
    /// The robot's bodies.
    pub bodies: Vec<FilterBody>,
    /// The obstacles.
    pub objects: Vec<FilterObject>,
    /// All pairs.
    pub pairs: Vec<FilterPair>,
    /// For each body, the obstacles that it can come near.
    pub near: Vec<Vec<ObjectNode>>,
    /// For each body, the obstacles that it is always farther from than [`REMOTE_M`].
    pub remote: Vec<Vec<ObjectNode>>,
    /// Columns of translations and their ranges (m), outside of which what was taken for remote may not be.
    pub confines: Vec<(usize, std::ops::RangeInclusive<f64>)>,
    /// Pairs of two bodies of the robot.
    pub own: Vec<u32>,
    /// Rounding of half displacements, relative to their plain bound.
    pub blur: f32,
    /// Length that joint-space motion is measured by: how far the robot reaches (m).
    pub reach: f64,
}

impl Filter {
    /// Balls and boxes for the bodies of a model, of which the first `robot_bodies` move with the robot.
    pub fn new(robot: &RobotModel, bodies: &[Body], robot_bodies: usize, pairs: &[BodyPair]) -> Self {
        let skeleton = Skeleton::new(robot, |joint| super::body::rest_value(robot, joint));
        let objects = bodies[robot_bodies..].iter();
        let objects: Vec<_> = objects.map(|body| FilterObject::new(&body.solid.hulls, &body.place)).collect();
        let of_body = |body: &Body| body.chain.iter().map(|motion| motion.reach).fold(body.ball().radius, f64::max);
        let reach = bodies[..robot_bodies].iter().map(of_body).fold(1e-3, f64::max);
        let (mut near, mut remote) = (vec![Vec::new(); robot_bodies], vec![Vec::new(); robot_bodies]);
        let stays: Vec<_> = bodies[..robot_bodies].iter().map(|body| confinement(robot, body)).collect();
        let (mut own, mut filter_pairs) = (Vec::new(), Vec::new());
        for (index, pair) in pairs.iter().enumerate() {
            let index = index as u32;
            let partner = match pair.b.checked_sub(robot_bodies) {
                Some(object) => {
                    let is_remote = stays[pair.a]
                        .is_some_and(|Ball { center, radius }| objects[object].distance(center) > radius + REMOTE_M);
                    let list = if is_remote { &mut remote } else { &mut near };
                    list[pair.a].push((index, object as u32));
                    Partner::Object(object)
                }
                None => {
                    own.push(index);
                    let below = |body: usize| {
                        let is_below = |link| pair.ancestor.is_none_or(|ancestor| link > ancestor);
                        let mut joints: Vec<_> = bodies[body].chain.iter().map(|motion| motion.joint).collect();
                        joints.dedup();
                        joints.into_iter().filter(|&joint| is_below(joint)).count()
                    };
                    Partner::Body { body: pair.b, hops: [below(pair.a), below(pair.b)] }
                }
            };
            filter_pairs.push(FilterPair { body: pair.a, partner });
        }
        let trees = |lists: Vec<Vec<(u32, u32)>>| {
            lists.into_iter().map(|mut list| objects::tree(&mut list, &objects)).collect::<Vec<_>>()
        };
        let (near, remote) = (trees(near), trees(remote));
        let confines = robot.joints().iter().filter_map(|joint| match (joint.kind, joint.drive) {
            (JointKind::Prismatic, Drive::Variable { q, .. }) => {
                Some((q, robot.variables()[q].lower..=robot.variables()[q].upper))
            }
            _ => None,
        });
        let confines = confines.collect();
        let filter_bodies = bodies[..robot_bodies].iter().map(|body| FilterBody::new(body, &skeleton)).collect();
        let blur = 2.0 * skeleton.relative_rounding() as f32;
        Self { skeleton, blur, bodies: filter_bodies, objects, pairs: filter_pairs, near, remote, confines, own, reach }
    }
}

impl Filter {
    /// Whether the filter sees the distance of every pair as it is, up to rounding: the robot is made of balls,
    /// and every obstacle is a ball, box, cylinder or capsule or several of them.
    pub fn is_exact(&self) -> bool {
        self.bodies.iter().all(|body| body.is_exact) && self.objects.iter().all(|object| object.is_exact)
    }
}

impl FilterBody {
    fn new(body: &Body, skeleton: &Skeleton) -> Self {
        let (frame, place) = skeleton.carrier(body.link);
        let mut balls = body.solid.cover.clone();
        for ball in &mut balls {
            ball.center = place.transform_point(body.place.point(ball.center));
        }
        let starts = cover::cluster(&mut balls);
        let single = |ball: &Ball| FilterBall {
            center: ball.center.to_array().map(|value| value as f32),
            radius: (ball.radius + skeleton.rounding(ball.center.length() + ball.radius)) as f32 * (1.0 + f32::EPSILON),
        };
        let clusters = starts.windows(2).map(|w| (single(&cover::around(&balls[w[0]..w[1]])), w[0]..w[1])).collect();
        let mut hops: Vec<Hop> = Vec::new();
        for motion in body.chain.iter().rev() {
            let Some(index) = skeleton.motion_of(motion.joint) else { continue };
            let reach = match motion.kind {
                MotionKind::Translation(_) => 0.0,
                MotionKind::Axis | MotionKind::Ball => motion.reach as f32 * (1.0 + f32::EPSILON),
            };
            match hops.last_mut() {
                Some(hop) if hop.motion == index => hop.reach = hop.reach.max(reach),
                _ => hops.push(Hop { motion: index, reach }),
            }
        }
        let root = single(&cover::around(&balls));
        let is_exact = body.solid.tree.pieces().iter().all(|piece| matches!(piece.core, Core::Point(_)));
        Self { frame, root, clusters, balls: balls.iter().map(single).collect(), hops, is_exact }
    }
}

/// Ball in the world that the body never leaves as long as translations keep their limits; `None` where there
/// is no such ball.
fn confinement(robot: &RobotModel, body: &Body) -> Option<Ball> {
    let mut ball = body.ball();
    let mut at = body.link;
    while let Some(link) = at {
        let joint = &robot.joints()[link];
        match joint.kind {
            JointKind::Fixed => {}
            JointKind::Revolute | JointKind::Continuous => {
                let on_axis = joint.axis * ball.center.dot(joint.axis);
                ball = Ball { center: on_axis, radius: ball.radius + ball.center.distance(on_axis) };
            }
            JointKind::Prismatic => {
                let Drive::Variable { q, .. } = joint.drive else { return None };
                let variable = &robot.variables()[q];
                let (middle, half) = ((variable.lower + variable.upper) / 2.0, (variable.upper - variable.lower) / 2.0);
                if !half.is_finite() {
                    return None;
                }
                ball = Ball { center: ball.center + joint.axis * middle, radius: ball.radius + half };
            }
            JointKind::Planar | JointKind::Floating => return None,
        }
        ball.center = joint.origin.transform_point(ball.center);
        at = joint.parent;
    }
    Some(ball)
}
