//! One pair of bodies on one interval: proved free, refused, or to be split.
//!
//! The search goes down both ball trees at once, in B's frame. Each test is the theorem of
//! [`motion`](super::motion) for the two convex solids at hand: a ball moves like its centre, so
//! its radius never meets the angular velocity.

use super::motion::Twist;
use crate::collision::body::Body;
use crate::math::Vec3;
use crate::solid::TOUCHING_M;
use crate::solid::convex_hull::ConvexHull;
use crate::solid::distance;
use crate::solid::piece::Piece;
use crate::solid::query::{self, Split};
use crate::solid::transform::Transform;
use crate::solid::tree::{Ball, Content, Nodes, by_kind};

/// Allowed for the rounding of poses, distances and bounds (m): a thousand times what they amount
/// to in a world of a kilometre.
pub const ROUNDING_M: f64 = 1e-9;

/// Pieces from which on the whole of a body is worth a look at a cloud's box. Random bodies of tests
/// have few.
const LARGE: usize = if cfg!(test) { 2 } else { 32 };

/// A cloud's boxes are looked at with the whole of a body down to so much smaller than it: for the
/// clouds of five scenes a proof takes 24, 11, 9.8, 9.9 and 9.7 ms in the median with 1, 2, 4, 8 and 16.
const FINER: f64 = 4.0;

/// Pairs of pieces from which on two bodies are first tried as wholes.
const MANY_PAIRS: usize = 64;

/// Two bodies on an interval, everything in B's frame and multiplied by the interval's half width.
pub struct PairInterval<'a> {
    /// Pieces of A.
    pub a: &'a Body,
    /// Pieces of B.
    pub b: &'a Body,
    /// A's frame in B's.
    pub relative: Transform,
    /// Half displacement of A's points relative to the common ancestor.
    pub twist_a: Twist,
    /// The same of B's.
    pub twist_b: Twist,
    /// ½ h² (A_A + A_B) (m).
    pub bend: f64,
    /// h (V_A + V_B) (m), the plain bound.
    pub travel: f64,
    /// Distance to be proved (m).
    pub floor: f64,
    /// Bodies that are closer than this in the middle are too close; a proof is tried only of
    /// others (m).
    pub too_close: f64,
}

/// What came of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum IntervalVerdict {
    /// The pair keeps this distance (m) on the whole interval.
    Proved(f64),
    /// In the middle the bodies touch or overlap.
    Collision,
    /// In the middle they are closer than [`PairInterval::too_close`].
    TooClose,
    /// Nothing is decided: look at both halves.
    Split,
    /// `stop` said so.
    Stopped,
}

/// Counts the pairs of balls looked at, and asks now and then whether to stop.
pub struct Looks<'a> {
    /// Looks so far.
    pub count: u64,
    stop: &'a mut dyn FnMut() -> bool,
}

impl<'a> Looks<'a> {
    /// Looks between two questions: some tenths of a millisecond among meshes.
    const PATIENCE: u64 = 256;

    /// None so far.
    pub fn new(stop: &'a mut dyn FnMut() -> bool) -> Self {
        Self { count: 0, stop }
    }

    fn is_stopped(&mut self) -> bool {
        self.count += 1;
        self.count.is_multiple_of(Self::PATIENCE) && (self.stop)()
    }
}

