//! How deep two overlapping bodies are in each other: for what people are told, never for a proof.
//!
//! The penetration depth of two solids is the least distance by which one must be moved for them to
//! part. Of two convex bodies (a primitive, or a mesh of no more than 2048 triangles that is convex
//! to 1e-5 of its size) it is given as it is. Of others it is given from below: no less than the
//! overlap of any two of their convex pieces, and no less than the way out of one body for a point
//! of the other, which moves with a ball that lies in there. What is never overstated here: bodies
//! of several pieces, meshes with hollows, bodies in a mesh.

use std::borrow::Cow;
use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashMap};

use super::Solid;
use super::contact::{Contact, TOUCHING_M};
use super::core::Core;
use super::distance::{self, Hull, closest_on};
use super::inside;
use super::piece::Piece;
use super::query;
use super::transform::Transform;
use super::tree::{BallTree, Content, Tree};
use crate::math::Vec3;

/// A mesh counts as convex if no corner is farther outside of a neighbour's plane than this,
/// relative to its size: what six digits of a file do to a cylinder's facets.
const BENT: f64 = 1e-5;
/// Meshes of more triangles are taken as those that are not convex: each one's plane is tried with
/// every corner.
const MOST_TRIANGLES: usize = 2048;
/// Points that are asked how deep they are, for each of two bodies.
const MOST_POINTS: usize = 256;
/// Digging ends where nothing is deeper by this (m).
const RESOLUTION_M: f64 = 1e-6;

/// The contact of two bodies that touch or overlap, with the penetration depth; as
/// [`query::closest`] where they are apart.
pub fn penetration(a: &Solid, at_a: &Transform, b: &Solid, at_b: &Transform) -> Contact {
    let seen = query::closest(a, at_a, b, at_b);
    if seen.distance > TOUCHING_M || !(a.hollow || b.hollow) {
        return seen;
    }
    between_convex(a, at_a, b, at_b).unwrap_or_else(|| {
        let of_a = deepest(a, at_a, b, at_b);
        let of_b = deepest(b, at_b, a, at_a).map(Contact::reversed);
        of_a.into_iter()
            .chain(of_b)
            .fold(seen, Contact::deeper)
    })
}

fn between_convex(a: &Solid, at_a: &Transform, b: &Solid, at_b: &Transform) -> Option<Contact> {
    let relative = at_b.inverse_of(at_a);
    let a = hull(a, &relative)?;
    let b = hull(b, &Transform::IDENTITY)?;
    let Contact {
        point_a,
        point_b,
        normal,
        distance,
    } = distance::deepest_of_hulls(&a, &b)?;
    let [point_a, point_b] = [point_a, point_b].map(|point| at_b.point(point));
    Some(Contact {
        point_a,
        point_b,
        normal: at_b.rotation * normal,
        distance,
    })
}

/// A convex solid where `at` places it; `None` for one that is not convex.
fn hull(solid: &Solid, at: &Transform) -> Option<Hull> {
    let pieces = solid.tree.balls()?.pieces();
    match pieces {
        [piece] if !matches!(piece.core, Core::Triangle(..)) => {
            Some(Hull::Piece(piece.transformed(at)))
        }
        _ => {
            let (corners, normals) = convex(solid)?;
            let points = corners
                .into_iter()
                .map(|point| at.point(point))
                .collect();
            let normals = normals
                .into_iter()
                .map(|normal| at.rotation * normal)
                .collect();
            Some(Hull::Points {
                points,
                normals,
                radius: pieces[0].radius,
            })
        }
    }
}

/// The corners of a solid that is one convex mesh, and the normals of its triangles.
fn convex(solid: &Solid) -> Option<(Vec<Vec3>, Vec<Vec3>)> {
    let tree = solid.tree.balls()?;
    let pieces = tree.pieces();
    let bent = BENT * tree.balls()[0].radius;
    if solid.is_open || solid.anchors.len() != 1 || pieces.len() > MOST_TRIANGLES {
        return None;
    }
    // A few faces tell of most bodies that are not convex.
    let mut some = pieces.iter().step_by(pieces.len() / 16 + 1);
    if !some.all(|piece| is_outermost(tree, piece, bent)) {
        return None;
    }
    let mut surface = ConvexSurface::new(bent);
    for piece in pieces {
        surface.add(piece.core.triangle()?)?;
    }
    surface.finish()
}

