//! The plain bound V: how fast any point of a body can be on a segment, or on an interval of a curved one.
//!
//! Seen from the link that a joint hangs on, the joint moves every point of the body at most at
//! ‖v‖ + ‖ω‖ρ, v its translation and ω its rotation per unit t, ρ the farthest that a point of the
//! body can be from the joint's moving origin. Going up from the body, ρ grows by each link's arm:
//! the farthest that its origin gets from the origin of the link before. Whatever the joints do, V
//! is the sum.

use crate::math::Vec3;
use crate::robot::{JointKind, Kinematics, RobotModel, kinematics};

/// How fast each coordinate is at most on a segment or an interval of one, and the arms of the robot there.
#[derive(Debug)]
pub struct Travel<'a> {
    robot: &'a RobotModel,
    velocity: Vec<f64>,
    /// For each link, the farthest that its origin gets from its parent's (m).
    arms: Vec<f64>,
}

/// The farthest that a link's origin gets from its parent's; 0 for a root, which stands.
fn arm(parent: Option<usize>, link: usize, ends: [&Kinematics; 2]) -> f64 {
    let Some(parent) = parent else {
        return 0.0;
    };
    let [first, last] = ends.map(|at| {
        let origin = |link: usize| at.poses()[link].translation;
        origin(link).distance(origin(parent))
    });
    first.max(last)
}

impl<'a> Travel<'a> {
    /// The motion by `velocity` between two configurations at which the robot was placed.
    ///
    /// Seen from its parent a link's origin goes straight, so it is farthest at one of the ends.
    pub fn new(robot: &'a RobotModel, velocity: &[f64], ends: [&Kinematics; 2]) -> Self {
        let arm = |link: usize| arm(robot.joints()[link].parent, link, ends);
        Self {
            robot,
            velocity: velocity.to_vec(),
            arms: (0..robot.joints().len()).map(arm).collect(),
        }
    }

    /// Any motion no faster than `speeds` on an interval of this half width in whose middle the robot was
    /// placed.
    ///
    /// A link's origin is no farther from its parent's than there and as far as its joint carries it.
    pub fn about(robot: &'a RobotModel, speeds: Vec<f64>, middle: &Kinematics, half: f64) -> Self {
        let mut travel = Self {
            robot,
            velocity: speeds,
            arms: Vec::new(),
        };
        travel.arms = (0..robot.joints().len())
            .map(|link| {
                let parent = robot.joints()[link].parent;
                let carried = half * travel.rates(link).0;
                arm(parent, link, [middle, middle]) + parent.map_or(0.0, |_| carried)
            })
            .collect();
        travel
    }

    /// V (m per unit t) of a body that `link` carries, in the frame of `ancestor`; `reach` is the
    /// farthest that a point of the body is from the link's origin (m). `None` is the world, where
    /// obstacles stand still.
    pub fn speed(&self, link: Option<usize>, ancestor: Option<usize>, reach: f64) -> f64 {
        let mut at = link;
        let mut reach = reach;
        let mut speed = 0.0;
        while at != ancestor
            && let Some(link) = at
        {
            let (translation, rotation) = self.rates(link);
            speed += translation + rotation * reach;
            reach += self.arms[link];
            at = self.robot.joints()[link].parent;
        }
        // Far above what the sums lose.
        speed * (1.0 + 1e-12)
    }

    /// How fast a link turns at most (rad per unit t), in the world.
    pub fn turning(&self, link: Option<usize>) -> f64 {
        let parent = |link: &usize| self.robot.joints()[*link].parent;
        let way = std::iter::successors(link, parent);
        let turning: f64 = way.map(|link| self.rates(link).1).sum();
        turning * (1.0 + 1e-12)
    }

    /// ‖v‖ (m) and ‖ω‖ (rad) of a link's joint per unit t.
    fn rates(&self, link: usize) -> (f64, f64) {
        let joint = &self.robot.joints()[link];
        let Some((first, factor)) = kinematics::rate(self.robot.joints(), joint) else {
            return (0.0, 0.0);
        };
        let rate = |index: usize| factor * self.velocity[first + index];
        let length =
            |index: usize| Vec3::new(rate(index), rate(index + 1), rate(index + 2)).length();
        match joint.kind {
            JointKind::Fixed => (0.0, 0.0),
            JointKind::Revolute | JointKind::Continuous => (0.0, rate(0).abs()),
            JointKind::Prismatic => (rate(0).abs(), 0.0),
            JointKind::Planar => (rate(0).hypot(rate(1)), rate(2).abs()),
            JointKind::Floating => (length(0), length(3)),
        }
    }
}
