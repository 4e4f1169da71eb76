//! The closest pieces of two bodies, by halving.
//!
//! A cover is a body's pieces, halved again and again along the widest side of the box around their
//! middles, with a ball around each part that is measured at all of its pieces.

use std::ops::Range;

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
    /// Takes in what two pieces are apart.
    fn take_in(&mut self, gap: f64, distance: f64) {
        // A gap that is no number must not pass for a wide one.
        self.gap = if gap.is_nan() {
            f64::NEG_INFINITY
        } else {
            self.gap.min(gap)
        };
        self.distance = self.distance.min(distance);
    }
    /// Nothing found within that distance.
    fn none(within: f64) -> Self {
        Self {
            gap: within,
            distance: f64::INFINITY,
        }
    }
}

impl Part {
    /// Pieces of a body, in a ball around this centre.
    fn around(pieces: &[Piece], center: Vec3, range: Range<usize>) -> Self {
        Self {
            center,
            // Above what rounding loses.
            radius: farthest(pieces, center) * (1.0 + 1e-12),
            first: range.start,
            last: range.end,
            second_half: 0,
        }
    }
}

/// Farthest that a point of any piece is from this one (m).
fn farthest(pieces: &[Piece], from: Vec3) -> f64 {
    let distances = pieces.iter().map(|piece| piece.farthest(from));
    distances.fold(0.0, f64::max)
}

/// The box around the middles of pieces.
fn bounds(pieces: &[Piece]) -> [Vec3; 2] {
    let none = [Vec3::INFINITY, Vec3::NEG_INFINITY];
    let middles = pieces.iter().map(Piece::center);
    middles.fold(none, |[low, high], p| [low.min(p), high.max(p)])
}

/// Orders pieces along the widest side of their box.
fn sort_along_widest(pieces: &mut [Piece], side: Vec3) {
    let widest = widest(side);
    pieces.sort_by(|a, b| a.center()[widest].total_cmp(&b.center()[widest]));
}

/// Axis of the longest side; of equals, the last.
fn widest(side: Vec3) -> usize {
    let widest = (0..3).max_by(|&i, &j| side[i].total_cmp(&side[j]));
    widest.unwrap_or(0)
}

impl Cover {
    /// Covers at least one piece; `place` is where their frame is in the link's.
    pub fn new(pieces: &[Piece], place: &Transform) -> Self {
        let origin = place.inverse_point(Vec3::ZERO);
        let mut cover = Self {
            pieces: pieces.to_vec(),
            parts: Vec::new(),
            reach: farthest(pieces, origin),
        };
        cover.add(0, pieces.len());
        cover
    }

    fn add(&mut self, first: usize, last: usize) {
        let own = self.parts.len();
        let pieces = &mut self.pieces[first..last];
        let [low, high] = bounds(pieces);
        self.parts
            .push(Part::around(pieces, (low + high) / 2.0, first..last));
        if last - first > 1 {
            sort_along_widest(pieces, high - low);
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

/// Distance of a point from a piece; below 0 inside of its rounding.
fn from_piece(piece: &Piece, point: Vec3) -> f64 {
    distance::closest_on(&piece.core, point).distance(point) - piece.radius
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
        let piece_a = self.a.piece(&self.a.parts[i]);
        let piece_b = self.b.piece(&self.b.parts[j]);
        if let (Some(a), Some(b)) = (piece_a, piece_b) {
            return self.compare(&a.transformed(self.relative), b);
        }
        let halves = self.halves(i, j);
        let [first, second] = halves.map(|(i, j)| self.apart(i, j));
        // What is nearer first: it may make the other needless.
        let order = if first <= second { [0, 1] } else { [1, 0] };
        for (i, j) in order.map(|k| halves[k]) {
            self.descend(i, j);
        }
    }

    /// Both halves of the larger of two parts that has halves, each with the other part.
    fn halves(&self, i: usize, j: usize) -> [(usize, usize); 2] {
        let a = &self.a.parts[i];
        let b = &self.b.parts[j];
        let a_is_piece = self.a.piece(a).is_some();
        let b_is_piece = self.b.piece(b).is_some();
        if !a_is_piece && (b_is_piece || a.radius >= b.radius) {
            [(i + 1, j), (a.second_half, j)]
        } else {
            [(i, j + 1), (i, b.second_half)]
        }
    }

    /// At most the distance of two parts: of their balls, or of a ball and a piece.
    fn apart(&self, i: usize, j: usize) -> f64 {
        let a = &self.a.parts[i];
        let b = &self.b.parts[j];
        let center_a = self.relative.point(a.center);
        if let Some(piece) = self.b.piece(b) {
            return from_piece(piece, center_a) - a.radius;
        }
        if let Some(piece) = self.a.piece(a) {
            let center_b = self.relative.inverse_point(b.center);
            return from_piece(piece, center_b) - b.radius;
        }
        center_a.distance(b.center) - a.radius - b.radius
    }

    fn compare(&mut self, a: &Piece, b: &Piece) {
        let apart = distance::separation(a, b);
        let distance = (apart.point_a - apart.point_b).dot(apart.normal);
        self.best.take_in(apart.gap, distance);
    }
}