/// Whether all of a solid lies on one side of a triangle of it.
fn is_outermost(tree: &BallTree, piece: &Piece, bent: f64) -> bool {
    let Some(corners) = piece.core.triangle() else {
        return false;
    };
    let above = |normal: Vec3| normal.dot(tree.farthest_along(normal) - corners[0]);
    normal_of(corners).is_some_and(|normal| above(normal).min(above(-normal)) <= bent)
}

fn normal_of([a, b, c]: [Vec3; 3]) -> Option<Vec3> {
    (b - a).cross(c - a).try_normalize()
}

/// A surface that is convex as far as it was read.
struct ConvexSurface {
    bent: f64,
    numbers: HashMap<[u64; 3], usize>,
    corners: Vec<Vec3>,
    normals: Vec<Vec3>,
    /// By edge: a triangle's normal, which faces outwards or inwards, and its third corner.
    waiting: HashMap<[usize; 2], (Vec3, Vec3)>,
    /// How far the last third corner was off its neighbour's plane: on one side everywhere.
    side: f64,
}

impl ConvexSurface {
    fn new(bent: f64) -> Self {
        Self {
            bent,
            numbers: HashMap::new(),
            corners: Vec::new(),
            normals: Vec::new(),
            waiting: HashMap::new(),
            side: 0.0,
        }
    }

    /// Adds a triangle; `None` where the surface is not convex.
    fn add(&mut self, [a, b, c]: [Vec3; 3]) -> Option<()> {
        let normal = normal_of([a, b, c])?;
        self.normals.push(normal);
        let [i, j, k] = [a, b, c].map(|corner| self.number(corner));
        for (from, to, on_edge, third) in [(i, j, a, c), (j, k, b, a), (k, i, c, b)] {
            let edge = [from.min(to), from.max(to)];
            match self.waiting.remove(&edge) {
                None => drop(self.waiting.insert(edge, (normal, third))),
                Some((_, other)) => self.bend(normal.dot(other - on_edge))?,
            }
        }
        Some(())
    }

    fn number(&mut self, corner: Vec3) -> usize {
        let bits = corner.to_array().map(|c| (c + 0.0).to_bits());
        *self.numbers.entry(bits).or_insert_with(|| {
            self.corners.push(corner);
            self.corners.len() - 1
        })
    }

    /// At an edge the surface bends by this; `None` where it has bent the other way.
    fn bend(&mut self, above: f64) -> Option<()> {
        if above.abs() <= self.bent {
            return Some(());
        }
        if above * self.side < 0.0 {
            return None;
        }
        self.side = above;
        Some(())
    }

    fn finish(self) -> Option<(Vec<Vec3>, Vec<Vec3>)> {
        let is_closed = self.waiting.is_empty();
        is_closed.then_some((self.corners, self.normals))
    }
}

/// The deepest points of `inner` in `outer`, as far as they are looked for; `None` where none is in
/// there.
fn deepest(
    inner: &Solid,
    at_inner: &Transform,
    outer: &Solid,
    at_outer: &Transform,
) -> Option<Contact> {
    let relative = at_outer.inverse_of(at_inner);
    let ground = Ground { solid: outer };
    let mut heap = BinaryHeap::from([Reach {
        deepest: f64::INFINITY,
        ball: 0,
    }]);
    let mut best: Option<(f64, Vec3, Vec3)> = None;
    let mut asked = 0;
    while let Some(Reach { deepest, ball }) = heap.pop() {
        let enough = best.map_or(0.0, |(depth, ..)| depth + RESOLUTION_M);
        if deepest <= enough || asked >= MOST_POINTS {
            break;
        }
        match inner.tree.ball(ball).content {
            Content::Balls(left, right) => {
                for child in [left, right] {
                    let ball = inner.tree.ball(child);
                    asked += 1;
                    let (depth, _) = ground.depth(relative.point(ball.center));
                    heap.push(Reach {
                        deepest: depth + ball.radius,
                        ball: child,
                    });
                }
            }
            Content::Piece(piece) => {
                let piece = &*inner.tree.piece(piece);
                for point in points(piece) {
                    asked += 1;
                    let point = relative.point(point);
                    let (depth, way) = ground.depth(point);
                    if best.is_none_or(|(most, ..)| depth + piece.radius > most) {
                        best = Some((depth + piece.radius, point, way));
                    }
                }
            }
        }
    }
    let (depth, point, way) = best.filter(|(depth, ..)| *depth > 0.0)?;
    let point = at_outer.point(point);
    Some(Contact {
        point_a: point,
        point_b: point,
        normal: at_outer.rotation * way,
        distance: -depth,
    })
}

