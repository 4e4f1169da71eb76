//! Whether a point is inside the meshes of a solid.

use std::f64::consts::PI;

use super::piece::Core;
use super::shell;
use super::solid::Solid;
use super::tree::{BallTree, Content};
use crate::math::Vec3;
use crate::shape::solid_angle;

/// Rays that look for a way out of a surface that is not closed.
const RAYS: usize = 64;
/// Of these, as many may find one from a place that counts as inside: gaps.
const GAPS: usize = RAYS / 10;
/// How far beside a triangle a ray still meets it, relative to the triangle: no ray slips between two of them.
const RIM: f64 = 1e-9;

/// Whether a point is inside, by the winding number (Jacobson, Kavan and Sorkine-Hornung, 2013), which is sure for
/// surfaces that are closed and face one way. For others it is a guess, and places that such a surface hides from
/// nearly all directions count as inside too, however its triangles face.
pub(super) fn contains(solid: &Solid, point: Vec3) -> bool {
    let root = solid.tree.balls()[0];
    if point.distance(root.center) > root.radius {
        return false;
    }
    let angle: f64 = triangles(&solid.tree).map(|corners| solid_angle(corners.map(|corner| corner - point))).sum();
    angle.abs() > 2.0 * PI || solid.is_open && is_hidden(&solid.tree, point)
}

/// The same where every surface is closed and any rounding will do: by the triangles that rays meet. A tenth of the
/// work and less.
pub(super) fn probably_contains(tree: &BallTree, point: Vec3) -> bool {
    let is_odd = |index: &usize| {
        let mut met = 0;
        meet(tree, point, shell::direction(*index, RAYS), 0.0, &mut |_| {
            met += 1;
            true
        });
        met % 2 == 1
    };
    [7, 23, 47].iter().filter(|index| is_odd(index)).count() >= 2
}

fn triangles(tree: &BallTree) -> impl Iterator<Item = [Vec3; 3]> {
    tree.pieces().iter().filter_map(|piece| match piece.core {
        Core::Triangle(a, b, c) => Some([a, b, c]),
        _ => None,
    })
}

fn is_hidden(tree: &BallTree, point: Vec3) -> bool {
    let escapes = |index: &usize| {
        let mut escapes = true;
        meet(tree, point, shell::direction(*index, RAYS), RIM, &mut |_| {
            escapes = false;
            false
        });
        escapes
    };
    (0..RAYS).filter(escapes).take(GAPS + 1).count() <= GAPS
}

/// Tells of each triangle that a ray meets, until it hears that this is enough.
fn meet(tree: &BallTree, from: Vec3, along: Vec3, rim: f64, tell: &mut impl FnMut([Vec3; 3]) -> bool) {
    let mut left = vec![0];
    while let Some(ball) = left.pop() {
        let ball = tree.ball(ball);
        let (offset, radius) = (ball.center - from, ball.radius * (1.0 + RIM) + 1e-12);
        let ahead = offset.dot(along);
        if ahead < -radius || offset.length_squared() - ahead * ahead > radius * radius {
            continue;
        }
        match ball.content {
            Content::Balls(a, b) => left.extend([a, b]),
            Content::Piece(piece) => {
                if let Core::Triangle(a, b, c) = tree.pieces()[piece as usize].core
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
    let (ab, ac) = (b - a, c - a);
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
