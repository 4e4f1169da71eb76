//! Each answer is its own certificate: points on the pieces bound the distance from above, the
//! support gap from below. The tests check both with formulas of their own, and that they meet.

// A core that has no formula of its own here is not drawn here.
#![allow(clippy::wildcard_enum_match_arm)]

use fastrand::Rng;
use parry3d_f64::query;
use parry3d_f64::shape::{Cuboid, Segment, Triangle};

use super::*;
use crate::math::{Mat3, Pose, Quat, quat_exp};
use crate::solid::transform::Transform;
use crate::testing::{uniform, vector};
use crate::validation::soundness::cases;

const KINDS: [&str; 5] = ["point", "segment", "triangle", "box", "cylinder"];

/// A core of one kind about a place within `size` of the origin.
fn core(rng: &mut Rng, kind: usize, size: f64) -> Core {
    let pose = Transform {
        rotation: Mat3::from_quat(quat_exp(vector(rng, 1.8))),
        translation: vector(rng, size),
    };
    upright(rng, kind).transformed(&pose)
}

fn upright(rng: &mut Rng, kind: usize) -> Core {
    let center = Vec3::ZERO;
    let axes = Mat3::IDENTITY;
    let mut size = || uniform(rng, 0.02, 0.4);
    match kind {
        0 => Core::Point(center),
        1 => Core::Segment(Vec3::Z * -size(), Vec3::Z * size()),
        2 => Core::Triangle(
            Vec3::X * size(),
            Vec3::new(-size(), size(), 0.0),
            Vec3::new(-size(), -size(), 0.0),
        ),
        3 => Core::Box {
            center,
            axes,
            half: Vec3::new(size(), size(), size()),
        },
        _ => Core::Cylinder {
            center,
            axes,
            half_height: size(),
            radius: size(),
        },
    }
}

/// Two cores in parallel or at right angles, on a grid so coarse that faces, edges and corners
/// meet; some out of line by a rounding or by a nanoradian.
fn aligned(rng: &mut Rng, kinds: (usize, usize)) -> (Core, Core) {
    let mut place = |kind| {
        let quarter = |rng: &mut Rng| std::f64::consts::FRAC_PI_2 * f64::from(rng.u8(0..4));
        let turn = Quat::from_rotation_z(quarter(rng)) * Quat::from_rotation_x(quarter(rng));
        let tilt = [0.0, 0.0, 1e-16, 1e-12, 1e-9, 1e-6][rng.usize(0..6)];
        let grid = |rng: &mut Rng| 0.1 * f64::from(rng.i8(-6..7));
        let step = |rng: &mut Rng| 0.1 * f64::from(rng.u8(1..4));
        let core = match kind {
            0 => Core::Point(Vec3::ZERO),
            1 => Core::Segment(Vec3::ZERO, Vec3::Z * step(rng)),
            2 => Core::Triangle(Vec3::ZERO, Vec3::X * step(rng), Vec3::Y * step(rng)),
            3 => {
                let half = Vec3::new(step(rng), step(rng), step(rng));
                Core::Box {
                    center: Vec3::ZERO,
                    axes: Mat3::IDENTITY,
                    half,
                }
            }
            _ => {
                let half_height = step(rng);
                let radius = step(rng);
                Core::Cylinder {
                    center: Vec3::ZERO,
                    axes: Mat3::IDENTITY,
                    half_height,
                    radius,
                }
            }
        };
        let turn = Mat3::from_quat(turn * quat_exp(vector(rng, tilt)));
        let translation = Vec3::new(grid(rng), grid(rng), grid(rng));
        core.transformed(&Transform {
            rotation: turn,
            translation,
        })
    };
    let first = place(kinds.0);
    (first, place(kinds.1))
}

/// Corners of a core, for a cylinder those of prisms around its rims: their hull contains the core.
fn corners(core: &Core) -> Vec<Vec3> {
    let signs = || {
        (0..8).map(|i| {
            Vec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64) * 2.0 - Vec3::ONE
        })
    };
    match *core {
        Core::Point(a) => vec![a],
        Core::Segment(a, b) => vec![a, b],
        Core::Triangle(a, b, c) => vec![a, b, c],
        Core::Box { center, axes, half } => signs()
            .map(|s| center + axes * (s * half))
            .collect(),
        _ => unreachable!("a core without corners has a reach of its own"),
    }
}

