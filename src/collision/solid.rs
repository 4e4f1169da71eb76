//! Solids: shapes made ready for checking, once, in their own frame. Where a solid stands, who
//! carries it and whom it may touch is said elsewhere, so that none of this makes anything anew.

use serde::{Deserialize, Serialize};

use super::filter::SolidHulls;
use super::filter::cover::{self, Ball};
use super::piece::Piece;
use super::shell::Shell;
use super::tree::BallTree;
use crate::math::Vec3;
use crate::shape::{PlacedShape, Shape};

/// Shapes that move as one, made ready for checking.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Solid {
    /// Its pieces, in its own frame.
    pub tree: BallTree,
    /// A point of every connected part of its surface, for asking whether the part is inside a
    /// mesh.
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
    pub shell: Option<Shell>,
}

impl Solid {
    /// The solid of at least one shape.
    pub fn new(shapes: &[PlacedShape]) -> Self {
        let mut pieces = Vec::new();
        let mut anchors = Vec::new();
        let mut hollow = false;
        let mut is_open = false;
        for placed in shapes {
            let first = pieces.len();
            Piece::append_of(placed, &mut pieces);
            match &placed.shape {
                Shape::Mesh(mesh) => {
                    hollow = true;
                    is_open |= !mesh.has_inside();
                    anchors.extend(
                        mesh.parts()
                            .into_iter()
                            .map(|vertex| placed.pose.transform_point(vertex)),
                    );
                }
                _ => anchors.extend(pieces[first..].iter().map(Piece::center)),
            }
        }
        let tree = BallTree::new(pieces);
        let cover = cover::balls(&tree);
        let hulls = SolidHulls::new(tree.pieces());
        let shell = Shell::new(&tree);
        Self {
            tree,
            anchors,
            hollow,
            is_open,
            cover,
            hulls,
            shell,
        }
    }

    /// All points within `padding` (m) of the solid. Pieces are cores swept by a ball, and so they
    /// stay: the ball is larger, the tree over them the same.
    #[must_use]
    pub fn padded(&self, padding: f64) -> Self {
        Self {
            tree: self.tree.padded(padding),
            anchors: self.anchors.clone(),
            hollow: self.hollow,
            is_open: self.is_open,
            cover: self.cover.iter().map(|ball| ball.padded(padding)).collect(),
            hulls: self.hulls.padded(padding),
            shell: self.shell.as_ref().map(|shell| shell.padded(padding)),
        }
    }
}
