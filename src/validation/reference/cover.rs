//! The closest pieces of two bodies, by halving.
//!
//! A cover is a body's pieces, halved again and again along the widest side of the box around their
//! middles, with a ball around each part that is measured at all of its pieces.

use crate::math::Vec3;
use crate::solid::distance;
use crate::solid::piece::Piece;
use crate::solid::transform::Transform;

/// The pieces of a body in parts of parts.
#[derive(Debug)]
pub struct Cover {
    pieces: Vec<Piece>,
    /// Parts; the first is the whole.
    parts: Vec<Part>,
    /// Farthest that a point of the body is from its link's origin (m).
    pub reach: f64,
}

/// Pieces `first..last`, and the ball around them.
#[derive(Clone, Copy, Debug)]
struct Part {
    center: Vec3,
    radius: f64,
    first: usize,
    last: usize,
    /// Where the other half is; the first half is the next part.
    second_half: usize,
}

/// Two bodies at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Near {
    /// At most the distance (m): a support gap.
    pub gap: f64,
    /// At least the distance (m), between two points of the bodies; not above 0 where they overlap.
    pub distance: f64,
}

impl Near {
    /// Nothing found within that distance.
    fn none(within: f64) -> Self {
        Self {
            gap: within,
            distance: f64::INFINITY,
        }
    }
}

impl Cover {
    /// Covers at least one piece; `place` is where their frame is in the link's.
    pub fn new(pieces: &[Piece], place: &Transform) -> Self {
        let mut cover = Self {
            pieces: pieces.to_vec(),
            parts: Vec::new(),
            reach: 0.0,
        };
        let origin = place.inverse_point(Vec3::ZERO);
        cover.reach = cover
            .pieces
            .iter()
            .map(|piece| piece.farthest(origin))
            .fold(0.0, f64::max);
        cover.add(0, pieces.len());
        cover
    }

    fn add(&mut self, first: usize, last: usize) {
        let pieces = &mut self.pieces[first..last];
        let bounds = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        let [low, high] = pieces
            .iter()
            .map(Piece::center)
            .fold(bounds, |[l, h], p| [l.min(p), h.max(p)]);
        let center = (low + high) / 2.0;
        let radius = pieces
            .iter()
            .map(|piece| piece.farthest(center))
            .fold(0.0, f64::max)
            * (1.0 + 1e-12);
        let own = self.parts.len();
        self.parts.push(Part {
            center,
            radius,
            first,
            last,
            second_half: 0,
        });
        if last - first > 1 {
            let side = high - low;
            let widest = (0..3)
                .max_by(|&i, &j| side[i].total_cmp(&side[j]))
                .unwrap_or(0);
            pieces.sort_by(|a, b| a.center()[widest].total_cmp(&b.center()[widest]));
            let middle = (first + last) / 2;
            self.add(first, middle);
            self.parts[own].second_half = self.parts.len();
            self.add(middle, last);
        }
    }

    fn piece(&self, part: &Part) -> Option<&Piece> {
        (part.last - part.first == 1).then(|| &self.pieces[part.first])
    }
}

/// How a search may end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Until {
    /// Two pieces closer than asked for will do.
    AnyCloser,
    /// The closest of all.
    Closest,
}

/// What two bodies, of which `relative` places A in B's frame, are apart, as far as it is less than
/// `within`.
pub fn near(a: &Cover, b: &Cover, relative: &Transform, within: f64, until: Until) -> Near {
    let mut search = Search {
        a,
        b,
        relative,
        until,
        within,
        best: Near::none(within),
    };
    search.descend(0, 0);
    search.best
}

struct Search<'a> {
    a: &'a Cover,
    b: &'a Cover,
    relative: &'a Transform,
    until: Until,
    within: f64,
    best: Near,
}

impl Search<'_> {
    fn descend(&mut self, i: usize, j: usize) {
        let found = self.until == Until::AnyCloser && self.best.gap < self.within;
        if found || self.apart(i, j) >= self.best.gap {
            return;
        }
        let part_a = self.a.parts[i];
        let part_b = self.b.parts[j];
        match (self.a.piece(&part_a), self.b.piece(&part_b)) {
            (Some(piece_a), Some(piece_b)) => {
                self.compare(&piece_a.transformed(self.relative), piece_b)
            }
            (one, other) => {
                // The larger of those that have halves.
                let halve_a = one.is_none() && (other.is_some() || part_a.radius >= part_b.radius);
                let halves = if halve_a {
                    [(i + 1, j), (part_a.second_half, j)]
                } else {
                    [(i, j + 1), (i, part_b.second_half)]
                };
                let [first, second] = halves.map(|(i, j)| self.apart(i, j));
                let order = if first <= second { [0, 1] } else { [1, 0] };
                order
                    .into_iter()
                    .for_each(|k| self.descend(halves[k].0, halves[k].1));
            }
        }
    }

    /// At most the distance of two parts: of their balls, or of a ball and a piece.
    fn apart(&self, i: usize, j: usize) -> f64 {
        let part_a = &self.a.parts[i];
        let part_b = &self.b.parts[j];
        let center_a = self.relative.point(part_a.center);
        if let Some(piece) = self.b.piece(part_b) {
            return distance::closest_on(&piece.core, center_a).distance(center_a)
                - piece.radius
                - part_a.radius;
        }
        if let Some(piece) = self.a.piece(part_a) {
            let center_b = self.relative.inverse_point(part_b.center);
            return distance::closest_on(&piece.core, center_b).distance(center_b)
                - piece.radius
                - part_b.radius;
        }
        center_a.distance(part_b.center) - part_a.radius - part_b.radius
    }

    fn compare(&mut self, a: &Piece, b: &Piece) {
        let apart = distance::separation(a, b);
        let distance = (apart.point_a - apart.point_b).dot(apart.normal);
        // A gap that is no number must not pass for a wide one.
        self.best.gap = if apart.gap.is_nan() {
            f64::NEG_INFINITY
        } else {
            self.best.gap.min(apart.gap)
        };
        self.best.distance = self.best.distance.min(distance);
    }
}
