//! The promise of the timed proof, against samples of the curve and distances that share none of
//! its code.

use fastrand::Rng;

use super::inside::{Inside, stays_inside};
use super::*;
use crate::collision::CollisionModel;
use crate::math::Vec3;
use crate::path::Path;
use crate::robot::{Component, RobotModel};
use crate::testing::{self, Oracle};
use crate::validation::soundness::cases;
use crate::validation::{Corridor, Scratch};

const FLOOR_M: f64 = 1e-3;
/// How far the oracle's distances may be off (m).
const ORACLE_M: f64 = 2e-5;

fn verdict(model: &CollisionModel, curve: &Curve, strict: bool) -> TimedVerdict {
    let held: Vec<f64> = model
        .robot()
        .held()
        .iter()
        .map(|variable| variable.default)
        .collect();
    let space = model.robot().space().unwrapped();
    let mut scratch = Scratch::default();
    let mut validator = Validator::new(model, &space, &held, FLOOR_M, &mut scratch);
    let verdict = prove(&mut validator, curve, strict, &mut || false);
    assert!(
        validator
            .floors()
            .clearances()
            .iter()
            .all(|floor| *floor <= FLOOR_M),
        "the floors are as they were"
    );
    verdict
}

/// Two to four points near each other; quaternions stand still.
pub(in crate::validation) fn points(rng: &mut Rng, robot: &RobotModel) -> Vec<Point> {
    let space = robot.space();
    let first = testing::configuration(rng, robot);
    let mut points: Vec<Point> = Vec::new();
    let with_velocities = rng.f64() < 0.8;
    let with_accelerations = rng.f64() < 0.5;
    for index in 0..rng.usize(2..5) {
        let mut positions = match points.last() {
            None => first.clone(),
            Some(point) => testing::neighbour(rng, robot, &point.positions),
        };
        let mut is_still = vec![false; space.nq()];
        for component in space.components() {
            if let Component::Rotation { q, .. } = *component {
                positions[q..q + 4].copy_from_slice(&first[q..q + 4]);
                is_still[q..q + 4].fill(true);
            }
        }
        let mut rates = |size: f64| -> Vec<f64> {
            is_still
                .iter()
                .map(|still| {
                    if *still {
                        0.0
                    } else {
                        testing::uniform(rng, -size, size)
                    }
                })
                .collect()
        };
        let velocities = if with_velocities {
            rates(0.6)
        } else {
            Vec::new()
        };
        let accelerations = if with_velocities && with_accelerations {
            rates(2.0)
        } else {
            Vec::new()
        };
        points.push(Point {
            time_s: 0.7 * index as f64 + 0.2,
            positions,
            velocities,
            accelerations,
        });
    }
    points
}

/// The curve again, from the definition and not from its coefficients: Hermite's basis on [0, 1].
pub(in crate::validation) fn sampled(a: &Point, b: &Point, u: f64) -> Vec<f64> {
    let t = b.time_s - a.time_s;
    let u2 = u * u;
    let u3 = u.powi(3);
    let u4 = u.powi(4);
    let u5 = u.powi(5);
    let of = |list: &[f64], j: usize| list.get(j).copied().unwrap_or(0.0);
    let column = |j: usize| {
        let p = a.positions[j];
        let q = b.positions[j];
        let v = t * of(&a.velocities, j);
        let w = t * of(&b.velocities, j);
        let k = t * t * of(&a.accelerations, j);
        let l = t * t * of(&b.accelerations, j);
        if a.velocities.is_empty() {
            p + u * (q - p)
        } else if a.accelerations.is_empty() {
            let h = 3.0 * u2 - 2.0 * u3;
            let g = u3 - 2.0 * u2 + u;
            p * (1.0 - h) + q * h + v * g + w * (u3 - u2)
        } else {
            let h = 10.0 * u3 - 15.0 * u4 + 6.0 * u5;
            let g = u - 6.0 * u3 + 8.0 * u4 - 3.0 * u5;
            let f = -4.0 * u3 + 7.0 * u4 - 3.0 * u5;
            let e = 0.5 * u2 - 1.5 * u3 + 1.5 * u4 - 0.5 * u5;
            let d = 0.5 * u3 - u4 + 0.5 * u5;
            p * (1.0 - h) + q * h + v * g + w * f + k * e + l * d
        }
    };
    (0..a.positions.len()).map(column).collect()
}

