//! What the filter sees of a collision model: balls around the robot's bodies, boxes and cylinders
//! around the obstacles. It may prove that two bodies keep apart, never that they touch.

pub mod object_tree;

use std::sync::Arc;

use super::body::Body;
use super::chain::MotionKind;
use super::pairs::BodyPair;
use crate::robot::lane_kinematics::Skeleton;
use crate::robot::{Drive, JointKind, RobotModel};
use crate::solid::core::Core;
use crate::solid::cover::{self, Ball};
use crate::solid::hulls::FilterObject;
use crate::solid::piece::Piece;
pub use object_tree::ObjectNode;

/// Obstacles that stay farther than this (m) from a body in every configuration are not looked at
/// for clearances below it.
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
    /// Distance from its axis (ball: centre) to the farthest point of the body (m), translations
    /// below at rest.
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
    pub skeleton: Arc<Skeleton>,
    /// The robot's bodies.
    pub bodies: Arc<[FilterBody]>,
    /// The obstacles.
    pub objects: Vec<FilterObject>,
    /// All pairs.
    pub pairs: Arc<[FilterPair]>,
    /// For each body, the obstacles that it can come near.
    pub near: Vec<Arc<Vec<ObjectNode>>>,
    /// For each body, the obstacles that it is always farther from than [`REMOTE_M`].
    pub remote: Vec<Arc<Vec<ObjectNode>>>,
    /// Columns of translations and their ranges (m), outside of which what was taken for remote may
    /// not be.
    pub confines: Arc<[(usize, std::ops::RangeInclusive<f64>)]>,
    /// Pairs of two bodies of the robot.
    pub own: Arc<[u32]>,
    /// Rounding of half displacements, relative to their plain bound.
    pub blur: f32,
    /// Length that joint-space motion is measured by: how far the robot reaches (m).
    pub reach: f64,
    /// For each body, a ball that it never leaves.
    stays: Arc<[Option<Ball>]>,
}

impl Filter {
    /// Balls and boxes for the bodies of a model, of which the first `robot_bodies` move with the
    /// robot.
    pub fn new(
        robot: &RobotModel,
        bodies: &[Body],
        robot_bodies: usize,
        pairs: &[BodyPair],
    ) -> Self {
        let skeleton = Skeleton::new(robot, |joint| super::chain::rest_value(robot, joint));
        let objects = bodies[robot_bodies..].iter();
        let objects = objects
            .map(|body| FilterObject::new(&body.solid.hulls, &body.place))
            .collect();
        let of_body = |body: &Body| {
            body.chain
                .iter()
                .map(|motion| motion.reach)
                .fold(body.ball().radius, f64::max)
        };
        let reach = bodies[..robot_bodies]
            .iter()
            .map(of_body)
            .fold(1e-3, f64::max);
        let pair = |pair: &BodyPair| FilterPair {
            body: pair.a,
            partner: partner(bodies, robot_bodies, pair),
        };
        let is_own = |&index: &u32| pairs[index as usize].b < robot_bodies;
        let confines = robot
            .joints()
            .iter()
            .filter_map(|joint| match (joint.kind, joint.drive) {
                (JointKind::Prismatic, Drive::Variable { q, .. }) => Some((
                    q,
                    robot.variables()[q].hard_lower..=robot.variables()[q].hard_upper,
                )),
                _ => None,
            });
        let mut filter = Self {
            blur: 2.0 * skeleton.relative_rounding() as f32,
            bodies: bodies[..robot_bodies]
                .iter()
                .map(|body| FilterBody::new(body, &skeleton))
                .collect(),
            skeleton: Arc::new(skeleton),
            objects,
            pairs: pairs.iter().map(pair).collect(),
            near: vec![Arc::default(); robot_bodies],
            remote: vec![Arc::default(); robot_bodies],
            confines: confines.collect(),
            own: (0..pairs.len() as u32).filter(is_own).collect(),
            reach,
            stays: bodies[..robot_bodies]
                .iter()
                .map(|body| confinement(robot, body))
                .collect(),
        };
        filter.plant(&vec![[true; 2]; robot_bodies]);
        filter
    }

    /// Memory that it takes (bytes).
    pub fn bytes(&self) -> usize {
        let balls = self
            .bodies
            .iter()
            .map(|body| size_of_val(&*body.balls));
        let boxes = self
            .objects
            .iter()
            .map(|object| size_of_val(&*object.boxes));
        let trees = self.near.iter().chain(&self.remote);
        let nodes = trees.map(|tree| size_of_val(&***tree));
        let bodies = size_of_val(&*self.bodies) + balls.sum::<usize>();
        let objects = size_of_val(&*self.objects) + boxes.sum::<usize>();
        bodies + objects + size_of_val(&*self.pairs) + nodes.sum::<usize>()
    }

    /// The filter of the same bodies, some of which, obstacles, stand elsewhere.
    pub fn with_moved(&self, bodies: &[Body], moved: impl Iterator<Item = usize>) -> Self {
        let mut filter = self.clone();
        let mut has_moved = vec![false; filter.objects.len()];
        for body in moved {
            let object = body - filter.bodies.len();
            filter.objects[object] =
                FilterObject::new(&bodies[body].solid.hulls, &bodies[body].place);
            has_moved[object] = true;
        }
        let mut stale = vec![[false; 2]; filter.bodies.len()];
        for pair in &*filter.pairs {
            let Partner::Object(object) = pair.partner else {
                continue;
            };
            if has_moved[object] {
                let sides = [self, &filter].map(|filter| filter.is_remote(pair.body, object));
                sides
                    .into_iter()
                    .for_each(|side| stale[pair.body][usize::from(side)] = true);
            }
        }
        filter.plant(&stale);
        filter
    }

