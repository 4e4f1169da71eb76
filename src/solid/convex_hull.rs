//! The convex hull of a solid, a little too large: some of its outermost points, and how far it
//! reaches beyond them.

use serde::{Deserialize, Serialize};

use super::core::Core;
use super::distance;
use super::transform::Transform;
use super::tree::BallTree;
use crate::math::Vec3;

/// Points and a slack: the solid is within `slack` of the points' convex hull.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ConvexHull {
    corners: Vec<Vec3>,
    slack: f64,
}

/// Directions along which corners are looked for.
const CORNERS: usize = 128;
/// Points beyond the hull of those that become corners too.
const MORE_CORNERS: usize = 32;
/// Solids of more pieces get no convex_hull: every point of them would have to be measured.
const MOST_PIECES: usize = 32_768;
/// Allowed for the rounding of a point's distance from the hull (m).
const ROUNDING_M: f64 = 1e-7;

impl ConvexHull {
    /// The convex_hull of a solid; `None` for one of too many pieces.
    pub fn new(tree: &BallTree) -> Option<Self> {
        if tree.pieces().len() > MOST_PIECES {
            return None;
        }
        let mut corners: Vec<_> = (0..CORNERS)
            .map(|index| tree.farthest_along(direction(index, CORNERS)))
            .collect();
        sort_out(&mut corners);
        let mut points = Vec::new();
        let mut round = 0.0_f64;
        for piece in tree.pieces() {
            round = round.max(piece.radius + piece.core.outline(&mut points));
        }
        sort_out(&mut points);
        let mut beyond: Vec<_> = points
            .into_iter()
            .map(|point| (distance::from_hull(&corners, point), point))
            .collect();
        beyond.sort_by(|a, b| b.0.total_cmp(&a.0));
        // Those that are farthest from the hull, or could not be measured well, become corners
        // themselves.
        let farther = beyond.len().min(MORE_CORNERS);
        corners.extend(
            beyond
                .drain(..farther)
                .filter(|(distance, _)| *distance > ROUNDING_M)
                .map(|(_, point)| point),
        );
        sort_out(&mut corners);
        let slack = beyond
            .first()
            .map_or(0.0, |(distance, _)| *distance);
        Some(Self {
            corners,
            slack: slack + round + ROUNDING_M,
        })
    }

    /// Memory of the corners (bytes).
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.corners)
    }

    /// The hull of the same solid, thicker by `padding` (m).
    #[must_use]
    pub fn padded(&self, padding: f64) -> Self {
        Self {
            corners: self.corners.clone(),
            slack: self.slack + padding,
        }
    }

    /// Direction from B's hull to A's, which `relative` places in B's frame; `None` where they
    /// overlap.
    pub fn direction(a: &Self, relative: &Transform, b: &Self) -> Option<Vec3> {
        distance::direction_between(&a.corners, relative, &b.corners)
    }

    /// Direction from a box to the hull, which `relative` places in the box's frame; `None` where they
    /// overlap or the core is none.
    pub fn direction_from(&self, relative: &Transform, core: &Core) -> Option<Vec3> {
        distance::direction_between(&self.corners, relative, &core.box_corners()?)
    }

    /// At least the farthest that any point of the solid gets along `direction`, times its length
    /// (m).
    pub fn farthest_along(&self, direction: Vec3) -> f64 {
        let farthest = self
            .corners
            .iter()
            .map(|corner| corner.dot(direction))
            .fold(f64::NEG_INFINITY, f64::max);
        farthest + direction.length() * self.slack
    }
}

/// One of so many directions that are spread evenly, on a spiral by the golden angle.
pub(super) fn direction(index: usize, count: usize) -> Vec3 {
    const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
    let height = 1.0 - (2 * index + 1) as f64 / count as f64;
    let (sine, cosine) = (GOLDEN_ANGLE * index as f64).sin_cos();
    let across = (1.0 - height * height).sqrt();
    Vec3::new(across * cosine, across * sine, height)
}

fn sort_out(points: &mut Vec<Vec3>) {
    points.sort_unstable_by(|a, b| {
        a.x.total_cmp(&b.x)
            .then(a.y.total_cmp(&b.y))
            .then(a.z.total_cmp(&b.z))
    });
    points.dedup();
}

#[cfg(test)]
mod tests {
    use crate::testing;
    use crate::validation::soundness::cases;

    #[test]
    fn a_shell_encloses_its_solid_and_not_much_more() {
        let (count, mut rng) = cases(300);
        let mut slack = 0.0;
        let mut size = 0.0;
        for _ in 0..count {
            let model = testing::model(&mut rng);
            for body in model.bodies() {
                let convex_hull = body.solid.convex_hull.as_ref().unwrap();
                let directions: Vec<_> = (0..50)
                    .map(|_| testing::vector(&mut rng, 1.0))
                    .collect();
                let pieces = body.solid.tree.pieces();
                for (piece, &along) in pieces
                    .iter()
                    .flat_map(|piece| directions.iter().map(move |d| (piece, d)))
                {
                    let farthest =
                        along.dot(piece.core.support(along)) + along.length() * piece.radius;
                    assert!(
                        farthest <= convex_hull.farthest_along(along),
                        "{farthest} along {along}"
                    );
                }
                let round = pieces
                    .iter()
                    .map(|piece| piece.radius)
                    .fold(0.0, f64::max);
                slack += convex_hull.slack - round;
                size += body.solid.tree.ball(0).radius;
            }
        }
        assert!(slack < 0.1 * size, "{slack} of {size}");
    }
}
