//! What a query descends: a binary tree of balls over the pieces of a body.

use std::borrow::Cow;
use std::ops::Deref;

use serde::{Deserialize, Serialize};

pub use super::ball::{Ball, Content};
use super::cells::CellTree;
use super::piece::Piece;
use crate::math::Vec3;

/// The tree of a solid.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Tree {
    /// Over pieces of all kinds.
    Balls(BallTree),
    /// Over the cells of a cloud.
    #[serde(skip)]
    Cells(CellTree),
}

impl Tree {
    /// One ball; number 0 encloses all.
    #[inline]
    pub fn ball(&self, index: u32) -> Ball {
        match self {
            Self::Balls(tree) => tree.ball(index),
            Self::Cells(tree) => tree.ball(index),
        }
    }

    /// One piece.
    #[inline]
    pub fn piece(&self, index: u32) -> Cow<'_, Piece> {
        match self {
            Self::Balls(tree) => Cow::Borrowed(&tree.pieces()[index as usize]),
            Self::Cells(tree) => Cow::Owned(tree.piece(index)),
        }
    }

    /// All pieces, in tree order; those of a cloud are made for it.
    pub fn pieces(&self) -> Cow<'_, [Piece]> {
        match self {
            Self::Balls(tree) => tree.pieces().into(),
            Self::Cells(tree) => (0..tree.cloud().len() as u32)
                .map(|place| tree.piece(place))
                .collect(),
        }
    }

    /// Number of pieces.
    #[inline]
    pub fn count(&self) -> usize {
        match self {
            Self::Balls(tree) => tree.pieces().len(),
            Self::Cells(tree) => tree.cloud().len(),
        }
    }

    /// The tree over pieces of all kinds, if it is that.
    pub fn balls(&self) -> Option<&BallTree> {
        match self {
            Self::Balls(tree) => Some(tree),
            Self::Cells(_) => None,
        }
    }

    /// The tree over the cells of a cloud, if it is that.
    pub fn cells(&self) -> Option<&CellTree> {
        match self {
            Self::Balls(_) => None,
            Self::Cells(tree) => Some(tree),
        }
    }

    /// Whether some pieces are parts of a surface.
    pub fn has_surfaces(&self) -> bool {
        let mut pieces = self
            .balls()
            .map_or(&[][..], BallTree::pieces)
            .iter();
        pieces.any(|piece| piece.core.is_surface())
    }

    /// Farthest that the centre of a ball is from that of the first (m).
    pub fn spread(&self) -> f64 {
        match self {
            Self::Balls(tree) => {
                let root = tree.balls()[0];
                let centers = tree
                    .balls()
                    .iter()
                    .map(|ball| ball.center.distance(root.center));
                centers.fold(0.0, f64::max)
            }
            // They are all in the box of the first.
            Self::Cells(tree) => tree.ball(0).radius,
        }
    }

    /// The tree of the same pieces, all of them thicker by `padding` (m).
    #[must_use]
    pub fn padded(&self, padding: f64) -> Self {
        match self {
            Self::Balls(tree) => Self::Balls(tree.padded(padding)),
            Self::Cells(tree) => Self::Cells(tree.padded(padding)),
        }
    }

    /// Memory that it takes (bytes).
    pub fn bytes(&self) -> usize {
        match self {
            Self::Balls(tree) => tree.bytes(),
            Self::Cells(tree) => tree.bytes(),
        }
    }
}

/// What a search of two bodies sees of a tree. Searches are made for each kind of tree
/// (`by_kind!`), so that no look at a node asks which one it is.
pub trait Nodes {
    /// Whether nodes that are no leaves have convex pieces.
    const HAS_BOXES: bool;
    /// A piece that the tree has, or makes.
    type Held<'a>: Deref<Target = Piece>
    where
        Self: 'a;

    /// One ball; number 0 encloses all.
    fn ball(&self, index: u32) -> Ball;

    /// A convex piece around all that a ball is over, and about its centre, where there is a
    /// closer one than the ball: the only piece below it, or the box of a cloud's node.
    fn convex(&self, index: u32, ball: &Ball) -> Option<Self::Held<'_>>;

    /// One piece.
    fn piece(&self, index: u32) -> Self::Held<'_>;
}

impl Nodes for BallTree {
    const HAS_BOXES: bool = false;
    type Held<'a> = &'a Piece;

    #[inline]
    fn ball(&self, index: u32) -> Ball {
        self.balls[index as usize]
    }

    #[inline]
    fn convex(&self, _: u32, ball: &Ball) -> Option<&Piece> {
        match ball.content {
            Content::Piece(index) => Some(&self.pieces[index as usize]),
            Content::Balls(..) => None,
        }
    }

    #[inline]
    fn piece(&self, index: u32) -> &Piece {
        &self.pieces[index as usize]
    }
}

/// A piece that was made for whoever looks at it.
pub struct Made(Piece);

impl Deref for Made {
    type Target = Piece;

    #[inline]
    fn deref(&self) -> &Piece {
        &self.0
    }
}

