//! The theorem for curves against samples, of all joint kinds: slides that turning joints carry swing out
//! between the ends of a piece.

use fastrand::Rng;

use super::motion::{Course, MotionBounds};
use super::polynomial::{Knot, Polynomial};
use super::soundness::cases;
use super::way::Expansion;
use super::{Scratch, Validator};
use crate::constraint::{Stand, Vector, Watched};
use crate::lanes::LANES;
use crate::math::Vec3;
use crate::robot::lane_kinematics::LaneInterval;
use crate::robot::{Component, Kinematics, RobotModel};
use crate::testing::{self, Oracle};

const FLOOR_M: f64 = 1e-3;

/// A cubic or quintic between two configurations, as fast at its ends as it likes.
fn column(rng: &mut Rng, from: f64, to: f64) -> Polynomial {
    let size = 3.0 * (to - from).abs() + 0.2;
    let mut knot = |position| Knot {
        position,
        velocity: testing::uniform(rng, -size, size),
        acceleration: testing::uniform(rng, -4.0 * size, 4.0 * size),
    };
    let ends = [knot(from), knot(to)];
    match rng.usize(0..4) {
        0 => Polynomial::quintic(ends[0], ends[1], 1.0),
        1 => Polynomial::linear(ends[0], ends[1], 1.0),
        _ => Polynomial::cubic(ends[0], ends[1], 1.0),
    }
}

/// A curve; quaternions stand still.
fn columns(rng: &mut Rng, robot: &RobotModel) -> Vec<Polynomial> {
    let from = testing::configuration(rng, robot);
    let to = testing::neighbour(rng, robot, &from);
    let mut columns: Vec<Polynomial> = from
        .iter()
        .map(|value| Polynomial::constant(*value))
        .collect();
    for component in robot.space().components() {
        if let Component::Line { q, .. } | Component::Circle { q, .. } = *component {
            columns[q] = column(rng, from[q], to[q]);
        }
    }
    columns
}

fn at(columns: &[Polynomial], t: f64) -> Vec<f64> {
    columns
        .iter()
        .map(|column| column.at(t))
        .collect()
}

fn held(robot: &RobotModel) -> Vec<f64> {
    let held = robot.held().iter();
    held.map(|variable| variable.default).collect()
}

/// The middle of an interval and its half width.
fn interval(rng: &mut Rng) -> (f64, f64) {
    let half = [0.5, 0.1, 0.02][rng.usize(0..3)];
    (testing::uniform(rng, half, 1.0 - half), half)
}

fn expansion(robot: &RobotModel, columns: &[Polynomial], (middle, half): (f64, f64)) -> Expansion {
    let mut expansion = Expansion::default();
    expansion.update(robot.space(), columns, middle, half);
    expansion
}

/// Where a vector is, and how fast it moves where the robot moves at this velocity.
fn seen(robot: &RobotModel, watched: &Watched, q: &[f64], velocity: &[f64]) -> [Vec3; 2] {
    let mut kinematics = Kinematics::default();
    kinematics.update(robot, q, &held(robot));
    kinematics.update_velocities(robot, velocity);
    let stand = Stand {
        kinematics: &kinematics,
        configuration: q,
        velocity,
    };
    [watched.at(&stand), watched.rate(&stand)]
}

/// A point or direction of a link, as the world or another link sees it.
fn watched(rng: &mut Rng, robot: &RobotModel) -> Watched {
    let links = robot.links().len();
    let mut link = || Some(rng.usize(0..=links)).filter(|link| *link < links);
    let ends = [link(), link()];
    let vector = match rng.bool() {
        true => Vector::Point(testing::vector(rng, 0.5)),
        false => Vector::Direction(
            testing::vector(rng, 1.0)
                .try_normalize()
                .unwrap_or(Vec3::Z),
        ),
    };
    Watched::new(robot, vector, ends[0], ends[1])
}

#[test]
fn columns_go_no_faster_and_no_farther_than_their_expansion_says() {
    let (count, mut rng) = cases(10_000);
    let mut most = [0.0_f64; 2];
    for _ in 0..count {
        let robot = testing::robot(&mut rng);
        let columns = columns(&mut rng, &robot);
        let (middle, half) = interval(&mut rng);
        let expansion = expansion(&robot, &columns, (middle, half));
        for component in robot.space().components() {
            let (Component::Line { q, v } | Component::Circle { q, v }) = *component else {
                continue;
            };
            for i in 0..=8 {
                let after = half * (f64::from(i) / 4.0 - 1.0);
                let speed = columns[q].derivative().at(middle + after).abs();
                let tangent = expansion.middle[q] + expansion.velocity[v] * after;
                let stray = (columns[q].at(middle + after) - tangent).abs();
                let bound = 0.5 * after * after * expansion.acceleration[v];
                assert!(speed <= expansion.speed[v] * (1.0 + 1e-12) + 1e-12);
                assert!(
                    stray <= bound * (1.0 + 1e-9) + 1e-12,
                    "{stray} above {bound}"
                );
                if stray > 1e-6 {
                    let parts = [speed / expansion.speed[v], stray / bound];
                    most = std::array::from_fn(|k| most[k].max(parts[k]));
                }
            }
        }
    }
    assert!(most.iter().all(|part| *part > 0.99), "{most:?}");
}

