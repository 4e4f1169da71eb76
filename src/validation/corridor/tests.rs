//! The promise of the corridor, against distances that share none of its code.

use super::*;
use crate::testing::{self, Oracle};
use crate::validation::Scratch;
use crate::validation::certificate::Terms;
use crate::validation::path_proof::{self, PathVerdict};
use crate::validation::soundness::cases;

/// How far the oracle's distances may be off (m).
const ORACLE_M: f64 = 2e-5;
const FLOOR_M: f64 = 1e-3;

/// A proved path of some waypoints in a random model, widened; `None` where it is not proved.
fn corridor(model: &CollisionModel, path: &Path) -> Option<Corridor> {
    let held: Vec<f64> = model
        .robot()
        .held()
        .iter()
        .map(|variable| variable.default)
        .collect();
    let mut scratch = Scratch::default();
    let mut validator = Validator::new(model, model.robot().space(), &held, FLOOR_M, &mut scratch);
    let PathVerdict::Proved(proved) = path_proof::prove(&mut validator, path, &mut || false) else {
        return None;
    };
    let mut proofs = proved.into_proofs();
    let before: Vec<f64> = proofs
        .iter()
        .map(|proof| proof.clearance_m)
        .collect();
    validator.widen(path, &mut proofs, &mut || false);
    assert!(
        proofs
            .iter()
            .zip(before)
            .all(|(proof, before)| proof.clearance_m >= before.min(WIDEST_M))
    );
    assert!(
        validator
            .floors()
            .clearances()
            .iter()
            .all(|floor| *floor == FLOOR_M),
        "the floors are as they were"
    );
    let terms = Terms {
        clearance_m: FLOOR_M,
        lowered: Vec::new(),
        unwrapped: false,
        held: None,
        constraints: None,
    };
    Some(Corridor::new(
        model,
        path,
        &Certificate::new(model, path.into(), terms, &proofs),
    ))
}

#[test]
fn whatever_is_in_the_corridor_keeps_the_floor() {
    let (count, mut rng) = cases(400);
    let mut looked = 0;
    let mut nearest = f64::INFINITY;
    let mut straightened = Vec::new();
    for _ in 0..count {
        let model = testing::model(&mut rng);
        let robot = model.robot();
        let space = model.robot().space();
        let from = testing::configuration(&mut rng, robot);
        let to = testing::neighbour(&mut rng, robot, &from);
        let Some(path) = Path::from_rows(space.nq(), [from.clone(), to.clone()].concat()) else {
            continue;
        };
        let Some(corridor) = corridor(&model, &path) else {
            continue;
        };
        let oracle = Oracle::new(&model);
        let slack = corridor.slack_m[0];
        for _ in 0..6 {
            let p = space.between(&from, &to, rng.f64());
            // All of the slack, spread over some coordinates or spent on one.
            let alone = (rng.f64() < 0.5).then(|| rng.usize(0..space.nv()));
            let share = |j: usize, rng: &mut fastrand::Rng| match alone {
                Some(only) => f64::from(u8::from(only == j)),
                None => rng.f64(),
            };
            let shares: Vec<f64> = (0..space.nv())
                .map(|j| share(j, &mut rng))
                .collect();
            let sum: f64 = shares.iter().sum();
            let spent = |(share, reach): (&f64, &f64)| {
                if *reach > 0.0 {
                    slack * share / sum / reach
                } else {
                    *share
                }
            };
            let sign = |rng: &mut fastrand::Rng| if rng.bool() { 1.0 } else { -1.0 };
            let deviation: Vec<f64> = shares
                .iter()
                .zip(&corridor.reach)
                .map(spent)
                .map(|step| step.min(3.0) * sign(&mut rng))
                .collect();
            let mut q = vec![0.0; space.nq()];
            space.integrate(&p, &deviation, 1.0, &mut q);
            for pair in 0..model.pairs().len() {
                let [before, after] = [&p, &q].map(|q| oracle.pair_distance(&model, pair, q));
                assert!(
                    after >= FLOOR_M - ORACLE_M,
                    "{after} with slack {slack}: {:?}",
                    model.pair_names(pair)
                );
                nearest = nearest.min(after);
                straightened.push((before - after) / slack);
                looked += 1;
            }
        }
    }
    let most = straightened.iter().copied().fold(0.0, f64::max);
    println!("{looked} distances, nearest {nearest:.2e}, at most {most:.2} of the slack used");
    assert!(looked > 2_000, "{looked}");
    assert!(
        most > 0.9,
        "a slack that is never used up could be larger: {most}"
    );
}

#[test]
fn the_slack_is_most_of_what_is_there() {
    let (count, mut rng) = cases(60);
    let mut parts = Vec::new();
    for _ in 0..count {
        let model = testing::plain_model(&mut rng);
        let space = model.robot().space();
        let from = testing::configuration(&mut rng, model.robot());
        let to = testing::neighbour(&mut rng, model.robot(), &from);
        let Some(path) = Path::from_rows(space.nq(), [from.clone(), to.clone()].concat()) else {
            continue;
        };
        let Some(corridor) = corridor(&model, &path) else {
            continue;
        };
        let oracle = Oracle::new(&model);
        let sampled = (0..=64).map(|i| space.between(&from, &to, f64::from(i) / 64.0));
        let all = sampled.flat_map(|q| {
            let pairs = 0..model.pairs().len();
            pairs
                .map(|pair| oracle.pair_distance(&model, pair, &q))
                .collect::<Vec<_>>()
        });
        let least = all.fold(f64::INFINITY, f64::min);
        let there = (least - FLOOR_M).clamp(0.0, WIDEST_M);
        if there > 5e-3 {
            parts.push(corridor.slack_m[0] / there);
        }
    }
    parts.sort_by(f64::total_cmp);
    println!(
        "{} segments: {:.3} to {:.3} of what is there",
        parts.len(),
        parts[0],
        parts[parts.len() - 1]
    );
    assert!(
        parts.len() > 10 && parts[0] > 0.75 && parts[parts.len() - 1] < 1.01,
        "{parts:?}"
    );
}
