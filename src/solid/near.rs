//! How far a point is from a solid, where that is near.

use super::Solid;
use super::cover::Ball;
use super::distance::closest_on;
use super::inside::probably_contains;
use super::piece::Piece;
use super::tree::{Content, Tree};
use crate::math::Vec3;

/// Distance (m) from a point, in the solid's frame, to the solid, where that is at most `most` (m);
/// 0 inside. Of a mesh that is not closed only the surface counts.
pub fn distance_up_to(solid: &Solid, point: Vec3, most: f64) -> Option<f64> {
    let mut search = Search {
        tree: &solid.tree,
        point,
        nearest: most,
        found: None,
    };
    search.descend(0);
    let is_inside = || solid.hollow && !solid.is_open && is_in_mesh(solid, point);
    match search.found {
        Some(0.0) => Some(0.0),
        _ if is_inside() => Some(0.0),
        found => found,
    }
}

/// Rays are for what bounds leave open.
fn is_in_mesh(solid: &Solid, point: Vec3) -> bool {
    let is_in = |ball: &Ball| point.distance(ball.center) <= ball.radius;
    let balls = solid.tree.balls();
    solid.cover.iter().any(is_in) && balls.is_some_and(|balls| probably_contains(balls, point))
}

struct Search<'a> {
    tree: &'a Tree,
    point: Vec3,
    /// What is farther does not matter (m).
    nearest: f64,
    found: Option<f64>,
}

impl Search<'_> {
    fn descend(&mut self, index: u32) {
        let ball = self.tree.ball(index);
        if self.gap(index) > self.nearest {
            return;
        }
        match ball.content {
            Content::Piece(piece) => self.look(&self.tree.piece(piece)),
            Content::Balls(left, right) => {
                let [first, second] = match self.gap(left) <= self.gap(right) {
                    true => [left, right],
                    false => [right, left],
                };
                self.descend(first);
                self.descend(second);
            }
        }
    }

    fn gap(&self, index: u32) -> f64 {
        let ball = self.tree.ball(index);
        ball.center.distance(self.point) - ball.radius
    }

    fn look(&mut self, piece: &Piece) {
        let closest = closest_on(&piece.core, self.point);
        let distance = (closest.distance(self.point) - piece.radius).max(0.0);
        if distance <= self.nearest {
            self.nearest = distance;
            self.found = Some(distance);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Pose;
    use crate::shape::{PlacedShape, Shape};

    #[test]
    fn what_is_near_has_its_distance_and_what_is_far_has_none() {
        let placed = |shape, x| PlacedShape {
            pose: Pose::from_translation(Vec3::X * x),
            shape,
        };
        let solid = Solid::new(&[
            placed(Shape::sphere(0.1).unwrap(), 0.0),
            placed(Shape::cuboid(Vec3::splat(0.2)).unwrap(), 1.0),
        ]);
        let distance = |x: f64| distance_up_to(&solid, Vec3::X * x, 0.05);
        assert_eq!(distance(0.0), Some(0.0));
        assert!((distance(0.12).unwrap() - 0.02).abs() < 1e-12);
        assert_eq!(distance(0.5), None);
        assert_eq!(distance(1.0), Some(0.0));
    }
}
