//! The verdict on random paths of random robots, against dense samples and distances that share
//! none of its code.

use proptest::prelude::*;
use proptest::test_runner::TestCaseError;

use super::*;
use crate::collision::CollisionModel;
use crate::testing::{self, Oracle};
use crate::validation::validator::FINEST;
use crate::validation::{Layers, Scratch};

const CLEARANCE_M: f64 = 1e-3;
/// How far the oracle's distances and depths may be off (m).
const ORACLE_M: f64 = 2e-5;
/// Depth (m) from which a collision must be found: well above what may pass unseen and what the
/// oracle is off by.
const DEEP_M: f64 = 1e-4;

fn cases() -> u32 {
    std::env::var("TAUT_CASES")
        .ok()
        .and_then(|cases| cases.parse().ok())
        .unwrap_or(100)
}

/// A random model and a random path of one to six waypoints, whatever it meets; every other is
/// resampled, and not quite straight then.
fn request(seed: u64) -> (CollisionModel, Path) {
    let mut rng = fastrand::Rng::with_seed(seed);
    let model = testing::model(&mut rng);
    let mut rows = testing::configuration(&mut rng, model.robot());
    let nq = rows.len();
    for i in 0..rng.usize(0..6) {
        let next = testing::neighbour(&mut rng, model.robot(), &rows[i * nq..]);
        rows.extend(next);
    }
    if rng.bool() && rng.bool() && rows.len() > nq {
        rows = resampled(&mut rng, &model, &rows);
    }
    let path = if nq == 0 {
        Path::from_rows(1, vec![0.0])
    } else {
        Path::from_rows(nq, rows)
    };
    (model, path.expect("whole rows"))
}

fn resampled(rng: &mut fastrand::Rng, model: &CollisionModel, rows: &[f64]) -> Vec<f64> {
    let space = model.robot().space();
    let nq = space.nq();
    let parts = rng.usize(2..60);
    let noise = [0.0, 1e-7, 1e-4][rng.usize(0..3)];
    let mut fine = rows[..nq].to_vec();
    for (from, to) in rows.chunks(nq).zip(rows.chunks(nq).skip(1)) {
        for part in 1..=parts {
            let shaken: Vec<f64> = (0..space.nv())
                .map(|_| testing::uniform(rng, -noise, noise))
                .collect();
            let mut at = vec![0.0; nq];
            space.integrate(
                &space.between(from, to, part as f64 / parts as f64),
                &shaken,
                1.0,
                &mut at,
            );
            fine.extend(at);
        }
    }
    fine
}

struct Run<'p> {
    verdict: PathVerdict<'p>,
    floors: Vec<f64>,
    /// How often it was asked whether to stop.
    polls: u64,
}

fn run<'p>(
    model: &CollisionModel,
    path: &'p Path,
    may_lower: bool,
    layers: Layers,
    last: u64,
) -> Run<'p> {
    let held: Vec<f64> = model
        .robot()
        .held()
        .iter()
        .map(|held| held.default)
        .collect();
    let mut scratch = Scratch::default();
    let validator = Validator::new(
        model,
        model.robot().space(),
        &held,
        CLEARANCE_M,
        &mut scratch,
    );
    let mut validator = validator.with_layers(layers);
    let mut polls = 0;
    let mut stop = || {
        polls += 1;
        polls > last
    };
    let verdict = prove_input(&mut validator, path, may_lower, &mut stop);
    Run {
        verdict,
        floors: validator.floors().clearances().to_vec(),
        polls,
    }
}

fn whole<'p>(model: &CollisionModel, path: &'p Path, may_lower: bool) -> Run<'p> {
    run(model, path, may_lower, Layers::default(), u64::MAX)
}

/// Where along the path, in segments, and the configuration there.
fn samples(model: &CollisionModel, path: &Path) -> Vec<(f64, Vec<f64>)> {
    let each = (256 / segments(path)).clamp(4, 64);
    let at = |i: usize| {
        let segment = i / each;
        let t = (i % each) as f64 / each as f64;
        let [from, to] = ends(path, segment);
        (
            segment as f64 + t,
            model.robot().space().between(from, to, t),
        )
    };
    (0..segments(path) * each)
        .map(at)
        .chain([(
            segments(path) as f64,
            path.waypoint(path.len() - 1).to_vec(),
        )])
        .collect()
}

/// Whether a body begins inside of a mesh, which the oracle sees as a surface.
fn begins_enclosed(model: &CollisionModel, path: &Path) -> bool {
    let held: Vec<f64> = model
        .robot()
        .held()
        .iter()
        .map(|held| held.default)
        .collect();
    let mut scratch = Scratch::default();
    let mut validator = Validator::new(
        model,
        model.robot().space(),
        &held,
        CLEARANCE_M,
        &mut scratch,
    );
    validator.enclosed_at(path.waypoint(0), &mut || false) != Enclosed::Nothing
}

