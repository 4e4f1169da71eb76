//! RRT-Connect (Kuffner and LaValle, 2000): two trees, from the start and from the goal, grow
//! towards random configurations and each other. Every edge is proved free, not sampled.

use fastrand::Rng;
use taut::collision::{CollisionModel, reach_weights};
use taut::path::{Metric, Path};
use taut::robot::{Component, ConfigurationSpace, Variable};
use taut::validation::{Scratch, Validator};

/// Range of a translation that the robot does not limit [m].
const UNLIMITED_M: f64 = 3.0;

/// What a search may do.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// Seed: the same seed, the same path.
    pub seed: u64,
    /// Random configurations to try before giving up.
    pub iterations: usize,
    /// Longest edge, in the metric of the robot's reach [m].
    pub edge_m: f64,
    /// Distance that every pair of bodies keeps [m].
    pub clearance_m: f64,
}

impl Default for Rules {
    fn default() -> Self {
        // Wider than what the daemon keeps by default, so that its proof starts with room.
        Self {
            seed: 0,
            iterations: 20_000,
            edge_m: 0.5,
            clearance_m: 5e-3,
        }
    }
}

/// A path from `start` to `goal`; `None` where the iterations did not find one.
pub fn plan(model: &CollisionModel, start: &[f64], goal: &[f64], rules: &Rules) -> Option<Path> {
    let robot = model.robot();
    let mut scratch = Scratch::default();
    let held: Vec<f64> = robot
        .held()
        .iter()
        .map(|held| held.default)
        .collect();
    let space = robot.space();
    let mut search = Search {
        space,
        variables: robot.variables(),
        metric: Metric::new(space, reach_weights(robot, model.bodies())).ok()?,
        validator: Validator::new(model, space, &held, rules.clearance_m, &mut scratch),
        random: Rng::with_seed(rules.seed),
        edge_m: rules.edge_m,
        velocity: vec![0.0; space.nv()],
    };
    let mut near = Tree::new(start);
    let mut far = Tree::new(goal);
    for iteration in 0..rules.iterations {
        let target = search.random_configuration();
        if search.extend(&mut near, &target) != Extension::Blocked {
            // The node just made is where the other tree tries to get to.
            let meeting = near.last().to_vec();
            if search.connect(&mut far, &meeting) {
                let (first, second) = if iteration % 2 == 0 {
                    (&near, &far)
                } else {
                    (&far, &near)
                };
                return join(first, second, space.nq());
            }
        }
        std::mem::swap(&mut near, &mut far);
    }
    None
}

/// From the root of one tree to its newest node, which is the other's newest too, and on to that
/// one's root.
fn join(first: &Tree, second: &Tree, nq: usize) -> Option<Path> {
    let mut rows = first.branch();
    rows.reverse();
    rows.extend(second.branch().into_iter().skip(1));
    Path::from_rows(nq, rows.concat())
}

/// How far a tree came.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Extension {
    /// Not at all: something is in the way.
    Blocked,
    /// One edge nearer.
    Nearer,
    /// There.
    Reached,
}

struct Search<'a> {
    space: &'a ConfigurationSpace,
    variables: &'a [Variable],
    metric: Metric,
    validator: Validator<'a>,
    random: Rng,
    edge_m: f64,
    velocity: Vec<f64>,
}

impl Search<'_> {
    /// Adds one edge from the nearest node of `tree` towards `target`.
    fn extend(&mut self, tree: &mut Tree, target: &[f64]) -> Extension {
        let nearest = self.nearest(tree, target);
        self.extend_from(tree, nearest, target)
    }

    /// Adds edges towards `target` until it is reached or something is in the way.
    fn connect(&mut self, tree: &mut Tree, target: &[f64]) -> bool {
        let mut extension = self.extend(tree, target);
        while extension == Extension::Nearer {
            extension = self.extend_from(tree, tree.rows.len() - 1, target);
        }
        extension == Extension::Reached
    }

    fn extend_from(&mut self, tree: &mut Tree, node: usize, target: &[f64]) -> Extension {
        let from = &tree.rows[node];
        let length = self
            .metric
            .distance(self.space, from, target, &mut self.velocity);
        let mut next = target.to_vec();
        let mut extension = Extension::Reached;
        if length > self.edge_m {
            self.space
                .integrate(from, &self.velocity, self.edge_m / length, &mut next);
            extension = Extension::Nearer;
        }
        if self
            .validator
            .proves(from, &next, &mut || false)
            != Some(true)
        {
            return Extension::Blocked;
        }
        tree.rows.push(next);
        tree.parents.push(node);
        extension
    }

    fn nearest(&mut self, tree: &Tree, target: &[f64]) -> usize {
        let mut best = (f64::INFINITY, 0);
        for (node, row) in tree.rows.iter().enumerate() {
            let distance = self
                .metric
                .distance(self.space, row, target, &mut self.velocity);
            if distance < best.0 {
                best = (distance, node);
            }
        }
        best.1
    }

    /// Uniform within the limits; angles and rotations uniform too.
    fn random_configuration(&mut self) -> Vec<f64> {
        let mut row = vec![0.0; self.space.nq()];
        for component in self.space.components() {
            match *component {
                Component::Line { q, .. } => {
                    let limit =
                        |value: f64, open: f64| if value.is_finite() { value } else { open };
                    let lower = limit(self.variables[q].lower, -UNLIMITED_M);
                    row[q] = lower
                        + self.random.f64() * (limit(self.variables[q].upper, UNLIMITED_M) - lower);
                }
                Component::Circle { q, .. } => {
                    row[q] = (2.0 * self.random.f64() - 1.0) * std::f64::consts::PI
                }
                Component::Rotation { q, .. } => {
                    row[q..q + 4].copy_from_slice(&random_rotation(&mut self.random))
                }
            }
        }
        row
    }
}

/// A direction in four dimensions, uniform because the corners of the cube are left out.
fn random_rotation(random: &mut Rng) -> [f64; 4] {
    loop {
        let row: [f64; 4] = std::array::from_fn(|_| 2.0 * random.f64() - 1.0);
        let norm = row
            .iter()
            .map(|value| value * value)
            .sum::<f64>()
            .sqrt();
        if (0.1..1.0).contains(&norm) {
            return row.map(|value| value / norm);
        }
    }
}

/// Configurations, each with the one that it was reached from.
struct Tree {
    rows: Vec<Vec<f64>>,
    parents: Vec<usize>,
}

impl Tree {
    /// The root is its own parent.
    fn new(root: &[f64]) -> Self {
        Self {
            rows: vec![root.to_vec()],
            parents: vec![0],
        }
    }

    fn last(&self) -> &[f64] {
        &self.rows[self.rows.len() - 1]
    }

    /// From the newest node back to the root.
    fn branch(&self) -> Vec<Vec<f64>> {
        let mut node = self.rows.len() - 1;
        let mut rows = vec![self.rows[node].clone()];
        while node != 0 {
            node = self.parents[node];
            rows.push(self.rows[node].clone());
        }
        rows
    }
}