/// Largest `direction · x` over a core, from the definition.
fn reach(core: &Core, direction: Vec3) -> f64 {
    if let Core::Cylinder {
        center,
        axes,
        half_height,
        radius,
    } = *core
    {
        let along = axes.z_axis.dot(direction);
        let across = direction.cross(axes.z_axis).length();
        return center.dot(direction) + half_height * along.abs() + radius * across;
    }
    corners(core)
        .iter()
        .map(|x| x.dot(direction))
        .fold(f64::NEG_INFINITY, f64::max)
}

/// How far a point is from a core, by the core's own inequalities.
fn outside(core: &Core, p: Vec3) -> f64 {
    let beside = |a: Vec3, b: Vec3| {
        let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        (a + (b - a) * t).distance(p)
    };
    if let Core::Cylinder {
        center,
        axes,
        half_height,
        radius,
    } = *core
    {
        let along = axes.z_axis.dot(p - center);
        let across = (p - center - axes.z_axis * along).length();
        return (across - radius)
            .max(0.0)
            .hypot((along.abs() - half_height).max(0.0));
    }
    match *core {
        Core::Point(a) => a.distance(p),
        Core::Segment(a, b) => beside(a, b),
        Core::Triangle(a, b, c) => {
            let normal = (b - a).cross(c - a).normalize();
            let over =
                [(a, b), (b, c), (c, a)].map(|(u, v)| (v - u).cross(p - u).dot(normal) >= 0.0);
            if over == [true; 3] {
                normal.dot(p - a).abs()
            } else {
                beside(a, b).min(beside(b, c)).min(beside(c, a))
            }
        }
        Core::Box { center, axes, half } => {
            let local = Vec3::new(
                axes.x_axis.dot(p - center),
                axes.y_axis.dot(p - center),
                axes.z_axis.dot(p - center),
            );
            (local.abs() - half).max(Vec3::ZERO).length()
        }
        _ => unreachable!("only cores whose inequalities stand here are asked"),
    }
}

/// Upper bound minus lower bound of an answer, all of its promises checked; `None` where it says
/// overlap.
fn slack(a: &Piece, b: &Piece, seen: &Separation, what: &str) -> Option<f64> {
    assert!(
        (seen.normal.length() - 1.0).abs() < 1e-12,
        "{what}: normal {:?}",
        seen.normal
    );
    let upper = (seen.point_a - seen.point_b).dot(seen.normal);
    if upper <= 1e-9 {
        assert!(seen.gap <= 1e-9, "{what}: overlap, but gap {}", seen.gap);
        return None;
    }
    let lower = -reach(&a.core, -seen.normal) - reach(&b.core, seen.normal) - a.radius - b.radius;
    assert!(
        (seen.gap - lower).abs() < 1e-13,
        "{what}: gap {} by the definition {lower}",
        seen.gap
    );
    for (piece, point, side) in [(a, seen.point_a, "A"), (b, seen.point_b, "B")] {
        let beside = outside(&piece.core, point) - piece.radius;
        assert!(beside < 1e-9, "{what}: point of {side} {beside} m outside");
    }
    let apart = seen.point_a - seen.point_b;
    assert!(
        apart.distance(seen.normal * upper) < 1e-9,
        "{what}: points {apart} along {}",
        seen.normal
    );
    assert!(
        seen.gap <= upper + 1e-12,
        "{what}: gap {} above the points' distance {upper}",
        seen.gap
    );
    Some(upper - seen.gap)
}

fn piece(core: Core) -> Piece {
    Piece { core, radius: 0.0 }
}

/// What parry says of two cores without curves; it is exact there.
fn by_parry(a: &Core, b: &Core) -> Option<f64> {
    let shape = |core: &Core| -> Option<(Pose, Box<dyn parry3d_f64::shape::Shape>)> {
        let here = Pose::identity();
        Some(match *core {
            Core::Segment(p, q) => (here, Box::new(Segment::new(p, q))),
            Core::Triangle(p, q, r) => (here, Box::new(Triangle::new(p, q, r))),
            Core::Box { center, axes, half } => (
                Pose::from_parts(center, Quat::from_mat3(&axes)),
                Box::new(Cuboid::new(half)),
            ),
            _ => return None,
        })
    };
    let (at_a, a) = shape(a)?;
    let (at_b, b) = shape(b)?;
    query::distance(&at_a, &*a, &at_b, &*b)
        .ok()
        .map(|answer| answer.distance)
}

