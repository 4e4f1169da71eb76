//! What must hold of every optimizer, on random robots of all joint kinds among random obstacles.

use proptest::prelude::*;

use super::{Mode, Outcome, Settings, Workspace, run};
use crate::collision::CollisionModel;
use crate::path::Path;
use crate::testing;
use crate::validation::{Scratch, SegmentVerdict, Validator};

pub(super) const OPTIMIZERS: [Mode; 5] = [
    Mode::Gradient,
    Mode::RandomShortcut,
    Mode::PartialShortcut,
    Mode::Contact,
    Mode::Hybrid,
];
const CLEARANCE_M: f64 = 1e-3;

/// Random cases of each property; `TAUT_CASES` asks for more.
pub(super) fn cases() -> u32 {
    std::env::var("TAUT_CASES")
        .ok()
        .and_then(|cases| cases.parse().ok())
        .unwrap_or(60)
}

/// A random walk whose every segment is proved; `None` where the robot cannot start or move.
fn walk(rng: &mut fastrand::Rng, model: &CollisionModel, waypoints: usize) -> Option<Path> {
    let robot = model.robot();
    let held: Vec<f64> = robot.held().iter().map(|h| h.default).collect();
    let mut scratch = Scratch::default();
    let mut validator = Validator::new(model, robot.space(), &held, CLEARANCE_M, &mut scratch);
    let mut at = testing::configuration(rng, robot);
    let mut rows = at.clone();
    for _ in 0..20 * waypoints {
        if rows.len() == waypoints * at.len() {
            return Path::from_rows(at.len(), rows);
        }
        let to = testing::neighbour(rng, robot, &at);
        let inside = to
            .iter()
            .zip(robot.variables())
            .all(|(x, v)| (v.lower..=v.upper).contains(x));
        if inside
            && matches!(
                validator.segment(&at, &to, &mut || false),
                SegmentVerdict::Proved(_)
            )
        {
            rows.extend_from_slice(&to);
            at = to;
        }
    }
    None
}

/// A robot that can move, its path, and the settings for `mode`, some of them with fixed waypoints
/// and coordinates.
pub(super) fn request(seed: u64, mode: Mode) -> Option<(CollisionModel, Path, Settings)> {
    let mut rng = fastrand::Rng::with_seed(seed);
    let model = testing::model(&mut rng);
    let nv = model.robot().space().nv();
    if nv == 0 {
        return None;
    }
    let waypoints = rng.usize(1..9);
    let path = walk(&mut rng, &model, waypoints)?;
    let mut settings = Settings {
        mode,
        seed,
        clearance_m: CLEARANCE_M,
        work_budget: 3_000_000,
        ..Settings::default()
    };
    // Links that no joint moves may stand in obstacles: the walk does not see them, the request
    // does.
    let check = Settings {
        mode: Mode::Check,
        ..settings.clone()
    };
    if !answer(&model, &path, &check).0.proved {
        return None;
    }
    if rng.bool() {
        settings.fixed_waypoints = Some(
            (0..path.len())
                .map(|_| rng.f64() < 0.2)
                .collect(),
        );
    }
    if rng.bool() {
        settings.moving = Some(masks(&mut rng, &model));
    }
    Some((model, path, settings))
}

/// Whole components that move.
fn masks(rng: &mut fastrand::Rng, model: &CollisionModel) -> Vec<bool> {
    use crate::robot::Component;
    let mut moving = vec![true; model.robot().space().nv()];
    for component in model.robot().space().components() {
        let still = rng.f64() < 0.4;
        match *component {
            Component::Rotation { v, .. } => moving[v..v + 3].fill(!still),
            Component::Line { v, .. } | Component::Circle { v, .. } => moving[v] = !still,
        }
    }
    moving
}

fn answer(model: &CollisionModel, path: &Path, settings: &Settings) -> (Outcome, Vec<(Path, f64)>) {
    let mut published = Vec::new();
    let mut take = |improvement: super::Improvement| {
        published.push((improvement.path.clone(), improvement.length))
    };
    let outcome = run(
        model,
        path,
        settings,
        &mut Workspace::default(),
        &mut || false,
        &mut take,
    );
    (outcome.expect("a valid request"), published)
}

