//! The cost of a path: `C(x) = ½ Σ λᵢ ‖W (q_{i+1} ⊖ qᵢ)‖²`, an elastic string through the
//! waypoints.
//!
//! λᵢ is the inverse length of segment i of the *input* path, so that the string keeps the ratio of
//! segment lengths and does not drag waypoints out of narrow passages (Campana, Lamiraux, Laumond,
//! *A gradient-based path optimization method for motion planning*, 2016).
//!
//! On lines and circles the Hessian is constant, `H = T ⊗ W²`, T tridiagonal with the λ's over the
//! waypoints that may move. Its inverse is known in closed form, so it is never built: T⁻¹ is the
//! Green's function of a string that is held at its ends. On SO(3) the same H is a preconditioner.

use crate::path::Metric;
use crate::robot::ConfigurationSpace;

/// The cost of all paths with the waypoint count and the fixed waypoints of one input path.
///
/// Velocities of a whole path are flat rows, one of nv numbers for each waypoint, fixed ones
/// included.
#[derive(Clone, Debug)]
pub struct Cost<'a> {
    space: &'a ConfigurationSpace,
    /// wᵥ².
    squared_weights: Vec<f64>,
    /// wᵥ⁻², 0 for a coordinate that may not move.
    inverse_weights: Vec<f64>,
    /// λ of each segment.
    stiffness: Vec<f64>,
    nodes: Vec<Node>,
}

/// Where a waypoint lies on its string: a stretch between two neighbouring fixed waypoints.
#[derive(Clone, Copy, Debug)]
struct Node {
    string: usize,
    /// sᵢ = Σ 1/λ from the string's start; 0 for a fixed waypoint, where the string cannot move.
    place: f64,
    /// S = Σ 1/λ of the whole string.
    length: f64,
}

impl Node {
    /// `min(sᵢ, sⱼ) (S − max(sᵢ, sⱼ)) / S` of two waypoints of a string.
    #[inline]
    fn compliance(&self, other: &Self) -> f64 {
        let (near, far) = if self.place < other.place {
            (self, other)
        } else {
            (other, self)
        };
        near.place * far.rest() / self.length
    }
    /// A waypoint that is a string of its own and yields to nothing.
    fn held(string: usize) -> Self {
        Self {
            string,
            place: 0.0,
            length: 1.0,
        }
    }

    /// The waypoints of a string, from its start to the last one before its end.
    fn along(string: usize, rest_lengths: &[f64]) -> impl Iterator<Item = Self> {
        let length = rest_lengths.iter().sum();
        starts(rest_lengths).map(move |place| Self {
            string,
            place,
            length,
        })
    }
    fn is_fixed(&self) -> bool {
        self.place == 0.0
    }

    /// S − sᵢ.
    fn rest(&self) -> f64 {
        self.length - self.place
    }
}

/// Shortest rest length of a segment, as a part of the path's: it keeps λ finite.
const SHORTEST_SEGMENT: f64 = 1e-9;

impl<'a> Cost<'a> {
    /// The cost whose λ come from the path `rows` (flat, nq columns).
    ///
    /// `fixed` has one entry a waypoint (the first and last are true), `moving` one a velocity
    /// coordinate.
    pub fn new(
        space: &'a ConfigurationSpace,
        metric: &Metric,
        rows: &[f64],
        fixed: &[bool],
        moving: &[bool],
    ) -> Self {
        let lengths = rest_lengths(space, metric, rows, SHORTEST_SEGMENT);
        Self::of_rest_lengths(space, metric, &lengths, fixed, moving)
    }

    /// The cost of a string whose segments are slack at these lengths: λ = 1/length.
    pub fn of_rest_lengths(
        space: &'a ConfigurationSpace,
        metric: &Metric,
        lengths: &[f64],
        fixed: &[bool],
        moving: &[bool],
    ) -> Self {
        let squared_weights: Vec<f64> = metric.weights().iter().map(|w| w * w).collect();
        Self {
            space,
            inverse_weights: inverse_of_moving(&squared_weights, moving),
            squared_weights,
            stiffness: lengths
                .iter()
                .map(|length| 1.0 / length)
                .collect(),
            nodes: nodes(lengths, fixed),
        }
    }

