//! Polygons as triangles. A convex one is cut from its first corner, as assimp, coal and trimesh
//! cut it: where its corners are not in one plane, the cut is part of the shape. Any other is cut
//! by ears, the same ones whichever of its corners comes first.
//!
//! Convex is what turns one way, and once around, as seen along the polygon's own normal
//! (Newell's). Repeated corners and corners on a straight side change nothing about that: they make
//! triangles without an area. A polygon that crosses itself has no inside: it is filled as far as
//! ears go, the rest from one corner, and this is said.

use std::f64::consts::PI;

use crate::math::Vec3;

/// Corners that a polygon may have that is not convex: cutting ears takes the square of it.
const MOST_CORNERS: usize = 4096;
/// A corner turns neither way below this, relative to the square of the polygon's size: rounding.
const STRAIGHT: f64 = 1e-14;

/// A polygon as triangles.
pub(super) struct Filled {
    /// Positions of their corners among the polygon's, with its winding.
    pub triangles: Vec<[usize; 3]>,
    /// Whether the polygon crosses itself.
    pub crosses: bool,
}

/// Fills a polygon; fewer than three corners have nothing to fill.
///
/// # Errors
/// A polygon that is not convex and has more than [`MOST_CORNERS`] corners.
pub(super) fn fill(corners: &[Vec3]) -> Result<Filled, String> {
    if corners.len() <= 3 {
        return Ok(Filled::fan(corners.len(), false));
    }
    let first = least_rotation(corners);
    // From here on nothing depends on the corner that comes first.
    let rotated = [&corners[first..], &corners[..first]].concat();
    let Some(flat) = flatten(&rotated) else {
        return Ok(Filled::fan(corners.len(), fan_has_area(corners)));
    };
    let straight = STRAIGHT * flat.iter().map(square).fold(0.0, f64::max);
    if is_convex(&flat, straight) {
        return Ok(Filled::fan(corners.len(), false));
    }
    check_count(corners.len())?;
    Ok(cut_ears(&flat, straight).counted_from(first, corners.len()))
}

impl Filled {
    /// All triangles from the first corner.
    fn fan(corners: usize, crosses: bool) -> Self {
        Self {
            triangles: (2..corners).map(|at| [0, at - 1, at]).collect(),
            crosses,
        }
    }

    /// With corner 0 where `first` is among so many corners.
    fn counted_from(mut self, first: usize, corners: usize) -> Self {
        for triangle in &mut self.triangles {
            *triangle = triangle.map(|at| (at + first) % corners);
        }
        self
    }
}

fn fan_has_area(corners: &[Vec3]) -> bool {
    let has_area = |pair: &[Vec3]| {
        let [b, c] = [pair[0] - corners[0], pair[1] - corners[0]];
        b.cross(c).length() > 0.0
    };
    corners[1..].windows(2).any(has_area)
}

fn square(p: &[f64; 2]) -> f64 {
    p[0] * p[0] + p[1] * p[1]
}

fn check_count(corners: usize) -> Result<(), String> {
    if corners <= MOST_CORNERS {
        return Ok(());
    }
    let advice = "export the mesh as triangles";
    Err(format!(
        "a polygon of {corners} corners that is not convex; at most {MOST_CORNERS} are read: {advice}"
    ))
}

/// Where the least of all sequences begins that the same corners make from another one on (Booth's
/// question, asked simply: few corners are equal).
fn least_rotation(corners: &[Vec3]) -> usize {
    let key = |at: usize| {
        corners[at % corners.len()]
            .to_array()
            .map(|c| c + 0.0)
    };
    let is_less = |a: usize, b: usize| {
        let differ = (0..corners.len()).find(|step| key(a + step) != key(b + step));
        differ.is_some_and(|step| key(a + step) < key(b + step))
    };
    (1..corners.len()).fold(0, |best, at| if is_less(at, best) { at } else { best })
}

/// The corners along the polygon's normal, turning counter-clockwise; `None` where it has no
/// normal.
fn flatten(corners: &[Vec3]) -> Option<Vec<[f64; 2]>> {
    let from_first: Vec<Vec3> = corners
        .iter()
        .map(|corner| *corner - corners[0])
        .collect();
    let normal = normal(&from_first)?;
    let (x, y) = normal.try_normalize()?.any_orthonormal_pair();
    // The pair may turn either way about the normal.
    let y = if x.cross(y).dot(normal) < 0.0 { -y } else { y };
    let flat = from_first.iter().map(|p| [p.dot(x), p.dot(y)]);
    Some(flat.collect())
}

/// Newell's normal, which is right for polygons that are not convex, or not quite flat; `None`
/// where it is no more than rounding.
fn normal(from_first: &[Vec3]) -> Option<Vec3> {
    let next = from_first.iter().cycle().skip(1);
    let normal: Vec3 = from_first
        .iter()
        .zip(next)
        .map(|(a, b)| a.cross(*b))
        .sum();
    let squares = from_first.iter().map(|p| p.length_squared());
    let largest = squares.fold(0.0, f64::max);
    (normal.length() > STRAIGHT * largest).then_some(normal)
}

