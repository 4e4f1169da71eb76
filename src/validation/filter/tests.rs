//! What the filter promises, against the oracle and against itself with other layers.

use crate::collision::CollisionModel;
use crate::collision::filter::FilterBall;
use crate::lanes::LANES;
use crate::math::Vec3;
use crate::robot::lane_kinematics::LaneInterval;
use crate::solid::hulls::{Hull, HullCore};
use crate::testing::{self, Oracle};
use crate::validation::soundness::{cases, surface_points};
use crate::validation::{HitReason, Layers, Scratch, SegmentVerdict, Validator};

fn wide(v: [f32; 3]) -> Vec3 {
    Vec3::from_array(v.map(f64::from))
}

/// Points on and in the pieces of a body, in the frame that carries it.
fn points_in(body: &crate::collision::Body, rng: &mut fastrand::Rng) -> Vec<Vec3> {
    let mut points = Vec::new();
    for piece in body.solid.tree.pieces().iter() {
        let surface = surface_points(piece);
        for _ in 0..20 {
            let mut pick = || surface[rng.usize(0..surface.len())];
            let a = pick();
            let b = pick();
            let c = pick();
            let s = rng.f64();
            let t = rng.f64();
            points.push(a.lerp(b, s).lerp(c, t));
        }
        points.extend(surface);
    }
    points
        .into_iter()
        .map(|point| body.place.point(point))
        .collect()
}

fn in_ball(ball: &FilterBall, point: Vec3) -> bool {
    point.distance(wide(ball.center)) <= f64::from(ball.radius)
}

fn in_hull(hull: &Hull, point: Vec3) -> bool {
    let mut local = point - wide(hull.center);
    if let Some(axes) = hull.axes {
        local = Vec3::from_array(axes.map(|axis| wide(axis).dot(local)));
    }
    let outside = match hull.core {
        HullCore::Box(half) => (local.abs() - wide(half))
            .max(Vec3::ZERO)
            .length(),
        HullCore::Cylinder {
            radius,
            half_height,
        } => {
            let across = (local.x.hypot(local.y) - f64::from(radius)).max(0.0);
            across.hypot((local.z.abs() - f64::from(half_height)).max(0.0))
        }
    };
    outside <= f64::from(hull.radius)
}

#[test]
fn balls_and_hulls_enclose_their_bodies() {
    let (count, mut rng) = cases(150);
    for _ in 0..count {
        let model = testing::model(&mut rng);
        let filter = model.filter();
        for (index, body) in model.bodies().iter().enumerate() {
            let points = points_in(body, &mut rng);
            match filter.bodies.get(index) {
                Some(balls) => {
                    let (frame, place) = filter.skeleton.carrier(body.link);
                    assert_eq!(frame, balls.frame);
                    for point in points
                        .iter()
                        .map(|point| place.transform_point(*point))
                    {
                        assert!(
                            in_ball(&balls.root, point),
                            "{}: the root leaves out {point}",
                            body.name
                        );
                        assert!(
                            balls
                                .balls
                                .iter()
                                .any(|ball| in_ball(ball, point)),
                            "{}: {point}",
                            body.name
                        );
                        for (cluster, range) in &balls.clusters {
                            let inside = balls.balls[range.clone()].iter().all(|ball| {
                                wide(ball.center).distance(wide(cluster.center))
                                    + f64::from(ball.radius)
                                    <= f64::from(cluster.radius) * (1.0 + 1e-6) + 1e-6
                            });
                            assert!(inside, "{}: a cluster leaves out a ball", body.name);
                        }
                    }
                }
                None => {
                    let object = &filter.objects[index - filter.bodies.len()];
                    for point in points {
                        assert!(
                            in_hull(&object.hull, point),
                            "{}: the hull leaves out {point}",
                            body.name
                        );
                        let boxed = object.boxes.is_empty()
                            || object
                                .boxes
                                .iter()
                                .any(|part| in_hull(part, point));
                        assert!(boxed, "{}: no part has {point}", body.name);
                    }
                }
            }
        }
    }
}

/// Eight intervals of a segment.
fn intervals(rng: &mut fastrand::Rng) -> [LaneInterval; LANES] {
    let half = [0.5, 0.1, 0.02][rng.usize(0..3)];
    std::array::from_fn(|_| LaneInterval {
        segment: 0,
        middle: testing::uniform(rng, half, 1.0 - half),
        half,
    })
}

