//! A tree of balls over the pieces of a body: what a query descends.

use super::piece::Piece;
use crate::math::Vec3;

/// A ball that encloses the pieces below it, in the body's frame.
#[derive(Clone, Copy, Debug)]
pub struct Ball {
    /// Centre (m).
    pub center: Vec3,
    /// Radius (m).
    pub radius: f64,
    /// What it encloses.
    pub content: Content,
}

/// What a ball encloses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// One piece, by index.
    Piece(u32),
    /// Two balls, by index.
    Balls(u32, u32),
}

/// Pieces of a body and the balls over them; ball 0 encloses all.
#[derive(Clone, Debug)]
pub struct BallTree {
    pieces: Vec<Piece>,
    balls: Vec<Ball>,
}

/// Steps of the centre towards the farthest point; the radius is within a few per cent of the best after these.
const CENTERING_STEPS: usize = 10;
/// Added to each radius, relative: covers the rounding of the distances it was made of.
const ROUNDING: f64 = 1e-12;

impl BallTree {
    /// Builds the tree; `pieces` is not empty.
    pub fn new(mut pieces: Vec<Piece>) -> Self {
        let mut balls = Vec::with_capacity(2 * pieces.len());
        build(&mut pieces, 0, &mut balls);
        Self { pieces, balls }
    }

    /// The tree of the same pieces, all of them thicker by `padding` (m).
    #[must_use]
    pub fn padded(&self, padding: f64) -> Self {
        let thicker = |piece: &Piece| Piece { radius: piece.radius + padding, ..*piece };
        let wider = |ball: &Ball| Ball { radius: (ball.radius + padding) * (1.0 + ROUNDING), ..*ball };
        Self { pieces: self.pieces.iter().map(thicker).collect(), balls: self.balls.iter().map(wider).collect() }
    }

    /// The pieces, in tree order.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }
    /// The balls; the first encloses all.
    pub fn balls(&self) -> &[Ball] {
        &self.balls
    }
    /// One ball.
    pub fn ball(&self, index: u32) -> &Ball {
        &self.balls[index as usize]
    }
    /// The piece below a ball, where it is only one.
    pub fn leaf(&self, ball: &Ball) -> Option<&Piece> {
        match ball.content {
            Content::Piece(index) => Some(&self.pieces[index as usize]),
            Content::Balls(..) => None,
        }
    }
}

/// Appends the ball over `pieces` (the first of which is number `first`) and all below it; returns its index.
fn build(pieces: &mut [Piece], first: u32, balls: &mut Vec<Ball>) -> u32 {
    let (center, radius) = enclosing_ball(pieces);
    let index = balls.len() as u32;
    balls.push(Ball { center, radius, content: Content::Piece(first) });
    if pieces.len() > 1 {
        let axis = widest_axis(pieces);
        let key = |piece: &Piece| piece.center()[axis];
        let half = pieces.len() / 2;
        pieces.select_nth_unstable_by(half, |a, b| key(a).total_cmp(&key(b)));
        let (low, high) = pieces.split_at_mut(half);
        let left = build(low, first, balls);
        let right = build(high, first + half as u32, balls);
        balls[index as usize].content = Content::Balls(left, right);
    }
    index
}

fn widest_axis(pieces: &[Piece]) -> usize {
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for piece in pieces {
        low = low.min(piece.center());
        high = high.max(piece.center());
    }
    let size = high - low;
    (0..3).max_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or(0)
}

/// Nearly smallest enclosing ball: the centre walks towards the farthest piece by ever smaller steps
/// (Bădoiu and Clarkson, 2003); the radius is measured at the centre taken, so it encloses whatever the walk.
fn enclosing_ball(pieces: &[Piece]) -> (Vec3, f64) {
    let mut center = pieces.iter().map(Piece::center).sum::<Vec3>() / pieces.len() as f64;
    let mut best = (center, f64::INFINITY);
    let steps = if pieces.len() > 1 { CENTERING_STEPS } else { 0 };
    for step in 0..=steps {
        let (mut towards, mut radius) = (center, 0.0);
        for piece in pieces {
            let reach = piece.farthest(center);
            if reach > radius {
                (towards, radius) = (piece.center(), reach);
            }
        }
        if radius < best.1 {
            best = (center, radius);
        }
        center += (towards - center) / (step as f64 + 2.0);
    }
    (best.0, best.1 * (1.0 + ROUNDING))
}
