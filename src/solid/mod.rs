//! Solids: shapes made ready for checking, once, in their own frame, and what is asked of two of
//! them: how far apart they are, where they touch, how deep they overlap. Where a solid stands, who
//! carries it and whom it may touch is said elsewhere, so that none of this makes anything anew.

// A new kind of shape, core or joint is an error here, not another one's arm.
#![deny(clippy::wildcard_enum_match_arm)]

mod ball;
pub mod cells;
pub mod contact;
pub mod convex_hull;
pub mod core;
pub mod cover;
pub mod distance;
pub mod hulls;
mod inside;
pub mod near;
pub mod penetration;
pub mod piece;
pub mod query;
pub mod transform;
pub mod tree;

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::math::{Pose, Vec3};
use crate::shape::{Cloud, PlacedShape};
use cells::CellTree;
use convex_hull::ConvexHull;
use cover::Ball;
use hulls::SolidHulls;
use piece::Piece;
use tree::{BallTree, Tree};

pub use contact::{Contact, TOUCHING_M};
pub use transform::Transform;

/// Shapes that move as one, made ready for checking.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Solid {
    /// Where its own frame is in that of its shapes; `None` where it is that.
    #[serde(skip)]
    pub frame: Option<Transform>,
    /// Its pieces, in its own frame.
    pub tree: Tree,
    /// A point of every connected part of its surface, for asking whether the part is inside a
    /// mesh. Of a cloud, whose parts are as many as its cells, the tree is asked instead.
    pub anchors: Vec<Vec3>,
    /// Pieces that belong to closed surfaces (mesh triangles): only these can hide something
    /// inside.
    pub hollow: bool,
    /// Some of these surfaces are not closed or do not face one way: what is inside of them is a
    /// guess.
    pub is_open: bool,
    /// Balls that enclose it together: what the filter sees of it where it moves.
    pub cover: Vec<Ball>,
    /// Boxes and cylinders that enclose it: what the filter sees of it where it stands.
    pub hulls: SolidHulls,
    /// Its convex hull, a little too large, unless it has too many pieces.
    pub convex_hull: Option<ConvexHull>,
}

impl Solid {
    /// The solid of at least one shape.
    pub fn new(shapes: &[PlacedShape]) -> Self {
        match shapes {
            [only] => match only.shape.cloud() {
                Some(cloud) => Self::of_cloud(cloud, &only.pose),
                None => Self::of_pieces(shapes),
            },
            _ => Self::of_pieces(shapes),
        }
    }

    /// The solid of a cloud, in a frame of its own: about the cloud's origin, so that numbers are small
    /// wherever that is, and along the axes of its boxes.
    fn of_cloud(cloud: &Arc<Cloud>, pose: &Pose) -> Self {
        let cells = CellTree::new(cloud.clone());
        let hulls = SolidHulls::of_cells(&cells);
        let tree = Tree::Cells(cells);
        Self {
            frame: Some(Transform::from(pose).of(&Transform::shift(cloud.origin()))),
            cover: cover::balls(&tree),
            tree,
            anchors: Vec::new(),
            hollow: false,
            is_open: false,
            hulls,
            convex_hull: None,
        }
    }

    fn of_pieces(shapes: &[PlacedShape]) -> Self {
        let mut pieces = Vec::new();
        let mut anchors = Vec::new();
        let mut hollow = false;
        let mut is_open = false;
        for placed in shapes {
            let first = pieces.len();
            Piece::append_of(placed, &mut pieces);
            match placed.shape.mesh() {
                Some(mesh) => {
                    hollow = true;
                    is_open |= !mesh.has_inside();
                    anchors.extend(
                        mesh.parts()
                            .into_iter()
                            .map(|vertex| placed.pose.transform_point(vertex)),
                    );
                }
                None => anchors.extend(pieces[first..].iter().map(Piece::center)),
            }
        }
        let balls = BallTree::new(pieces);
        let hulls = SolidHulls::new(balls.pieces());
        let convex_hull = ConvexHull::new(&balls);
        let tree = Tree::Balls(balls);
        Self {
            frame: None,
            cover: cover::balls(&tree),
            tree,
            anchors,
            hollow,
            is_open,
            hulls,
            convex_hull,
        }
    }

    /// Memory that it takes (bytes).
    pub fn bytes(&self) -> usize {
        let convex_hull = self.convex_hull.as_ref();
        size_of::<Self>()
            + self.tree.bytes()
            + size_of_val(&*self.anchors)
            + size_of_val(&*self.cover)
            + self.hulls.bytes()
            + convex_hull.map_or(0, ConvexHull::bytes)
    }

    /// Where its own frame is, with its shapes' frame at `place`.
    pub fn placed(&self, place: Transform) -> Transform {
        self.frame
            .map_or(place, |frame| place.of(&frame))
    }

    /// All points within `padding` (m) of the solid. Pieces are cores swept by a ball, and so they
    /// stay: the ball is larger, the tree over them the same.
    #[must_use]
    pub fn padded(&self, padding: f64) -> Self {
        Self {
            frame: self.frame,
            tree: self.tree.padded(padding),
            anchors: self.anchors.clone(),
            hollow: self.hollow,
            is_open: self.is_open,
            cover: self
                .cover
                .iter()
                .map(|ball| ball.padded(padding))
                .collect(),
            hulls: self.hulls.padded(padding),
            convex_hull: self
                .convex_hull
                .as_ref()
                .map(|convex_hull| convex_hull.padded(padding)),
        }
    }
}
