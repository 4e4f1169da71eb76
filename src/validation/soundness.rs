//! The promises of the checker against oracles that share none of its code.

use fastrand::Rng;

use super::interval::PairInterval;
use super::motion::{Course, MotionBounds, Twist};
use super::*;
use crate::robot::Kinematics;
use crate::solid::transform::Transform;
use crate::testing::{self, Oracle};

/// Random cases; `TAUT_CASES` asks for a long run, `TAUT_SEED` for other ones.
pub(crate) fn cases(short: usize) -> (usize, Rng) {
    let number = |name: &str| {
        std::env::var(name)
            .ok()
            .and_then(|text| text.parse().ok())
    };
    let seed = number("TAUT_SEED").unwrap_or(20_150_423);
    println!("seed {seed}");
    (
        number("TAUT_CASES").map_or(short, |n| n as usize),
        Rng::with_seed(seed),
    )
}

#[test]
fn kinematics_agree_with_the_definition() {
    let (count, mut rng) = cases(200);
    for _ in 0..count {
        let robot = testing::robot(&mut rng);
        let q = testing::configuration(&mut rng, &robot);
        let held: Vec<f64> = robot.held().iter().map(|h| h.default).collect();
        let mut kinematics = Kinematics::default();
        kinematics.update(&robot, &q, &held);
        for (pose, expected) in kinematics
            .poses()
            .iter()
            .zip(testing::link_poses(&robot, &q))
        {
            let at = expected.translation.vector;
            assert!((pose.translation - crate::math::Vec3::new(at.x, at.y, at.z)).length() < 1e-12);
            let turned = expected.rotation * nalgebra::Vector3::new(0.3, -0.5, 0.8);
            let ours = pose.rotation * crate::math::Vec3::new(0.3, -0.5, 0.8);
            assert!((ours - crate::math::Vec3::new(turned.x, turned.y, turned.z)).length() < 1e-12);
        }
    }
}

/// V bounds the sampled speed of every point, and is tight enough to be of use.
#[test]
fn speed_and_acceleration_bounds_hold_and_are_tight() {
    let (count, mut rng) = cases(300);
    let mut ratios = Vec::new();
    let mut cut_refuted = 0;
    for _ in 0..count {
        let model = testing::model(&mut rng);
        let robot = model.robot();
        let from = testing::configuration(&mut rng, robot);
        let to = testing::neighbour(&mut rng, robot, &from);
        let mut velocity = vec![0.0; robot.space().nv()];
        robot
            .space()
            .difference(&to, &from, &mut velocity);
        let held: Vec<f64> = robot.held().iter().map(|h| h.default).collect();
        let [from, velocity] = [from.as_slice(), &velocity];
        let course = Course::Straight { from, velocity };
        for pair in model.pairs() {
            let mut bound = 0.0;
            let mut seen = 0.0;
            for (body, above) in [
                (pair.a, pair.motions_above[0]),
                (pair.b, pair.motions_above[1]),
            ] {
                let body = &model.bodies()[body];
                let Some(link) = body.link else { continue };
                let mut bounds = MotionBounds::default();
                bounds.update(&body.chain, &course, &held);
                let speed = bounds.speed(above);
                let acceleration = bounds.acceleration(above);
                let points: Vec<_> = body
                    .solid
                    .tree
                    .pieces()
                    .iter()
                    .flat_map(surface_points)
                    .map(|p| body.place.point(p))
                    .collect();
                let (fastest, hardest) =
                    sampled_motion(robot, from, velocity, link, pair.ancestor, &points);
                assert!(
                    fastest <= speed * (1.0 + 1e-6) + 1e-6,
                    "speed {fastest} above its bound {speed}"
                );
                assert!(
                    hardest <= acceleration * (1.0 + 1e-3) + 1e-3,
                    "acceleration {hardest} above {acceleration}"
                );
                bound += speed;
                seen += fastest;
            }
            if seen > 1e-3 {
                ratios.push(bound / seen);
                cut_refuted += usize::from(seen > 0.8 * bound);
            }
        }
    }
    ratios.sort_by(f64::total_cmp);
    let median = ratios[ratios.len() / 2];
    println!(
        "{} pairs, median of bound over fastest point {median:.2}, × 0.8 refuted {cut_refuted}",
        ratios.len()
    );
    assert!(median <= 3.0, "the bound is valid but of no use: {median}");
    assert!(
        cut_refuted > 0,
        "a bound that can be cut by a fifth has slack to find"
    );
}