/// Points of a piece, without its rounding.
fn points(piece: &Piece) -> Vec<Vec3> {
    let mut points = vec![piece.center()];
    piece.core.outline(&mut points);
    points
}

/// A ball, and how deep anything in it may be.
struct Reach {
    deepest: f64,
    ball: u32,
}

impl PartialEq for Reach {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Reach {}
impl PartialOrd for Reach {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Reach {
    fn cmp(&self, other: &Self) -> Ordering {
        self.deepest
            .total_cmp(&other.deepest)
            .then(other.ball.cmp(&self.ball))
    }
}

/// What points are in.
struct Ground<'s> {
    solid: &'s Solid,
}

impl Ground<'_> {
    /// At most how far a point is from the outside (m), negative outside; and the unit direction of
    /// the way out.
    fn depth(&self, point: Vec3) -> (f64, Vec3) {
        let Solid {
            tree,
            hollow,
            is_open,
            ..
        } = self.solid;
        let (piece, on_surface) = nearest(tree, point);
        let offset = on_surface - point;
        let away = offset.length();
        let radius = piece.radius;
        // Of a surface that is not closed only the overlap of its triangles is known.
        if *hollow
            && !is_open
            && tree
                .balls()
                .is_some_and(|balls| inside::probably_contains(balls, point))
        {
            return (away + radius, offset.try_normalize().unwrap_or(Vec3::Z));
        }
        match piece.core.inner_depth(point) {
            Some((depth, way)) => (depth + radius, way),
            None => (radius - away, (-offset).try_normalize().unwrap_or(Vec3::Z)),
        }
    }
}