/// Everything before `until` keeps the floors.
fn is_free_until(
    model: &CollisionModel,
    path: &Path,
    floors: &[f64],
    until: f64,
) -> Result<(), TestCaseError> {
    let oracle = Oracle::new(model);
    for (place, q) in samples(model, path)
        .iter()
        .filter(|(place, _)| *place < until)
    {
        for (pair, floor) in floors.iter().enumerate() {
            let distance = oracle.pair_distance(model, pair, q);
            prop_assert!(
                distance >= floor - ORACLE_M,
                "{distance} at {place}, before {until}, where {floor} is proved"
            );
            prop_assert!(
                oracle.pair_depth(model, pair, q) < ORACLE_M || model.pair_names(pair).is_empty()
            );
        }
    }
    Ok(())
}

/// The first sample at which any two bodies are deep in each other.
fn first_deep(model: &CollisionModel, path: &Path) -> Option<f64> {
    let oracle = Oracle::new(model);
    let is_deep =
        |q: &[f64]| (0..model.pairs().len()).any(|pair| oracle.pair_depth(model, pair, q) > DEEP_M);
    samples(model, path)
        .into_iter()
        .find(|(_, q)| is_deep(q))
        .map(|(place, _)| place)
}

/// Where a path is refused for a collision.
fn collision(verdict: &PathVerdict) -> Option<f64> {
    match verdict {
        PathVerdict::Refused { segment, hit, .. } if hit.reason == HitReason::Collision => {
            Some(*segment as f64 + hit.t)
        }
        _ => None,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases()))]

    #[test]
    fn a_collision_anywhere_is_the_verdict_and_the_first_one(seed: u64, may_lower: bool) {
        let (model, path) = request(seed);
        let Run { verdict, floors, .. } = whole(&model, &path, may_lower);
        prop_assert!(may_lower || floors.iter().all(|floor| *floor == CLEARANCE_M));
        if begins_enclosed(&model, &path) {
            prop_assert_eq!(collision(&verdict), Some(0.0));
            return Ok(());
        }
        if let Some(deep) = first_deep(&model, &path) {
            let Some(place) = collision(&verdict) else { panic!("{verdict:?}, though bodies collide at {deep}") };
            prop_assert!(place <= deep + FINEST, "a collision at {}, the first at {}", place, deep);
        }
        match verdict {
            PathVerdict::Proved(proved) => {
                prop_assert_eq!(proved.proofs().len(), segments(&path));
                is_free_until(&model, &path, &floors, f64::INFINITY)?;
            }
            PathVerdict::Refused { segment, hit, proved_prefix } => {
                prop_assert!(proved_prefix <= segment as f64 + hit.t);
                is_free_until(&model, &path, &floors, proved_prefix)?;
                let [from, to] = ends(&path, segment);
                let q = model.robot().space().between(from, to, hit.t);
                let distance = Oracle::new(&model).kept(&model, hit.requirement, &q);
                let most = if hit.reason == HitReason::Collision { 0.0 } else { 1.5 * CLEARANCE_M };
                prop_assert!(distance <= most + 2.0 * ORACLE_M, "{:?} at {}", hit, distance);
            }
            PathVerdict::Stopped => panic!("nothing stops it"),
        }
    }

    /// A stop leaves no verdict, a collision that is one, or what would have been said without it.
    #[test]
    fn a_stop_turns_no_verdict_into_another(seed: u64, may_lower: bool, part in 0.0f64..1.0) {
        let (model, path) = request(seed);
        let all = whole(&model, &path, may_lower);
        let stopped = run(&model, &path, may_lower, Layers::default(), (part * all.polls as f64) as u64);
        match (&stopped.verdict, collision(&stopped.verdict)) {
            (PathVerdict::Stopped, _) => {}
            (PathVerdict::Refused { segment, hit, proved_prefix }, Some(place)) => {
                let Some(first) = collision(&all.verdict) else { panic!("{:?} is none", stopped.verdict) };
                prop_assert!(first <= place + FINEST, "{} is before the first, {}", place, first);
                let [from, to] = ends(&path, *segment);
                let q = model.robot().space().between(from, to, hit.t);
                let is_enclosed = hit.measure.points[0] == hit.measure.points[1];
                prop_assert!(is_enclosed || Oracle::new(&model).kept(&model, hit.requirement, &q) < ORACLE_M);
                if !begins_enclosed(&model, &path) {
                    is_free_until(&model, &path, &stopped.floors, *proved_prefix)?;
                }
            }
            (verdict, _) => prop_assert_eq!(verdict, &all.verdict),
        }
    }

    #[test]
    fn layers_change_no_collision(seed: u64, layer in 0usize..4) {
        let (model, path) = request(seed);
        let mut layers = Layers::default();
        [&mut layers.filter, &mut layers.along_normal, &mut layers.reuse, &mut layers.portable_lanes]
            .into_iter().enumerate().filter(|(i, _)| *i == layer).for_each(|(_, flag)| *flag = !*flag);
        let [one, other] = [Layers::default(), layers].map(|layers| run(&model, &path, true, layers, u64::MAX).verdict);
        if first_deep(&model, &path).is_some() || begins_enclosed(&model, &path) {
            let [one, other] = [&one, &other].map(collision);
            let (Some(one), Some(other)) = (one, other) else { panic!("{one:?} and {other:?}") };
            prop_assert!((one - other).abs() <= 2.0 * FINEST, "{} and {}", one, other);
        }
    }
}