impl PairInterval<'_> {
    /// Decides the interval. `direction` is where the bodies lay apart as wholes when they were
    /// last looked at, and becomes where they do now; a direction that is out of date costs a
    /// search, never truth.
    pub fn decide(&self, direction: &mut Option<Vec3>, looks: &mut Looks) -> IntervalVerdict {
        let trees = (&self.a.solid.tree, &self.b.solid.tree);
        by_kind!(trees.0, trees.1, |a, b| {
            let pieces = Pieces {
                interval: self,
                a,
                b,
            };
            if self.has_many_pairs() && !self.is_enough(pieces.kept_at_the_top()) {
                looks.count += 1;
                let kept = self.kept_along(direction);
                if self.is_enough(kept) {
                    return IntervalVerdict::Proved(kept);
                }
            }
            pieces.descend(0, 0, looks)
        })
    }

    /// Whether two bodies are first tried as wholes.
    fn has_many_pairs(&self) -> bool {
        self.a.solid.tree.count() * self.b.solid.tree.count() >= MANY_PAIRS
    }

    /// Whether a distance kept proves the pair.
    #[inline]
    fn is_enough(&self, kept: f64) -> bool {
        // On the safe side of what rounding adds; no number is not enough.
        kept >= self.floor + ROUNDING_M
    }

    /// Distance that the bodies keep as wholes along a direction, or where that is out of date along a
    /// new one.
    fn kept_along(&self, direction: &mut Option<Vec3>) -> f64 {
        let kept = self.kept_if_known(*direction);
        if self.is_enough(kept) {
            return kept;
        }
        *direction = self.direction_of_wholes();
        self.kept_if_known(*direction)
    }

    fn kept_if_known(&self, normal: Option<Vec3>) -> f64 {
        normal.map_or(f64::NEG_INFINITY, |normal| self.kept_by_wholes(normal))
    }

    /// Whether surfaces touch or overlap in the middle; [`IntervalVerdict::Split`] where they do
    /// not.
    pub fn touches_in_the_middle(&self, looks: &mut Looks) -> IntervalVerdict {
        let rest = self.at_rest();
        let trees = (&self.a.solid.tree, &self.b.solid.tree);
        let verdict = by_kind!(trees.0, trees.1, |a, b| {
            let pieces = Pieces {
                interval: &rest,
                a,
                b,
            };
            pieces.descend(0, 0, looks)
        });
        match verdict {
            verdict @ (IntervalVerdict::Collision | IntervalVerdict::Stopped) => verdict,
            IntervalVerdict::Proved(_) | IntervalVerdict::TooClose | IntervalVerdict::Split => {
                IntervalVerdict::Split
            }
        }
    }

    /// The middle alone: nothing moves, and any distance is enough.
    fn at_rest(&self) -> Self {
        let still = Twist::default();
        PairInterval {
            twist_a: still,
            twist_b: still,
            bend: 0.0,
            travel: 0.0,
            floor: 0.0,
            too_close: f64::NEG_INFINITY,
            ..*self
        }
    }

    /// Unit vector from B's convex hull towards A's in the middle, in B's frame; `None` where they
    /// overlap.
    pub fn direction_of_wholes(&self) -> Option<Vec3> {
        ConvexHull::direction(
            self.a.solid.convex_hull.as_ref()?,
            &self.relative,
            self.b.solid.convex_hull.as_ref()?,
        )
    }

    /// Distance that the bodies' convex hulls keep on the interval along a unit vector: most meshes
    /// that pass each other closely never reach into each other's hollows.
    ///
    /// But for the bend, a point p of a body that moves with the half displacements ω and l is at
    /// p + τ (l + ω × p) for τ in [−1, 1], and along n at (n + τ n × ω)·p + τ n·l. The least of such
    /// linear functions over A less the greatest over B is concave in τ, so it is least at an end.
    pub fn kept_by_wholes(&self, normal: Vec3) -> f64 {
        let (Some(a), Some(b)) = (&self.a.solid.convex_hull, &self.b.solid.convex_hull) else {
            return f64::NEG_INFINITY;
        };
        self.kept_by_hulls(a, |along| b.farthest_along(along), normal)
    }

    /// The same of A's hull and of anything convex that gets this far along a direction, times its
    /// length.
    #[inline]
    fn kept_by_hulls(&self, a: &ConvexHull, b: impl Fn(Vec3) -> f64, normal: Vec3) -> f64 {
        let gap_at = |end: f64| self.gap_of_hulls(a, &b, normal, end);
        gap_at(-1.0).min(gap_at(1.0)) - self.bend
    }

    /// The gap along a unit vector at τ = ±1, but for the bend.
    #[inline]
    fn gap_of_hulls(&self, a: &ConvexHull, b: impl Fn(Vec3) -> f64, normal: Vec3, end: f64) -> f64 {
        let along_a = normal + normal.cross(self.twist_a.angular) * end;
        let along_b = normal + normal.cross(self.twist_b.angular) * end;
        let back = self.relative.rotation.transpose() * (-along_a);
        let nearest_a = along_a.dot(self.relative.translation) - a.farthest_along(back);
        nearest_a - b(along_b) + end * normal.dot(self.twist_a.linear - self.twist_b.linear)
    }

    /// What B's ball is over is within this piece.
    #[inline]
    fn kept_by_ball_and_piece(
        &self,
        a: &Ball,
        center_a: Vec3,
        b: &Ball,
        piece: &Piece,
    ) -> Option<f64> {
        let (normal, gap) = from_piece(piece, center_a)?;
        let reach = || reach(b, piece);
        Some(gap - a.radius - self.displacement(normal, center_a, 0.0, piece.center(), reach))
    }

    /// What A's ball is over is within this piece.
    #[inline]
    fn kept_by_piece_and_ball(
        &self,
        a: &Ball,
        piece: &Piece,
        center_a: Vec3,
        b: &Ball,
    ) -> Option<f64> {
        let piece = piece.transformed(&self.relative);
        let (outward, gap) = from_piece(&piece, b.center)?;
        let reach = reach(a, &piece);
        Some(gap - b.radius - self.displacement(-outward, center_a, reach, b.center, || 0.0))
    }

    #[inline]
    fn kept_by_two_balls(&self, a: &Ball, center_a: Vec3, b: &Ball) -> Option<f64> {
        let offset = center_a - b.center;
        let length = offset.length();
        if length < TOUCHING_M {
            return None;
        }
        // What a ball is over moves like its centre, whatever turns: the ball's radius is only taken off.
        let moved = self.displacement(offset / length, center_a, 0.0, b.center, || 0.0);
        Some(length - a.radius - b.radius - moved)
    }

    /// What two pieces keep along the first of the cheap directions that proves them.
    #[inline]
    fn kept_cheaply(&self, a: &Piece, b: &Piece, reaches: (f64, f64)) -> Option<f64> {
        for normal in cheap_normals(a, b).into_iter().flatten() {
            let gap = distance::gap_along(a, b, normal);
            // Nearer than this the verdict is `TooClose` at last: nothing may be proved before.
            if gap >= self.too_close {
                let kept = gap - self.displacement_of_pieces(a, b, normal, reaches);
                if self.is_enough(kept) {
                    return Some(kept);
                }
            }
        }
        None
    }

    /// How much of the gap of two pieces along `normal` the interval can take, with their reaches
    /// about their middles.
    fn displacement_of_pieces(
        &self,
        a: &Piece,
        b: &Piece,
        normal: Vec3,
        reaches: (f64, f64),
    ) -> f64 {
        self.displacement(normal, a.center(), reaches.0, b.center(), || reaches.1)
    }

    /// What two pieces with this gap along `normal` keep on the interval.
    #[inline]
    fn kept_by_pieces(
        &self,
        a: &Piece,
        b: &Piece,
        normal: Vec3,
        gap: f64,
        reaches: (f64, f64),
    ) -> f64 {
        gap - self.displacement_of_pieces(a, b, normal, reaches)
    }

    /// Gap and displacement bound of the two pieces that keep least.
    #[cfg(test)]
    pub fn weakest_pieces(&self) -> Option<(f64, f64)> {
        let pieces = |tree: &crate::solid::tree::Tree| 0..tree.count();
        let all = pieces(&self.a.solid.tree)
            .flat_map(|i| pieces(&self.b.solid.tree).map(move |j| (i, j)));
        let piece = |i: usize| self.a.solid.tree.pieces()[i].transformed(&self.relative);
        let reach = |piece: &Piece| piece.core.farthest(piece.center());
        let bounds = all.map(|(i, j)| {
            let a = piece(i);
            let b = &self.b.solid.tree.pieces()[j];
            let apart = distance::separation(&a, b);
            (
                apart.gap,
                self.displacement_of_pieces(&a, b, apart.normal, (reach(&a), reach(b))),
            )
        });
        bounds
            .min_by(|x, y| (x.0 - x.1).total_cmp(&(y.0 - y.1)))
            .filter(|(gap, _)| *gap > 1e-6)
    }

    /// D: how much the gap along `normal` can shrink, for solids that reach `radius` about their
    /// points.
    fn displacement(
        &self,
        normal: Vec3,
        a: Vec3,
        radius_a: f64,
        b: Vec3,
        radius_b: impl Fn() -> f64,
    ) -> f64 {
        let approach = normal
            .dot(self.twist_a.at(a) - self.twist_b.at(b))
            .abs();
        let turn_a = self.turn_a(normal, radius_a);
        let turn_b = self.turn_b(normal, radius_b);
        // Both bounds hold, so the smaller does.
        (approach + turn_a + turn_b + self.bend).min(self.travel)
    }

    /// What A's turn moves along `normal`, this far about its point.
    #[inline]
    fn turn_a(&self, normal: Vec3, radius: f64) -> f64 {
        if radius > 0.0 {
            self.twist_a.swing(normal) * radius
        } else {
            0.0
        }
    }

    /// The same of B.
    #[inline]
    fn turn_b(&self, normal: Vec3, radius: impl Fn() -> f64) -> f64 {
        // An obstacle turns nothing: its radius need not be known.
        let is_still = self.twist_b.angular == Vec3::ZERO;
        if is_still {
            0.0
        } else {
            self.twist_b.swing(normal) * radius()
        }
    }
}

