//! Balls: the nodes of trees.

use serde::{Deserialize, Serialize};

use crate::math::Vec3;

/// A ball that encloses the pieces below it, in the body's frame.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Ball {
    /// Centre (m).
    pub center: Vec3,
    /// Radius (m).
    pub radius: f64,
    /// What it encloses.
    pub content: Content,
}

/// What a ball encloses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Content {
    /// One piece, by index.
    Piece(u32),
    /// Two balls, by index.
    Balls(u32, u32),
}

impl Ball {
    /// Whether it is over one piece.
    #[inline]
    pub fn is_leaf(&self) -> bool {
        matches!(self.content, Content::Piece(_))
    }
}
