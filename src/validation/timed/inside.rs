//! Whether a timed trajectory stays inside the corridor of a path: a proof without robot and scene.
//!
//! Around one segment of the path the corridor is {q : min_p Σ_j reach_j |q_j − p_j| ≤ slack},
//! which is convex. So the chord of a piece of the curve is inside if both its ends are, and the
//! curve is if they are inside by the curve's deviation from the chord, Σ_j reach_j e_j.

use super::Piece;
use super::curve::Curve;
use crate::path::Path;
use crate::validation::Corridor;
use crate::validation::interval::ROUNDING_M;

/// A piece is not halved below this width (s).
const FINEST_S: f64 = 1e-6;

/// Whether a trajectory stays in a corridor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Inside {
    /// It does, and uses at most this part of the slack anywhere.
    Yes(f64),
    /// It does not, or cannot be told within a microsecond.
    No {
        /// The point before the place, from 0.
        point: usize,
        /// When (s).
        time_s: f64,
        /// Segment of the path that it is closest to the corridor of, from 0.
        segment: usize,
        /// How far the corridor is exceeded there or at a point after it, whichever is most (m).
        excess_m: f64,
    },
    /// `stop` said so.
    Stopped,
}

/// Whether a curve stays, up to a nanometre, in the corridor around a path of the same columns, all
/// of joints of one value, with the numbers of both as they stand.
pub fn stays_inside(
    curve: &Curve,
    path: &Path,
    corridor: &Corridor,
    stop: &mut dyn FnMut() -> bool,
) -> Inside {
    let tube = Tube { path, corridor };
    let mut hint = 0;
    let mut most_used = 0.0_f64;
    let whole = |point| Piece {
        point,
        from: 0.0,
        to: curve.duration(point),
    };
    let mut open: Vec<Piece> = (0..curve.segments()).rev().map(whole).collect();
    while let Some(piece) = open.pop() {
        if stop() {
            return Inside::Stopped;
        }
        let deviation = cost(
            &corridor.reach,
            curve
                .deviations(piece.point, piece.from, piece.to)
                .into_iter(),
        );
        let ends = [piece.from, piece.to].map(|t| curve.at(piece.point, t));
        let both = tube.nearest(&ends, hint);
        if both.excess + deviation <= 0.0 {
            hint = both.segment;
            let slack = corridor.slack_m[hint];
            most_used = most_used.max(1.0 + (both.excess + deviation) / (slack + ROUNDING_M));
            continue;
        }
        // Pieces come in the order of time: what is outside at its beginning is so nowhere before.
        let first = tube.nearest(&ends[..1], hint);
        if first.excess > 0.0 || piece.width() < FINEST_S {
            let point = piece.point;
            let time_s = curve.time(piece.point) + piece.from;
            let after =
                (point..curve.segments()).map(|point| curve.at(point, curve.duration(point)));
            let excess_m = after
                .map(|q| tube.nearest(&[q], hint).excess)
                .fold(first.excess.max(0.0), f64::max);
            return Inside::No {
                point,
                time_s,
                segment: first.segment,
                excess_m,
            };
        }
        open.extend(piece.halves());
    }
    Inside::Yes(most_used)
}

struct Tube<'a> {
    path: &'a Path,
    corridor: &'a Corridor,
}

/// A segment of the path, and how far its slack is exceeded (m).
#[derive(Clone, Copy, Debug)]
struct Place {
    segment: usize,
    excess: f64,
}

impl Tube<'_> {
    /// The segment whose corridor is exceeded least by all of these configurations; that of the
    /// hint if it is not.
    fn nearest(&self, configurations: &[Vec<f64>], hint: usize) -> Place {
        let excess = |segment: usize| {
            let farthest = configurations
                .iter()
                .map(|q| self.distance(segment, q))
                .fold(0.0, f64::max);
            Place {
                segment,
                excess: farthest - self.corridor.slack_m[segment] - ROUNDING_M,
            }
        };
        let hinted = excess(hint);
        if hinted.excess <= 0.0 {
            return hinted;
        }
        (0..self.corridor.slack_m.len())
            .map(excess)
            .fold(hinted, |best, other| {
                if other.excess < best.excess {
                    other
                } else {
                    best
                }
            })
    }

    /// min_p Σ_j reach_j |q_j − p_j| over a segment (m): convex in the ratio along it and straight
    /// between the ratios at which a column agrees.
    fn distance(&self, segment: usize, q: &[f64]) -> f64 {
        let [from, to] =
            [segment, (segment + 1).min(self.path.len() - 1)].map(|k| self.path.waypoint(k));
        let at = |ratio: f64| {
            let gaps = q
                .iter()
                .zip(from.iter().zip(to))
                .map(|(q, (from, to))| q - (from + ratio * (to - from)));
            cost(&self.corridor.reach, gaps)
        };
        let agrees =
            |(q, (from, to)): (&f64, (&f64, &f64))| ((q - from) / (to - from)).clamp(0.0, 1.0);
        let ratios = q
            .iter()
            .zip(from.iter().zip(to))
            .map(agrees)
            .filter(|ratio| ratio.is_finite());
        ratios
            .chain([0.0, 1.0])
            .map(at)
            .fold(f64::INFINITY, f64::min)
    }
}

fn cost(reach: &[f64], deviations: impl Iterator<Item = f64>) -> f64 {
    // Far above what the sum loses.
    reach
        .iter()
        .zip(deviations)
        .map(|(reach, deviation)| reach * deviation.abs())
        .sum::<f64>()
        * (1.0 + 1e-12)
}
