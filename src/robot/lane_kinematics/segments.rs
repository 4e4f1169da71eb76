//! Segments and intervals as the lanes take them in.

use super::Skeleton;
use super::ZERO;
use crate::lanes::{Eight, LANES, Lanes, Packed};
use crate::math::{Quat, Vec3, quat_exp};
use crate::robot::{Component, ConfigurationSpace};

/// Eight configurations and half displacements, by column and coordinate.
#[derive(Clone, Debug, Default)]
pub struct LaneInput {
    /// Columns of the configurations, then the held values.
    pub values: Vec<Packed>,
    /// Half displacements.
    pub rates: Vec<Packed>,
    /// On curves alone: the greatest speeds, times half the width.
    pub speeds: Vec<Packed>,
    /// On curves alone: how far coordinates get from where their rates in the middle would take them.
    pub bulges: Vec<Packed>,
}

/// Segments in the form from which lanes are filled.
#[derive(Clone, Debug, Default)]
pub struct LaneSegments {
    nq: usize,
    nv: usize,
    from: Vec<f32>,
    velocity: Vec<f32>,
    /// Rounding of places that comes of large values (m).
    rounding: Vec<f32>,
}

/// What one lane looks at: the middle of an interval of a segment, and its half width.
#[derive(Clone, Copy, Debug, Default)]
pub struct LaneInterval {
    /// Segment, by index.
    pub segment: usize,
    /// Ratio on the segment.
    pub middle: f64,
    /// Half width, as a ratio.
    pub half: f64,
}

impl LaneSegments {
    /// Forgets all segments.
    pub fn clear(&mut self) {
        self.from.clear();
        self.velocity.clear();
        self.rounding.clear();
    }

    /// Appends the segment `from ⊕ t velocity`.
    pub fn push(&mut self, skeleton: &Skeleton, from: &[f64], velocity: &[f64], held: &[f64]) {
        self.nq = from.len();
        self.nv = velocity.len();
        self.from
            .extend(from.iter().map(|&value| value as f32));
        self.velocity
            .extend(velocity.iter().map(|&value| value as f32));
        self.rounding
            .push(skeleton.rounding_of_values(from, velocity, held) as f32);
    }

    /// Rounding that comes of large values, of a segment (m).
    pub fn rounding(&self, segment: usize) -> f32 {
        self.rounding[segment]
    }

    /// Fills the lanes. Held values stay as they are in `input`.
    #[inline(always)]
    pub fn fill<S: Eight>(
        &self,
        simd: S,
        space: &ConfigurationSpace,
        intervals: &[LaneInterval; LANES],
        input: &mut LaneInput,
    ) {
        let mut middles = [0.0_f32; LANES];
        let mut halves = [0.0_f32; LANES];
        let mut rows = [0; LANES];
        for (lane, interval) in intervals.iter().enumerate() {
            middles[lane] = interval.middle as f32;
            // A little wider than the interval: its middle may have been rounded.
            halves[lane] = interval.half as f32 * (1.0 + f32::EPSILON) + f32::EPSILON;
            rows[lane] = interval.segment;
        }
        let middles = Lanes::new(simd, pulp::cast(middles));
        let halves = Lanes::new(simd, pulp::cast(halves));
        let alike = rows.iter().all(|&row| row == rows[0]);
        let gather = Gather { simd, rows, alike };
        for component in space.components() {
            match *component {
                Component::Line { q, v } | Component::Circle { q, v } => {
                    let velocity = gather.column(&self.velocity, self.nv, v);
                    input.values[q] =
                        (gather.column(&self.from, self.nq, q) + velocity * middles).packed;
                    input.rates[v] = (velocity * halves).packed;
                }
                Component::Rotation { q, v } => {
                    for k in v..v + 3 {
                        input.rates[k] =
                            (gather.column(&self.velocity, self.nv, k) * halves).packed;
                    }
                    let turned = intervals.map(|interval| self.turned(&interval, q, v));
                    for k in 0..4 {
                        input.values[q + k] = pulp::cast(turned.map(|rotation| rotation[k] as f32));
                    }
                }
            }
        }
    }

    /// Rotation of a ball joint at the middle of an interval.
    fn turned(&self, interval: &LaneInterval, q: usize, v: usize) -> [f64; 4] {
        let from: [f64; 4] =
            std::array::from_fn(|k| f64::from(self.from[interval.segment * self.nq + q + k]));
        let turn: [f64; 3] =
            std::array::from_fn(|k| f64::from(self.velocity[interval.segment * self.nv + v + k]));
        let turn = quat_exp(Vec3::from_array(turn) * interval.middle);
        (Quat::from_array(from) * turn)
            .normalize()
            .to_array()
    }
}

/// Reads a column of a table for each lane's row.
struct Gather<S: Eight> {
    simd: S,
    rows: [usize; LANES],
    alike: bool,
}

impl<S: Eight> Gather<S> {
    #[inline(always)]
    fn column(&self, values: &[f32], width: usize, column: usize) -> Lanes<S> {
        if self.alike {
            return Lanes::splat(self.simd, values[self.rows[0] * width + column]);
        }
        let mut lanes = [0.0_f32; LANES];
        for (lane, row) in lanes.iter_mut().zip(self.rows) {
            *lane = values[row * width + column];
        }
        Lanes::new(self.simd, pulp::cast(lanes))
    }
}

/// Of one lane on an interval of a curve: its columns and coordinates, as [`LaneInput`] has them.
#[derive(Clone, Copy, Debug)]
pub struct LaneCurve<'a> {
    /// The configuration in the middle.
    pub middle: &'a [f64],
    /// Velocity there, greatest speed and acceleration of each coordinate, per unit t.
    pub rates: [&'a [f64]; 3],
    /// Half width of the interval.
    pub half: f64,
}

impl LaneInput {
    /// Fills the lanes with intervals of curves. Held values stay as they are.
    pub fn fill_with_curves(&mut self, lanes: &[LaneCurve; LANES]) {
        for (q, values) in self
            .values
            .iter_mut()
            .enumerate()
            .take(lanes[0].middle.len())
        {
            *values = pulp::cast(lanes.map(|lane| lane.middle[q] as f32));
        }
        // A little more than it is: half a width is rounded twice.
        let widths = lanes.map(|lane| lane.half * (1.0 + 1e-6));
        let shares = [widths, widths, widths.map(|width| 0.5 * width * width)];
        let all = [&mut self.rates, &mut self.speeds, &mut self.bulges];
        for (kind, (packed, share)) in all.into_iter().zip(shares).enumerate() {
            for (v, packed) in packed.iter_mut().enumerate() {
                let of_lane = |lane: usize| (lanes[lane].rates[kind][v] * share[lane]) as f32;
                *packed = pulp::cast(std::array::from_fn::<f32, LANES, _>(of_lane));
            }
        }
    }

    /// Memory for a robot, with the values of its held variables in place.
    pub fn reset(&mut self, space: &ConfigurationSpace, held: &[f64]) {
        self.values.clear();
        self.values.resize(space.nq(), ZERO);
        self.values.extend(
            held.iter()
                .map(|&value| -> Packed { pulp::cast([value as f32; LANES]) }),
        );
        for rates in [&mut self.rates, &mut self.speeds, &mut self.bulges] {
            rates.clear();
            rates.resize(space.nv(), ZERO);
        }
    }
}