/// Checks many poses of each pair of kinds; returns the largest slack.
fn check_pairs(
    name: &str,
    count: usize,
    most: f64,
    mut pose: impl FnMut((usize, usize)) -> (Core, Core),
) -> f64 {
    let mut worst = 0.0_f64;
    for (i, kind_a) in KINDS.iter().enumerate() {
        for (j, kind_b) in KINDS.iter().enumerate() {
            let what = format!("{name} {kind_a} × {kind_b}");
            let mut widest = 0.0_f64;
            let mut apart = 0;
            for _ in 0..count {
                let (a, b) = pose((i, j));
                let what = format!("{what}: {a:?} {b:?}");
                let seen = separation(&piece(a), &piece(b));
                let slack = slack(&piece(a), &piece(b), &seen, &what);
                let upper = seen.point_a.distance(seen.point_b);
                if let Some(parry) = by_parry(&a, &b) {
                    // An upper bound too; looser for segments a nanoradian apart, and it takes what
                    // all but touches for touching.
                    assert!(
                        upper < parry + 1e-9 || upper < 1e-7,
                        "{what}: {upper}, parry {parry}"
                    );
                }
                if let Some(slack) = slack {
                    // Nearer than any floor, rounding may choose the wrong one of two pairs of
                    // edges.
                    let most = if (i, j) == (4, 4) { 1e-8 } else { most };
                    assert!(
                        slack < most + 1e-14 / upper || upper < 1e-6,
                        "{what}: {} to {upper}: {slack}",
                        seen.gap
                    );
                    if upper < 1e-6 {
                        continue;
                    }
                    widest = widest.max(slack);
                    apart += 1;
                } else if i != j || i == 4 {
                    let common = outside(&a, seen.point_b).max(outside(&b, seen.point_a));
                    assert!(common < 1e-9, "{what}: said to overlap, {common}");
                }
            }
            println!("{what}: {apart} of {count} apart, slack up to {widest:.1e}");
            worst = worst.max(widest);
        }
    }
    worst
}

#[test]
fn points_and_gaps_meet_in_random_poses() {
    let (count, mut rng) = cases(400);
    check_pairs("random", count, 1e-10, |(i, j)| {
        let size = [0.2, 0.8, 3.0][rng.usize(0..3)];
        (core(&mut rng, i, size), core(&mut rng, j, size))
    });
}

#[test]
fn points_and_gaps_meet_in_parallel_poses() {
    let (count, mut rng) = cases(400);
    check_pairs("parallel", count, 1e-10, |kinds| aligned(&mut rng, kinds));
}

fn posed(core: Core, rotation: [f64; 4], translation: [f64; 3]) -> Core {
    let [x, y, z, w] = rotation;
    let rotation = Mat3::from_quat(Quat::from_xyzw(x, y, z, w).normalize());
    core.transformed(&Transform {
        rotation,
        translation: Vec3::from_array(translation),
    })
}

fn capsule(half_length: f64, radius: f64) -> Piece {
    Piece {
        core: Core::Segment(Vec3::Z * -half_length, Vec3::Z * half_length),
        radius,
    }
}

fn cuboid(half: [f64; 3]) -> Core {
    Core::Box {
        center: Vec3::ZERO,
        axes: Mat3::IDENTITY,
        half: Vec3::from_array(half),
    }
}

/// Poses for which parry's iteration over-estimates the distance of smooth shapes, by up to 1.7e-5
/// m.
#[test]
fn distances_of_capsules_that_an_iteration_over_estimates() {
    let other = Piece {
        core: posed(
            capsule(0.1, 0.0).core,
            [
                -0.26163221420256183,
                0.8875276038267238,
                0.16392009014825218,
                -0.34201394852088696,
            ],
            [
                0.22585360969274926,
                -0.07966046117667758,
                -0.1843787092366015,
            ],
        ),
        radius: 0.05,
    };
    let seen = separation(&capsule(0.15, 0.06), &other);
    assert!((seen.gap - 0.0908817046).abs() < 1e-9, "{}", seen.gap);
    assert!(slack(&capsule(0.15, 0.06), &other, &seen, "capsules").unwrap() < 1e-14);

    // The quaternion was measured 8e-8 longer than a unit, with 0.0910617335; of unit length it
    // gives this.
    let other = posed(
        cuboid([0.05, 0.1, 0.2]),
        [
            -0.41087883922593015,
            -0.36764217689404527,
            0.7963622123508917,
            0.2486467380362126,
        ],
        [
            -0.08909969234427739,
            -0.013730884249530506,
            0.471324974938399,
        ],
    );
    let seen = separation(&capsule(0.15, 0.06), &piece(other));
    assert!(
        (seen.gap - 0.091_061_776_643_421_6).abs() < 1e-12,
        "{}",
        seen.gap
    );
    assert!((seen.gap - 0.0910617335).abs() < 1e-7, "{}", seen.gap);
    assert!(
        slack(
            &capsule(0.15, 0.06),
            &piece(other),
            &seen,
            "capsule and box"
        )
        .unwrap()
            < 1e-14
    );
}