impl Nodes for CellTree {
    const HAS_BOXES: bool = true;
    type Held<'a> = Made;

    #[inline]
    fn ball(&self, index: u32) -> Ball {
        Self::ball(self, index)
    }

    #[inline]
    fn convex(&self, index: u32, _: &Ball) -> Option<Made> {
        Some(Made(self.box_of(index)))
    }

    #[inline]
    fn piece(&self, index: u32) -> Made {
        Made(Self::piece(self, index))
    }
}

/// Makes something for each pair of kinds that two trees may be of.
macro_rules! by_kind {
    ($tree_a:expr, $tree_b:expr, |$a:ident, $b:ident| $made:expr) => {{
        use crate::solid::tree::Tree;
        match ($tree_a, $tree_b) {
            (Tree::Balls($a), Tree::Balls($b)) => $made,
            (Tree::Balls($a), Tree::Cells($b)) => $made,
            (Tree::Cells($a), Tree::Balls($b)) => $made,
            (Tree::Cells($a), Tree::Cells($b)) => $made,
        }
    }};
}
pub(crate) use by_kind;

/// Pieces of a body and the balls over them; ball 0 encloses all.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct BallTree {
    pieces: Vec<Piece>,
    balls: Vec<Ball>,
}

/// Steps of the centre towards the farthest point; the radius is within a few per cent of the best
/// after these.
const CENTERING_STEPS: usize = 10;
/// Pieces among which each step looks for the farthest; of more, as many lead and are joined by
/// those left outside.
const LEADERS: usize = 512;
/// How often the farthest of all pieces joins the leaders.
const ROUNDS: usize = 4;
/// Added to each radius, relative: covers the rounding of the distances it was made of.
const ROUNDING: f64 = 1e-12;

impl BallTree {
    /// Builds the tree; `pieces` is not empty.
    pub fn new(pieces: Vec<Piece>) -> Self {
        let mut balls = Vec::with_capacity(2 * pieces.len());
        // Pieces are large: only their numbers and centres are sorted.
        let number = |(index, piece): (usize, &Piece)| Place {
            center: piece.center(),
            piece: index as u32,
        };
        let mut places: Vec<Place> = pieces.iter().enumerate().map(number).collect();
        build(&pieces, &mut places, 0, &mut balls);
        let pieces = places
            .iter()
            .map(|place| pieces[place.piece as usize])
            .collect();
        Self { pieces, balls }
    }

    /// The tree of the same pieces, all of them thicker by `padding` (m).
    #[must_use]
    pub fn padded(&self, padding: f64) -> Self {
        let thicker = |piece: &Piece| Piece {
            radius: piece.radius + padding,
            ..*piece
        };
        let wider = |ball: &Ball| Ball {
            radius: (ball.radius + padding) * (1.0 + ROUNDING),
            ..*ball
        };
        Self {
            pieces: self.pieces.iter().map(thicker).collect(),
            balls: self.balls.iter().map(wider).collect(),
        }
    }

    /// Memory of pieces and balls (bytes).
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.pieces) + size_of::<Ball>() * self.balls.capacity()
    }

    /// The pieces, in tree order.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }
    /// The balls; the first encloses all.
    pub fn balls(&self) -> &[Ball] {
        &self.balls
    }
    /// A point of a core that gets farthest along `direction`.
    pub fn farthest_along(&self, direction: Vec3) -> Vec3 {
        let mut farthest = (f64::NEG_INFINITY, Vec3::ZERO);
        self.look_along(0, direction, &mut farthest);
        farthest.1
    }

    fn look_along(&self, ball: u32, direction: Vec3, farthest: &mut (f64, Vec3)) {
        match self.ball(ball).content {
            Content::Piece(index) => {
                let point = self.pieces[index as usize]
                    .core
                    .support(direction);
                let along = direction.dot(point);
                if along > farthest.0 {
                    *farthest = (along, point);
                }
            }
            Content::Balls(left, right) => {
                let length = direction.length();
                let reach = |ball: u32| {
                    direction.dot(self.ball(ball).center) + length * self.ball(ball).radius
                };
                let mut first = (reach(left), left);
                let mut second = (reach(right), right);
                if second.0 > first.0 {
                    (first, second) = (second, first);
                }
                for (reach, ball) in [first, second] {
                    if reach > farthest.0 {
                        self.look_along(ball, direction, farthest);
                    }
                }
            }
        }
    }
}

/// A piece in the order that the tree gives it.
#[derive(Clone, Copy)]
struct Place {
    center: Vec3,
    piece: u32,
}

