//! The distance of two convex parts: the algorithm of Gilbert, Johnson and Keerthi, the nearest
//! point of each simplex by trying all of its faces. Slow and plain; taut's own is neither used nor
//! copied.

use super::pose::{Pose, Vector, add, cross, dot, length, scaled, sub};
use super::solid::{Convex, Part};

/// How far apart, from both sides (m). Parts that overlap are at most 0 apart, by less than their
/// depth.
#[derive(Clone, Copy, Debug)]
pub struct Apart {
    pub at_least: f64,
    pub at_most: f64,
}

/// A part as it stands in the world, drawn towards its middle by a factor of 1 − `shrunk`.
struct Placed<'a> {
    shape: &'a Convex,
    pose: Pose,
    middle: Vector,
    shrunk: f64,
}

impl Placed<'_> {
    fn farthest(&self, d: Vector) -> Vector {
        let point = self.pose.point(
            self.shape
                .farthest(self.pose.direction_inside(d)),
        );
        add(point, scaled(sub(self.middle, point), self.shrunk))
    }
}

/// The distance of two parts whose bodies stand at these poses. It is not looked for more closely
/// where they are farther apart than `enough`.
pub fn apart(a: (&Part, &Pose), b: (&Part, &Pose), enough: f64) -> Apart {
    shrunk_apart(a, b, 0.0, enough)
}

/// Whether two parts share points that lie inside of both by more than a millionth of their size or
/// so: a certain overlap, whatever the rounding.
pub fn overlap(a: (&Part, &Pose), b: (&Part, &Pose), deeper_than: f64) -> bool {
    let smaller = a.0.ball.1.min(b.0.ball.1);
    let shrunk = deeper_than / smaller.max(1e-3);
    shrunk_apart(a, b, shrunk, 0.0).at_most
        <= -deeper_than.min(a.0.shape.roundness() + b.0.shape.roundness())
}

fn shrunk_apart(a: (&Part, &Pose), b: (&Part, &Pose), shrunk: f64, enough: f64) -> Apart {
    let place = |(part, pose): (&Part, &Pose)| (pose.then(&part.pose), pose.point(part.ball.0));
    let (pose_a, middle_a) = place(a);
    let (pose_b, middle_b) = place(b);
    let a = Placed {
        shape: &a.0.shape,
        pose: pose_a,
        middle: middle_a,
        shrunk,
    };
    let b = Placed {
        shape: &b.0.shape,
        pose: pose_b,
        middle: middle_b,
        shrunk,
    };
    let round = (1.0 - shrunk) * (a.shape.roundness() + b.shape.roundness());
    let cores = cores_apart(&a, &b, enough + round);
    Apart {
        at_least: cores.at_least - round,
        at_most: cores.at_most - round,
    }
}

fn cores_apart(a: &Placed, b: &Placed, enough: f64) -> Apart {
    let support = |d: Vector| sub(a.farthest(d), b.farthest(scaled(d, -1.0)));
    let mut nearest = sub(a.middle, b.middle);
    if length(nearest) < 1e-12 {
        nearest = [1.0, 0.0, 0.0];
    }
    let mut simplex = vec![support(scaled(nearest, -1.0))];
    nearest = simplex[0];
    let mut at_least = f64::NEG_INFINITY;
    for _ in 0..100 {
        let far = length(nearest);
        if far < 1e-12 {
            return Apart {
                at_least: at_least.min(0.0),
                at_most: 0.0,
            };
        }
        let next = support(scaled(nearest, -1.0));
        at_least = at_least.max(dot(nearest, next) / far);
        if at_least > enough || far - at_least < 1e-10 {
            return Apart {
                at_least,
                at_most: far,
            };
        }
        if simplex
            .iter()
            .any(|p| length(sub(*p, next)) < 1e-14)
        {
            return Apart {
                at_least,
                at_most: far,
            };
        }
        simplex.push(next);
        let (found, kept) = nearest_of(&simplex);
        // Rounding alone can take it no nearer; then it is there.
        if simplex.len() < 5 && length(found) >= far && length(found) > 1e-12 {
            return Apart {
                at_least,
                at_most: far,
            };
        }
        nearest = found;
        simplex = kept;
        if simplex.len() == 4 {
            return Apart {
                at_least: at_least.min(0.0),
                at_most: 0.0,
            };
        }
    }
    Apart {
        at_least,
        at_most: length(nearest),
    }
}