/// Points that span a piece.
pub(super) fn surface_points(piece: &crate::solid::piece::Piece) -> Vec<crate::math::Vec3> {
    let directions = (0..26).map(|i| {
        let i = i + i / 13;
        crate::math::Vec3::new(
            (i % 3 - 1) as f64,
            (i / 3 % 3 - 1) as f64,
            (i / 9 - 1) as f64,
        )
    });
    directions
        .map(|d| piece.core.support(d) + d.normalize_or_zero() * piece.radius)
        .collect()
}

/// Fastest and hardest accelerated of `points` of a link in the frame of `ancestor`, by
/// differences.
pub(super) fn sampled_motion(
    robot: &crate::robot::RobotModel,
    from: &[f64],
    velocity: &[f64],
    link: usize,
    ancestor: Option<usize>,
    points: &[crate::math::Vec3],
) -> (f64, f64) {
    let step = 1e-4;
    let mut q = vec![0.0; from.len()];
    let mut positions = |t: f64| -> Vec<nalgebra::Point3<f64>> {
        robot
            .space()
            .integrate(from, velocity, t, &mut q);
        let poses = testing::link_poses(robot, &q);
        let carrier = ancestor.map_or(nalgebra::Isometry3::identity(), |a| poses[a]);
        let relative = carrier.inverse() * poses[link];
        points
            .iter()
            .map(|p| relative * nalgebra::Point3::new(p.x, p.y, p.z))
            .collect()
    };
    let mut fastest = 0.0f64;
    let mut hardest = 0.0f64;
    for sample in 0..12 {
        let t = f64::from(sample) / 12.0 + step;
        let before = positions(t - step);
        let here = positions(t);
        let after = positions(t + step);
        for i in 0..points.len() {
            fastest = fastest.max((after[i] - before[i]).norm() / (2.0 * step));
            let bend = (after[i].coords + before[i].coords) - here[i].coords * 2.0;
            hardest = hardest.max(bend.norm() / (step * step));
        }
    }
    (fastest, hardest)
}

/// The theorem itself: whatever an interval is proved to keep, parry finds kept; cut by a fifth it
/// would not be.
#[test]
fn what_an_interval_keeps_is_kept_and_the_bound_has_teeth() {
    let (count, mut rng) = cases(10_000);
    let mut checked = 0;
    let mut refuted = 0;
    let mut refuted_wholes = 0;
    let mut weakest = f64::INFINITY;
    for _ in 0..count {
        let model = testing::model(&mut rng);
        let robot = model.robot();
        let oracle = Oracle::new(&model);
        let from = testing::configuration(&mut rng, robot);
        let to = testing::neighbour(&mut rng, robot, &from);
        let held: Vec<f64> = robot.held().iter().map(|h| h.default).collect();
        let mut scratch = Scratch::default();
        let mut validator = Validator::new(&model, robot.space(), &held, 1e-3, &mut scratch);
        let half = [0.5, 0.1, 0.02][rng.usize(0..3)];
        let middle = testing::uniform(&mut rng, half, 1.0 - half);
        for pair in 0..model.pairs().len() {
            let bound = validator.closest_bound(&from, &to, middle, half, pair);
            let Some((gap, displacement, wholes)) = bound else {
                continue;
            };
            let least = (0..=16)
                .map(|i| {
                    let t = middle + half * (f64::from(i) / 8.0 - 1.0);
                    let mut velocity = vec![0.0; robot.space().nv()];
                    let mut q = vec![0.0; robot.space().nq()];
                    robot
                        .space()
                        .difference(&to, &from, &mut velocity);
                    robot
                        .space()
                        .integrate(&from, &velocity, t, &mut q);
                    oracle.pair_distance(&model, pair, &q)
                })
                .fold(f64::INFINITY, f64::min);
            // Parry over-estimates smooth shapes by up to 1.7e-5 m.
            let kept = gap - displacement;
            weakest = weakest.min(least - kept);
            assert!(least > kept - 1e-7, "kept {kept} promised, {least} seen");
            assert!(
                least > wholes - 1e-7,
                "kept {wholes} promised of the wholes, {least} seen"
            );
            checked += 1;
            refuted += usize::from(least < gap - 0.8 * displacement - 2e-5);
            refuted_wholes += usize::from(least < gap - 0.8 * (gap - wholes) - 2e-5);
        }
    }
    println!(
        "{checked} intervals, closest to the promise {weakest:.2e} m, × 0.8 refuted {refuted}, {refuted_wholes}"
    );
    assert!(checked > count / 2);
    assert!(
        refuted * 200 > checked,
        "only {refuted} of {checked} refute the bound cut by a fifth"
    );
    assert!(
        refuted_wholes * 20 > checked,
        "only {refuted_wholes} of {checked} refute that of the wholes"
    );
}