/// The piece of a tree nearest to a point, and its nearest point.
fn nearest(tree: &Tree, point: Vec3) -> (Cow<'_, Piece>, Vec3) {
    let mut best = (f64::INFINITY, tree.piece(0), point);
    let mut left = vec![0];
    let least = |ball: u32| {
        let ball = tree.ball(ball);
        ball.center.distance(point) - ball.radius
    };
    while let Some(ball) = left.pop() {
        if least(ball) >= best.0 {
            continue;
        }
        match tree.ball(ball).content {
            Content::Balls(a, b) => left.extend(if least(a) < least(b) { [b, a] } else { [a, b] }),
            Content::Piece(index) => {
                let piece = tree.piece(index);
                let on_core = closest_on(&piece.core, point);
                let away = on_core.distance(point) - piece.radius;
                if away < best.0 {
                    best = (away, piece, on_core);
                }
            }
        }
    }
    (best.1, best.2)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::math::{Pose, Quat, quat_exp};
    use crate::shape::{Mesh, PlacedShape, Shape, mesh_file};
    use crate::testing::vector;

    fn body(shape: Shape) -> Solid {
        let shapes = [PlacedShape {
            pose: Pose::from_parts(Vec3::ZERO, Quat::IDENTITY),
            shape,
        }];
        Solid::new(&shapes)
    }

    fn mesh(text: &str) -> Solid {
        body(Shape::Mesh(Arc::new(
            mesh_file::read("m.obj", text.as_bytes(), Vec3::ONE).unwrap(),
        )))
    }

    fn cube_mesh() -> Solid {
        let corner = |i: u32| {
            Vec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64) * 0.2 - Vec3::splat(0.1)
        };
        let quads = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let faces = quads
            .iter()
            .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]])
            .collect();
        body(Shape::Mesh(Arc::new(
            Mesh::new("cube", (0..8).map(corner).collect(), faces).unwrap(),
        )))
    }

    fn at(turn: Vec3, shift: Vec3) -> Transform {
        Transform::from(&Pose::from_parts(shift, quat_exp(turn)))
    }

    /// Least way that parts two cubes, by all directions that can be the least: their faces' and
    /// pairs of edges'.
    fn cubes_apart(relative: &Transform) -> f64 {
        let axes =
            |rotation: crate::math::Mat3| [rotation.x_axis, rotation.y_axis, rotation.z_axis];
        let a = axes(relative.rotation);
        let b = axes(crate::math::Mat3::IDENTITY);
        let across = a
            .iter()
            .flat_map(|a| b.iter().map(|b| a.cross(*b)))
            .filter_map(Vec3::try_normalize);
        let reach = |axes: &[Vec3; 3], n: Vec3| {
            axes.iter()
                .map(|axis| 0.1 * axis.dot(n).abs())
                .sum::<f64>()
        };
        let depth = |n: Vec3| reach(&a, n) + reach(&b, n) - n.dot(relative.translation).abs();
        across
            .chain(a)
            .chain(b)
            .map(depth)
            .fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn a_cube_of_triangles_is_as_deep_as_a_box_and_as_the_closed_form() {
        let cube = cube_mesh();
        let cuboid = body(Shape::cuboid(Vec3::splat(0.2)).unwrap());
        let mut rng = fastrand::Rng::with_seed(5);
        let mut deep = 0;
        for _ in 0..1000 {
            let placed = at(vector(&mut rng, 2.0), vector(&mut rng, 0.2));
            let exact = cubes_apart(&placed);
            if exact.abs() < 1e-6 {
                continue;
            }
            deep += usize::from(exact > 0.0);
            for (a, b) in [(&cube, &cube), (&cube, &cuboid), (&cuboid, &cube)] {
                let seen = penetration(a, &placed, b, &Transform::IDENTITY);
                assert_eq!(
                    seen.distance <= TOUCHING_M,
                    exact > 0.0,
                    "{seen:?}, {exact}"
                );
                assert!(
                    exact < 0.0 || (seen.distance + exact).abs() < 1e-7,
                    "{seen:?}, {exact}"
                );
            }
        }
        assert!(deep > 300, "{deep}");
        let seen = penetration(
            &cube,
            &at(Vec3::ZERO, Vec3::new(-0.1, 0.01, 0.02)),
            &cube,
            &Transform::IDENTITY,
        );
        assert!(
            (seen.distance + 0.1).abs() < 1e-9 && (seen.normal + Vec3::X).length() < 1e-6,
            "{seen:?}"
        );
    }

    /// An L of walls 50 mm thick, drawn as polygons.
    const BRACKET: &str = "v 0 0 0\nv .3 0 0\nv .3 .05 0\nv .05 .05 0\nv .05 .3 0\nv 0 .3 0\nv 0 0 .1\nv .3 0 .1\n\
        v .3 .05 .1\nv .05 .05 .1\nv .05 .3 .1\nv 0 .3 .1\nf 6 5 4 3 2 1\nf 7 8 9 10 11 12\nf 1 2 8 7\nf 2 3 9 8\n\
        f 3 4 10 9\nf 4 5 11 10\nf 5 6 12 11\nf 6 1 7 12\n";

    #[test]
    fn in_a_mesh_with_a_hollow_no_depth_is_overstated() {
        let bracket = mesh(BRACKET);
        let ball = body(Shape::sphere(0.02).unwrap());
        let depth = |x: f64, y: f64| {
            let seen = penetration(
                &ball,
                &at(Vec3::ZERO, Vec3::new(x, y, 0.05)),
                &bracket,
                &Transform::IDENTITY,
            );
            let turned = penetration(
                &bracket,
                &Transform::IDENTITY,
                &ball,
                &at(Vec3::ZERO, Vec3::new(x, y, 0.05)),
            );
            assert!(
                (seen.distance - turned.distance).abs() < 1e-12
                    && (seen.normal + turned.normal).length() < 1e-9
            );
            -seen.distance
        };
        // In the notch; touching a wall from there; its centre 5 mm, and half way, in the wall.
        assert!((depth(0.15, 0.15) + 0.08).abs() < 1e-12);
        assert!((depth(0.069, 0.2) - 0.001).abs() < 1e-9);
        assert!((depth(0.045, 0.2) - 0.025).abs() < 1e-9);
        assert!((depth(0.024, 0.2) - 0.044).abs() < 1e-9);
        // A cube over both walls is a point's way out of it, no less than half of what would part
        // them.
        let cube = cube_mesh();
        let seen = penetration(
            &cube,
            &at(Vec3::ZERO, Vec3::new(0.1, 0.12, 0.05)),
            &bracket,
            &Transform::IDENTITY,
        );
        assert!(
            -seen.distance > 0.02 && -seen.distance <= 0.05 + 1e-9,
            "{seen:?}"
        );
        // All of it inside.
        let room = mesh(
            &BRACKET
                .replace("v .05 .05", "v .3 .3")
                .replace(".05 ", ".3 "),
        );
        let seen = penetration(
            &ball,
            &at(Vec3::ZERO, Vec3::new(0.15, 0.15, 0.05)),
            &room,
            &Transform::IDENTITY,
        );
        assert!((seen.distance + 0.07).abs() < 1e-9, "{seen:?}");
    }
}
