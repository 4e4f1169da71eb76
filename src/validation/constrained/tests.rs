use std::f64::consts::PI;

use fastrand::Rng;

use super::*;
use crate::constraint::region::{Cylinder, HalfSpace, Region};
use crate::constraint::watched::angle_seen_from;
use crate::constraint::{ConstraintKind, JointValue, Stand, Vector, Watched};
use crate::math::{Quat, Vec3};
use crate::path::Path;
use crate::robot::Component;
use crate::robot::Kinematics;
use crate::robot::RobotModel;
use crate::scene::Scene;
use crate::testing;
use crate::validation::soundness::cases;
use crate::validation::{HitReason, Scratch, SegmentRefusal, Validator};

/// A segment of a robot, and where it stands on it.
struct Arc<'r> {
    robot: &'r RobotModel,
    from: Vec<f64>,
    velocity: Vec<f64>,
    held: Vec<f64>,
}

impl<'r> Arc<'r> {
    fn random(rng: &mut Rng, robot: &'r RobotModel) -> Self {
        let from = testing::configuration(rng, robot);
        let to = testing::neighbour(rng, robot, &from);
        let mut velocity = vec![0.0; robot.space().nv()];
        robot
            .space()
            .difference(&to, &from, &mut velocity);
        Self {
            robot,
            from,
            velocity,
            held: robot.held().iter().map(|h| h.default).collect(),
        }
    }

    fn at(&self, t: f64) -> Standing {
        let mut q = vec![0.0; self.from.len()];
        let space = self.robot.space();
        space.integrate(&self.from, &self.velocity, t, &mut q);
        let mut kinematics = Kinematics::default();
        kinematics.update(self.robot, &q, &self.held);
        kinematics.update_velocities(self.robot, &self.velocity);
        Standing {
            kinematics,
            configuration: q,
            velocity: self.velocity.clone(),
        }
    }

    fn bounds(&self, watched: &Watched) -> MotionBounds {
        let mut bounds = MotionBounds::default();
        let course = Course::Straight {
            from: &self.from,
            velocity: &self.velocity,
        };
        bounds.update(watched.chain(), &course, &self.held);
        bounds
    }
}

/// Where a robot stands on a segment.
struct Standing {
    kinematics: Kinematics,
    configuration: Vec<f64>,
    velocity: Vec<f64>,
}

impl Standing {
    fn stand(&self) -> Stand<'_> {
        Stand {
            kinematics: &self.kinematics,
            configuration: &self.configuration,
            velocity: &self.velocity,
        }
    }
}

fn direction(rng: &mut Rng) -> Vec3 {
    testing::vector(rng, 1.0)
        .try_normalize()
        .unwrap_or(Vec3::Z)
}

fn link_or_world(rng: &mut Rng, robot: &RobotModel) -> Option<usize> {
    let links = robot.links().len();
    Some(rng.usize(0..=links)).filter(|link| *link < links)
}

fn vector(rng: &mut Rng) -> Vector {
    match rng.bool() {
        true => Vector::Point(testing::vector(rng, 0.5)),
        false => Vector::Direction(direction(rng)),
    }
}

fn watched(rng: &mut Rng, robot: &RobotModel) -> Watched {
    let vector = vector(rng);
    let link = link_or_world(rng, robot);
    let seen_from = link_or_world(rng, robot);
    Watched::new(robot, vector, link, seen_from)
}

/// The remainder of Taylor's formula is within the bound, of all joint kinds and between any two links;
/// within nine tenths of it it would not be.
#[test]
fn what_is_watched_bends_no_more_than_its_bound() {
    let (count, mut rng) = cases(10_000);
    let mut most = 0.0_f64;
    for _ in 0..count {
        let robot = testing::robot(&mut rng);
        let arc = Arc::random(&mut rng, &robot);
        let watched = watched(&mut rng, &robot);
        let acceleration = arc.bounds(&watched).acceleration(0);
        let speed = arc.bounds(&watched).speed(0);
        let half = [0.5, 0.1, 0.02][rng.usize(0..3)];
        let middle = testing::uniform(&mut rng, half, 1.0 - half);
        let here = arc.at(middle);
        let at = watched.at(&here.stand());
        let rate = watched.rate(&here.stand());
        for side in [-1.0, -0.5, 0.25, 1.0] {
            let after = side * half;
            let there = watched.at(&arc.at(middle + after).stand());
            let remainder = (there - at - rate * after).length();
            let bound = 0.5 * after * after * acceleration;
            assert!(remainder <= bound + 1e-12, "{remainder} above {bound}");
            assert!((there - at).length() <= speed * after.abs() + 1e-12);
            if remainder > 1e-6 {
                most = most.max(remainder / bound);
            }
        }
    }
    println!("the most of a bound that was seen: {most:.4}");
    assert!(most > 0.9, "a bound cut by a tenth would hold too: {most}");
}

