//! Paths: waypoints in a flat buffer, as they stand in shared memory, and their length.

use crate::hash::ContentHasher;
use crate::robot::{Component, ConfigurationSpace};

/// Waypoints, one row of `nq` columns each, in row-major order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Path {
    nq: usize,
    rows: Vec<f64>,
}

impl Path {
    /// Takes rows laid end to end; `None` unless they are whole rows, at least one.
    pub fn from_rows(nq: usize, rows: Vec<f64>) -> Option<Self> {
        (nq > 0 && !rows.is_empty() && rows.len().is_multiple_of(nq)).then_some(Self { nq, rows })
    }

    /// Columns.
    pub fn nq(&self) -> usize {
        self.nq
    }
    /// Number of waypoints, at least one.
    pub fn len(&self) -> usize {
        self.rows.len() / self.nq
    }
    /// Never true; here because `len` is.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }
    /// All rows end to end.
    pub fn as_flat(&self) -> &[f64] {
        &self.rows
    }
    /// All rows end to end, to write.
    pub fn as_flat_mut(&mut self) -> &mut [f64] {
        &mut self.rows
    }
    /// One waypoint.
    pub fn waypoint(&self, index: usize) -> &[f64] {
        &self.rows[index * self.nq..(index + 1) * self.nq]
    }
    /// One waypoint, to write.
    pub fn waypoint_mut(&mut self, index: usize) -> &mut [f64] {
        &mut self.rows[index * self.nq..(index + 1) * self.nq]
    }
    /// Puts `rows`, whole rows end to end, in the place of the waypoints `range`, which may not be
    /// all.
    pub fn splice(&mut self, range: std::ops::Range<usize>, rows: &[f64]) {
        assert!(
            rows.len().is_multiple_of(self.nq) && (!rows.is_empty() || range.len() < self.len())
        );
        self.rows.splice(
            range.start * self.nq..range.end * self.nq,
            rows.iter().copied(),
        );
    }
    /// The waypoints before and after each segment, in order.
    pub fn segments(&self) -> impl ExactSizeIterator<Item = [&[f64]; 2]> + Clone {
        (1..self.len()).map(|segment| [self.waypoint(segment - 1), self.waypoint(segment)])
    }
    /// The waypoints in order.
    pub fn waypoints(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.rows.chunks_exact(self.nq)
    }

    /// Content hash of the exact bits.
    pub fn hash(&self) -> u64 {
        self.hasher().finish()
    }

    /// All of the SHA-256 of the exact bits, four little-endian words.
    pub fn digest(&self) -> [u64; 4] {
        self.hasher().finish_digest()
    }

    fn hasher(&self) -> ContentHasher {
        let mut hasher = ContentHasher::default();
        hasher.floats(&self.rows);
        hasher
    }
}

/// The metric of a request: `d(a, b) = ‖W (b ⊖ a)‖`, W diagonal, one weight per velocity
/// coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct Metric {
    weights: Vec<f64>,
}

/// Weights that no metric can have.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MetricError {
    /// Not one weight per velocity coordinate.
    #[error("{got} weights given, the robot has {expected} velocity coordinates")]
    Count {
        /// Weights given.
        got: usize,
        /// Weights needed.
        expected: usize,
    },
    /// Not finite or not positive.
    #[error("weight {index} is {value}; weights are finite and greater than 0")]
    Value {
        /// Coordinate.
        index: usize,
        /// Its weight.
        value: f64,
    },
    /// The three weights of a rotation differ.
    #[error("the weights of the rotation at coordinates {first}..{} differ ({values:?}); they must be equal", first + 3)]
    Rotation {
        /// First coordinate.
        first: usize,
        /// The three weights.
        values: [f64; 3],
    },
}

impl Metric {
    /// Checks weights against the space; the three of a rotation may differ by rounding only (1e-9
    /// of their size).
    pub fn new(space: &ConfigurationSpace, weights: Vec<f64>) -> Result<Self, MetricError> {
        if weights.len() != space.nv() {
            return Err(MetricError::Count {
                got: weights.len(),
                expected: space.nv(),
            });
        }
        if let Some(index) = weights
            .iter()
            .position(|w| !(w.is_finite() && *w > 0.0))
        {
            return Err(MetricError::Value {
                index,
                value: weights[index],
            });
        }
        for component in space.components() {
            if let Component::Rotation { v, .. } = *component {
                let values = [weights[v], weights[v + 1], weights[v + 2]];
                if values
                    .iter()
                    .any(|w| (w - values[0]).abs() > 1e-9 * values[0])
                {
                    return Err(MetricError::Rotation { first: v, values });
                }
            }
        }
        Ok(Self { weights })
    }

    /// The weights, one per velocity coordinate.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// `‖W v‖` of a velocity.
    pub fn norm(&self, velocity: &[f64]) -> f64 {
        self.weights
            .iter()
            .zip(velocity)
            .map(|(w, v)| (w * v) * (w * v))
            .sum::<f64>()
            .sqrt()
    }

    /// Length of one straight segment; `scratch` holds nv numbers.
    pub fn distance(
        &self,
        space: &ConfigurationSpace,
        from: &[f64],
        to: &[f64],
        scratch: &mut [f64],
    ) -> f64 {
        space.difference(to, from, scratch);
        self.norm(scratch)
    }

    /// Length of a path given as flat rows; `scratch` holds nv numbers.
    pub fn length(&self, space: &ConfigurationSpace, rows: &[f64], scratch: &mut [f64]) -> f64 {
        let nq = space.nq();
        let rows: Vec<&[f64]> = rows.chunks_exact(nq).collect();
        rows.windows(2)
            .map(|pair| self.distance(space, pair[0], pair[1], scratch))
            .sum()
    }
}