#[test]
fn places_in_the_lanes_are_off_by_less_than_their_margin() {
    let (count, mut rng) = cases(300);
    let mut worst = 0.0_f64;
    for _ in 0..count {
        let model = testing::model(&mut rng);
        let robot = model.robot();
        let filter = model.filter();
        let from = testing::configuration(&mut rng, robot);
        let to = testing::neighbour(&mut rng, robot, &from);
        let held: Vec<f64> = robot
            .held()
            .iter()
            .map(|held| held.default)
            .collect();
        let mut scratch = Scratch::default();
        let mut validator = Validator::new(&model, robot.space(), &held, 1e-3, &mut scratch);
        let lanes = intervals(&mut rng);
        let frames = validator.filtered_frames(&from, &to, lanes);
        let mut velocity = vec![0.0; robot.space().nv()];
        let mut q = vec![0.0; robot.space().nq()];
        robot
            .space()
            .difference(&to, &from, &mut velocity);
        for (lane, interval) in lanes.iter().enumerate() {
            robot
                .space()
                .integrate(&from, &velocity, interval.middle, &mut q);
            let poses = testing::link_poses(robot, &q);
            for body in &model.bodies()[..filter.bodies.len()] {
                let (frame, place) = filter.skeleton.carrier(body.link);
                let center = body.ball().center;
                let exact =
                    poses[body.link.unwrap()] * nalgebra::Point3::new(center.x, center.y, center.z);
                let seen = frames[frame].lane(
                    lane,
                    place
                        .transform_point(center)
                        .to_array()
                        .map(|x| x as f32),
                );
                let error = wide(seen).distance(Vec3::new(exact.x, exact.y, exact.z));
                let margin = filter
                    .skeleton
                    .rounding(place.transform_point(center).length())
                    + f64::from(validator.rounding_of_values());
                worst = worst.max(error / margin);
            }
        }
    }
    println!("largest error / margin {worst:.3}");
    assert!(worst < 0.5 && worst > 1e-4, "{worst}");
}

/// What the filter proves of an interval is kept all over it, and the smallest of it is what the
/// filter says.
#[test]
fn what_the_filter_proves_is_kept() {
    let (count, mut rng) = cases(400);
    let mut checked = 0;
    let floor = 1e-3;
    for _ in 0..count {
        let model = testing::model(&mut rng);
        let robot = model.robot();
        let oracle = Oracle::new(&model);
        let from = testing::configuration(&mut rng, robot);
        let to = testing::neighbour(&mut rng, robot, &from);
        let held: Vec<f64> = robot
            .held()
            .iter()
            .map(|held| held.default)
            .collect();
        let mut scratch = Scratch::default();
        let mut validator = Validator::new(&model, robot.space(), &held, floor, &mut scratch);
        let lanes = intervals(&mut rng);
        let (unproved, kept) = validator.filtered(&from, &to, lanes);
        // One lane is enough for each case; which one changes.
        let lane = rng.usize(0..LANES);
        for pair in 0..model.pairs().len() {
            if is_proved(&unproved, pair, lane) {
                let least = least_distance(&model, &oracle, pair, &from, &to, &lanes[lane]);
                let claimed = f64::from(kept[lane]).max(floor);
                assert!(least >= claimed - 1e-6, "{least} where {claimed} is kept");
                checked += 1;
            }
        }
    }
    assert!(checked > count);
}

/// A ball whose centre was inside a box once had 0 / 0 for what it keeps, which each set of
/// instructions took for something else: intervals were split into other parts from machine to
/// machine.
#[test]
fn what_the_filter_says_of_overlaps_is_a_number() {
    let (count, mut rng) = cases(300);
    let mut inside = 0;
    for _ in 0..count {
        let model = testing::model(&mut rng);
        let robot = model.robot();
        let from = testing::configuration(&mut rng, robot);
        let to = testing::neighbour(&mut rng, robot, &from);
        let held: Vec<f64> = robot
            .held()
            .iter()
            .map(|held| held.default)
            .collect();
        let said = [false, true].map(|portable_lanes| {
            let mut scratch = Scratch::default();
            let layers = Layers {
                portable_lanes,
                ..Layers::default()
            };
            let validator = Validator::new(&model, robot.space(), &held, 1e-3, &mut scratch);
            let mut validator = validator.with_layers(layers);
            validator.filtered(
                &from,
                &to,
                [LaneInterval {
                    segment: 0,
                    middle: 0.5,
                    half: 0.1,
                }; LANES],
            );
            validator
                .examiner
                .scratch
                .filter
                .unproved
                .iter()
                .map(|u| (u.pair, u.gap[0], u.excess[0]))
                .collect::<Vec<_>>()
        });
        assert!(
            said[0]
                .iter()
                .all(|(_, gap, excess)| !gap.is_nan() && !excess.is_nan()),
            "{:?}",
            said[0]
        );
        assert_eq!(said[0], said[1]);
        inside += said[0]
            .iter()
            .filter(|(_, gap, _)| *gap < 0.0)
            .count();
    }
    assert!(inside > count, "{inside} overlaps");
}