/// A region that is about as large as the motion, near where the vector is.
fn region(rng: &mut Rng, at: Vec3, size: f64) -> Region {
    let center = at + testing::vector(rng, size);
    let axis = direction(rng);
    match rng.usize(0..6) {
        0 => Region::Cone {
            axis: (at + testing::vector(rng, size))
                .try_normalize()
                .unwrap_or(axis),
            angle: (2.0 * size).clamp(1e-3, PI / 2.0),
        },
        1 => Region::Box {
            center,
            turned: Quat::from_axis_angle(axis, 1.0),
            half: Vec3::new(size, 2.0 * size, 3.0 * size),
        },
        2 => Region::Ball {
            center,
            radius: 2.0 * size,
        },
        3 => Region::Cylinder(Cylinder {
            center,
            axis,
            radius: 1.5 * size,
            half_length: 2.0 * size,
        }),
        4 => Region::EulerXy {
            turned: Quat::from_axis_angle(axis, 1.0),
            x: (2.0 * size).min(1.5),
            y: size,
        },
        _ => Region::HalfSpace(HalfSpace {
            normal: axis,
            offset: axis.dot(center) + size,
        }),
    }
}

/// What is kept on an interval is kept wherever one looks; taken nine tenths of the bend, somewhere it is
/// not.
#[test]
fn what_is_kept_is_kept_everywhere() {
    let (count, mut rng) = cases(10_000);
    let mut proved = 0;
    for _ in 0..count {
        let robot = testing::robot(&mut rng);
        let arc = Arc::random(&mut rng, &robot);
        let watched = watched(&mut rng, &robot);
        let bounds = arc.bounds(&watched);
        let half = [0.5, 0.1, 0.02][rng.usize(0..3)];
        let middle = testing::uniform(&mut rng, half, 1.0 - half);
        let here = arc.at(middle);
        let size = half * bounds.speed(0) + 1e-3;
        let regions = (0..rng.usize(1..3))
            .map(|_| region(&mut rng, watched.at(&here.stand()), size))
            .collect();
        let held = Held { watched, regions };
        let kept = kept(&held, &here.stand(), &bounds, half);
        proved += usize::from(kept >= 0.0);
        for i in 0..=16 {
            let t = middle + half * (f64::from(i) / 8.0 - 1.0);
            let depth = held.depth(held.watched.at(&arc.at(t).stand()));
            assert!(
                kept < 0.0 || depth >= kept,
                "{depth} below {kept} in {held:?}"
            );
        }
    }
    assert!(proved > count / 20, "{proved} of {count} intervals proved");
}

/// A region of directions for a direction, of points for a point: what is left is counted in its unit.
fn region_of(rng: &mut Rng, watched: &Watched, at: Vec3, size: f64) -> Region {
    let is_direction = matches!(watched.vector(), Vector::Direction(_));
    loop {
        let region = region(rng, at, size);
        let of_directions = matches!(region, Region::Cone { .. } | Region::EulerXy { .. });
        if of_directions == is_direction {
            return region;
        }
    }
}

/// Some constraints that are kept at one end of a segment or not far from it.
fn constraints(rng: &mut Rng, arc: &Arc) -> Vec<Constraint> {
    let count = rng.usize(1..4);
    let constraint = |rng: &mut Rng| {
        let watched = watched(rng, arc.robot);
        let size = 0.3 * arc.bounds(&watched).speed(0) + 1e-3;
        let at = watched.at(&arc.at(rng.f64()).stand());
        let regions = (0..rng.usize(1..3))
            .map(|_| region_of(rng, &watched, at, size))
            .collect();
        Constraint {
            kind: ConstraintKind::Position,
            name: "near".into(),
            held: Held { watched, regions },
        }
    };
    (0..count).map(|_| constraint(rng)).collect()
}

