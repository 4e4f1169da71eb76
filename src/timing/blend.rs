//! A path with its corners rounded: straight lines, and parabolas about the waypoints.
//!
//! Lengths are seconds: a segment is as long as its slowest column takes at full speed, so that u, the
//! columns' change by length, is the same at whatever scale they are. About a waypoint, from r before it to
//! r after it, u changes evenly from that of one segment to that of the next: a parabola that meets both
//! lines smoothly. It strays from them by r/4 Σ reach |Δu| at most, but how far it may is found by proofs.

use super::limits::Limits;
use super::trajectory::{State, TimedState};
use crate::path::Path;

/// Waypoints nearer to each other than this (s) count as one.
const SAME_S: f64 = 1e-6;

/// Part of a path of which each column is a polynomial of the second degree of the length along it.
#[derive(Clone, Debug, PartialEq)]
pub struct Stretch {
    /// Where it begins.
    pub start: Vec<f64>,
    /// Change by length there.
    pub slope: Vec<f64>,
    /// Change of that by length.
    pub bend: Vec<f64>,
    /// How long it is (s).
    pub length: f64,
}

impl Stretch {
    /// Where it is at a length.
    pub fn at(&self, length: f64) -> Vec<f64> {
        let columns = 0..self.start.len();
        columns
            .map(|column| {
                let rise = self.slope[column] + 0.5 * self.bend[column] * length;
                self.start[column] + rise * length
            })
            .collect()
    }

    /// Its change by length there.
    pub fn slope_at(&self, length: f64) -> Vec<f64> {
        let slopes = self.slope.iter().zip(&self.bend);
        slopes
            .map(|(slope, bend)| slope + bend * length)
            .collect()
    }

    /// Whether it is straight.
    pub fn is_line(&self) -> bool {
        self.bend.iter().all(|bend| *bend == 0.0)
    }

    /// The same as two states, one length after the other: what a controller makes of them is it.
    pub fn states(&self) -> [TimedState; 2] {
        let state = |length: f64| State {
            positions: self.at(length),
            velocities: self.slope_at(length),
        };
        let length_ns = (self.length * super::trajectory::NS).max(1.0) as i64;
        [
            TimedState::at(0, state(0.0)),
            TimedState::at(length_ns, state(self.length)),
        ]
    }
}

/// A path whose waypoints may be rounded.
#[derive(Clone, Debug)]
pub struct Corners {
    rows: Vec<Vec<f64>>,
    /// Of each segment: how long it is, and its change by length.
    lengths: Vec<f64>,
    slopes: Vec<Vec<f64>>,
    /// Of each waypoint, 0 of the ends.
    radii: Vec<f64>,
}

impl Corners {
    /// Of a path whose waypoints are all passed at rest; those too near to the one before are left out.
    pub fn new(path: &Path, limits: &Limits) -> Self {
        let rows = distinct(path, limits);
        let segments = rows.windows(2);
        let lengths: Vec<f64> = segments
            .map(|ends| length(&ends[0], &ends[1], limits))
            .collect();
        let slopes = rows
            .windows(2)
            .zip(&lengths)
            .map(|(ends, length)| {
                let columns = ends[1].iter().zip(&ends[0]);
                columns
                    .map(|(to, from)| (to - from) / length)
                    .collect()
            })
            .collect();
        Self {
            radii: vec![0.0; rows.len()],
            rows,
            lengths,
            slopes,
        }
    }

    /// The waypoints that are left.
    pub fn rows(&self) -> &[Vec<f64>] {
        &self.rows
    }

    /// The numbers of those between the ends.
    pub fn inner(&self) -> std::ops::Range<usize> {
        1..self.rows.len().max(2) - 1
    }

    /// How far from a waypoint it may be rounded, so that its neighbours may be as well.
    pub fn room(&self, waypoint: usize) -> f64 {
        0.5 * self.lengths[waypoint - 1].min(self.lengths[waypoint])
    }

    /// How far from a waypoint it is rounded.
    pub fn radius(&self, waypoint: usize) -> f64 {
        self.radii[waypoint]
    }

    /// Rounds it from this far.
    pub fn round(&mut self, waypoint: usize, radius: f64) {
        self.radii[waypoint] = radius;
    }

    /// The parabola about a waypoint.
    pub fn parabola(&self, waypoint: usize) -> Stretch {
        let radius = self.radii[waypoint];
        let [before, after] = [&self.slopes[waypoint - 1], &self.slopes[waypoint]];
        let corner = &self.rows[waypoint];
        let columns = before.iter().zip(after);
        Stretch {
            start: corner
                .iter()
                .zip(before)
                .map(|(at, slope)| at - slope * radius)
                .collect(),
            slope: before.clone(),
            bend: columns
                .map(|(before, after)| (after - before) / (2.0 * radius))
                .collect(),
            length: 2.0 * radius,
        }
    }

    /// All of it in order; a stretch that does not begin smoothly after the one before is to be begun at
    /// rest.
    pub fn stretches(&self) -> Vec<Stretch> {
        let mut all = Vec::new();
        for segment in 0..self.lengths.len() {
            if self.radii[segment] > 0.0 {
                all.push(self.parabola(segment));
            }
            all.extend(self.line(segment));
        }
        all
    }

    /// What is left of a segment between its rounded ends.
    fn line(&self, segment: usize) -> Option<Stretch> {
        let slope = &self.slopes[segment];
        let from = self.radii[segment];
        let length = self.lengths[segment] - from - self.radii[segment + 1];
        let start = self.rows[segment].iter().zip(slope);
        (length > SAME_S * 1e-3).then(|| Stretch {
            start: start
                .map(|(at, slope)| at + slope * from)
                .collect(),
            slope: slope.clone(),
            bend: vec![0.0; slope.len()],
            length,
        })
    }
}

/// The waypoints, but for those that are hardly apart from the one before; both ends stay.
fn distinct(path: &Path, limits: &Limits) -> Vec<Vec<f64>> {
    let mut rows: Vec<Vec<f64>> = vec![path.waypoint(0).to_vec()];
    let last = path.len() - 1;
    for waypoint in 1..path.len() {
        let row = path.waypoint(waypoint);
        let is_apart = length(&rows[rows.len() - 1], row, limits) > SAME_S;
        if is_apart {
            rows.push(row.to_vec());
        } else if waypoint == last && rows.len() > 1 {
            let end = rows.len() - 1;
            rows[end] = row.to_vec();
        }
    }
    rows
}

/// How long the slowest column takes at full speed (s).
fn length(from: &[f64], to: &[f64], limits: &Limits) -> f64 {
    let columns = from.iter().zip(to).zip(limits.columns());
    columns
        .map(|((from, to), limits)| limits.velocity.part(to - from))
        .fold(0.0, f64::max)
}