/// No proved segment in which the oracle finds the pair closer than its floor; and what keeps clear
/// of 1.5 floors by the oracle is proved.
#[test]
fn proved_segments_are_free_and_clear_segments_are_proved() {
    let (count, mut rng) = cases(10_000);
    let mut proved = 0;
    let mut refused = 0;
    for _ in 0..count {
        let model = testing::model(&mut rng);
        let robot = model.robot();
        let oracle = Oracle::new(&model);
        let from = testing::configuration(&mut rng, robot);
        let to = testing::neighbour(&mut rng, robot, &from);
        let held: Vec<f64> = robot.held().iter().map(|h| h.default).collect();
        let floor = 1e-3;
        let mut scratch = Scratch::default();
        let mut validator = Validator::new(&model, robot.space(), &held, floor, &mut scratch);
        if validator.enclosed_at(&from, &mut || false) != crate::validation::Enclosed::Nothing {
            continue;
        }
        let verdict = validator.segment(&from, &to, &mut || false);
        let mut velocity = vec![0.0; robot.space().nv()];
        let mut q = vec![0.0; robot.space().nq()];
        robot
            .space()
            .difference(&to, &from, &mut velocity);
        match verdict {
            SegmentVerdict::Proved(proof) => {
                proved += 1;
                for i in 0..=60 {
                    robot
                        .space()
                        .integrate(&from, &velocity, f64::from(i) / 60.0, &mut q);
                    for pair in 0..model.pairs().len() {
                        let distance = oracle.pair_distance(&model, pair, &q);
                        let claimed = proof.clearance_m.max(floor);
                        assert!(
                            distance >= claimed - 1e-7,
                            "{distance} where {claimed} is proved"
                        );
                    }
                }
            }
            SegmentVerdict::Refused(hit) => {
                refused += 1;
                robot
                    .space()
                    .integrate(&from, &velocity, hit.t, &mut q);
                let distance = oracle.kept(&model, hit.requirement, &q);
                // The oracle sees surfaces only: a body inside a mesh is away from it.
                assert!(
                    distance < 1.5 * floor + 4e-5,
                    "refused ({:?}) at distance {distance}",
                    hit.reason
                );
                let first = validator.first_hit(&from, &to, &mut || false);
                let SegmentVerdict::Refused(first) = first else {
                    panic!("first_hit found nothing")
                };
                assert!(first.t <= hit.t && first.proved_until <= first.t);
            }
            SegmentVerdict::Stopped => unreachable!("nothing stops it"),
        }
    }
    println!("{proved} proved, {refused} refused");
    assert!(proved > count / 10 && refused > count / 25);
}

#[test]
fn a_pair_far_away_is_proved_by_its_root_balls_alone() {
    let far = |rng: &mut Rng| testing::model(rng);
    let mut rng = Rng::with_seed(7);
    let model = far(&mut rng);
    if let Some(pair) = model.pairs().first() {
        let a = &model.bodies()[pair.a];
        let b = &model.bodies()[pair.b];
        let away = Transform {
            translation: crate::math::Vec3::X * 100.0,
            ..Transform::IDENTITY
        };
        let still = Twist::default();
        let floor = 1e-3;
        let too_close = 1.5e-3;
        let bend = 0.0;
        let travel = 0.0;
        let interval = PairInterval {
            a,
            b,
            relative: away,
            twist_a: still,
            twist_b: still,
            bend,
            travel,
            floor,
            too_close,
        };
        let mut never = || false;
        let mut looks = super::interval::Looks::new(&mut never);
        assert!(matches!(
            interval.decide(&mut None, &mut looks),
            super::interval::IntervalVerdict::Proved(_)
        ));
        assert_eq!(looks.count, 1);
    }
}