/// A box that hangs below a floor of two triangles, where parry's closest points are 3.4 m apart.
#[test]
fn points_and_normals_of_a_box_parallel_to_a_floor() {
    let a = [-2.0, -2.0, 0.0];
    let b = [2.0, -2.0, 0.0];
    let c = [2.0, 2.0, 0.0];
    let d = [-2.0, 2.0, 0.0];
    let at = Vec3::from_array;
    let floor = [
        Core::Triangle(at(a), at(b), at(c)),
        Core::Triangle(at(a), at(c), at(d)),
    ];
    for turn in [0.0, 0.3, std::f64::consts::FRAC_PI_2] {
        let half_turn = [0.0, 0.0, f64::sin(turn / 2.0), f64::cos(turn / 2.0)];
        let mut least = f64::INFINITY;
        for (i, triangle) in floor.iter().enumerate() {
            for height in [-0.25, 0.25] {
                let box_ = posed(cuboid([0.05, 0.1, 0.2]), half_turn, [1.35, 1.45, height]);
                let seen = separation(&piece(*triangle), &piece(box_));
                let what = format!("triangle {i}, {height}, turned {turn}");
                assert!(
                    slack(&piece(*triangle), &piece(box_), &seen, &what).unwrap() < 1e-12,
                    "{what}"
                );
                if (seen.gap - 0.05).abs() < 1e-12 {
                    assert!(
                        (seen.normal + Vec3::Z * height.signum()).length() < 1e-9,
                        "{what}: {:?}",
                        seen.normal
                    );
                }
                least = least.min(seen.gap);
            }
        }
        assert!((least - 0.05).abs() < 1e-12, "turned {turn}: {least}");
    }
}

/// Faces, sides and lids that lie flat against each other: the normal is theirs, the points are on
/// both.
#[test]
fn points_and_normals_where_solids_lie_flat() {
    let lid = |z: f64| Core::Cylinder {
        center: Vec3::Z * z,
        axes: Mat3::IDENTITY,
        half_height: 0.1,
        radius: 0.2,
    };
    let lying = Core::Cylinder {
        center: Vec3::new(0.05, 0.0, 0.4),
        axes: Mat3::from_quat(Quat::from_rotation_y(std::f64::consts::FRAC_PI_2)),
        half_height: 0.15,
        radius: 0.1,
    };
    let aside = |core: Core, x: f64, y: f64, z: f64| {
        core.transformed(&Transform {
            rotation: Mat3::IDENTITY,
            translation: Vec3::new(x, y, z),
        })
    };
    let block = cuboid([0.3, 0.2, 0.1]);
    let rod = |z: f64| Core::Segment(Vec3::new(-0.5, 0.2, z), Vec3::new(0.5, 0.2, z));
    let tile = Core::Triangle(
        Vec3::new(-0.1, 0.0, 0.3),
        Vec3::new(0.1, 0.0, 0.3),
        Vec3::new(0.0, 0.1, 0.3),
    );
    let cases = [
        ("lid on lid", lid(0.5), lid(0.0), 0.3, Vec3::Z),
        (
            "lid on lid, off centre",
            aside(lid(0.5), 0.3, 0.1, 0.0),
            lid(0.0),
            0.3,
            Vec3::Z,
        ),
        (
            "lids side by side",
            aside(lid(0.05), 0.5, 0.0, 0.0),
            lid(0.0),
            0.1,
            Vec3::X,
        ),
        ("cylinder lying on a lid", lying, lid(0.0), 0.2, Vec3::Z),
        (
            "box face to face",
            aside(block, 0.1, 0.05, 0.4),
            block,
            0.2,
            Vec3::Z,
        ),
        (
            "box face to face, beyond its rim",
            aside(block, 0.55, 0.35, 0.4),
            block,
            0.2,
            Vec3::Z,
        ),
        (
            "box on a lid",
            aside(block, 0.1, 0.0, 0.4),
            lid(0.0),
            0.2,
            Vec3::Z,
        ),
        ("box under a lying cylinder", lying, block, 0.2, Vec3::Z),
        (
            "rod along an edge of a box",
            rod(0.25),
            block,
            0.15,
            Vec3::Z,
        ),
        ("tile on a box", tile, block, 0.2, Vec3::Z),
        ("tile on a lid", tile, lid(0.0), 0.2, Vec3::Z),
        (
            "tile on a larger tile",
            tile,
            posed(tile, [0.0, 0.0, 0.0, 1.0], [0.02, -0.03, -0.25]),
            0.25,
            Vec3::Z,
        ),
        (
            "rod on a tile",
            aside(rod(0.6), 0.0, -0.15, 0.0),
            tile,
            0.3,
            Vec3::Z,
        ),
    ];
    for (what, a, b, distance, normal) in cases {
        for (a, b, normal) in [(a, b, normal), (b, a, -normal)] {
            for radius in [0.0, 0.03] {
                let a = Piece { core: a, radius };
                let b = piece(b);
                let seen = separation(&a, &b);
                assert!(
                    (seen.gap - (distance - radius)).abs() < 1e-12,
                    "{what}: {}",
                    seen.gap
                );
                assert!(
                    (seen.normal - normal).length() < 1e-9,
                    "{what}: {:?}",
                    seen.normal
                );
                assert!(slack(&a, &b, &seen, what).unwrap() < 1e-12, "{what}");
                let contact = contact(&a, &b);
                assert!(
                    (contact.distance - seen.gap).abs() < 1e-12,
                    "{what}: {contact:?}"
                );
                assert_eq!(
                    (contact.point_a, contact.point_b),
                    (seen.point_a, seen.point_b),
                    "{what}"
                );
            }
        }
    }
}

