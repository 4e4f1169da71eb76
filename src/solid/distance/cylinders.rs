//! Two cylinders: an iteration, because their rims have no closed form.
//!
//! The algorithm of Gilbert, Johnson and Keerthi on the difference A − B, whose point closest to
//! the origin is sought. Each step gives a support gap, a lower bound, and two points, an upper
//! one; it ends where they meet.

use super::gap::{Nearest, gap_of_cores};
use super::point::closest_on;
use crate::math::Vec3;
use crate::solid::core::Core;

/// Steps at most; a dozen is usual.
const MOST_STEPS: usize = 64;
/// Rounds of nearest points from one to the other at most, for what the steps left.
const MOST_ROUNDS: usize = 32;
/// Where upper and lower bound have met (m), relative to a metre and the distance.
const CLOSE_ENOUGH: f64 = 1e-12;

/// A point of A − B, and the points that it comes from.
#[derive(Clone, Copy, Default)]
struct Vertex {
    offset: Vec3,
    a: Vec3,
    b: Vec3,
}

impl Vertex {
    fn new(a: Vec3, b: Vec3) -> Self {
        Self {
            offset: a - b,
            a,
            b,
        }
    }
}

/// At most four vertices and the weights of the point of their hull that is closest to the origin.
#[derive(Default)]
struct Simplex {
    vertices: [Vertex; 4],
    weights: [f64; 4],
    len: usize,
}

/// Closest points of two convex cores; equal, or as good as, where they overlap.
pub(super) fn closest(a: &Core, b: &Core) -> (Vec3, Vec3) {
    polish(a, b, descend(a, b, (a.center(), b.center())).points)
}

/// Steps towards the closest points from any two points of the cores, until rounding ends them.
fn descend(a: &Core, b: &Core, start: (Vec3, Vec3)) -> Nearest {
    let mut best = Nearest::default();
    let mut lower = 0.0_f64;
    let mut simplex = Simplex::default();
    let mut nearest = Vertex::new(start.0, start.1);
    simplex.push(nearest);
    for _ in 0..MOST_STEPS {
        if !best.offer((nearest.a, nearest.b)) {
            break;
        }
        let length = nearest.offset.length();
        if length < 1e-12 {
            return Nearest::common(nearest.a);
        }
        let towards = -nearest.offset / length;
        let corner = Vertex::new(a.support(towards), b.support(-towards));
        lower = lower.max(-towards.dot(corner.offset));
        if length - lower <= CLOSE_ENOUGH * (1.0 + length) || simplex.holds(&corner) {
            break;
        }
        simplex.push(corner);
        nearest = simplex.reduce();
    }
    best
}

/// Goes to and fro between the cores, each time to the nearest point, and takes the points whose
/// direction has the widest gap. The length alone would not tell: it hardly changes with points
/// that slide along a side, while the gap shrinks in proportion.
fn polish(a: &Core, b: &Core, mut points: (Vec3, Vec3)) -> (Vec3, Vec3) {
    let mut best = points;
    let mut widest = f64::NEG_INFINITY;
    for _ in 0..MOST_ROUNDS {
        let offset = points.0 - points.1;
        let length = offset.length();
        if length <= 1e-12 {
            return points;
        }
        let gap = gap_of_cores(a, b, offset / length);
        if gap > widest {
            best = points;
            widest = gap;
        }
        if length - gap <= CLOSE_ENOUGH * (1.0 + length) {
            break;
        }
        let on_b = closest_on(b, points.0);
        points = (closest_on(a, on_b), on_b);
    }
    best
}

impl Simplex {
    fn holds(&self, vertex: &Vertex) -> bool {
        self.vertices[..self.len]
            .iter()
            .any(|known| known.offset == vertex.offset)
    }

    fn push(&mut self, vertex: Vertex) {
        self.vertices[self.len] = vertex;
        self.len += 1;
    }

