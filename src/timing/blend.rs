//! A path with its corners rounded: straight lines, and parabolas about the waypoints.
//!
//! Lengths are seconds: a segment is as long as its slowest column takes at full speed, so that u, the
//! columns' change by length, is the same at whatever scale they are. About a waypoint, from r before it to
//! r after it, u changes evenly from that of one segment to that of the next: a parabola that meets both
//! lines smoothly. It strays from them by r/4 Σ reach |Δu| at most, but how far it may is found by proofs.

use super::limits::Limits;
use super::settings::Fixed;
use super::trajectory::{NS, State, TimedState, moved};
use crate::path::Path;

/// Waypoints nearer to each other than this (s) count as one.
const SAME_S: f64 = 1e-6;

/// Where a path goes straight on in another direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Corner {
    /// m or rad.
    pub positions: Vec<f64>,
    /// Whether the way must pass it.
    pub is_fixed: bool,
}

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
    /// Whether it begins at rest, at a fixed waypoint.
    pub is_after_fixed: bool,
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
        moved(&self.slope, &self.bend, length)
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
        let length_ns = (self.length * NS).max(1.0) as i64;
        [
            TimedState::at(0, state(0.0)),
            TimedState::at(length_ns, state(self.length)),
        ]
    }
}

/// A path whose waypoints may be rounded.
#[derive(Clone, Debug)]
pub struct Corners {
    rows: Vec<Corner>,
    /// Of each segment: how long it is, and its change by length.
    lengths: Vec<f64>,
    slopes: Vec<Vec<f64>>,
    /// Of each waypoint, 0 of the ends.
    radii: Vec<f64>,
}

impl Corners {
    /// With none of them rounded.
    pub fn new(rows: Vec<Corner>, limits: &Limits) -> Self {
        let mut lengths = Vec::new();
        let mut slopes = Vec::new();
        for ends in rows.windows(2) {
            let from = &ends[0].positions;
            let to = &ends[1].positions;
            let length = length(from, to, limits);
            let columns = to.iter().zip(from);
            let slope = columns.map(|(to, from)| (to - from) / length);
            slopes.push(slope.collect());
            lengths.push(length);
        }
        Self {
            radii: vec![0.0; rows.len()],
            rows,
            lengths,
            slopes,
        }
    }

    /// The waypoints that are left.
    pub fn rows(&self) -> &[Corner] {
        &self.rows
    }

    /// The numbers of those that may be rounded.
    pub fn inner(&self) -> Vec<usize> {
        let between = 1..self.rows.len().max(2) - 1;
        between
            .filter(|waypoint| !self.rows[*waypoint].is_fixed)
            .collect()
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
        let before = &self.slopes[waypoint - 1];
        let after = &self.slopes[waypoint];
        let columns = before.iter().zip(after);
        let bend = columns.map(|(before, after)| (after - before) / (2.0 * radius));
        Stretch {
            start: moved(&self.rows[waypoint].positions, before, -radius),
            slope: before.clone(),
            bend: bend.collect(),
            length: 2.0 * radius,
            is_after_fixed: false,
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
        let start = &self.rows[segment];
        let from = self.radii[segment];
        let to = self.radii[segment + 1];
        let length = self.lengths[segment] - from - to;
        let least = SAME_S * 1e-3 * f64::from(from > 0.0 || to > 0.0);
        (length > least).then(|| Stretch {
            start: moved(&start.positions, slope, from),
            slope: slope.clone(),
            bend: vec![0.0; slope.len()],
            length,
            is_after_fixed: start.is_fixed,
        })
    }
}

/// The waypoints of a path, but for those that are hardly apart from the one before; fixed ones stay, and
/// so do both ends. Of a path that leads nowhere one is left: it ends where it begins, and must pass nothing.
pub fn distinct(path: &Path, fixed: &Fixed, limits: &Limits) -> Vec<Corner> {
    let corner = |waypoint: usize| Corner {
        positions: path.waypoint(waypoint).to_vec(),
        is_fixed: waypoint == path.len() - 1 || fixed.contains(waypoint),
    };
    let mut rows = vec![Corner {
        is_fixed: true,
        ..corner(0)
    }];
    for waypoint in 1..path.len() {
        let next = corner(waypoint);
        let last = rows.last_mut().expect("a path has a waypoint");
        let is_apart = length(&last.positions, &next.positions, limits) > SAME_S;
        if next.positions == last.positions {
            last.is_fixed |= next.is_fixed;
        } else if is_apart || last.is_fixed && next.is_fixed {
            rows.push(next);
        } else if next.is_fixed {
            *last = next;
        }
    }
    if leads_nowhere(&rows) {
        rows.truncate(1);
    }
    rows
}

fn leads_nowhere(rows: &[Corner]) -> bool {
    let last = rows.len() - 1;
    let inner = &rows[last.min(1)..last];
    rows[0].positions == rows[last].positions && inner.iter().all(|row| !row.is_fixed)
}

/// How long the slowest column takes at full speed (s).
fn length(from: &[f64], to: &[f64], limits: &Limits) -> f64 {
    let columns = from.iter().zip(to).zip(limits.columns());
    columns
        .map(|((from, to), limits)| limits.velocity.part(to - from))
        .fold(0.0, f64::max)
}
