//! Robot and surroundings together: bodies, and the pairs of them that must keep apart.

use std::collections::BTreeMap;

use super::pose::{Pose, Vector};
use super::robot::Robot;
use super::solid::{Part, ball_of};

/// A body: a link, an object, or what a link carries.
#[derive(Clone, Debug)]
pub struct Body {
    pub name: String,
    /// Link that carries it; `None` is the world.
    pub link: Option<usize>,
    /// Whether it is the link itself.
    pub is_link: bool,
    /// In the frame of what carries it.
    pub parts: Vec<Part>,
    pub ball: (Vector, f64),
}

impl Body {
    pub fn new(name: &str, link: Option<usize>, is_link: bool, parts: Vec<Part>) -> Self {
        let ball = ball_of(&parts);
        Self {
            name: name.to_owned(),
            link,
            is_link,
            parts,
            ball,
        }
    }

    pub fn pose(&self, links: &[Pose]) -> Pose {
        self.link
            .map_or(Pose::IDENTITY, |link| links[link])
    }
}

/// Two bodies that must keep apart.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    pub a: usize,
    pub b: usize,
    /// Whether a column moves them against each other; else they must only not overlap.
    pub is_moving: bool,
}

/// What the files describe.
#[derive(Clone, Debug)]
pub struct World {
    pub robot: Robot,
    pub bodies: Vec<Body>,
    pub pairs: Vec<Pair>,
}

impl World {
    /// Pairs of all bodies but those that may touch: `touching` are names that the scene allows.
    pub fn pair_up(robot: &Robot, bodies: &[Body], touching: &[(String, String)]) -> Vec<Pair> {
        let mut pairs = Vec::new();
        for b in 0..bodies.len() {
            for a in 0..b {
                let one = &bodies[a];
                let other = &bodies[b];
                let is_named = |(x, y): &(String, String)| {
                    (*x == one.name && *y == other.name) || (*y == one.name && *x == other.name)
                };
                if touching.iter().any(is_named) {
                    continue;
                }
                if let Some(is_moving) = is_checked(robot, one, other) {
                    pairs.push(Pair { a, b, is_moving });
                }
            }
        }
        pairs
    }

    /// Floors of the pairs that an answer lowered; all others keep `clearance`.
    pub fn floors(&self, clearance: f64, lowered: &BTreeMap<[String; 2], f64>) -> Vec<f64> {
        let floor = |pair: &Pair| {
            let a = &self.bodies[pair.a].name;
            let b = &self.bodies[pair.b].name;
            let named = [[a.clone(), b.clone()], [b.clone(), a.clone()]];
            let lowered = named
                .iter()
                .find_map(|names| lowered.get(names))
                .copied();
            if pair.is_moving {
                lowered.unwrap_or(clearance)
            } else {
                0.0
            }
        };
        self.pairs.iter().map(floor).collect()
    }
}

/// Whether a pair must keep apart, and then whether it moves.
fn is_checked(robot: &Robot, a: &Body, b: &Body) -> Option<bool> {
    match (a.link, b.link) {
        (None, None) => None,
        (Some(link), None) | (None, Some(link)) => Some(robot.moves(link)),
        (Some(one), Some(other)) => {
            let is_moving = one != other && robot.moves_between(one, other);
            if !(a.is_link && b.is_link) {
                // What a link carries may touch that link.
                let is_carried_by = one == other && (a.is_link || b.is_link);
                return (!is_carried_by).then_some(is_moving);
            }
            let is_left_out = match &robot.disabled {
                Some(pairs) => pairs.contains(&(one, other)) || pairs.contains(&(other, one)),
                None => {
                    robot.joints[one].parent == Some(other)
                        || robot.joints[other].parent == Some(one)
                }
            };
            (!is_left_out && is_moving).then_some(true)
        }
    }
}