/// How far the core of the only piece of a ball reaches about its middle, which is the ball's.
fn reach(ball: &Ball, piece: &Piece) -> f64 {
    ball.radius - piece.radius
}

/// Directions that may part two pieces, from B to A: from B's point nearest to A's middle, and the
/// normals of triangles.
fn cheap_normals(a: &Piece, b: &Piece) -> [Option<Vec3>; 3] {
    let middle = a.center();
    let outward = middle - b.center();
    [
        from_piece(b, middle).map(|(normal, _)| normal),
        across_triangle(a, outward),
        across_triangle(b, outward),
    ]
}

#[inline]
fn across_triangle(piece: &Piece, outward: Vec3) -> Option<Vec3> {
    let [normal, ..] = piece
        .core
        .triangle()
        .and(Some(piece.core.normals()))?;
    normal.map(|normal| towards(normal, outward))
}

/// A direction or its opposite, on the side of another.
#[inline]
fn towards(normal: Vec3, outward: Vec3) -> Vec3 {
    if normal.dot(outward) < 0.0 {
        -normal
    } else {
        normal
    }
}

/// Two children, the nearer first; of equals, as they come.
#[inline]
fn nearer_first([left, right]: [u32; 2], gap: impl Fn(u32) -> f64) -> [u32; 2] {
    if gap(left) <= gap(right) {
        [left, right]
    } else {
        [right, left]
    }
}