/// A ball over one long thin triangle is all air: asked of balls alone, a forearm of slivers beside
/// a fine mesh once took 33 million looks for a proof that takes a hundred thousand.
#[test]
fn long_thin_triangles_are_met_as_triangles_and_not_as_their_balls() {
    use crate::math::{Pose, Vec3};
    use crate::robot::{JointDescription, JointKind, LinkDescription, RobotDescription};
    use crate::shape::{Mesh, PlacedShape, Shape};
    let tube = |sides: u32, rings: u32, length: f64, radius: f64| {
        let at = |ring: u32, side: u32| {
            let angle = f64::from(side) / f64::from(sides) * std::f64::consts::TAU;
            let z = length * (f64::from(ring) / f64::from(rings) - 0.5);
            Vec3::new(radius * angle.cos(), radius * angle.sin(), z)
        };
        let vertices = (0..=rings)
            .flat_map(|ring| (0..sides).map(move |side| at(ring, side)))
            .collect();
        let quad = |ring: u32, side: u32| {
            let next = (side + 1) % sides;
            let [a, b, c, d] = [
                ring * sides + side,
                ring * sides + next,
                (ring + 1) * sides + next,
                (ring + 1) * sides + side,
            ];
            [[a, b, c], [a, c, d]]
        };
        let triangles = (0..rings)
            .flat_map(|ring| (0..sides).flat_map(move |side| quad(ring, side)))
            .collect();
        let mesh = Mesh::new("tube", vertices, triangles).unwrap();
        PlacedShape {
            pose: Pose::identity(),
            shape: Shape::Mesh(std::sync::Arc::new(mesh)),
        }
    };
    let link = |name: &str, shape| LinkDescription {
        name: name.into(),
        collision: vec![shape],
    };
    let description = RobotDescription {
        name: "tubes".into(),
        links: vec![
            link("slivers", tube(60, 1, 0.6, 0.05)),
            link("fine", tube(60, 60, 0.1, 0.05)),
        ],
        joints: vec![JointDescription {
            name: "turn".into(),
            kind: JointKind::Continuous,
            parent: "slivers".into(),
            child: "fine".into(),
            origin: Pose::from_parts(Vec3::new(0.13, 0.0, 0.0), crate::math::Quat::IDENTITY),
            axis: Vec3::Z,
            limits: None,
            soft_limits: None,
            mimic: None,
        }],
        // With semantics, links joined by one joint are checked.
        semantics: Some(crate::robot::Semantics::default()),
        ..RobotDescription::default()
    };
    let robot = std::sync::Arc::new(crate::robot::RobotModel::new(description).unwrap());
    let model = crate::collision::CollisionModel::new(
        robot,
        std::sync::Arc::new(crate::scene::Scene::default()),
    )
    .unwrap();
    let mut scratch = Scratch::default();
    let mut validator = Validator::new(&model, model.robot().space(), &[], 1e-3, &mut scratch);
    let verdict = validator.segment(&[0.0], &[1.0], &mut || false);
    assert!(matches!(verdict, SegmentVerdict::Proved(_)), "{verdict:?}");
    println!("{} looks", validator.work());
    assert!(validator.work() < 20_000, "{} looks", validator.work());
}

#[test]
fn a_raised_floor_is_proved_anew() {
    let mut rng = Rng::with_seed(3);
    let mut met = 0;
    for _ in 0..200 {
        let model = testing::model(&mut rng);
        let robot = model.robot();
        let (held, q): (Vec<f64>, _) = (
            robot.held().iter().map(|h| h.default).collect(),
            testing::configuration(&mut rng, robot),
        );
        let mut scratch = Scratch::default();
        let mut validator = Validator::new(&model, robot.space(), &held, 1e-3, &mut scratch);
        if let Some(SegmentProof { clearance_m, .. }) =
            match validator.segment(&q, &q, &mut || false) {
                SegmentVerdict::Proved(proof) if proof.clearance_m.is_finite() => Some(proof),
                _ => None,
            }
        {
            (0..model.pairs().len()).for_each(|pair| {
                validator.set_floor(Requirement::Clearance(pair), 3.0 * clearance_m + 10.0)
            });
            assert!(matches!(
                validator.segment(&q, &q, &mut || false),
                SegmentVerdict::Refused(_)
            ));
            met += 1;
        }
    }
    assert!(met > 20);
}

