//! What a segment goes along, and how its columns go on an interval of it.

use super::polynomial::Polynomial;
use crate::robot::lane_kinematics::LaneCurve;
use crate::robot::{Component, ConfigurationSpace};

/// What a segment goes along, for t in [0, 1].
#[derive(Clone, Copy, Debug)]
pub(super) enum Way<'q> {
    /// Straight from one configuration to another.
    Straight([&'q [f64]; 2]),
    /// Each column by a polynomial of t; quaternions stand still.
    Curved(&'q [Polynomial]),
}

impl<'q> From<[&'q [f64]; 2]> for Way<'q> {
    fn from(ends: [&'q [f64]; 2]) -> Self {
        Self::Straight(ends)
    }
}

/// How columns that are polynomials of t go on an interval, seen from its middle; per unit t.
///
/// With q(m + τ) = Σ a_k τᵏ and half width h the speed is at most Σ k |a_k| hᵏ⁻¹, and the column is never farther than h² Σ_{k ≥ 2} |a_k| hᵏ⁻² from where its
/// velocity in the middle would take it.
#[derive(Clone, Debug, Default)]
pub struct Expansion {
    /// The configuration in the middle.
    pub(super) middle: Vec<f64>,
    /// The velocity there.
    pub(super) velocity: Vec<f64>,
    /// The greatest speed of each coordinate on the interval.
    pub(super) speed: Vec<f64>,
    /// What each coordinate accelerates by, as far as a place depends on it: ½ h² of it bounds how far
    /// it is from where the velocity in the middle would take it.
    pub(super) acceleration: Vec<f64>,
    /// Half width of the interval.
    pub(super) half: f64,
}

impl Expansion {
    /// Looks from the middle of another interval.
    pub(super) fn update(
        &mut self,
        space: &ConfigurationSpace,
        columns: &[Polynomial],
        middle: f64,
        half: f64,
    ) {
        self.half = half;
        self.middle.resize(space.nq(), 0.0);
        for rates in [&mut self.velocity, &mut self.speed, &mut self.acceleration] {
            rates.resize(space.nv(), 0.0);
        }
        for component in space.components() {
            match *component {
                Component::Line { q, v } | Component::Circle { q, v } => {
                    self.expand(&columns[q], middle, [q, v]);
                }
                Component::Rotation { q, v } => self.stand_still(&columns[q..q + 4], [q, v]),
            }
        }
    }

    fn expand(&mut self, column: &Polynomial, middle: f64, [q, v]: [usize; 2]) {
        let [at, velocity, higher @ ..] = column.seen_from(middle, 1.0);
        let mut speed = velocity.abs();
        let mut acceleration = 0.0;
        let mut power = 1.0;
        for (order, coefficient) in (2..).zip(higher) {
            acceleration += 2.0 * power * coefficient.abs();
            power *= self.half;
            speed += f64::from(order) * power * coefficient.abs();
        }
        self.middle[q] = at;
        self.velocity[v] = velocity;
        self.speed[v] = speed;
        self.acceleration[v] = acceleration;
    }

    fn stand_still(&mut self, quaternion: &[Polynomial], [q, v]: [usize; 2]) {
        for (middle, column) in self.middle[q..].iter_mut().zip(quaternion) {
            *middle = column.at(0.0);
        }
        for rates in [&mut self.velocity, &mut self.speed, &mut self.acceleration] {
            rates[v..v + 3].fill(0.0);
        }
    }

    /// The same for the filter.
    pub(super) fn of_lane(&self) -> LaneCurve<'_> {
        LaneCurve {
            middle: &self.middle,
            rates: [&self.velocity, &self.speed, &self.acceleration],
            half: self.half,
        }
    }

    /// How far each coordinate goes at most.
    pub(super) fn size(&self) -> impl Iterator<Item = f64> {
        let rates = self.velocity.iter().zip(&self.acceleration);
        rates.map(|(velocity, acceleration)| {
            2.0 * self.half * (velocity.abs() + 0.5 * self.half * acceleration)
        })
    }
}
