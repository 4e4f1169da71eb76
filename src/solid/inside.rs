//! Whether a point is inside the meshes of a solid.

use std::f64::consts::PI;

use super::Solid;
use super::cells::CellTree;
use super::convex_hull;
use super::distance::closest_on;
use super::piece::Piece;
use super::transform::Transform;
use super::tree::{BallTree, Content, Nodes};
use crate::math::Vec3;
use crate::shape::solid_angle;

/// Rays that look for a way out of a surface that is not closed.
const RAYS: usize = 64;
/// Of these, as many may find one from a place that counts as inside however the surface faces:
/// gaps.
const GAPS: usize = RAYS / 10;
/// How far beside a triangle a ray still meets it, relative to the triangle: no ray slips between
/// two of them.
const RIM: f64 = 1e-9;

/// Whether a point is inside, by the winding number (Jacobson, Kavan and Sorkine-Hornung, 2013),
/// which is sure for surfaces that are closed and face one way. For others it is a guess, which
/// counts where the surface hides the point from half of all directions; and where it hides it from
/// nearly all, the point is inside however triangles face.
pub(super) fn contains(solid: &Solid, point: Vec3) -> bool {
    let Some(tree) = solid.tree.balls() else {
        return false;
    };
    let root = tree.balls()[0];
    if point.distance(root.center) > root.radius {
        return false;
    }
    let angle: f64 = triangles(tree)
        .map(|corners| solid_angle(corners.map(|corner| corner - point)))
        .sum();
    let is_wound = angle.abs() > 2.0 * PI;
    match solid.is_open {
        true => is_hidden(tree, point, if is_wound { RAYS / 2 } else { GAPS }),
        false => is_wound,
    }
}

/// The same where every surface is closed and any rounding will do: by the triangles that rays
/// meet. A tenth of the work and less.
pub(super) fn probably_contains(tree: &BallTree, point: Vec3) -> bool {
    let is_odd = |index: &usize| {
        let mut met = 0;
        meet(
            tree,
            point,
            convex_hull::direction(*index, RAYS),
            0.0,
            &mut |_| {
                met += 1;
                true
            },
        );
        met % 2 == 1
    };
    [7, 23, 47]
        .iter()
        .filter(|index| is_odd(index))
        .count()
        >= 2
}

/// A point of a cloud inside of a solid, in whose frame `relative` places it. What is in a box that the
/// surface does not meet is inside or outside altogether, so that one point tells of all.
pub(super) fn hidden_cell(solid: &Solid, cells: &CellTree, relative: &Transform) -> Option<Vec3> {
    let balls = solid.tree.balls().filter(|_| solid.hollow)?;
    let hiding = Hiding {
        solid,
        balls,
        cells,
        relative,
    };
    hiding.look(0)
}

/// A solid that may hide cells.
struct Hiding<'a> {
    solid: &'a Solid,
    balls: &'a BallTree,
    cells: &'a CellTree,
    relative: &'a Transform,
}

impl Hiding<'_> {
    fn look(&self, node: u32) -> Option<Vec3> {
        let hull = self
            .cells
            .box_of(node)
            .transformed(self.relative);
        if self.is_beside(&hull) {
            return None;
        }
        match self.cells.ball(node).content {
            Content::Balls(left, right) if self.meets_surface(0, &hull) => {
                self.look(left).or_else(|| self.look(right))
            }
            Content::Balls(..) | Content::Piece(_) => {
                Some(hull.center()).filter(|point| contains(self.solid, *point))
            }
        }
    }

    /// Whether a box lies beside the solid's convex hull, or its ball.
    fn is_beside(&self, hull: &Piece) -> bool {
        let root = self.balls.balls()[0];
        let offset = hull.center() - root.center;
        let is_beyond = |along: Vec3| {
            let nearest = along.dot(hull.core.support(-along));
            let farthest = self.solid.convex_hull.as_ref();
            let reach = || along.dot(root.center) + along.length() * root.radius;
            nearest > farthest.map_or_else(reach, |convex| convex.farthest_along(along))
        };
        is_beyond(offset) || AXES.into_iter().any(is_beyond)
    }

    /// Whether the surface below a ball may meet a box.
    fn meets_surface(&self, ball: u32, hull: &Piece) -> bool {
        let ball = self.balls.ball(ball);
        let nearest = closest_on(&hull.core, ball.center);
        if nearest.distance(ball.center) > ball.radius {
            return false;
        }
        match ball.content {
            Content::Piece(_) => true,
            Content::Balls(left, right) => {
                self.meets_surface(left, hull) || self.meets_surface(right, hull)
            }
        }
    }
}

/// Directions along which a box is looked for beside a solid.
const AXES: [Vec3; 6] = [
    Vec3::X,
    Vec3::Y,
    Vec3::Z,
    Vec3::NEG_X,
    Vec3::NEG_Y,
    Vec3::NEG_Z,
];

fn triangles(tree: &BallTree) -> impl Iterator<Item = [Vec3; 3]> {
    tree.pieces()
        .iter()
        .filter_map(|piece| piece.core.triangle())
}

