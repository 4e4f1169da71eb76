use fastrand::Rng;

use super::*;
use crate::collision::CollisionModel;
use crate::testing;
use crate::validation::{Scratch, SegmentVerdict};

const CLEARANCE_M: f64 = 1e-3;
/// Samples of each segment.
const SAMPLES: u32 = 500;

fn held(model: &CollisionModel) -> Vec<f64> {
    model.robot().held().iter().map(|held| held.default).collect()
}

/// A proved path that goes as near to what is in its way as a proof allows.
fn walk(rng: &mut Rng, model: &CollisionModel) -> Option<Path> {
    let (robot, held) = (model.robot(), held(model));
    let mut scratch = Scratch::default();
    let mut validator = Validator::new(model, robot.space(), &held, CLEARANCE_M, &mut scratch);
    let mut at = testing::configuration(rng, robot);
    if robot.space().nv() == 0 || validator.proves(&at, &at, &mut || false) != Some(true) {
        return None;
    }
    let mut rows = at.clone();
    for _ in 0..rng.usize(1..5) {
        let to = testing::neighbour(rng, robot, &at);
        let (mut proved, mut refused) = (0.0, 1.0);
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
    samples.iter().map(|sample| sample.1).fold(f64::INFINITY, f64::min)
}

/// Distances of a pair at many places of the path, each with its place along it.
fn sampled(validator: &mut Validator, path: &Path, pair: usize) -> Vec<(f64, f64)> {
    let mut samples = Vec::new();
    for segment in 0..(path.len() - 1).max(1) {
        let (from, to) = (path.waypoint(segment), path.waypoint((segment + 1).min(path.len() - 1)));
        for sample in 0..=SAMPLES {
            let t = f64::from(sample) / f64::from(SAMPLES);
            samples.push((segment as f64 + t, validator.contact_between(pair, from, to, t).distance));
        }
    }
    samples
}

fn along(near: &Near) -> f64 {
    near.segment as f64 + near.t
}

#[test]
fn nothing_is_nearer_than_what_is_reported() {
    let cases = std::env::var("TAUT_CASES").ok().and_then(|cases| cases.parse().ok()).unwrap_or(300);
    let mut rng = Rng::with_seed(std::env::var("TAUT_SEED").ok().and_then(|seed| seed.parse().ok()).unwrap_or(5));
    let (mut held_paths, mut contacts, mut free) = (0, 0, 0);
    for _ in 0..cases {
        let model = testing::model(&mut rng);
        let Some(path) = walk(&mut rng, &model) else { continue };
        let held = held(&model);
        let mut scratch = Scratch::default();
        let mut validator = Validator::new(&model, model.robot().space(), &held, CLEARANCE_M, &mut scratch);
        let nearest = validator.nearest(&path, &mut || false).expect("not dearer than it may be");
        let (within, tolerance) = (CONTACT_FLOORS * CLEARANCE_M, RESOLUTION * CLEARANCE_M + 1e-9);
        let parted = 1.5 * within;
        held_paths += usize::from(!nearest.contacts.is_empty());
        contacts += nearest.contacts.len();
        free += usize::from(nearest.smallest.is_none());
        let least = nearest.smallest.map_or(nearest.searched_m, |near| near.contact.distance);
        for pair in 0..model.pairs().len() {
            let samples = sampled(&mut validator, &path, pair);
            let of_pair: Vec<&Near> = nearest.contacts.iter().filter(|near| near.pair == pair).collect();
            for run in samples.chunk_by(|a, b| (a.1 < parted) == (b.1 < parted)) {
                let (lowest, first, last) = (least_of(run), run[0].0, run[run.len() - 1].0);
                let here = |near: &&&Near| (first - 0.01..=last + 0.01).contains(&along(near));
                let named = of_pair.iter().filter(here).map(|near| near.contact.distance).fold(f64::INFINITY, f64::min);
                assert!(named.min(within) < lowest + tolerance, "{lowest} m in {first}..{last}, named {of_pair:?}");
            }
            let lowest = least_of(&samples);
            assert!(lowest > least - tolerance, "{lowest} seen, {least} said to be the least");
        }
        for near in nearest.contacts.iter().chain(&nearest.smallest) {
            let ends = [near.segment, (near.segment + 1).min(path.len() - 1)].map(|waypoint| path.waypoint(waypoint));
            let exact = validator.contact_between(near.pair, ends[0], ends[1], near.t);
            assert_eq!(exact, near.contact);
        }
        assert!(nearest.contacts.is_sorted_by(|a, b| along(a) <= along(b)));
    }
    println!("{held_paths} paths held by {contacts} contacts, nothing near on {free}");
    assert!(held_paths > cases / 10 && free > cases / 100);
}

#[test]
fn a_search_leaves_the_validator_as_it_was_and_stops_when_asked() {
    let mut rng = Rng::with_seed(8);
    for _ in 0..60 {
        let model = testing::model(&mut rng);
        let Some(path) = walk(&mut rng, &model) else { continue };
        let held = held(&model);
        let goal = testing::configuration(&mut rng, model.robot());
        let verdicts = |searches: bool| {
            let mut scratch = Scratch::default();
            let mut validator = Validator::new(&model, model.robot().space(), &held, CLEARANCE_M, &mut scratch);
            if let Some(pair) = model.pairs().len().checked_sub(1) {
                validator.set_floor(pair, CLEARANCE_M / 4.0);
            }
            let before: Vec<SegmentVerdict> =
                path.segments().map(|[a, b]| validator.segment(a, b, &mut || false)).collect();
            if searches {
                let mut polls = 0;
                let mut stop = || {
                    polls += 1;
                    polls > 3
                };
                validator.nearest(&path, &mut stop);
                validator.nearest(&path, &mut || false).expect("an answer");
                assert_eq!(validator.nearest(&path, &mut || true), None);
            }
            let floors = (validator.floors().to_vec(), validator.lowered().collect::<Vec<_>>());
            let after: Vec<SegmentVerdict> =
                path.segments().map(|[a, b]| validator.segment(b, a, &mut || false)).collect();
            let away = validator.segment(path.waypoint(0), &goal, &mut || false);
            (before, floors, after, away)
        };
        assert_eq!(verdicts(true), verdicts(false));
    }
}