#[test]
fn what_is_watched_on_a_curve_bends_no_more_than_its_bound() {
    let (count, mut rng) = cases(10_000);
    let mut most = 0.0_f64;
    for _ in 0..count {
        let robot = testing::robot(&mut rng);
        let columns = columns(&mut rng, &robot);
        let watched = watched(&mut rng, &robot);
        let (middle, half) = interval(&mut rng);
        let expansion = expansion(&robot, &columns, (middle, half));
        let mut bounds = MotionBounds::default();
        bounds.update(watched.chain(), &Course::Curved(&expansion), &held(&robot));
        let [here, rate] = seen(&robot, &watched, &expansion.middle, &expansion.velocity);
        for side in [-1.0, -0.5, 0.25, 1.0] {
            let after = side * half;
            let there = seen(
                &robot,
                &watched,
                &at(&columns, middle + after),
                &expansion.velocity,
            )[0];
            let remainder = (there - here - rate * after).length();
            let bound = 0.5 * after * after * bounds.acceleration(0);
            assert!(
                remainder <= bound * (1.0 + 1e-9) + 1e-12,
                "{remainder} above {bound}"
            );
            assert!((there - here).length() <= bounds.speed(0) * after.abs() + 1e-12);
            if remainder > 1e-6 {
                most = most.max(remainder / bound);
            }
        }
    }
    println!("the most of a bound that was seen: {most:.4}");
    assert!(most > 0.9, "a bound cut by a tenth would hold too: {most}");
}

/// What an interval of a curve is proved to keep, parry finds kept; cut by a fifth it would not be.
#[test]
fn what_an_interval_of_a_curve_keeps_is_kept_and_the_bound_has_teeth() {
    let (count, mut rng) = cases(10_000);
    let [mut checked, mut refuted, mut refuted_wholes] = [0; 3];
    for _ in 0..count {
        let model = testing::model(&mut rng);
        let robot = model.robot();
        let oracle = Oracle::new(&model);
        let columns = columns(&mut rng, robot);
        let held = held(robot);
        let mut scratch = Scratch::default();
        let mut validator = Validator::new(&model, robot.space(), &held, FLOOR_M, &mut scratch);
        let (middle, half) = interval(&mut rng);
        for pair in 0..model.pairs().len() {
            let bound = validator.closest_bound_on_curve(&columns, (middle, half), pair);
            let Some((gap, displacement, wholes)) = bound else {
                continue;
            };
            let least = (0..=16)
                .map(|i| at(&columns, middle + half * (f64::from(i) / 8.0 - 1.0)))
                .map(|q| oracle.pair_distance(&model, pair, &q))
                .fold(f64::INFINITY, f64::min);
            let kept = gap - displacement;
            assert!(least > kept - 1e-7, "kept {kept} promised, {least} seen");
            assert!(
                least > wholes - 1e-7,
                "kept {wholes} promised of the wholes, {least} seen"
            );
            checked += 1;
            // Parry over-estimates smooth shapes by up to 1.7e-5 m.
            refuted += usize::from(least < gap - 0.8 * displacement - 2e-5);
            refuted_wholes += usize::from(least < gap - 0.8 * (gap - wholes) - 2e-5);
        }
    }
    println!("{checked} intervals, × 0.8 refuted {refuted}, {refuted_wholes}");
    assert!(checked > count / 2);
    assert!(refuted * 200 > checked && refuted_wholes * 40 > checked);
}

/// What the filter proves of an interval of a curve is kept all over it, and it is no idle promise.
#[test]
fn what_the_filter_proves_of_a_curve_is_kept() {
    let (count, mut rng) = cases(3_000);
    let mut checked = 0;
    let mut nearest = f64::INFINITY;
    for _ in 0..count {
        let model = testing::model(&mut rng);
        let robot = model.robot();
        if robot.space().nq() == 0 {
            continue;
        }
        let oracle = Oracle::new(&model);
        let columns = columns(&mut rng, robot);
        let held = held(robot);
        let mut scratch = Scratch::default();
        let mut validator = Validator::new(&model, robot.space(), &held, FLOOR_M, &mut scratch);
        let lanes: [LaneInterval; LANES] = std::array::from_fn(|_| {
            let (middle, half) = interval(&mut rng);
            LaneInterval {
                segment: 0,
                middle,
                half,
            }
        });
        let (unproved, kept) = validator.filtered_curve(&columns, lanes);
        let lane = rng.usize(0..LANES);
        let LaneInterval { middle, half, .. } = lanes[lane];
        for pair in 0..model.pairs().len() {
            let is_open =
                |(other, open): &(u32, u8)| *other as usize == pair && open >> lane & 1 == 1;
            if unproved.iter().any(is_open) {
                continue;
            }
            let least = (0..=16)
                .map(|i| at(&columns, middle + half * (f64::from(i) / 8.0 - 1.0)))
                .map(|q| oracle.pair_distance(&model, pair, &q))
                .fold(f64::INFINITY, f64::min);
            let claimed = f64::from(kept[lane]).max(FLOOR_M);
            assert!(least >= claimed - 1e-6, "{least} where {claimed} is kept");
            nearest = nearest.min(least - claimed);
            checked += 1;
        }
    }
    println!("{checked} pairs, nearest to the promise {nearest:.2e} m");
    assert!(checked > count && nearest < 0.02, "{checked}, {nearest}");
}