/// Far from the origin the filter's rounding may exceed half a floor: it then sees a pair 1.5
/// floors apart in the middle of every interval, however short, and proves none of them. This once
/// went on without an end.
#[test]
fn a_pair_that_rounding_hides_from_the_filter_is_decided_exactly() {
    use crate::math::{Pose, Vec3};
    use crate::robot::{
        JointDescription, JointKind, LinkDescription, RobotDescription, RobotModel,
    };
    use crate::scene::{Obstacle, Scene};
    use crate::shape::{PlacedShape, Shape};
    const FAR: f64 = 500.0;
    let placed = |shape, at| PlacedShape {
        pose: Pose::from_translation(at),
        shape,
    };
    let link = |name: &str, collision| LinkDescription {
        name: name.into(),
        collision,
    };
    let description = RobotDescription {
        name: "slider".into(),
        links: vec![
            link("rail", vec![]),
            link(
                "ball",
                vec![placed(Shape::sphere(0.1).unwrap(), Vec3::ZERO)],
            ),
        ],
        joints: vec![JointDescription {
            name: "slide".into(),
            kind: JointKind::Prismatic,
            parent: "rail".into(),
            child: "ball".into(),
            origin: Pose::identity(),
            axis: Vec3::X,
            limits: Some((-2.0 * FAR, 2.0 * FAR)),
            soft_limits: None,
            mimic: None,
        }],
        ..RobotDescription::default()
    };
    let robot = std::sync::Arc::new(RobotModel::new(description).unwrap());
    for nanometres in (100_000..400_000).step_by(5_000) {
        let floor = 1e-4;
        let distance = f64::from(nanometres) * 1e-9;
        let floor_below = placed(
            Shape::cuboid(Vec3::new(2.0, 2.0, 0.2)).unwrap(),
            Vec3::new(FAR, 0.0, -0.2 - distance),
        );
        let table = Obstacle::new("table", vec![floor_below]);
        let scene = Scene::new("table", vec![table], Vec::new(), Vec::new()).unwrap();
        let model =
            crate::collision::CollisionModel::new(robot.clone(), std::sync::Arc::new(scene))
                .unwrap();
        let mut scratch = Scratch::default();
        let mut validator = Validator::new(&model, model.robot().space(), &[], floor, &mut scratch);
        let mut asked = 0;
        let mut stop = || {
            asked += 1;
            asked > 100_000
        };
        let verdict = validator.segment(&[FAR - 0.1], &[FAR + 0.1], &mut stop);
        match verdict {
            SegmentVerdict::Proved(proof) => assert!(
                proof.clearance_m <= distance + 1e-9,
                "{distance}: {proof:?}"
            ),
            SegmentVerdict::Refused(hit) => assert!(
                hit.measure.amount < 1.5 * floor + 1e-9,
                "{distance}: {hit:?}"
            ),
            SegmentVerdict::Stopped => panic!("{distance} m apart: no end"),
        }
    }
}

/// What is refused of several segments is named rightly: that pair is too close there, exactly.
#[test]
fn a_refusal_names_a_pair_that_is_too_close_there() {
    let (count, mut rng) = cases(400);
    let mut collisions = 0;
    let mut too_close = 0;
    for _ in 0..count {
        let model = testing::model(&mut rng);
        let robot = model.robot();
        let held: Vec<f64> = robot
            .held()
            .iter()
            .map(|held| held.default)
            .collect();
        let mut scratch = Scratch::default();
        let mut validator = Validator::new(
            &model,
            robot.space(),
            &held,
            testing::uniform(&mut rng, 1e-4, 3e-2),
            &mut scratch,
        );
        for pair in 0..model.pairs().len() {
            if rng.f64() < 0.1 {
                validator.set_floor(
                    Requirement::Clearance(pair),
                    testing::uniform(&mut rng, 1e-3, 0.1),
                );
            }
        }
        let mut rows = vec![testing::configuration(&mut rng, robot)];
        for i in 0..rng.usize(1..5) {
            rows.push(testing::neighbour(&mut rng, robot, &rows[i]));
        }
        let segments = || {
            rows.windows(2)
                .map(|ends| [ends[0].as_slice(), ends[1].as_slice()])
        };
        let verdict = validator.segments(segments(), &mut || false);
        match verdict {
            SegmentsVerdict::Proved => {}
            SegmentsVerdict::Refused(refusal) => {
                assert!((0.0..=1.0).contains(&refusal.t));
                let SegmentRefusal {
                    segment,
                    t,
                    requirement,
                    reason,
                } = refusal;
                let floor = validator.floors().of(requirement);
                let ends = [segment, segment + 1].map(|row| rows[row].as_slice());
                let seen = validator.measure(requirement, ends, t);
                assert!(
                    seen.amount < 1.5 * floor + 1e-9,
                    "{refusal:?} at {seen:?}, floor {floor}"
                );
                match reason {
                    HitReason::Collision => {
                        assert!(seen.touches(), "{refusal:?} at {seen:?}");
                        collisions += 1;
                    }
                    HitReason::TooClose => too_close += 1,
                    HitReason::Uncertified => panic!("no floor is lowered that far"),
                    HitReason::Outside => panic!("there are no constraints"),
                }
            }
            SegmentsVerdict::Stopped => panic!("nobody stops it"),
        }
    }
    println!("{collisions} collisions, {too_close} too close");
    assert!(
        collisions > count / 10 && too_close > 5,
        "{collisions} and {too_close}"
    );
}