/// Appends the ball over `places` (the first of which is number `first`) and all below it; returns
/// its index.
fn build(pieces: &[Piece], places: &mut [Place], first: u32, balls: &mut Vec<Ball>) -> u32 {
    let (center, radius) = enclosing_ball(pieces, places);
    let index = balls.len() as u32;
    balls.push(Ball {
        center,
        radius,
        content: Content::Piece(first),
    });
    if places.len() > 1 {
        let axis = widest_axis(places);
        let half = places.len() / 2;
        places.select_nth_unstable_by(half, |a, b| a.center[axis].total_cmp(&b.center[axis]));
        let (low, high) = places.split_at_mut(half);
        let left = build(pieces, low, first, balls);
        let right = build(pieces, high, first + half as u32, balls);
        balls[index as usize].content = Content::Balls(left, right);
    }
    index
}

fn widest_axis(places: &[Place]) -> usize {
    let mut low = Vec3::INFINITY;
    let mut high = Vec3::NEG_INFINITY;
    for place in places {
        low = low.min(place.center);
        high = high.max(place.center);
    }
    let size = high - low;
    (0..3)
        .max_by(|&a, &b| size[a].total_cmp(&size[b]))
        .unwrap_or(0)
}

/// Nearly smallest enclosing ball. Of many pieces a few lead: the ball around them is taken, and
/// the piece that is farthest outside it joins them. The radius is measured over all pieces at the
/// centre taken, so it encloses whatever led there.
fn enclosing_ball(pieces: &[Piece], places: &[Place]) -> (Vec3, f64) {
    if places.len() <= 2 * LEADERS {
        return walk(pieces, places);
    }
    let mut leaders: Vec<Place> = places
        .iter()
        .step_by(places.len() / LEADERS)
        .copied()
        .collect();
    let mut best = (Vec3::ZERO, f64::INFINITY);
    for _ in 0..ROUNDS {
        let center = walk(pieces, &leaders).0;
        let (farthest, radius) = farthest(pieces, places, center);
        if radius < best.1 {
            best = (center, radius);
        }
        leaders.push(farthest);
    }
    (best.0, best.1 * (1.0 + ROUNDING))
}

/// The centre walks towards the farthest piece by ever smaller steps (Bădoiu and Clarkson, 2003);
/// gives the best centre on the way and the radius there.
fn walk(pieces: &[Piece], places: &[Place]) -> (Vec3, f64) {
    let mut center = places
        .iter()
        .map(|place| place.center)
        .sum::<Vec3>()
        / places.len() as f64;
    let mut best = (center, f64::INFINITY);
    let steps = if places.len() > 1 { CENTERING_STEPS } else { 0 };
    for step in 0..=steps {
        let (towards, radius) = farthest(pieces, places, center);
        if radius < best.1 {
            best = (center, radius);
        }
        center += (towards.center - center) / (step as f64 + 2.0);
    }
    (best.0, best.1 * (1.0 + ROUNDING))
}

/// The piece that reaches farthest from a point, and how far that is (m).
fn farthest(pieces: &[Piece], places: &[Place], from: Vec3) -> (Place, f64) {
    let mut best = places[0];
    let mut square = -1.0;
    for place in places {
        let reach = pieces[place.piece as usize].farthest_squared(from);
        if reach > square {
            best = *place;
            square = reach;
        }
    }
    (best, square.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::core::Core;
    use crate::testing::vector;

    /// Every ball of a body of many pieces holds all that is below it, and the first is nearly the
    /// smallest.
    #[test]
    fn balls_enclose_the_pieces_below_them_however_few_of_them_led() {
        let mut rng = fastrand::Rng::with_seed(7);
        let triangle = |rng: &mut fastrand::Rng| {
            let corner = vector(rng, 1.0).normalize_or_zero() * 0.3;
            let b = corner + vector(rng, 0.01);
            let c = corner + vector(rng, 0.01);
            Piece {
                core: Core::Triangle(corner, b, c),
                radius: 0.0,
            }
        };
        let mut pieces: Vec<Piece> = (0..5000).map(|_| triangle(&mut rng)).collect();
        // A spike that few would meet by chance.
        pieces[3333] = Piece {
            core: Core::Triangle(Vec3::X * 0.3, Vec3::X * 0.6, Vec3::Y * 0.3),
            radius: 0.0,
        };
        let tree = BallTree::new(pieces.clone());
        for ball in tree.balls() {
            let mut below = vec![ball.content];
            while let Some(content) = below.pop() {
                match content {
                    Content::Balls(left, right) => {
                        below.extend([tree.ball(left).content, tree.ball(right).content]);
                    }
                    Content::Piece(index) => {
                        let reach = tree.pieces()[index as usize].farthest(ball.center);
                        assert!(reach <= ball.radius, "{reach} > {}", ball.radius);
                    }
                }
            }
        }
        let mut held: Vec<_> = tree
            .pieces()
            .iter()
            .map(|piece| piece.center().to_array().map(f64::to_bits))
            .collect();
        let mut given: Vec<_> = pieces
            .iter()
            .map(|piece| piece.center().to_array().map(f64::to_bits))
            .collect();
        held.sort_unstable();
        given.sort_unstable();
        assert!(held == given, "every piece is there once");
        // From −0.3 to 0.6 along x.
        assert!(tree.ball(0).radius < 1.03 * 0.46, "{}", tree.ball(0).radius);
    }
}
