use fastrand::Rng;

use super::*;
use crate::collision::CollisionModel;
use crate::testing;
use crate::validation::{Scratch, SegmentVerdict};

const CLEARANCE_M: f64 = 1e-3;
/// Samples of each segment.
const SAMPLES: u32 = 500;

fn held(model: &CollisionModel) -> Vec<f64> {
    model
        .robot()
        .held()
        .iter()
        .map(|held| held.default)
        .collect()
}

/// A proved path that goes as near to what is in its way as a proof allows.
fn walk(rng: &mut Rng, model: &CollisionModel) -> Option<Path> {
    let robot = model.robot();
    let held = held(model);
    let mut scratch = Scratch::default();
    let mut validator = Validator::new(model, robot.space(), &held, CLEARANCE_M, &mut scratch);
    let mut at = testing::configuration(rng, robot);
    if robot.space().nv() == 0 || validator.proves(&at, &at, &mut || false) != Some(true) {
        return None;
    }
    let mut rows = at.clone();
    for _ in 0..rng.usize(1..5) {
        let to = testing::neighbour(rng, robot, &at);
        let mut proved = 0.0;
        let mut refused = 1.0;
        if validator.proves(&at, &to, &mut || false) == Some(true) {
            proved = 1.0;
        } else {
            for _ in 0..14 {
                let middle = (proved + refused) / 2.0;
                let part = robot.space().between(&at, &to, middle);
                let proves = validator.proves(&at, &part, &mut || false) == Some(true);
                *(if proves { &mut proved } else { &mut refused }) = middle;
            }
        }
        if proved > 0.0 {
            at = robot.space().between(&at, &to, proved);
            rows.extend_from_slice(&at);
        }
    }
    Path::from_rows(at.len(), rows)
}

fn least_of(samples: &[(f64, f64)]) -> f64 {
    samples
        .iter()
        .map(|sample| sample.1)
        .fold(f64::INFINITY, f64::min)
}

/// Distances of a pair at many places of the path, each with its place along it.
fn sampled(validator: &mut Validator, path: &Path, pair: usize) -> Vec<(f64, f64)> {
    let mut samples = Vec::new();
    for segment in 0..(path.len() - 1).max(1) {
        let from = path.waypoint(segment);
        let to = path.waypoint((segment + 1).min(path.len() - 1));
        for sample in 0..=SAMPLES {
            let t = f64::from(sample) / f64::from(SAMPLES);
            samples.push((
                segment as f64 + t,
                validator
                    .measure(Requirement::Clearance(pair), [from, to], t)
                    .amount,
            ));
        }
    }
    samples
}

fn along(near: &Near) -> f64 {
    near.segment as f64 + near.t
}

#[test]
fn nothing_is_nearer_than_what_is_reported() {
    let cases = std::env::var("TAUT_CASES")
        .ok()
        .and_then(|cases| cases.parse().ok())
        .unwrap_or(300);
    let mut rng = Rng::with_seed(
        std::env::var("TAUT_SEED")
            .ok()
            .and_then(|seed| seed.parse().ok())
            .unwrap_or(5),
    );
    let mut held_paths = 0;
    let mut holds = 0;
    let mut free = 0;
    let mut vague = 0;
    for _ in 0..cases {
        let model = testing::model(&mut rng);
        let Some(path) = walk(&mut rng, &model) else {
            continue;
        };
        let held = held(&model);
        let mut scratch = Scratch::default();
        let mut validator = Validator::new(
            &model,
            model.robot().space(),
            &held,
            CLEARANCE_M,
            &mut scratch,
        );
        let nearest = validator
            .nearest(&path, &mut || false)
            .expect("not dearer than it may be");
        let within = CONTACT_FLOORS * CLEARANCE_M;
        let tolerance = RESOLUTION * CLEARANCE_M + 1e-9;
        held_paths += usize::from(!nearest.holds.is_empty());
        holds += nearest.holds.len();
        free += usize::from(nearest.smallest.is_none());
        let least = nearest
            .smallest
            .map_or(nearest.searched_m, |near| near.measure.amount);
        for pair in 0..model.pairs().len() {
            let samples = sampled(&mut validator, &path, pair);
            let of_pair: Vec<&Near> = nearest
                .holds
                .iter()
                .filter(|near| near.requirement == Requirement::Clearance(pair))
                .collect();
            // A stretch may go on beyond a waypoint, and is then named where it is nearest.
            let of_segment: Vec<&[(f64, f64)]> = samples.chunks(SAMPLES as usize + 1).collect();
            for near in of_segment.chunk_by(|a, b| (least_of(a) < within) == (least_of(b) < within))
            {
                let lowest = least_of(&near.concat());
                let first = near[0][0].0;
                let here = |it: &&&Near| (first..=first + near.len() as f64).contains(&along(it));
                let named = of_pair
                    .iter()
                    .filter(here)
                    .map(|near| near.measure.amount)
                    .fold(f64::INFINITY, f64::min);
                assert!(
                    named.min(within) < lowest + tolerance,
                    "{lowest} m from {first} on, named {of_pair:?}"
                );
                vague += usize::from(lowest < within && named > lowest + 0.1 * tolerance);
            }
            let lowest = least_of(&samples);
            assert!(
                lowest > least - tolerance,
                "{lowest} seen, {least} said to be the least"
            );
        }
        for near in nearest.holds.iter().chain(&nearest.smallest) {
            let ends = [near.segment, (near.segment + 1).min(path.len() - 1)]
                .map(|waypoint| path.waypoint(waypoint));
            let exact = validator.measure(near.requirement, ends, near.t);
            assert_eq!(exact, near.measure);
        }
        assert!(
            nearest
                .holds
                .is_sorted_by(|a, b| along(a) <= along(b))
        );
    }
    println!(
        "{held_paths} paths held by {holds} holds, {vague} of them vague, nothing near on {free}"
    );
    assert!(held_paths > cases / 10 && free > cases / 100);
    assert!(
        vague * 50 <= holds,
        "{vague} of {holds} holds are not at the nearest place"
    );
}