/// Whatever a validator proves is kept wherever one looks, by the tolerance and by what is claimed of
/// it; what it refuses is outside where it says, or has nothing left to prove it with.
#[test]
fn no_validator_proves_what_sampling_refutes() {
    let (count, mut rng) = cases(10_000);
    let none = || Scene::new("none", Vec::new(), Vec::new(), Vec::new()).unwrap();
    let [mut proved, mut refused] = [0; 2];
    for _ in 0..count / 10 {
        let robot = std::sync::Arc::new(testing::robot(&mut rng));
        let model = CollisionModel::new(robot, std::sync::Arc::new(none())).unwrap();
        // What has no variables has no path.
        let tries = if model.robot().space().nq() > 0 {
            10
        } else {
            0
        };
        for _ in 0..tries {
            let arc = Arc::random(&mut rng, model.robot());
            let mut to = vec![0.0; arc.from.len()];
            let space = model.robot().space();
            space.integrate(&arc.from, &arc.velocity, 1.0, &mut to);
            let constraints = constraints(&mut rng, &arc);
            let mut scratch = Scratch::default();
            let mut validator = Validator::new(&model, space, &arc.held, 1e-3, &mut scratch)
                .with_constraints(&constraints);
            let path = Path::from_rows(to.len(), [arc.from.clone(), to].concat()).unwrap();
            let violations = validator.violations(path.as_flat());
            let kept = validator.kept(&path, &mut || false);
            let ends = [path.waypoint(0), path.waypoint(1)];
            for near in &kept.tightest {
                let there = validator.measure(near.requirement, ends, near.t);
                assert_eq!(there, near.measure);
            }
            for SegmentRefusal {
                requirement,
                t,
                reason,
                ..
            } in &violations
            {
                refused += 1;
                let left = validator.measure(*requirement, ends, *t).amount;
                assert!(
                    left < 0.0 || *reason == HitReason::Uncertified,
                    "{left} left"
                );
            }
            let claims = kept.left[0].iter().zip(&kept.tightest);
            for (constraint, (claim, tightest)) in constraints.iter().zip(claims) {
                proved += usize::from(violations.is_empty());
                let found = tightest.measure.amount;
                assert!(
                    !violations.is_empty() || found >= *claim,
                    "{found} found, {claim} claimed"
                );
                for look in 0..=64 {
                    let held = &constraint.held;
                    let at = held
                        .watched
                        .at(&arc.at(f64::from(look) / 64.0).stand());
                    let left = held.left(at);
                    let kept = left >= -1e-9 && left >= claim - 1e-9;
                    assert!(
                        !violations.is_empty() || kept,
                        "{left} left, {claim} claimed of {held:?}"
                    );
                }
            }
        }
    }
    println!("{proved} proved, {refused} refused");
    assert!(
        proved > count / 20 && refused > count / 20,
        "{proved}, {refused}"
    );
}

/// Where little is left it is found, and nearly as much is proved; where it holds the path it is told.
#[test]
fn what_is_found_is_nearly_the_least_and_what_is_claimed_nearly_that() {
    let (count, mut rng) = cases(2_000);
    let [mut told, mut near] = [0, 0];
    for _ in 0..count / 10 {
        let robot = std::sync::Arc::new(testing::robot(&mut rng));
        let scene = Scene::new("none", Vec::new(), Vec::new(), Vec::new()).unwrap();
        let model = CollisionModel::new(robot, std::sync::Arc::new(scene)).unwrap();
        if model.robot().space().nq() == 0 {
            continue;
        }
        let arc = Arc::random(&mut rng, model.robot());
        let mut to = vec![0.0; arc.from.len()];
        let space = model.robot().space();
        space.integrate(&arc.from, &arc.velocity, 1.0, &mut to);
        let watched = watched(&mut rng, arc.robot);
        let size = 0.6 * arc.bounds(&watched).speed(0) + 1e-3;
        let region = region_of(&mut rng, &watched, watched.at(&arc.at(0.5).stand()), size);
        let mut held = Held {
            watched,
            regions: vec![region],
        };
        let look = |held: &Held, t: f64| held.left(held.watched.at(&arc.at(t).stand()));
        let looks = (0..=4096).map(|look| f64::from(look) / 4096.0);
        let least = looks
            .map(|t| look(&held, t))
            .fold(f64::INFINITY, f64::min);
        // So that a fiftieth of the tolerance is left.
        held = held.widened(-least);
        let more = 0.02 * held.tolerance() / 0.98;
        held = held.widened(more);
        let is_far = arc.bounds(&held.watched).speed(0) > 2.0 * held.tolerance();
        if !held.is_convex() || is_far || held.tolerance() > 1.0 {
            continue;
        }
        let tolerance = held.tolerance();
        let constraints = [Constraint {
            kind: ConstraintKind::Position,
            name: "near".into(),
            held,
        }];
        let mut scratch = Scratch::default();
        let mut validator = Validator::new(&model, space, &arc.held, 1e-3, &mut scratch)
            .with_constraints(&constraints);
        let path = Path::from_rows(to.len(), [arc.from.clone(), to].concat()).unwrap();
        let kept = validator.kept(&path, &mut || false);
        let found = kept.tightest[0].measure.amount;
        let part = |amount: f64| amount / tolerance;
        assert!(part(found) < 0.022, "{} found", part(found));
        assert!(part(found) > 0.0199, "{} found", part(found));
        near += usize::from(part(found - kept.left[0][0]) < 0.004);
        let [hold] = kept.holds.as_slice() else {
            panic!("{:?}", kept.holds);
        };
        assert_eq!(hold.measure.amount, found);
        told += 1;
    }
    println!("{told} told, {near} nearly claimed");
    assert!(told > count / 100 && 10 * near > 9 * told, "{told}, {near}");
}