    /// Whether an obstacle is always farther from a body than [`REMOTE_M`].
    fn is_remote(&self, body: usize, object: usize) -> bool {
        let is_far =
            |Ball { center, radius }| self.objects[object].distance(center) > radius + REMOTE_M;
        self.stays[body].is_some_and(is_far)
    }

    /// Makes trees over the obstacles: for each body, that of those which it can come near, and of
    /// the others.
    fn plant(&mut self, stale: &[[bool; 2]]) {
        let mut leaves = vec![[Vec::new(), Vec::new()]; stale.len()];
        for (index, pair) in self.pairs.iter().enumerate() {
            if let Partner::Object(object) = pair.partner
                && stale[pair.body] != [false; 2]
            {
                let side = usize::from(self.is_remote(pair.body, object));
                leaves[pair.body][side].push((index as u32, object as u32));
            }
        }
        for (body, leaves) in leaves.iter().enumerate() {
            for (side, trees) in [&mut self.near, &mut self.remote]
                .into_iter()
                .enumerate()
            {
                if stale[body][side] {
                    trees[body] = Arc::new(object_tree::tree(&leaves[side], &self.objects));
                }
            }
        }
    }
}

/// Whom the first body of a pair is checked against.
fn partner(bodies: &[Body], robot_bodies: usize, pair: &BodyPair) -> Partner {
    if let Some(object) = pair.b.checked_sub(robot_bodies) {
        return Partner::Object(object);
    }
    let below = |body: usize| {
        let is_below = |link| {
            pair.ancestor
                .is_none_or(|ancestor| link > ancestor)
        };
        let mut joints: Vec<_> = bodies[body]
            .chain
            .iter()
            .map(|motion| motion.joint)
            .collect();
        joints.dedup();
        joints
            .into_iter()
            .filter(|&joint| is_below(joint))
            .count()
    };
    Partner::Body {
        body: pair.b,
        hops: [below(pair.a), below(pair.b)],
    }
}

impl Filter {
    /// Whether the filter sees the distance of every pair as it is, up to rounding: the robot is
    /// made of balls, and every obstacle is a ball, box, cylinder or capsule or several of them.
    pub fn is_exact(&self) -> bool {
        self.bodies.iter().all(|body| body.is_exact)
            && self
                .objects
                .iter()
                .all(|object| object.is_exact)
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
            radius: (ball.radius + skeleton.rounding(ball.center.length() + ball.radius)) as f32
                * (1.0 + f32::EPSILON),
        };
        let clusters = starts
            .windows(2)
            .map(|w| (single(&cover::around(&balls[w[0]..w[1]])), w[0]..w[1]))
            .collect();
        let mut hops: Vec<Hop> = Vec::new();
        for motion in body.chain.iter().rev() {
            let Some(index) = skeleton.motion_of(motion.joint) else {
                continue;
            };
            let reach = match motion.kind {
                MotionKind::Translation(_) => 0.0,
                MotionKind::Axis | MotionKind::Ball => motion.reach as f32 * (1.0 + f32::EPSILON),
            };
            match hops.last_mut() {
                Some(hop) if hop.motion == index => hop.reach = hop.reach.max(reach),
                _ => hops.push(Hop {
                    motion: index,
                    reach,
                }),
            }
        }
        let root = single(&cover::around(&balls));
        let is_ball = |piece: &Piece| matches!(piece.core, Core::Point(_));
        // The cells of a cloud that moves are not looked at one by one.
        let tree = body.solid.tree.balls();
        let is_exact = tree.is_some_and(|tree| tree.pieces().iter().all(is_ball));
        Self {
            frame,
            root,
            clusters,
            balls: balls.iter().map(single).collect(),
            hops,
            is_exact,
        }
    }
}

/// Ball in the world that the body never leaves as long as translations keep their limits; `None`
/// where there is no such ball.
fn confinement(robot: &RobotModel, body: &Body) -> Option<Ball> {
    let mut ball = body.ball();
    let mut at = body.link;
    while let Some(link) = at {
        let joint = &robot.joints()[link];
        match joint.kind {
            JointKind::Fixed => {}
            JointKind::Revolute | JointKind::Continuous => {
                let on_axis = joint.axis * ball.center.dot(joint.axis);
                ball = Ball {
                    center: on_axis,
                    radius: ball.radius + ball.center.distance(on_axis),
                };
            }
            JointKind::Prismatic => {
                let Drive::Variable { q, .. } = joint.drive else {
                    return None;
                };
                let lower = robot.variables()[q].hard_lower;
                let upper = robot.variables()[q].hard_upper;
                let middle = (lower + upper) / 2.0;
                let half = (upper - lower) / 2.0;
                if !half.is_finite() {
                    return None;
                }
                ball = Ball {
                    center: ball.center + joint.axis * middle,
                    radius: ball.radius + half,
                };
            }
            JointKind::Planar | JointKind::Floating => return None,
        }
        ball.center = joint.origin.transform_point(ball.center);
        at = joint.parent;
    }
    Some(ball)
}