/// Whether no more than so many rays find a way out.
fn is_hidden(tree: &BallTree, point: Vec3, gaps: usize) -> bool {
    let escapes = |index: &usize| {
        let mut escapes = true;
        meet(
            tree,
            point,
            convex_hull::direction(*index, RAYS),
            RIM,
            &mut |_| {
                escapes = false;
                false
            },
        );
        escapes
    };
    (0..RAYS).filter(escapes).take(gaps + 1).count() <= gaps
}

/// Tells of each triangle that a ray meets, until it hears that this is enough.
fn meet(
    tree: &BallTree,
    from: Vec3,
    along: Vec3,
    rim: f64,
    tell: &mut impl FnMut([Vec3; 3]) -> bool,
) {
    let mut left = vec![0];
    while let Some(ball) = left.pop() {
        let ball = tree.ball(ball);
        let offset = ball.center - from;
        let radius = ball.radius * (1.0 + RIM) + 1e-12;
        let ahead = offset.dot(along);
        if ahead < -radius || offset.length_squared() - ahead * ahead > radius * radius {
            continue;
        }
        match ball.content {
            Content::Balls(a, b) => left.extend([a, b]),
            Content::Piece(piece) => {
                if let Some([a, b, c]) = tree.pieces()[piece as usize].core.triangle()
                    && meets(from, along, [a, b, c], rim)
                    && !tell([a, b, c])
                {
                    return;
                }
            }
        }
    }
}

/// Whether a ray meets a triangle (Möller and Trumbore, 1997).
fn meets(from: Vec3, along: Vec3, [a, b, c]: [Vec3; 3], rim: f64) -> bool {
    let ab = b - a;
    let ac = c - a;
    let across = along.cross(ac);
    let volume = ab.dot(across);
    if volume == 0.0 {
        return false;
    }
    let offset = from - a;
    let u = offset.dot(across) / volume;
    let beside = offset.cross(ab);
    let v = along.dot(beside) / volume;
    u >= -rim && v >= -rim && u + v <= 1.0 + rim && ac.dot(beside) / volume >= 0.0
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::math::Pose;
    use crate::shape::{Mesh, PlacedShape, Shape};
    use crate::testing::{vector, wedge};

    fn solid(mesh: Mesh) -> Solid {
        Solid::new(&[PlacedShape {
            pose: Pose::identity(),
            shape: Shape::Mesh(Arc::new(mesh)),
        }])
    }

    /// The walls of a unit cube about the origin, each by itself and moved out a little; those
    /// named face inwards.
    fn walls(turned: usize, gap: f64, without: &[usize]) -> Solid {
        let mut vertices = Vec::new();
        let mut triangles = Vec::new();
        for wall in (0..6).filter(|wall| !without.contains(wall)) {
            let axis = wall / 2;
            let side = if wall % 2 == 0 { 1.0 } else { -1.0 };
            let [out, u, v] = [0, 1, 2].map(|i| [Vec3::X, Vec3::Y, Vec3::Z][(axis + i) % 3]);
            let center = out * (side * (0.5 + gap));
            let first = vertices.len() as u32;
            vertices.extend(
                [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]
                    .map(|[a, b]| center + u * a + v * b),
            );
            let inwards = (turned >> wall & 1 == 1) == (side > 0.0);
            let quad = if inwards { [0, 3, 2, 1] } else { [0, 1, 2, 3] }.map(|i| first + i);
            triangles.extend([[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]);
        }
        solid(Mesh::new("walls", vertices, triangles).unwrap())
    }

    /// However its walls face and though none of them meet, what stands in a box is in it, and what
    /// stands outside of it or in a corner of walls is not.
    #[test]
    fn a_surface_that_hides_a_place_all_round_has_it_inside() {
        for turned in 0..64 {
            let gaps = walls(turned, 1e-5, &[]);
            assert!(gaps.is_open);
            for inside in [Vec3::ZERO, Vec3::new(0.45, -0.4, 0.3)] {
                assert!(contains(&gaps, inside), "{turned:b} {inside}");
            }
            assert!(!contains(&gaps, Vec3::new(0.0, 0.51, 0.0)), "{turned:b}");
            let corner = walls(turned, 1e-5, &[0, 2, 4]);
            assert!(!contains(&corner, Vec3::splat(0.2)), "{turned:b}");
        }
        // Without a lid it takes walls that face one way, as most do.
        assert!(
            contains(&walls(0, 0.0, &[0]), Vec3::ZERO)
                && contains(&walls(63, 0.0, &[0]), Vec3::ZERO)
        );
    }

    #[test]
    fn rays_and_angles_agree_in_a_closed_mesh() {
        let wedge = solid(wedge(Vec3::ONE));
        assert!(!wedge.is_open);
        let mut rng = fastrand::Rng::with_seed(2);
        let mut count = 0;
        for _ in 0..5000 {
            let point = vector(&mut rng, 1.2);
            let inside = contains(&wedge, point);
            count += usize::from(inside);
            assert_eq!(
                probably_contains(wedge.tree.balls().unwrap(), point),
                inside,
                "{point}"
            );
        }
        assert!(count > 500, "{count}");
    }
}