/// An angle is the same to whom it is handed on to, and its bound is smaller.
#[test]
fn turns_about_the_axis_do_not_count() {
    let (_, mut rng) = cases(1);
    let mut handed_on = 0;
    for _ in 0..500 {
        let robot = testing::robot(&mut rng);
        let arc = Arc::random(&mut rng, &robot);
        let link = Some(rng.usize(0..robot.links().len()));
        let vector = Vector::Direction(direction(&mut rng));
        // The axis of the first joint that turns is what uprightness often is about.
        let axis = robot.joints()[0].origin.rotation * robot.joints()[0].axis;
        let (seen_from, axis_there) = angle_seen_from(&robot, link, None, axis);
        let by_world = Watched::new(&robot, vector, link, None);
        let by_link = Watched::new(&robot, vector, link, seen_from);
        for t in [0.0, 0.3, 1.0] {
            let there = arc.at(t);
            let tilt = by_world.at(&there.stand()).dot(axis);
            let same = by_link.at(&there.stand()).dot(axis_there);
            assert!((tilt - same).abs() < 1e-12, "{tilt}, {same}");
        }
        let most = arc.bounds(&by_world).acceleration(0);
        let left = arc.bounds(&by_link).acceleration(0);
        assert!(left <= most * (1.0 + 1e-9), "{left} above {most}");
        handed_on += usize::from(seen_from.is_some());
    }
    assert!(handed_on > 50, "{handed_on}");
}

/// The row is the rate: along any velocity, and as differences have it.
#[test]
fn rows_are_what_the_vector_does() {
    let (_, mut rng) = cases(1);
    for _ in 0..500 {
        let robot = testing::robot(&mut rng);
        let arc = Arc::random(&mut rng, &robot);
        let watched = watched(&mut rng, &robot);
        let normal = direction(&mut rng);
        let here = arc.at(0.4);
        let by_way = watched.at_configuration(&robot, &here.configuration, &arc.held);
        assert!(by_way.distance(watched.at(&here.stand())) < 1e-12);
        let mut row = vec![0.0; robot.space().nv()];
        watched.add_row(&robot, &here.kinematics, normal, &mut row);
        let along: f64 = row
            .iter()
            .zip(&arc.velocity)
            .map(|(a, b)| a * b)
            .sum();
        assert!((along - normal.dot(watched.rate(&here.stand()))).abs() < 1e-9);
        let step = 1e-5;
        let moved =
            watched.at(&arc.at(0.4 + step).stand()) - watched.at(&arc.at(0.4 - step).stand());
        assert!((along - normal.dot(moved) / (2.0 * step)).abs() < 1e-4);
    }
}

/// Far from the world's origin last bits are larger, and so is what a proof leaves for them.
#[test]
fn rounding_grows_with_the_way_to_the_origin() {
    let (_, mut rng) = cases(1);
    for _ in 0..100 {
        let robot = testing::robot(&mut rng);
        let arc = Arc::random(&mut rng, &robot);
        let here = arc.at(0.5);
        let point = |far: f64| Watched::new(&robot, Vector::Point(Vec3::X * far), None, None);
        let near = super::rounding(&point(0.0), &here.stand());
        let far = super::rounding(&point(1e5), &here.stand());
        assert!(near == ROUNDING && far > 1e4 * near && far < 1e6 * near);
        // The last bit of a number of that size.
        assert!(far > 100.0 * (1e5_f64.next_up() - 1e5));
    }
}

