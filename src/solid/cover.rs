//! Balls that together enclose a body: what the filter sees of it.

use serde::{Deserialize, Serialize};

use super::core::Length;
use super::piece::Piece;
use super::tree::{Content, Tree};
use crate::math::Vec3;

/// A ball that encloses a part of a body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ball {
    /// Centre (m).
    pub center: Vec3,
    /// Radius (m).
    pub radius: f64,
}

impl Ball {
    /// The ball around what the ball encloses, made thicker by `padding` (m).
    #[must_use]
    pub fn padded(&self, padding: f64) -> Self {
        Self {
            radius: (self.radius + padding) * (1.0 + ROUNDING),
            ..*self
        }
    }
}

/// Balls over parts of a mesh: more of them are tighter, and dearer where nothing is near.
const MESH_BALLS: usize = 32;
/// Slices of a long piece, one ball each.
const SLICES: usize = 6;
/// Balls of a cluster.
const CLUSTER: usize = 6;
/// Relative, covers the rounding of what a radius was computed from.
const ROUNDING: f64 = 1e-9;

/// The balls over a body's pieces. A mesh or cloud gives balls of its tree, a long piece one for each slice.
pub fn balls(tree: &Tree) -> Vec<Ball> {
    let is_fine = tree.has_surfaces() || tree.balls().is_none();
    let mut open = vec![0_u32];
    let mut balls: Vec<Ball> = Vec::new();
    while let Some(at) = widest(&open, tree) {
        let index = open.swap_remove(at);
        let ball = tree.ball(index);
        match ball.content {
            // Everything that is not a triangle is worth its own balls.
            Content::Balls(left, right) if open.len() + balls.len() < MESH_BALLS || !is_fine => {
                open.extend([left, right]);
            }
            Content::Balls(..) => balls.push(Ball {
                center: ball.center,
                radius: ball.radius,
            }),
            Content::Piece(piece) => slices(&tree.piece(piece), &mut balls),
        }
    }
    balls
}

fn widest(open: &[u32], tree: &Tree) -> Option<usize> {
    (0..open.len()).max_by(|&i, &j| {
        tree.ball(open[i])
            .radius
            .total_cmp(&tree.ball(open[j]).radius)
    })
}

/// Cuts a piece across its longest direction, so that each slice is about as long as it is wide.
fn slices(piece: &Piece, balls: &mut Vec<Ball>) {
    let Some(Length {
        center,
        along,
        half,
        across,
    }) = piece.core.length()
    else {
        let center = piece.center();
        return balls.push(Ball {
            center,
            radius: piece.farthest(center) * (1.0 + ROUNDING),
        });
    };
    let width = (across + piece.radius)
        .max(half / SLICES as f64)
        .max(f64::MIN_POSITIVE);
    let count = (half / width).ceil().clamp(1.0, SLICES as f64);
    let step = half / count;
    for slice in 0..count as usize {
        let at = center + along * (step * (2 * slice + 1) as f64 - half);
        balls.push(Ball {
            center: at,
            radius: (across.hypot(step) + piece.radius) * (1.0 + ROUNDING),
        });
    }
}

/// A nearly smallest ball around balls: the centre walks towards the farthest by ever smaller
/// steps.
pub fn around(balls: &[Ball]) -> Ball {
    let mut center = balls
        .iter()
        .map(|ball| ball.center)
        .sum::<Vec3>()
        / balls.len() as f64;
    let mut best = Ball {
        center,
        radius: f64::INFINITY,
    };
    for step in 0..64 {
        let reach = |ball: &Ball| ball.center.distance(center) + ball.radius;
        let Some(farthest) = balls
            .iter()
            .max_by(|a, b| reach(a).total_cmp(&reach(b)))
        else {
            break;
        };
        let radius = reach(farthest) * (1.0 + ROUNDING);
        if radius < best.radius {
            best = Ball { center, radius };
        }
        center += (farthest.center - center) / f64::from(step + 2);
    }
    best
}

/// Groups the balls into clusters, near ones together; returns where each cluster begins, and the
/// end.
pub fn cluster(balls: &mut [Ball]) -> Vec<usize> {
    let mut starts = Vec::new();
    group(balls, 0, &mut starts);
    starts.push(balls.len());
    starts
}

fn group(balls: &mut [Ball], first: usize, starts: &mut Vec<usize>) {
    if balls.len() <= CLUSTER {
        return starts.push(first);
    }
    let (low, high) = balls
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), ball| {
            (low.min(ball.center), high.max(ball.center))
        });
    let size = high - low;
    let axis = (0..3)
        .max_by(|&i, &j| size[i].total_cmp(&size[j]))
        .unwrap_or(0);
    balls.sort_by(|a, b| a.center[axis].total_cmp(&b.center[axis]));
    let half = balls.len() / 2;
    let (left, right) = balls.split_at_mut(half);
    group(left, first, starts);
    group(right, first + half, starts);
}