/// `contact_within` may leave out only what is not closer, and whatever it returns is the contact.
#[test]
fn asked_with_a_bound_nothing_closer_is_left_out() {
    let (count, mut rng) = cases(300);
    let mut spared = 0;
    let mut asked = 0;
    for _ in 0..count {
        for i in 0..5 {
            for j in 0..5 {
                let a = piece(core(&mut rng, i, 0.5));
                let b = piece(core(&mut rng, j, 0.5));
                let full = contact(&a, &b);
                let within = uniform(&mut rng, -0.1, 0.8);
                match contact_within(&a, &b, within) {
                    Some(seen) => assert_eq!(seen, full),
                    None => assert!(
                        full.distance >= within - 1e-9,
                        "{a:?} {b:?}: {full:?} within {within}"
                    ),
                }
                asked += usize::from(full.distance >= within);
                spared += usize::from(contact_within(&a, &b, within).is_none());
            }
        }
    }
    println!("{spared} of {asked} spared");
    assert!(2 * spared > asked, "only {spared} of {asked} were spared");
}

/// What the gap was computed from is exact to the margin stated above, however far out the pieces
/// lie.
#[test]
fn gaps_keep_to_the_stated_rounding() {
    let (count, mut rng) = cases(500);
    for far in [1.0, 30.0, 1000.0] {
        for _ in 0..count {
            let kinds = (rng.usize(0..4), rng.usize(0..4));
            let a = core(&mut rng, kinds.0, 0.6);
            let b = core(&mut rng, kinds.1, 0.6);
            // Places on a grid of 2⁻²⁰ m are moved without rounding, so the distance stays what it
            // was.
            let snap = |core: &Core, shift: Vec3| {
                let coarse = |p: Vec3| (p * 1_048_576.0).round() / 1_048_576.0 + shift;
                match *core {
                    Core::Point(p) => Core::Point(coarse(p)),
                    Core::Segment(p, q) => Core::Segment(coarse(p), coarse(q)),
                    Core::Triangle(p, q, r) => Core::Triangle(coarse(p), coarse(q), coarse(r)),
                    Core::Box { center, axes, half } => Core::Box {
                        center: coarse(center),
                        axes,
                        half,
                    },
                    other => other,
                }
            };
            let shift = (vector(&mut rng, far) * 1024.0).round() / 1024.0;
            let normal = vector(&mut rng, 1.0).normalize();
            let near = gap_along(
                &piece(snap(&a, Vec3::ZERO)),
                &piece(snap(&b, Vec3::ZERO)),
                normal,
            );
            let away = gap_along(&piece(snap(&a, shift)), &piece(snap(&b, shift)), normal);
            let margin = 40.0 * f64::EPSILON / 2.0 * (far + 2.0);
            assert!(
                (near - away).abs() <= margin,
                "{far} m away: {near} became {away}"
            );
        }
    }
}