#[test]
fn a_proved_curve_keeps_its_floors_and_a_refused_one_touches_where_it_says() {
    let (count, mut rng) = cases(250);
    let mut proved = 0;
    let mut touched = 0;
    let mut near = 0;
    for _ in 0..count {
        let model = testing::model(&mut rng);
        let points = points(&mut rng, model.robot());
        let curve = Curve::new(model.robot(), &points).unwrap();
        let oracle = Oracle::new(&model);
        let samples: Vec<Vec<f64>> = points
            .windows(2)
            .flat_map(|ends| {
                (0..=40)
                    .map(|i| sampled(&ends[0], &ends[1], f64::from(i) / 40.0))
                    .collect::<Vec<_>>()
            })
            .collect();
        match verdict(&model, &curve, false) {
            TimedVerdict::Proved(proof) => {
                proved += 1;
                for pair in 0..model.pairs().len() {
                    let lowered = proof
                        .lowered
                        .iter()
                        .find(|(lowered, _)| *lowered == Requirement::Clearance(pair));
                    let floor = lowered.map_or(FLOOR_M, |(_, floor)| *floor);
                    for q in &samples {
                        let distance = oracle.pair_distance(&model, pair, q);
                        assert!(distance >= floor - ORACLE_M, "{distance} below {floor}");
                        near += usize::from(distance < 10.0 * floor);
                    }
                }
            }
            // To the oracle a mesh is its surface: what begins wholly inside of one is apart from
            // it.
            TimedVerdict::Refused(hit)
                if hit.time_s == points[0].time_s
                    && hit.measure.points[0] == hit.measure.points[1] => {}
            TimedVerdict::Refused(hit) if hit.reason == HitReason::Collision => {
                touched += 1;
                let since = hit.time_s - points[hit.point].time_s;
                let ends = [&points[hit.point], &points[hit.point + 1]];
                let q = sampled(ends[0], ends[1], since / (ends[1].time_s - ends[0].time_s));
                assert!(
                    oracle.kept(&model, hit.requirement, &q) < ORACLE_M,
                    "{hit:?}"
                );
            }
            other => println!("{other:?}"),
        }
    }
    println!("{proved} proved, {touched} touch, {near} near samples");
    assert!(
        proved > count / 10 && touched > count / 20 && near > 20,
        "{proved} {touched} {near}"
    );
}

fn wall_at(y: f64) -> CollisionModel {
    testing::slider(&[(Vec3::new(0.5, y, 0.0), Vec3::new(1.0, 5e-4, 1.0))])
}

fn point(time_s: f64, positions: [f64; 2], velocities: [f64; 2]) -> Point {
    Point {
        time_s,
        positions: positions.to_vec(),
        velocities: velocities.to_vec(),
        ..Point::default()
    }
}

/// From y = 0 to y = 0 it swings out to y = v t (1 − t)² + v t² (1 − t), v/4 at the most, in the
/// middle.
fn swing(velocity: f64) -> Vec<Point> {
    vec![
        point(1.0, [0.0, 0.0], [1.0, velocity]),
        point(2.0, [1.0, 0.0], [1.0, -velocity]),
    ]
}

#[test]
fn a_wall_that_only_the_overshoot_between_two_points_meets() {
    let (count, mut rng) = cases(60);
    for _ in 0..count {
        let velocity = testing::uniform(&mut rng, 0.2, 2.0);
        let reached = velocity / 4.0 + 0.05 + 5e-4;
        let met = wall_at(reached - testing::uniform(&mut rng, 1e-6, 0.01));
        let missed = wall_at(reached + 2e-3);
        let curve =
            |model: &CollisionModel, points: &[Point]| Curve::new(model.robot(), points).unwrap();
        let straight: Vec<Point> = swing(velocity)
            .into_iter()
            .map(|point| Point {
                velocities: Vec::new(),
                ..point
            })
            .collect();
        assert!(matches!(
            verdict(&met, &curve(&met, &straight), true),
            TimedVerdict::Proved(_)
        ));
        match verdict(&met, &curve(&met, &swing(velocity)), false) {
            TimedVerdict::Refused(hit) => {
                assert_eq!((hit.reason, hit.point), (HitReason::Collision, 0));
                assert!(
                    (1.25..=1.5 + 1e-3).contains(&hit.time_s),
                    "first touched on the way out: {}",
                    hit.time_s
                );
            }
            other => panic!("{other:?}"),
        }
        assert!(matches!(
            verdict(&missed, &curve(&missed, &swing(velocity)), true),
            TimedVerdict::Proved(_)
        ));
    }
}