    /// Point of the hull closest to the origin; keeps only the vertices that it is made of: all
    /// four where the origin is inside.
    fn reduce(&mut self) -> Vertex {
        let offsets = self.vertices.map(|vertex| vertex.offset);
        self.weights = match self.len {
            1 => [1.0, 0.0, 0.0, 0.0],
            2 => {
                let [u, v] = on_edge(offsets[0], offsets[1]);
                [u, v, 0.0, 0.0]
            }
            3 => {
                let [u, v, w] = on_face(offsets[0], offsets[1], offsets[2]);
                [u, v, w, 0.0]
            }
            _ => on_solid(&offsets),
        };
        let mut point = Vertex::default();
        let mut kept = 0;
        for i in 0..self.len {
            let weight = self.weights[i];
            if weight > 0.0 {
                let vertex = self.vertices[i];
                point.offset += vertex.offset * weight;
                point.a += vertex.a * weight;
                point.b += vertex.b * weight;
                self.vertices[kept] = vertex;
                kept += 1;
            }
        }
        self.len = kept;
        point
    }
}

/// Weights of the point of a segment that is closest to the origin.
fn on_edge(a: Vec3, b: Vec3) -> [f64; 2] {
    let along = b - a;
    let square = along.length_squared();
    let v = if square > 0.0 {
        (-a.dot(along) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    [1.0 - v, v]
}

/// The same for a triangle: inside, if all weights are positive, else on its nearest edge.
fn on_face(a: Vec3, b: Vec3, c: Vec3) -> [f64; 3] {
    let normal = (b - a).cross(c - a);
    let weights = [
        normal.dot(b.cross(c)),
        normal.dot(c.cross(a)),
        normal.dot(a.cross(b)),
    ];
    if weights.iter().all(|w| *w > 0.0) {
        // Their own sum, not the normal's square, which for a sliver differs: the point stays in
        // the plane.
        let sum: f64 = weights.iter().sum();
        return weights.map(|w| w / sum);
    }
    let [ab, ba] = on_edge(a, b);
    let [bc, cb] = on_edge(b, c);
    let [ca, ac] = on_edge(c, a);
    let options = [
        ([ab, ba, 0.0], a * ab + b * ba),
        ([0.0, bc, cb], b * bc + c * cb),
        ([ac, 0.0, ca], c * ca + a * ac),
    ];
    least(options)
}

/// The same for a tetrahedron: inside, if all weights are positive, else on its nearest face.
fn on_solid(p: &[Vec3; 4]) -> [f64; 4] {
    const FACES: [[usize; 4]; 4] = [[0, 1, 2, 3], [0, 1, 3, 2], [0, 2, 3, 1], [1, 2, 3, 0]];
    let mut within = [0.0; 4];
    for [i, j, k, opposite] in FACES {
        let normal = (p[j] - p[i]).cross(p[k] - p[i]);
        within[opposite] = normal.dot(-p[i]) / normal.dot(p[opposite] - p[i]);
    }
    let sum: f64 = within.iter().sum();
    let weights = within.map(|w| w / sum);
    let point = (0..4).map(|i| p[i] * weights[i]).sum::<Vec3>();
    // Of a flat one the weights are all rounding, and the point is not the origin.
    if within.iter().all(|w| *w > 0.0) && point.length() < 5e-13 {
        return weights;
    }
    least(FACES.map(|[i, j, k, _]| {
        let face = on_face(p[i], p[j], p[k]);
        let mut weights = [0.0; 4];
        weights[i] = face[0];
        weights[j] = face[1];
        weights[k] = face[2];
        (weights, p[i] * face[0] + p[j] * face[1] + p[k] * face[2])
    }))
}

/// Weights of the point closest to the origin.
fn least<const N: usize, const M: usize>(options: [([f64; N], Vec3); M]) -> [f64; N] {
    let mut best = options[0];
    for option in &options[1..] {
        if option.1.length_squared() < best.1.length_squared() {
            best = *option;
        }
    }
    best.0
}
