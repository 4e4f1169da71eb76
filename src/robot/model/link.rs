//! A link of a robot.

use crate::shape::PlacedShape;

/// A link and its collision shapes in the link's frame.
#[derive(Clone, Debug)]
pub struct Link {
    /// Name.
    pub name: String,
    /// Collision shapes; often none.
    pub shapes: Vec<PlacedShape>,
}