#[test]
fn a_curve_that_comes_closer_than_asked_lowers_a_floor_or_is_refused() {
    let model = wall_at(0.1 + 0.05 + 5e-4 + 4e-4);
    let curve = Curve::new(model.robot(), &swing(0.4)).unwrap();
    match verdict(&model, &curve, false) {
        TimedVerdict::Proved(proof) => {
            assert_eq!(proof.lowered, [(Requirement::Clearance(0), FLOOR_M / 4.0)]);
            assert!((2.5e-4..=4e-4).contains(&proof.clearance_m()), "{proof:?}");
        }
        other => panic!("{other:?}"),
    }
    match verdict(&model, &curve, true) {
        TimedVerdict::Refused(hit) => {
            assert_eq!(hit.reason, HitReason::TooClose);
            assert!(
                hit.measure.amount >= 3.9e-4 && hit.measure.amount < 2e-3,
                "{hit:?}"
            );
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn limits_count_between_points_too() {
    let model = testing::slider(&[]);
    let outside = |velocity| {
        Curve::new(model.robot(), &swing(velocity))
            .unwrap()
            .outside(model.robot())
    };
    assert_eq!(outside(7.9), None);
    let found = outside(8.4).unwrap();
    assert_eq!((found.point, found.column), (0, 1));
    assert!(
        (found.by - 0.1).abs() < 1e-9 && (found.time_s - 1.5).abs() < 1e-6,
        "{found:?}"
    );
}

#[test]
fn points_that_make_no_curve_are_named() {
    let model = testing::slider(&[]);
    let refusal = |points: &[Point]| {
        Curve::new(model.robot(), points)
            .unwrap_err()
            .to_string()
    };
    let [a, b] = [
        point(0.0, [0.0; 2], [0.0; 2]),
        point(1.0, [0.5; 2], [0.0; 2]),
    ];
    assert_eq!(
        refusal(std::slice::from_ref(&a)),
        "the trajectory has 1 points; it needs at least 2"
    );
    let back = refusal(&[
        a.clone(),
        Point {
            time_s: 0.0,
            ..b.clone()
        },
    ]);
    assert_eq!(
        back,
        "point 1: its time is 0 s, that of the point before 0 s; times must grow"
    );
    let short = refusal(&[
        a.clone(),
        Point {
            velocities: vec![1.0],
            ..b.clone()
        },
    ]);
    assert_eq!(short, "point 1: 1 velocities given, 2 needed");
    let lone = Point {
        velocities: Vec::new(),
        accelerations: vec![0.0; 2],
        ..b.clone()
    };
    assert!(
        refusal(&[a.clone(), lone]).starts_with("point 1: it has accelerations but no velocities")
    );
    let infinite = Point {
        positions: vec![f64::NAN, 0.0],
        ..b
    };
    assert_eq!(
        refusal(&[a, infinite]),
        "point 1: positions hold NaN; they must be finite"
    );
}

#[test]
fn a_trajectory_along_a_path_is_inside_its_corridor_and_one_that_strays_is_not() {
    let (count, mut rng) = cases(100);
    let model = testing::slider(&[]);
    let path = Path::from_rows(2, vec![0.0, 0.0, 0.5, 0.1, 1.0, 0.0]).unwrap();
    for _ in 0..count {
        let slack = testing::uniform(&mut rng, 1e-4, 5e-3);
        let corridor = Corridor {
            floor_m: FLOOR_M,
            reach: vec![1.0, 2.0],
            slack_m: vec![slack, 2.0 * slack],
        };
        let check = |points: &[Point]| {
            stays_inside(
                &Curve::new(model.robot(), points).unwrap(),
                &path,
                &corridor,
                &mut || false,
            )
        };
        // Straight on the path, but for a step aside of this part of the slack on the second
        // segment.
        let aside = |part: f64| {
            let y = 0.05 + part * slack;
            let still = [0.0; 2];
            let times = [0.0, 1.0, 1.5, 2.0];
            let positions = [[0.0, 0.0], [0.5, 0.1], [0.75, y], [1.0, 0.0]];
            let point = |(time, at): (&f64, &[f64; 2])| Point {
                velocities: Vec::new(),
                ..point(*time, *at, still)
            };
            times
                .iter()
                .zip(&positions)
                .map(point)
                .collect::<Vec<_>>()
        };
        assert!(matches!(check(&aside(0.0)), Inside::Yes(used) if used < 1e-3));
        assert!(matches!(check(&aside(0.9)), Inside::Yes(used) if (used - 0.9).abs() < 0.05));
        match check(&aside(1.1)) {
            Inside::No {
                point,
                time_s,
                segment,
                excess_m,
            } => {
                assert_eq!((point, segment), (1, 1));
                assert!((1.4..1.5).contains(&time_s), "{time_s}");
                assert!(
                    (excess_m - 0.2 * slack).abs() < 1e-6,
                    "the point aside is out by a tenth of twice the slack: {excess_m}"
                );
            }
            other => panic!("{other:?}"),
        }
    }
}