/// The pieces of both bodies, by trees of some kinds.
struct Pieces<'a, A, B> {
    interval: &'a PairInterval<'a>,
    a: &'a A,
    b: &'a B,
}

impl<A: Nodes, B: Nodes> Pieces<'_, A, B> {
    fn kept_at_the_top(&self) -> f64 {
        self.kept_by_balls((0, &self.a.ball(0)), (0, &self.b.ball(0)))
    }

    fn descend(&self, a: u32, b: u32, looks: &mut Looks) -> IntervalVerdict {
        if looks.is_stopped() {
            return IntervalVerdict::Stopped;
        }
        let ball_a = &self.a.ball(a);
        let ball_b = &self.b.ball(b);
        let kept = self.kept_by_balls((a, ball_a), (b, ball_b));
        if self.interval.is_enough(kept) {
            return IntervalVerdict::Proved(kept);
        }
        if let Some(kept) = self.kept_by_piece_and_box((a, ball_a), (b, ball_b)) {
            return IntervalVerdict::Proved(kept);
        }
        if let Some(kept) = self.kept_by_whole_and_box(a, (b, ball_b)) {
            return IntervalVerdict::Proved(kept);
        }
        match self.opened(a, ball_a, ball_b) {
            Split::Neither(i, j) => self.decide_pieces((ball_a, i), (ball_b, j)),
            // The nearer child is the one that may refuse.
            Split::A(left, right) => {
                let [near, far] = nearer_first([left, right], |child| self.ball_gap(child, b));
                both(self.descend(near, b, looks), || self.descend(far, b, looks))
            }
            Split::B(left, right) => {
                let [near, far] = nearer_first([left, right], |child| self.ball_gap(a, child));
                both(self.descend(a, near, looks), || self.descend(a, far, looks))
            }
        }
    }

    #[inline]
    fn ball_gap(&self, a: u32, b: u32) -> f64 {
        let a = self.a.ball(a);
        let b = self.b.ball(b);
        self.interval
            .relative
            .point(a.center)
            .distance(b.center)
            - a.radius
            - b.radius
    }

    /// Distance that two balls keep on the interval; a ball with a convex piece around what it is over is
    /// that piece.
    fn kept_by_balls(&self, (i, a): (u32, &Ball), (j, b): (u32, &Ball)) -> f64 {
        let interval = self.interval;
        let center_a = interval.relative.point(a.center);
        let kept = if let Some(piece) = self.b.convex(j, b) {
            interval.kept_by_ball_and_piece(a, center_a, b, &piece)
        } else if let Some(piece) = self.a.convex(i, a) {
            interval.kept_by_piece_and_ball(a, &piece, center_a, b)
        } else {
            interval.kept_by_two_balls(a, center_a, b)
        };
        // Without a direction the theorem says nothing.
        kept.unwrap_or(f64::NEG_INFINITY)
    }

    /// What a single piece and the box of a cloud's node keep, if that is enough: the ball of a large
    /// piece would have the cloud opened down to its cells.
    fn kept_by_piece_and_box(
        &self,
        (i, ball_a): (u32, &Ball),
        (j, ball_b): (u32, &Ball),
    ) -> Option<f64> {
        if ball_a.is_leaf() == ball_b.is_leaf() {
            return None;
        }
        let piece_a = self.a.convex(i, ball_a)?;
        let piece_b = self.b.convex(j, ball_b)?;
        let piece_a = piece_a.transformed(&self.interval.relative);
        let reaches = (reach(ball_a, &piece_a), reach(ball_b, &piece_b));
        self.interval
            .kept_cheaply(&piece_a, &piece_b, reaches)
    }

    /// Which of two balls to open.
    fn opened(&self, a: u32, ball_a: &Ball, ball_b: &Ball) -> Split {
        match ball_b.content {
            Content::Balls(left, right)
                if a == 0
                    && B::HAS_BOXES
                    && self.interval.a.solid.tree.count() >= LARGE
                    && FINER * ball_b.radius > ball_a.radius =>
            {
                Split::B(left, right)
            }
            _ => query::children(ball_a, ball_b),
        }
    }

    /// What the hull of all of A and the box of a cloud's node keep, if that is enough.
    fn kept_by_whole_and_box(&self, a: u32, (j, ball_b): (u32, &Ball)) -> Option<f64> {
        let interval = self.interval;
        let is_large = interval.a.solid.tree.count() >= LARGE;
        if a != 0 || !is_large || ball_b.is_leaf() {
            return None;
        }
        let hull = interval.a.solid.convex_hull.as_ref()?;
        let part = self.b.convex(j, ball_b)?;
        let farthest =
            |along: Vec3| along.dot(part.core.support(along)) + along.length() * part.radius;
        let keeps = |normal: Vec3| {
            let kept = interval.kept_by_hulls(hull, farthest, normal);
            interval.is_enough(kept).then_some(kept)
        };
        let center_a = interval.relative.point(self.a.ball(0).center);
        let (outward, _) = from_piece(&part, center_a)?;
        keeps(outward).or_else(|| keeps(hull.direction_from(&interval.relative, &part.core)?))
    }

    fn decide_pieces(
        &self,
        (ball_a, i): (&Ball, u32),
        (ball_b, j): (&Ball, u32),
    ) -> IntervalVerdict {
        let interval = self.interval;
        let piece_a = self.a.piece(i).transformed(&interval.relative);
        let piece_b = &*self.b.piece(j);
        let reaches = (reach(ball_a, &piece_a), reach(ball_b, piece_b));
        // Most pairs of pieces are settled along a direction that costs no search.
        if let Some(kept) = interval.kept_cheaply(&piece_a, piece_b, reaches) {
            return IntervalVerdict::Proved(kept);
        }
        let apart = distance::separation(&piece_a, piece_b);
        if (apart.point_a - apart.point_b).dot(apart.normal) <= TOUCHING_M {
            return IntervalVerdict::Collision;
        }
        if apart.gap < interval.too_close {
            return IntervalVerdict::TooClose;
        }
        match interval.kept_by_pieces(&piece_a, piece_b, apart.normal, apart.gap, reaches) {
            kept if interval.is_enough(kept) => IntervalVerdict::Proved(kept),
            _ => IntervalVerdict::Split,
        }
    }
}

/// Direction from a piece to a point outside of it, and the support gap along it.
fn from_piece(piece: &Piece, point: Vec3) -> Option<(Vec3, f64)> {
    let offset = point - distance::closest_on(&piece.core, point);
    let length = offset.length();
    if length < TOUCHING_M {
        return None;
    }
    let normal = offset / length;
    // Along the same normal, never the distance that it was found with: a normal that is off by a
    // little would make that a lie, while this is a lower bound along any.
    let gap = normal.dot(point - piece.core.support(normal)) - piece.radius;
    Some((normal, gap))
}

/// Both must hold: a refusal wins over everything, a split over a proof.
fn both(first: IntervalVerdict, second: impl FnOnce() -> IntervalVerdict) -> IntervalVerdict {
    match first {
        IntervalVerdict::Proved(kept) => match second() {
            IntervalVerdict::Proved(other) => IntervalVerdict::Proved(kept.min(other)),
            undecided => undecided,
        },
        // The interval will be looked at again in halves; what is left of the trees waits for them.
        undecided => undecided,
    }
}