/// Who says stop waits for no more than a segment.
#[test]
fn a_long_path_is_stopped_between_segments() {
    let (_, mut rng) = cases(1);
    let robot = testing::robot(&mut rng);
    let arc = Arc::random(&mut rng, &robot);
    let all = Region::Ball {
        center: Vec3::ZERO,
        radius: 1e3,
    };
    let constraints = vec![Constraint {
        kind: ConstraintKind::Position,
        name: "everywhere".into(),
        held: Held {
            watched: Watched::new(&robot, Vector::Point(Vec3::ZERO), Some(0), None),
            regions: vec![all],
        },
    }];
    let none = Scene::new("none", Vec::new(), Vec::new(), Vec::new()).unwrap();
    let model = CollisionModel::new(
        std::sync::Arc::new(robot.clone()),
        std::sync::Arc::new(none),
    )
    .unwrap();
    let mut scratch = Scratch::default();
    let space = model.robot().space();
    let mut validator =
        Validator::new(&model, space, &arc.held, 1e-3, &mut scratch).with_constraints(&constraints);
    let ends: [&[f64]; 2] = [&arc.from, &arc.from];
    let mut asked = 0;
    let mut stop = || {
        asked += 1;
        asked == 10
    };
    let verdict = validator.refused_by_constraints(std::iter::repeat_n(ends, 1000), &mut stop);
    assert_eq!((verdict, asked), (None, 10));
    let nobody = validator.refused_by_constraints(std::iter::repeat_n(ends, 20), &mut || false);
    assert_eq!(nobody, Some(None));
}

/// The value of a joint that turns or slides by one coordinate.
fn joint_value(rng: &mut Rng, robot: &RobotModel) -> Option<JointValue> {
    let components = robot.space().components();
    let (column, coordinate, is_angle) =
        match components.get(rng.usize(..components.len().max(1)))? {
            Component::Line { q, v, .. } => (*q, *v, false),
            Component::Circle { q, v, .. } => (*q, *v, true),
            Component::Rotation { .. } => return None,
        };
    Some(JointValue {
        column,
        coordinate,
        factor: 1.0,
        offset: testing::uniform(rng, -3.0, 3.0),
        is_angle,
    })
}

/// A joint is kept on the way that it goes, not on the way between its ends that looks shorter.
#[test]
fn a_joint_that_goes_through_half_a_turn_leaves_its_range() {
    let (count, mut rng) = cases(10_000);
    let none = || Scene::new("none", Vec::new(), Vec::new(), Vec::new()).unwrap();
    let [mut proved, mut outside] = [0; 2];
    for _ in 0..count / 10 {
        let robot = std::sync::Arc::new(testing::robot(&mut rng));
        let model = CollisionModel::new(robot, std::sync::Arc::new(none())).unwrap();
        let space = model.robot().space();
        let Some(value) = joint_value(&mut rng, model.robot()) else {
            continue;
        };
        let arc = Arc::random(&mut rng, model.robot());
        let mut to = vec![0.0; arc.from.len()];
        space.integrate(&arc.from, &arc.velocity, 1.0, &mut to);
        let watched = Watched::joint(value);
        let size = testing::uniform(&mut rng, 0.01, if value.is_angle { 3.13 } else { 5.0 });
        let range = Region::Range {
            lower: -size,
            upper: size,
        };
        let constraints = [Constraint {
            kind: ConstraintKind::Angle,
            name: "range".into(),
            held: Held {
                watched: watched.clone(),
                regions: vec![range],
            },
        }];
        let mut scratch = Scratch::default();
        let mut validator = Validator::new(&model, space, &arc.held, 1e-3, &mut scratch)
            .with_constraints(&constraints);
        let path = Path::from_rows(to.len(), [arc.from.clone(), to].concat()).unwrap();
        let is_proved = validator.violations(path.as_flat()).is_empty();
        let least = (0..=256)
            .map(|look| range.left(watched.at(&arc.at(f64::from(look) / 256.0).stand())))
            .fold(f64::INFINITY, f64::min);
        proved += usize::from(is_proved);
        outside += usize::from(least < 0.0);
        assert!(
            !is_proved || least >= -1e-9,
            "{least} left of {range:?}, {value:?}"
        );
    }
    assert!(
        proved > count / 100 && outside > count / 100,
        "{proved}, {outside}"
    );
}