/// The widest interval that the filter proves is free, and one a quarter wider (a bound cut by a
/// fifth would prove it) often is not.
#[test]
fn the_filters_bound_has_teeth() {
    let (count, mut rng) = cases(600);
    let mut checked = 0;
    let mut refuted = 0;
    let floor = 1e-3;
    for _ in 0..count {
        let model = testing::plain_model(&mut rng);
        let robot = model.robot();
        let oracle = Oracle::new(&model);
        let from = testing::configuration(&mut rng, robot);
        let to = testing::neighbour(&mut rng, robot, &from);
        let held: Vec<f64> = robot
            .held()
            .iter()
            .map(|held| held.default)
            .collect();
        let mut scratch = Scratch::default();
        let mut validator = Validator::new(&model, robot.space(), &held, floor, &mut scratch);
        let middle = testing::uniform(&mut rng, 0.3, 0.7);
        let mut unproved = |half: f64| {
            validator
                .filtered(
                    &from,
                    &to,
                    [LaneInterval {
                        segment: 0,
                        middle,
                        half,
                    }; LANES],
                )
                .0
        };
        let mut proved = 0.0;
        let mut open = 0.3;
        let narrow = unproved(1e-4);
        let between = unproved(open)
            .into_iter()
            .find(|(pair, _)| is_proved(&narrow, *pair as usize, 0));
        let Some(pair) = between.map(|(pair, _)| pair as usize) else {
            continue;
        };
        let mut at = |half: f64| is_proved(&unproved(half), pair, 0);
        for _ in 0..14 {
            let half = (proved + open) / 2.0;
            *(if at(half) { &mut proved } else { &mut open }) = half;
        }
        let least = |half: f64| {
            least_distance(
                &model,
                &oracle,
                pair,
                &from,
                &to,
                &LaneInterval {
                    segment: 0,
                    middle,
                    half,
                },
            )
        };
        assert!(
            least(proved) >= floor - 1e-6,
            "{} in the widest interval that is proved",
            least(proved)
        );
        checked += 1;
        refuted += usize::from(least(proved / 0.8) < floor);
    }
    println!("{checked} intervals, × 0.8 refuted {refuted}");
    assert!(
        checked * 50 > count && refuted * 40 > checked,
        "{refuted} of {checked} refute a narrower bound"
    );
}

fn is_proved(unproved: &[(u32, u8)], pair: usize, lane: usize) -> bool {
    !unproved
        .iter()
        .any(|(other, lanes)| *other as usize == pair && lanes >> lane & 1 == 1)
}

/// Least distance that the oracle sees of a pair on an interval.
fn least_distance(
    model: &CollisionModel,
    oracle: &Oracle,
    pair: usize,
    from: &[f64],
    to: &[f64],
    interval: &LaneInterval,
) -> f64 {
    let space = model.robot().space();
    let mut velocity = vec![0.0; space.nv()];
    let mut q = vec![0.0; space.nq()];
    space.difference(to, from, &mut velocity);
    let distances = (-8..=8).map(|i| {
        space.integrate(
            from,
            &velocity,
            interval.middle + interval.half * f64::from(i) / 8.0,
            &mut q,
        );
        oracle.pair_distance(model, pair, &q)
    });
    distances.fold(f64::INFINITY, f64::min)
}

/// With any layer switched off verdicts are the same, but for clearances between 1 and 1.5 floors;
/// with other instructions they are the same to the last bit.
#[test]
fn verdicts_do_not_depend_on_layers() {
    let (count, mut rng) = cases(400);
    let full = Layers::default();
    let others = [
        Layers {
            filter: false,
            ..full
        },
        Layers {
            along_normal: false,
            ..full
        },
        Layers {
            filter: false,
            along_normal: false,
            reuse: false,
            portable_lanes: true,
        },
        Layers {
            reuse: false,
            ..full
        },
        Layers {
            portable_lanes: true,
            ..full
        },
    ];
    let mut proved = 0;
    let mut refused = 0;
    let mut between = 0;
    for _ in 0..count {
        let model: CollisionModel = testing::model(&mut rng);
        let robot = model.robot();
        let from = testing::configuration(&mut rng, robot);
        let to = testing::neighbour(&mut rng, robot, &from);
        let held: Vec<f64> = robot
            .held()
            .iter()
            .map(|held| held.default)
            .collect();
        let verdict = |layers: Layers| {
            let mut scratch = Scratch::default();
            let mut validator = Validator::new(&model, robot.space(), &held, 1e-3, &mut scratch)
                .with_layers(layers);
            validator.segment(&from, &to, &mut || false)
        };
        let with_all = verdict(full);
        for (index, layers) in others.into_iter().enumerate() {
            let without = verdict(layers);
            match (&with_all, &without) {
                _ if index >= 3 => assert_eq!(with_all, without, "{layers:?}"),
                (SegmentVerdict::Proved(_), SegmentVerdict::Proved(_)) => proved += 1,
                (SegmentVerdict::Refused(_), SegmentVerdict::Refused(_)) => refused += 1,
                (SegmentVerdict::Proved(_), SegmentVerdict::Refused(hit))
                | (SegmentVerdict::Refused(hit), SegmentVerdict::Proved(_)) => {
                    assert_eq!(hit.reason, HitReason::TooClose, "{layers:?}");
                    let distance = hit.measure.amount;
                    assert!(
                        (1e-3 - 1e-8..1.5e-3 + 1e-8).contains(&distance),
                        "{layers:?}: {distance}"
                    );
                    between += 1;
                }
                _ => unreachable!("nothing stops it"),
            }
        }
    }
    println!("{proved} proved and {refused} refused by both, {between} between 1 and 1.5 floors");
    assert!(proved > count / 4 && refused > count / 4);
}