/// Whether the outline turns left or not at all, and once around.
fn is_convex(flat: &[[f64; 2]], straight: f64) -> bool {
    let sides = sides(flat);
    let pairs = sides.iter().zip(sides.iter().cycle().skip(1));
    let mut around = 0.0;
    for (a, b) in pairs {
        match turning(*a, *b, straight) {
            Some(angle) => around += angle,
            None => return false,
        }
    }
    around < 3.0 * PI
}

/// The sides of an outline that have a length.
fn sides(flat: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let pairs = flat.iter().zip(flat.iter().cycle().skip(1));
    pairs
        .map(|(a, b)| [b[0] - a[0], b[1] - a[1]])
        .filter(|side| *side != [0.0; 2])
        .collect()
}

/// How far the outline turns left from one side to the next; `None` where it turns right.
fn turning(a: [f64; 2], b: [f64; 2], straight: f64) -> Option<f64> {
    let cross = a[0] * b[1] - a[1] * b[0];
    let dot = a[0] * b[0] + a[1] * b[1];
    // Straight on, or straight back: a spike is no convex corner.
    let angle = if cross <= straight && dot < 0.0 {
        PI
    } else {
        cross.max(0.0).atan2(dot)
    };
    (cross >= -straight).then_some(angle)
}

fn cut_ears(flat: &[[f64; 2]], straight: f64) -> Filled {
    let mut left: Vec<usize> = (0..flat.len()).collect();
    let mut triangles = ears(flat, &mut left);
    let rest = (1..left.len() - 1).map(|at| [left[0], left[at], left[at + 1]]);
    let is_turned = |[a, b, c]: [usize; 3]| turn(flat[a], flat[b], flat[c]) < -straight;
    let crosses = rest.clone().any(is_turned);
    triangles.extend(rest);
    Filled { triangles, crosses }
}

/// Takes ears away from the corners that are left, until there are three or none is an ear.
fn ears(flat: &[[f64; 2]], left: &mut Vec<usize>) -> Vec<[usize; 3]> {
    let mut triangles = Vec::with_capacity(flat.len() - 2);
    let mut at = 0;
    let mut refused = 0;
    while left.len() > 3 && refused < left.len() {
        if is_ear(flat, left, at) {
            triangles.push(around(left, at));
            left.remove(at);
            refused = 0;
        } else {
            refused += 1;
            at += 1;
        }
        at %= left.len();
    }
    triangles
}

fn around(left: &[usize], at: usize) -> [usize; 3] {
    [
        left[(at + left.len() - 1) % left.len()],
        left[at],
        left[(at + 1) % left.len()],
    ]
}

/// Whether the triangle at a corner lies inside the polygon, with no other corner in it.
fn is_ear(flat: &[[f64; 2]], left: &[usize], at: usize) -> bool {
    let triangle = around(left, at);
    let corners = triangle.map(|i| flat[i]);
    let [a, b, c] = corners;
    // A polygon with a slit to a hole comes back to the same place: that is no corner in between.
    let is_other = |i: &&usize| !triangle.contains(i) && !corners.contains(&flat[**i]);
    let mut others = left.iter().filter(is_other);
    turn(a, b, c) > 0.0 && !others.any(|&i| is_inside(flat[i], corners))
}

fn is_inside(p: [f64; 2], [a, b, c]: [[f64; 2]; 3]) -> bool {
    turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0
}