/// One object of two posts that a ball passes on one segment: each post holds it, and the waypoint
/// beside the third counts once.
#[test]
fn a_body_that_is_passed_twice_holds_the_path_twice() {
    use crate::math::{Pose, Vec3};
    use crate::robot::{
        JointDescription, JointKind, LinkDescription, RobotDescription, RobotModel,
    };
    use crate::scene::{Obstacle, Scene};
    use crate::shape::{PlacedShape, Shape};
    use std::sync::Arc;
    let ball = |at: Vec3| PlacedShape {
        pose: Pose::from_translation(at),
        shape: Shape::sphere(0.05).unwrap(),
    };
    let link = |name: &str, collision| LinkDescription {
        name: name.into(),
        collision,
    };
    let slide = JointDescription {
        name: "slide".into(),
        kind: JointKind::Prismatic,
        parent: "rail".into(),
        child: "ball".into(),
        origin: Pose::identity(),
        axis: Vec3::X,
        limits: Some((-5.0, 5.0)),
        soft_limits: None,
        mimic: None,
    };
    let links = vec![link("rail", vec![]), link("ball", vec![ball(Vec3::ZERO)])];
    let robot = RobotDescription {
        name: "slider".into(),
        links,
        joints: vec![slide],
        ..Default::default()
    };
    let posts = [(0.5, 2e-3), (1.5, 2.5e-3), (2.0, 1.8e-3), (3.0, 3.5e-3)];
    let posts = posts
        .map(|(x, gap)| ball(Vec3::new(x, 0.1 + gap, 0.0)))
        .to_vec();
    let scene = Scene::new(
        "posts",
        vec![Obstacle::new("posts", posts)],
        Vec::new(),
        Vec::new(),
    )
    .unwrap();
    let model =
        CollisionModel::new(Arc::new(RobotModel::new(robot).unwrap()), Arc::new(scene)).unwrap();
    let mut scratch = Scratch::default();
    let mut validator = Validator::new(
        &model,
        model.robot().space(),
        &[],
        CLEARANCE_M,
        &mut scratch,
    );
    let path = Path::from_rows(1, vec![0.0, 2.0, 4.0]).unwrap();
    let nearest = validator.nearest(&path, &mut || false).unwrap();
    let places: Vec<f64> = nearest.holds.iter().map(along).collect();
    let distances: Vec<f64> = nearest
        .holds
        .iter()
        .map(|near| near.measure.amount)
        .collect();
    for (found, expected) in [
        (&places, [0.25, 0.75, 1.0]),
        (&distances, [2e-3, 2.5e-3, 1.8e-3]),
    ] {
        assert_eq!(found.len(), 3, "{:?}", nearest.holds);
        assert!(
            found
                .iter()
                .zip(expected)
                .all(|(found, expected)| (found - expected).abs() < 1e-4),
            "{found:?}"
        );
    }
    assert_eq!(nearest.smallest, Some(nearest.holds[2]));
    assert!((nearest.smallest.unwrap().measure.normal + Vec3::Y).length() < 1e-3);
    // Farther away nothing holds it, and the nearest is looked for a little farther.
    let path = Path::from_rows(1, vec![3.0, 3.2]).unwrap();
    let nearest = validator.nearest(&path, &mut || false).unwrap();
    assert!(
        (nearest.smallest.unwrap().measure.amount - 3.5e-3).abs() < 1e-9
            && nearest.holds.is_empty()
    );
    assert_eq!(nearest.searched_m, 10.0 * CLEARANCE_M);
}

#[test]
fn a_search_leaves_the_validator_as_it_was_and_stops_when_asked() {
    let mut rng = Rng::with_seed(8);
    for _ in 0..60 {
        let model = testing::model(&mut rng);
        let Some(path) = walk(&mut rng, &model) else {
            continue;
        };
        let held = held(&model);
        let goal = testing::configuration(&mut rng, model.robot());
        let verdicts = |searches: bool| {
            let mut scratch = Scratch::default();
            let mut validator = Validator::new(
                &model,
                model.robot().space(),
                &held,
                CLEARANCE_M,
                &mut scratch,
            );
            if let Some(pair) = model.pairs().len().checked_sub(1) {
                validator.set_floor(Requirement::Clearance(pair), CLEARANCE_M / 4.0);
            }
            let before: Vec<SegmentVerdict> = path
                .segments()
                .map(|[a, b]| validator.segment(a, b, &mut || false))
                .collect();
            if searches {
                let mut polls = 0;
                let mut stop = || {
                    polls += 1;
                    polls > 3
                };
                validator.nearest(&path, &mut stop);
                validator
                    .nearest(&path, &mut || false)
                    .expect("an answer");
                assert_eq!(validator.nearest(&path, &mut || true), None);
            }
            let floors = (
                validator.floors().clearances().to_vec(),
                validator.floors().lowered().collect::<Vec<_>>(),
            );
            let after: Vec<SegmentVerdict> = path
                .segments()
                .map(|[a, b]| validator.segment(b, a, &mut || false))
                .collect();
            let away = validator.segment(path.waypoint(0), &goal, &mut || false);
            (before, floors, after, away)
        };
        assert_eq!(verdicts(true), verdicts(false));
    }
}
