//! Whether a timed trajectory stays inside the corridor of a path: a proof without robot and scene.
//!
//! Around one segment of the path the corridor is {q : min_p Σ_j reach_j |q_j − p_j| ≤ slack},
//! which is convex. So the chord of a piece of the curve is inside if both its ends are, and the
//! curve is if they are inside by the curve's deviation from the chord, Σ_j reach_j e_j.

use super::curve::Curve;
use crate::path::Path;
use crate::validation::Corridor;
use crate::validation::interval::ROUNDING_M;
use crate::validation::path_proof::ends;
use crate::validation::reach::cost;

/// A piece is not halved below this width (s).
const FINEST_S: f64 = 1e-6;

/// A piece of time between two points.
#[derive(Clone, Copy, Debug)]
struct Piece {
    point: usize,
    /// From the point on (s).
    from: f64,
    to: f64,
}

impl Piece {
    fn width(&self) -> f64 {
        self.to - self.from
    }

    /// The later half first, as a stack takes them.
    fn halves(&self) -> [Self; 2] {
        let middle = self.from + self.width() / 2.0;
        [
            Self {
                from: middle,
                ..*self
            },
            Self {
                to: middle,
                ..*self
            },
        ]
    }
}

/// The pieces of a curve between points, the last first.
fn whole(curve: &Curve) -> Vec<Piece> {
    let piece = |point| Piece {
        point,
        from: 0.0,
        to: curve.duration(point),
    };
    (0..curve.segments()).rev().map(piece).collect()
}

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
    let mut open = whole(curve);
    while let Some(piece) = open.pop() {
        if stop() {
            return Inside::Stopped;
        }
        let ends = [piece.from, piece.to].map(|t| curve.at(piece.point, t));
        if let Some((segment, used)) = tube.keeps(curve, &piece, &ends, hint) {
            hint = segment;
            most_used = most_used.max(used);
            continue;
        }
        // Pieces come in the order of time: what is outside at its beginning is so nowhere before.
        let first = tube.nearest(&ends[..1], hint);
        if first.excess > 0.0 || piece.width() < FINEST_S {
            return tube.left_at(curve, &piece, first, hint);
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

impl Place {
    /// Of two, the one that is exceeded less; of equals, the first.
    fn less(self, other: Self) -> Self {
        if other.excess < self.excess {
            other
        } else {
            self
        }
    }
}

impl Tube<'_> {
    /// The segment whose corridor is exceeded least by all of these configurations; that of the
    /// hint if it is not.
    fn nearest(&self, configurations: &[Vec<f64>], hint: usize) -> Place {
        let hinted = self.excess(configurations, hint);
        if hinted.excess <= 0.0 {
            return hinted;
        }
        let segments = 0..self.corridor.slack_m.len();
        let places = segments.map(|segment| self.excess(configurations, segment));
        places.fold(hinted, Place::less)
    }

    /// How far these configurations exceed the corridor of a segment.
    fn excess(&self, configurations: &[Vec<f64>], segment: usize) -> Place {
        let farthest = self.farthest(configurations, segment);
        Place {
            segment,
            excess: farthest - self.corridor.slack_m[segment] - ROUNDING_M,
        }
    }

    fn farthest(&self, configurations: &[Vec<f64>], segment: usize) -> f64 {
        let distances = configurations
            .iter()
            .map(|q| self.distance(segment, q));
        distances.fold(0.0, f64::max)
    }

    /// The segment in whose corridor all of a piece with these ends stays, and which part of the slack
    /// it uses.
    fn keeps(
        &self,
        curve: &Curve,
        piece: &Piece,
        ends: &[Vec<f64>; 2],
        hint: usize,
    ) -> Option<(usize, f64)> {
        let deviations = curve.deviations(piece.point, piece.from, piece.to);
        let deviation = cost(&self.corridor.reach, deviations.into_iter());
        let Place { segment, excess } = self.nearest(ends, hint);
        // The corridor is convex: the chord is inside where its ends are.
        let is_inside = excess + deviation <= 0.0;
        let slack = self.corridor.slack_m[segment];
        is_inside.then(|| (segment, 1.0 + (excess + deviation) / (slack + ROUNDING_M)))
    }

    /// What is said of a curve that leaves the corridor where a piece begins.
    fn left_at(&self, curve: &Curve, piece: &Piece, first: Place, hint: usize) -> Inside {
        let after = piece.point..curve.segments();
        let points = after.map(|point| curve.at(point, curve.duration(point)));
        let excesses = points.map(|q| self.nearest(&[q], hint).excess);
        Inside::No {
            point: piece.point,
            time_s: curve.time(piece.point) + piece.from,
            segment: first.segment,
            excess_m: excesses.fold(first.excess.max(0.0), f64::max),
        }
    }

    /// min_p Σ_j reach_j |q_j − p_j| over a segment (m): convex in the ratio along it and straight
    /// between the ratios at which a column agrees.
    fn distance(&self, segment: usize, q: &[f64]) -> f64 {
        let [from, to] = ends(self.path, segment);
        let at = |ratio: f64| {
            let places = from
                .iter()
                .zip(to)
                .map(|(from, to)| from + ratio * (to - from));
            cost(
                &self.corridor.reach,
                q.iter().zip(places).map(|(q, place)| q - place),
            )
        };
        let ratios = agreements(q, from, to).chain([0.0, 1.0]);
        ratios.map(at).fold(f64::INFINITY, f64::min)
    }
}

/// The ratios along a segment at which its columns agree with a configuration.
fn agreements(q: &[f64], from: &[f64], to: &[f64]) -> impl Iterator<Item = f64> {
    let columns = q.iter().zip(from.iter().zip(to));
    let ratios = columns.map(|(q, (from, to))| (q - from) / (to - from));
    ratios
        .map(|ratio| ratio.clamp(0.0, 1.0))
        .filter(|ratio| ratio.is_finite())
}