/// Whether the answer is the last path that was published, of this length, or that without
/// waypoints that it can do without.
pub(super) fn is_last(last: &Path, outcome: &Outcome, length: f64) -> bool {
    let is_thinned =
        outcome.path.len() < last.len() && (outcome.length_after - length).abs() <= 1e-8 * length;
    *last == outcome.path || is_thinned
}

/// How far the coordinates that may not move travel along the path.
fn travel_of_still(model: &CollisionModel, path: &Path, moving: &[bool]) -> f64 {
    let space = model.robot().space();
    let mut velocity = vec![0.0; space.nv()];
    let mut travel = 0.0;
    for i in 1..path.len() {
        space.difference(path.waypoint(i), path.waypoint(i - 1), &mut velocity);
        let still = velocity
            .iter()
            .zip(moving)
            .filter(|(_, moves)| !**moves);
        travel += still.map(|(v, _)| v * v).sum::<f64>().sqrt();
    }
    travel
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases()))]

    #[test]
    fn every_answer_is_proved_and_never_longer(seed: u64, mode in 0usize..5) {
        let Some((model, path, settings)) = request(seed, OPTIMIZERS[mode]) else { return Ok(()) };
        let (outcome, published) = answer(&model, &path, &settings);
        prop_assert!(outcome.proved);
        prop_assert!(outcome.length_after <= outcome.length_before);
        let mut length = outcome.length_before;
        for (better, its_length) in &published {
            prop_assert!(*its_length < length, "published paths get shorter");
            length = *its_length;
            prop_assert_eq!(better.waypoint(0), path.waypoint(0));
            prop_assert_eq!(better.waypoint(better.len() - 1), path.waypoint(path.len() - 1));
        }
        let last = published.last().map_or(&path, |(best, _)| best);
        prop_assert!(is_last(last, &outcome, length), "the best path is the last one published");
    }

    #[test]
    fn fixed_waypoints_stay_and_limits_hold(seed: u64, mode in 0usize..5) {
        let Some((model, path, settings)) = request(seed, OPTIMIZERS[mode]) else { return Ok(()) };
        let (outcome, _) = answer(&model, &path, &settings);
        let mut rest = outcome.path.waypoints();
        let fixed = settings.fixed_waypoints.unwrap_or_default();
        for (i, waypoint) in path.waypoints().enumerate() {
            if i == 0 || i + 1 == path.len() || fixed.get(i) == Some(&true) {
                prop_assert!(rest.any(|row| row == waypoint), "waypoint {i} is gone");
            }
        }
        for waypoint in outcome.path.waypoints() {
            for (x, variable) in waypoint.iter().zip(model.robot().variables()) {
                prop_assert!((variable.lower..=variable.upper).contains(x), "{} = {x}", variable.name);
            }
        }
    }

    #[test]
    fn what_may_not_move_moves_as_before(seed: u64, mode in 0usize..5) {
        let Some((model, path, settings)) = request(seed, OPTIMIZERS[mode]) else { return Ok(()) };
        let Some(moving) = &settings.moving else { return Ok(()) };
        let (outcome, _) = answer(&model, &path, &settings);
        let (before, after) =
            (travel_of_still(&model, &path, moving), travel_of_still(&model, &outcome.path, moving));
        prop_assert!((before - after).abs() < 1e-9 * (1.0 + before), "{before} became {after}");
    }

    #[test]
    fn the_same_request_has_the_same_answer(seed: u64, mode in 0usize..5) {
        let Some((model, path, settings)) = request(seed, OPTIMIZERS[mode]) else { return Ok(()) };
        let (first, second) = (answer(&model, &path, &settings), answer(&model, &path, &settings));
        prop_assert_eq!(first.0.path.hash(), second.0.path.hash());
        prop_assert_eq!(first.0.work, second.0.work);
        prop_assert_eq!(first.1.len(), second.1.len());
    }
}