    /// Velocity coordinates of one configuration.
    pub fn nv(&self) -> usize {
        self.squared_weights.len()
    }

    /// Number of waypoints, fixed ones included.
    pub fn waypoints(&self) -> usize {
        self.nodes.len()
    }

    /// C of the path `rows`; half its length for the path that the λ come from.
    pub fn value(&self, rows: &[f64]) -> f64 {
        let mut velocity = vec![0.0; self.nv()];
        segments(rows, self.space.nq())
            .zip(&self.stiffness)
            .map(|((from, to), stiffness)| {
                self.space.difference(to, from, &mut velocity);
                self.energy(&velocity, *stiffness)
            })
            .sum()
    }

    /// Of one segment, `½ λ ‖W v‖²`.
    fn energy(&self, velocity: &[f64], stiffness: f64) -> f64 {
        let weighted = velocity.iter().zip(&self.squared_weights);
        let squares: f64 = weighted.map(|(v, w)| w * v * v).sum();
        0.5 * stiffness * squares
    }

    /// Gradient of C at the path `rows`: `W² (λ_{i−1} (qᵢ ⊖ q_{i−1}) − λᵢ (q_{i+1} ⊖ qᵢ))`, 0 at
    /// fixed waypoints.
    ///
    /// Exact on SO(3) too, where the three weights of a rotation are equal.
    pub fn gradient(&self, rows: &[f64], velocity: &mut [f64], gradient: &mut [f64]) {
        gradient.fill(0.0);
        for (i, (from, to)) in segments(rows, self.space.nq()).enumerate() {
            self.space.difference(to, from, velocity);
            self.pull_ends(i, velocity, gradient);
        }
        let rows = gradient.chunks_exact_mut(self.nv());
        for (_, row) in self
            .nodes
            .iter()
            .zip(rows)
            .filter(|(node, _)| node.is_fixed())
        {
            row.fill(0.0);
        }
    }

    /// Adds the tension of segment i to the gradient at its two waypoints.
    #[inline]
    fn pull_ends(&self, i: usize, velocity: &[f64], gradient: &mut [f64]) {
        let nv = self.nv();
        for v in 0..nv {
            let force = self.stiffness[i] * self.squared_weights[v] * velocity[v];
            gradient[i * nv + v] -= force;
            gradient[(i + 1) * nv + v] += force;
        }
    }

    /// `T⁻¹ᵢⱼ = min(sᵢ, sⱼ) (S − max(sᵢ, sⱼ)) / S`: how far waypoint i yields to a unit force on
    /// waypoint j.
    ///
    /// 0 between waypoints of different strings, and for fixed ones.
    pub fn compliance(&self, i: usize, j: usize) -> f64 {
        let a = &self.nodes[i];
        let b = &self.nodes[j];
        if a.string == b.string {
            a.compliance(b)
        } else {
            0.0
        }
    }

    /// wᵥ⁻² of each velocity coordinate, 0 for those that may not move.
    pub fn inverse_weights(&self) -> &[f64] {
        &self.inverse_weights
    }

    /// `H⁻¹ force` for a force on every waypoint; O(waypoints · nv), by two sweeps along each
    /// string.
    pub fn apply_inverse_hessian(&self, force: &[f64], out: &mut [f64]) {
        for v in 0..self.nv() {
            self.sweep_from_start(v, force, out);
            self.sweep_from_end(v, force, out);
        }
    }

