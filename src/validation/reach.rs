//! How far the bodies move against each other per unit of each coordinate: what a deviation of the
//! joints costs.
//!
//! Let a pair be d apart at a configuration p, and move each joint from p to q on its own straight
//! way. Seen from the link that carries both bodies, no point of a body moves farther than Σ s_l
//! over its motions below that link, s_l as in [`motion`](super::motion): the turn times the
//! farthest that the body can be from the axis, or the shift. So at q the pair is at least d − Σ_j
//! reach_j |(q ⊖ p)_j| apart, with reach_j the sum of what coordinate j moves of both bodies (two
//! where one coordinate drives both, as with mimic joints), the largest of all pairs.
//!
//! A translation between an axis and the body takes it farther from the axis. How far is bounded by
//! where the columns may be, which the caller says, and by `stray`: where deviations only count as
//! far as Σ reach_j |Δ_j| ≤ stray, no translation leaves the columns' range by more than that,
//! since its own reach is at least its factor.

use std::collections::HashSet;

use crate::collision::body::{ChainMotion, MotionKind, Source};
use crate::collision::{Body, CollisionModel};

/// Metres that bodies move against each other at most, per unit of each velocity coordinate (m per
/// rad or m).
#[derive(Clone, Debug, PartialEq)]
pub struct Reach(Vec<f64>);

/// The least and the greatest value of each column.
#[derive(Clone, Debug, PartialEq)]
pub struct Ranges(Vec<[f64; 2]>);

impl Ranges {
    /// Those of so many columns, still of no value.
    pub fn none(columns: usize) -> Self {
        Self(vec![[f64::INFINITY, f64::NEG_INFINITY]; columns])
    }

    /// Takes one more configuration in.
    pub fn add(&mut self, configuration: &[f64]) {
        for (column, value) in configuration.iter().enumerate() {
            self.add_value(column, *value);
        }
    }

    /// Takes one more value of a column in.
    pub fn add_value(&mut self, column: usize, value: f64) {
        let [low, high] = &mut self.0[column];
        *low = low.min(value);
        *high = high.max(value);
    }

    /// Those of all columns, least and greatest.
    pub fn all(&self) -> &[[f64; 2]] {
        &self.0
    }
}

impl Reach {
    /// The reach for deviations between configurations within `ranges`, which may lead out of them
    /// as long as they cost no more than `stray` (m). `held` are the values of the robot's held
    /// variables.
    pub fn new(model: &CollisionModel, held: &[f64], ranges: &Ranges, stray: f64) -> Self {
        let levers: Vec<_> = model
            .carried_bodies()
            .iter()
            .map(|body| levers(body, held, ranges, stray))
            .collect();
        let nv = model.robot().space().nv();
        let mut reach = vec![0.0_f64; nv];
        let mut of_pair = vec![0.0_f64; nv];
        let mut seen = HashSet::new();
        for pair in model.pairs() {
            // Obstacles stand still: they are all one to the body that moves.
            let partner = levers.get(pair.b);
            if !seen.insert((pair.a, pair.motions_above, partner.map(|_| pair.b))) {
                continue;
            }
            of_pair.fill(0.0);
            let [above_a, above_b] = pair.motions_above;
            let moved = levers[pair.a][above_a..]
                .iter()
                .chain(partner.map_or(&[][..], |levers| &levers[above_b..]));
            for lever in moved {
                let coordinates = lever.first..lever.first + lever.count;
                of_pair[coordinates]
                    .iter_mut()
                    .for_each(|sum| *sum += lever.metres);
            }
            reach
                .iter_mut()
                .zip(&of_pair)
                .for_each(|(most, sum)| *most = most.max(*sum));
        }
        // Far above what the sums lose.
        reach.iter_mut().for_each(|metres| *metres *= 1.0 + 1e-12);
        Self(reach)
    }

    /// One number per velocity coordinate (m per rad or m).
    pub fn all(&self) -> &[f64] {
        &self.0
    }

    /// Σ_j reach_j |Δ_j| (m).
    pub fn cost(&self, deviation: &[f64]) -> f64 {
        self.0
            .iter()
            .zip(deviation)
            .map(|(reach, deviation)| reach * deviation.abs())
            .sum::<f64>()
            * (1.0 + 1e-12)
    }
}

/// What one motion of a chain moves of the body, per unit of each of its coordinates.
#[derive(Clone, Copy, Debug)]
struct Lever {
    first: usize,
    /// 0 for a motion that is held.
    count: usize,
    metres: f64,
}

/// The levers of a body's chain, in its order.
fn levers(body: &Body, held: &[f64], ranges: &Ranges, stray: f64) -> Vec<Lever> {
    let mut pushed = 0.0;
    let mut levers: Vec<_> = body
        .chain
        .iter()
        .rev()
        .map(|motion| {
            let (count, arm) = match motion.kind {
                MotionKind::Translation(n) => {
                    pushed += farthest_push(motion, n, held, ranges, stray);
                    (n, 1.0)
                }
                MotionKind::Axis => (1, motion.reach + pushed),
                MotionKind::Ball => (3, motion.reach + pushed),
            };
            let count = if motion.coordinate.is_some() {
                count
            } else {
                0
            };
            Lever {
                first: motion.coordinate.unwrap_or(0),
                count,
                metres: arm * motion.factor.abs(),
            }
        })
        .collect();
    levers.reverse();
    levers
}

/// How far a translation can be from the value that the levers above it count on (m).
fn farthest_push(motion: &ChainMotion, n: usize, held: &[f64], ranges: &Ranges, stray: f64) -> f64 {
    let shift = |index: usize| {
        if n == 1 {
            motion.offset - motion.rest.x
        } else {
            -motion.rest[index]
        }
    };
    let farthest = |index: usize| {
        let ends = match motion.source {
            Source::Column(q) => ranges.all()[q + index],
            Source::Held(first) => [held[first + index]; 2],
        };
        ends.map(|value| (value * motion.factor + shift(index)).abs())
            .into_iter()
            .fold(0.0, f64::max)
    };
    let corner = (0..n)
        .map(|index| farthest(index).powi(2))
        .sum::<f64>()
        .sqrt();
    corner
        + if motion.coordinate.is_some() {
            stray
        } else {
            0.0
        }
}
