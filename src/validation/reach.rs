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

use crate::collision::chain::{ChainMotion, MotionKind, Source};
use crate::collision::{Body, BodyPair, CollisionModel};

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
        let bodies = model.carried_bodies().iter();
        let levers: Vec<_> = bodies
            .map(|body| levers(body, held, ranges, stray))
            .collect();
        let mut reach = vec![0.0_f64; model.robot().space().nv()];
        let mut of_pair = reach.clone();
        let mut seen = HashSet::new();
        for pair in model.pairs() {
            // Obstacles stand still: they are all one to the body that moves.
            let partner = levers.get(pair.b).map(|_| pair.b);
            if seen.insert((pair.a, pair.motions_above, partner)) {
                add_up(&levers, pair, &mut of_pair);
                let most = reach.iter_mut().zip(&of_pair);
                most.for_each(|(most, sum)| *most = most.max(*sum));
            }
        }
        // Far above what the sums lose.
        reach
            .iter_mut()
            .for_each(|metres| *metres *= 1.0 + 1e-12);
        Self(reach)
    }

    /// One number per velocity coordinate (m per rad or m).
    pub fn all(&self) -> &[f64] {
        &self.0
    }

    /// Σ_j reach_j |Δ_j| (m).
    pub fn cost(&self, deviation: &[f64]) -> f64 {
        cost(&self.0, deviation.iter().copied())
    }
}

/// Σ_j reach_j |Δ_j| (m).
pub(super) fn cost(reach: &[f64], deviations: impl Iterator<Item = f64>) -> f64 {
    let terms = reach.iter().zip(deviations);
    let sum = terms
        .map(|(reach, deviation)| reach * deviation.abs())
        .sum::<f64>();
    // Far above what the sum loses.
    sum * (1.0 + 1e-12)
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
    // From the body up: what lies between a motion and the body is then known.
    let mut pushed = 0.0;
    let mut levers = Vec::with_capacity(body.chain.len());
    for motion in body.chain.iter().rev() {
        levers.push(Lever::of(motion, pushed));
        if let MotionKind::Translation(n) = motion.kind {
            pushed += farthest_push(motion, n, held, ranges, stray);
        }
    }
    levers.reverse();
    levers
}

impl Lever {
    /// Of a motion below which translations take the body this much farther away (m).
    fn of(motion: &ChainMotion, pushed: f64) -> Self {
        let (count, arm) = match motion.kind {
            MotionKind::Translation(n) => (n, 1.0),
            MotionKind::Axis => (1, motion.reach + pushed),
            MotionKind::Ball => (3, motion.reach + pushed),
        };
        Self {
            first: motion.coordinate.unwrap_or(0),
            count: motion.coordinate.map_or(0, |_| count),
            metres: arm * motion.factor.abs(),
        }
    }
}

/// `of_pair` ← what each coordinate moves of both bodies of a pair.
fn add_up(levers: &[Vec<Lever>], pair: &BodyPair, of_pair: &mut [f64]) {
    of_pair.fill(0.0);
    for (body, above) in [pair.a, pair.b]
        .into_iter()
        .zip(pair.motions_above)
    {
        // What moves at or above the common link carries both alike; obstacles have no levers.
        for lever in levers
            .get(body)
            .map_or(&[][..], |levers| &levers[above..])
        {
            let coordinates = &mut of_pair[lever.first..lever.first + lever.count];
            coordinates
                .iter_mut()
                .for_each(|sum| *sum += lever.metres);
        }
    }
}

/// How far a translation can be from the value that the levers above it count on (m).
fn farthest_push(motion: &ChainMotion, n: usize, held: &[f64], ranges: &Ranges, stray: f64) -> f64 {
    let farthest = |index: usize| {
        let ends = match motion.source {
            Source::Column(q) => ranges.all()[q + index],
            Source::Held(first) => [held[first + index]; 2],
        };
        farthest_from_rest(motion, n, index, ends)
    };
    // Of a box the farthest point is a corner.
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

/// How far a coordinate between these values gets from rest.
fn farthest_from_rest(motion: &ChainMotion, n: usize, index: usize, ends: [f64; 2]) -> f64 {
    let shift = shift(motion, n, index);
    let away = ends.map(|value| (value * motion.factor + shift).abs());
    away.into_iter().fold(0.0, f64::max)
}

/// What is added to a coordinate's value to be seen from rest.
fn shift(motion: &ChainMotion, n: usize, index: usize) -> f64 {
    match n {
        1 => motion.offset - motion.rest.x,
        _ => -motion.rest[index],
    }
}