/// The point of a simplex that is nearest to the origin, and the corners of the face that it lies
/// on; all four where the origin is inside.
fn nearest_of(simplex: &[Vector]) -> (Vector, Vec<Vector>) {
    let mut best: Option<(f64, Vector, Vec<Vector>)> = None;
    for mask in 1..1_usize << simplex.len() {
        let face: Vec<Vector> = (0..simplex.len())
            .filter(|i| mask >> i & 1 == 1)
            .map(|i| simplex[i])
            .collect();
        let Some(point) = inside_of(&face) else {
            continue;
        };
        let far = dot(point, point);
        if best
            .as_ref()
            .is_none_or(|(least, _, _)| far < *least)
        {
            best = Some((far, point, face));
        }
    }
    let (_, point, face) = best.expect("a corner is always a face with its own nearest point");
    (point, face)
}

/// The foot of the origin on the span of a face, where it lies within the face.
fn inside_of(face: &[Vector]) -> Option<Vector> {
    let minus = |p: &Vector| scaled(*p, -1.0);
    match face {
        [a] => Some(*a),
        [a, b] => {
            let along = sub(*b, *a);
            let t = dot(minus(a), along) / dot(along, along);
            (t > 0.0 && t < 1.0).then(|| add(*a, scaled(along, t)))
        }
        [a, b, c] => {
            let ab = sub(*b, *a);
            let ac = sub(*c, *a);
            let normal = cross(ab, ac);
            let area = dot(normal, normal);
            let weight =
                |from: &Vector, along: Vector| dot(cross(along, minus(from)), normal) / area;
            let u = weight(b, sub(*c, *b));
            let v = weight(c, sub(*a, *c));
            let w = weight(a, ab);
            let foot = scaled(normal, dot(*a, normal) / area);
            (area > 1e-30 && u > 0.0 && v > 0.0 && w > 0.0).then_some(foot)
        }
        [a, b, c, d] => {
            let side = |p: &Vector, q: &Vector, r: &Vector, other: &Vector| {
                let normal = cross(sub(*q, *p), sub(*r, *p));
                let here = dot(normal, minus(p));
                let there = dot(normal, sub(*other, *p));
                there != 0.0 && here * there >= 0.0
            };
            (side(a, b, c, d) && side(b, c, d, a) && side(c, d, a, b) && side(d, a, b, c))
                .then_some([0.0; 3])
        }
        _ => None,
    }
}

#[test]
fn distances_are_those_of_closed_forms() {
    let placed = |shape: Convex| Part::new(Pose::IDENTITY, shape);
    let at = |x, y, z| Pose::shift([x, y, z]);
    let ball = placed(Convex::Sphere { radius: 0.5 });
    let cube = placed(Convex::cuboid([1.0; 3]));
    let pin = placed(Convex::Cylinder {
        half: 1.0,
        radius: 0.25,
    });
    let rod = placed(Convex::Capsule {
        half: 1.0,
        radius: 0.25,
    });
    let corner = (3.0 * 1.5_f64.powi(2)).sqrt() - 0.5;
    for (a, b, pose, expected) in [
        (&ball, &ball, at(3.0, 0.0, 0.0), 2.0),
        (&ball, &cube, at(2.0, 2.0, 2.0), corner),
        (&cube, &cube, at(0.3, 1.7, -0.2), 0.7),
        (&pin, &cube, at(0.0, 2.0, 0.0), 1.25),
        (&pin, &ball, at(0.0, 0.0, 2.0), 0.5),
        (&rod, &ball, at(0.0, 0.0, 2.0), 0.25),
        (&rod, &pin, at(2.0, 0.0, 0.3), 1.5),
        (&ball, &ball, at(0.4, 0.0, 0.0), -0.6),
    ] {
        let found = apart((a, &Pose::IDENTITY), (b, &pose), 10.0);
        assert!(
            (found.at_most - expected).abs() < 1e-7 && found.at_least <= found.at_most + 1e-12,
            "{found:?}"
        );
    }
    let inside = (&cube, &at(0.2, 0.1, 0.9));
    assert!(
        overlap((&cube, &Pose::IDENTITY), inside, 1e-6)
            && !overlap((&cube, &Pose::IDENTITY), (&cube, &at(0.0, 0.0, 1.0)), 1e-6)
    );
}