    /// Writes `(S − sᵢ)/S Σ_{j≤i} sⱼ fⱼ` of coordinate v.
    #[inline]
    fn sweep_from_start(&self, v: usize, force: &[f64], out: &mut [f64]) {
        let nv = self.nv();
        let mut sum = 0.0;
        for (i, node) in self.nodes.iter().enumerate() {
            // A fixed waypoint ends one string and starts the next.
            sum = if node.is_fixed() {
                0.0
            } else {
                sum + node.place * force[i * nv + v]
            };
            out[i * nv + v] = self.inverse_weights[v] * node.rest() / node.length * sum;
        }
    }

    /// Adds `sᵢ/S Σ_{j>i} (S − sⱼ) fⱼ` of coordinate v.
    #[inline]
    fn sweep_from_end(&self, v: usize, force: &[f64], out: &mut [f64]) {
        let nv = self.nv();
        let mut sum = 0.0;
        for (i, node) in self.nodes.iter().enumerate().rev() {
            // Before the sum takes in i itself, whose share the first sweep has.
            out[i * nv + v] += self.inverse_weights[v] * node.place / node.length * sum;
            sum = if node.is_fixed() {
                0.0
            } else {
                sum + node.rest() * force[i * nv + v]
            };
        }
    }
}

/// Neighbouring waypoints of a path given as flat rows.
pub(super) fn segments(rows: &[f64], nq: usize) -> impl Iterator<Item = (&[f64], &[f64])> {
    rows.chunks_exact(nq)
        .zip(rows.chunks_exact(nq).skip(1))
}

/// Length of each segment of a path given as flat rows.
pub fn segment_lengths(space: &ConfigurationSpace, metric: &Metric, rows: &[f64]) -> Vec<f64> {
    steps(space, metric, rows, &mut vec![0.0; space.nv()]).collect()
}

/// The same, where none is shorter than `shortest`, a part of the path's length.
pub fn rest_lengths(
    space: &ConfigurationSpace,
    metric: &Metric,
    rows: &[f64],
    shortest: f64,
) -> Vec<f64> {
    let lengths = segment_lengths(space, metric, rows);
    // A path of length 0 has finite λ too.
    let shortest = (shortest * lengths.iter().sum::<f64>()).max(f64::MIN_POSITIVE);
    lengths
        .into_iter()
        .map(|length| length.max(shortest))
        .collect()
}

/// The same, one after the other; `velocity` is scratch of nv numbers.
pub fn steps<'s>(
    space: &'s ConfigurationSpace,
    metric: &'s Metric,
    rows: &'s [f64],
    velocity: &'s mut [f64],
) -> impl Iterator<Item = f64> + use<'s> {
    segments(rows, space.nq()).map(move |(from, to)| metric.distance(space, from, to, velocity))
}

/// Length of a path given as flat rows; `velocity` is scratch of nv numbers.
pub fn length(
    space: &ConfigurationSpace,
    metric: &Metric,
    rows: &[f64],
    velocity: &mut [f64],
) -> f64 {
    steps(space, metric, rows, velocity).sum()
}

/// Where each of several lengths, laid end to end, begins.
fn starts(lengths: &[f64]) -> impl Iterator<Item = f64> {
    lengths.iter().scan(0.0, |end, length| {
        let start = *end;
        *end += length;
        Some(start)
    })
}

fn nodes(rest_lengths: &[f64], fixed: &[bool]) -> Vec<Node> {
    let ends: Vec<usize> = (0..fixed.len()).filter(|&i| fixed[i]).collect();
    let mut nodes: Vec<Node> = (0..fixed.len()).map(Node::held).collect();
    for stretch in ends.windows(2) {
        let string = stretch[0]..stretch[1];
        let on_string = Node::along(string.start, &rest_lengths[string.clone()]);
        nodes.splice(string, on_string);
    }
    nodes
}