/// Twice the area of a triangle, positive where it turns counter-clockwise.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::quat_exp;

    fn filled(corners: &[Vec3]) -> Vec<[usize; 3]> {
        let filled = fill(corners).unwrap();
        assert!(!filled.crosses, "{corners:?}");
        filled.triangles
    }

    fn areas(corners: &[Vec3]) -> Vec<Vec3> {
        let area = |t: [usize; 3]| {
            let [a, b, c] = t.map(|i| corners[i]);
            (b - a).cross(c - a) / 2.0
        };
        filled(corners).into_iter().map(area).collect()
    }

    fn from_corner(corners: &[Vec3], start: usize) -> Vec<Vec3> {
        corners
            .iter()
            .cycle()
            .skip(start)
            .take(corners.len())
            .copied()
            .collect()
    }

    /// The triangles as sets of places, each from its least corner.
    fn places(corners: &[Vec3]) -> Vec<[[f64; 3]; 3]> {
        let place = |t: [usize; 3]| {
            let mut corners = t.map(|i| corners[i].to_array());
            let least = (0..3)
                .min_by(|&a, &b| corners[a].partial_cmp(&corners[b]).unwrap())
                .unwrap();
            corners.rotate_left(least);
            corners
        };
        let mut all: Vec<_> = filled(corners).into_iter().map(place).collect();
        all.sort_by(|a, b| a.partial_cmp(b).unwrap());
        all
    }

    /// The areas of the triangles add up to the outline's only if none lies outside it.
    #[test]
    fn a_polygon_is_filled_to_its_outline_whatever_its_form_and_place() {
        let arrow = [[0.0, 0.0], [2.0, 1.0], [0.0, 2.0], [0.5, 1.0]];
        let comb = [
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 2.0],
            [3.0, 2.0],
            [3.0, 1.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [0.0, 2.0],
        ];
        let edge = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]];
        for (outline, area) in [(&arrow[..], 1.5), (&comb[..], 6.0), (&edge[..], 2.0)] {
            for turn in [Vec3::ZERO, Vec3::new(1.0, -2.0, 0.5), Vec3::X * PI] {
                let rotation = quat_exp(turn);
                let placed = |p: &[f64; 2]| {
                    rotation * Vec3::new(p[0], p[1], 0.3) + Vec3::new(5.0, 1.0, -2.0)
                };
                let corners: Vec<Vec3> = outline.iter().map(placed).collect();
                for start in 0..outline.len() {
                    let corners = from_corner(&corners, start);
                    let parts = areas(&corners);
                    let normal = rotation * Vec3::Z;
                    assert_eq!(parts.len(), corners.len() - 2);
                    let filled: f64 = parts.iter().map(|part| part.length()).sum();
                    assert!(
                        (filled - area).abs() < 1e-12,
                        "{outline:?} from {start}: {filled}"
                    );
                    assert!(
                        parts
                            .iter()
                            .all(|part| part.dot(normal) >= -1e-14),
                        "turned over: {outline:?}"
                    );
                }
            }
        }
    }

    /// Stars with random radii: simple, and mostly not convex.
    #[test]
    fn random_outlines_are_filled_exactly_and_whichever_corner_comes_first() {
        let mut rng = fastrand::Rng::with_seed(11);
        let mut concave = 0;
        for _ in 0..400 {
            let count = rng.usize(4..14);
            let at = |i: usize, rng: &mut fastrand::Rng| {
                let (sine, cosine) =
                    (2.0 * PI * (i as f64 + 0.8 * rng.f64()) / count as f64).sin_cos();
                Vec3::new(cosine, sine, 0.0) * (0.05 + rng.f64())
            };
            let outline: Vec<Vec3> = (0..count).map(|i| at(i, &mut rng)).collect();
            let rotation = quat_exp(crate::testing::vector(&mut rng, 3.0));
            let shift = crate::testing::vector(&mut rng, 9.0);
            let area: f64 = (0..count)
                .map(|i| outline[i].cross(outline[(i + 1) % count]).z / 2.0)
                .sum();
            let mut corners: Vec<Vec3> = outline
                .iter()
                .map(|p| rotation * *p + shift)
                .collect();
            if rng.bool() {
                let twice = rng.usize(0..count);
                corners.insert(twice, corners[twice]);
            }
            let parts: f64 = areas(&corners)
                .iter()
                .map(|part| part.length())
                .sum();
            assert!(
                (parts - area).abs() < 1e-11,
                "{parts} of {area}: {outline:?}"
            );
            let of_convex = is_convex(&flatten(&corners).unwrap(), 1e-14);
            if !of_convex {
                concave += 1;
                let first = places(&corners);
                (1..corners.len())
                    .for_each(|start| assert_eq!(places(&from_corner(&corners, start)), first));
            }
        }
        assert!(concave > 200, "{concave} of 400");
    }

    #[test]
    fn a_convex_polygon_is_a_fan_from_its_first_corner_even_where_it_is_bent() {
        let bent = [
            Vec3::ZERO,
            Vec3::new(1.0, 0.0, 0.5),
            Vec3::new(1.0, 1.0, 0.0),
            Vec3::new(0.0, 1.0, 0.5),
        ];
        for start in 0..4 {
            assert_eq!(filled(&from_corner(&bent, start)), [[0, 1, 2], [0, 2, 3]]);
        }
        let straight = [
            [0.0, 0.0],
            [1.0, 0.0],
            [2.0, 0.0],
            [2.0, 0.0],
            [2.0, 1.0],
            [0.0, 1.0],
        ];
        let straight = straight.map(|[x, y]| Vec3::new(x, y, 1.0));
        assert_eq!(
            filled(&straight),
            [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]
        );
    }

    #[test]
    fn what_has_no_inside_still_gives_triangles_and_says_so() {
        assert!(filled(&[Vec3::ZERO, Vec3::X]).is_empty());
        assert_eq!(
            filled(&[Vec3::ZERO, Vec3::X, Vec3::X * 2.0, Vec3::X * 3.0]).len(),
            2
        );
        let even = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(1.0, 1.0, 0.0)];
        let uneven = [Vec3::ZERO, Vec3::X * 3.0, Vec3::Y, Vec3::new(1.0, 1.0, 0.0)];
        for corners in [even, uneven] {
            let filled = fill(&corners).unwrap();
            assert!(filled.triangles.len() == 2 && filled.crosses, "{corners:?}");
        }
        let many = |count: usize| {
            let tooth =
                |i: usize| Vec3::new(i as f64, if i.is_multiple_of(2) { 0.0 } else { 1.0 }, 0.0);
            let mut corners: Vec<Vec3> = (0..count).map(tooth).collect();
            corners.push(Vec3::new(0.0, 5.0, 0.0));
            fill(&corners).map(|filled| filled.triangles.len())
        };
        assert_eq!(many(500), Ok(499));
        assert!(many(5000).unwrap_err().contains("5001 corners"));
    }
}