/// wᵥ⁻², 0 for what may not move: an infinite weight.
fn inverse_of_moving(squared_weights: &[f64], moving: &[bool]) -> Vec<f64> {
    let inverse = |(w, moves)| if moves { 1.0 / w } else { 0.0 };
    squared_weights
        .iter()
        .zip(moving.iter().copied())
        .map(inverse)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optimize::testing::{self, Instance};
    use proptest::prelude::*;

    #[test]
    fn the_cost_of_the_input_is_half_its_length() {
        for seed in 0..20 {
            let Instance {
                space,
                metric,
                rows,
                fixed,
                moving,
            } = testing::instance(seed, 9);
            let cost = Cost::new(&space, &metric, &rows, &fixed, &moving);
            let half = 0.5
                * segment_lengths(&space, &metric, &rows)
                    .iter()
                    .sum::<f64>();
            assert!((cost.value(&rows) - half).abs() < 1e-12 * half);
        }
    }

    #[test]
    fn the_compliance_inverts_the_tridiagonal_matrix_of_each_string() {
        for seed in 0..20 {
            let Instance {
                space,
                metric,
                rows,
                fixed,
                moving,
            } = testing::instance(seed, 9);
            let cost = Cost::new(&space, &metric, &rows, &fixed, &moving);
            let tridiagonal =
                testing::tridiagonal(&segment_lengths(&space, &metric, &rows), &fixed);
            let inverse = tridiagonal
                .try_inverse()
                .expect("positive definite");
            let free: Vec<usize> = (0..fixed.len())
                .filter(|&i| !fixed[i])
                .collect();
            for (a, &i) in free.iter().enumerate() {
                for (b, &j) in free.iter().enumerate() {
                    assert!(
                        (cost.compliance(i, j) - inverse[(a, b)]).abs() < 1e-11,
                        "seed {seed}: {i} {j}"
                    );
                }
            }
        }
    }

    proptest! {
        #[test]
        fn the_gradient_is_the_derivative_of_the_cost(seed in 0u64..10_000, waypoints in 3usize..8) {
            let Instance { space, metric, mut rows, fixed, moving } = testing::instance(seed, waypoints);
            let cost = Cost::new(&space, &metric, &rows, &fixed, &moving);
            let (nq, nv) = (space.nq(), space.nv());
            testing::shake(&space, &mut rows, seed);
            let (mut velocity, mut gradient) = (vec![0.0; nv], vec![0.0; waypoints * nv]);
            cost.gradient(&rows, &mut velocity, &mut gradient);
            for i in 0..waypoints {
                for v in 0..nv {
                    let at = |step: f64| {
                        let mut moved = rows.clone();
                        let mut direction = vec![0.0; nv];
                        direction[v] = step;
                        space.integrate(&rows[i * nq..][..nq], &direction, 1.0, &mut moved[i * nq..][..nq]);
                        cost.value(&moved)
                    };
                    let difference = (at(1e-5) - at(-1e-5)) / 2e-5;
                    let expected = if fixed[i] { 0.0 } else { difference };
                    prop_assert!((gradient[i * nv + v] - expected).abs() < 1e-5 * (1.0 + expected.abs()));
                }
            }
        }

        #[test]
        fn on_lines_the_newton_step_arrives_at_evenly_drawn_straight_lines(seed in 0u64..10_000) {
            let Instance { metric, mut rows, fixed, .. } = testing::lines(seed, 8, 4);
            let space = testing::line_space(4);
            let cost = Cost::new(&space, &metric, &rows, &fixed, &[true; 4]);
            let lengths = segment_lengths(&space, &metric, &rows);
            let (mut velocity, mut gradient, mut step) = ([0.0; 4], [0.0; 32], [0.0; 32]);
            cost.gradient(&rows, &mut velocity, &mut gradient);
            cost.apply_inverse_hessian(&gradient, &mut step);
            rows.iter_mut().zip(&step).for_each(|(x, p)| *x -= p);
            // Between fixed waypoints every segment has the same velocity per input length.
            for i in (1..7).filter(|&i| !fixed[i]) {
                for v in 0..4 {
                    let slope = |k: usize| (rows[(k + 1) * 4 + v] - rows[k * 4 + v]) / lengths[k];
                    prop_assert!((slope(i) - slope(i - 1)).abs() < 1e-9);
                }
            }
        }
    }
}
