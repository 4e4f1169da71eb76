//! What an integrator relies on, of every optimizer and wherever it is stopped, on random robots of
//! all joint kinds.

use proptest::prelude::*;
use proptest::test_runner::TestCaseError;

use super::properties::{OPTIMIZERS, cases, is_last, request};
use super::{Mode, Outcome, Settings, Termination, Workspace, run};
use crate::collision::CollisionModel;
use crate::path::Path;
use crate::robot::{Component, ConfigurationSpace};
use crate::validation::path_proof::{self, PathVerdict};
use crate::validation::{Layers, Requirement, Scratch, Validator};

/// Differences below this are rounding (rad or m).
const ROUNDING: f64 = 1e-7;

/// An answer and what was published on the way to it.
struct Run {
    outcome: Outcome,
    published: Vec<(Path, f64)>,
    /// How often it was asked whether to stop.
    polls: u64,
}

/// Runs a request that is stopped at this poll.
fn run_until(
    model: &CollisionModel,
    path: &Path,
    settings: &Settings,
    workspace: &mut Workspace,
    last: u64,
) -> Run {
    let mut published = Vec::new();
    let mut polls = 0;
    let mut stop = || {
        polls += 1;
        polls > last
    };
    let mut publish = |improvement: super::Improvement| {
        published.push((improvement.path.clone(), improvement.length))
    };
    let outcome =
        run(model, path, settings, workspace, &mut stop, &mut publish).expect("a valid request");
    Run {
        outcome,
        published,
        polls,
    }
}

fn whole(model: &CollisionModel, path: &Path, settings: &Settings) -> Run {
    run_until(model, path, settings, &mut Workspace::default(), u64::MAX)
}

/// Everything that is promised of an answer.
fn keeps_its_promises(
    model: &CollisionModel,
    path: &Path,
    settings: &Settings,
    run: &Run,
) -> Result<(), TestCaseError> {
    let Run {
        outcome, published, ..
    } = run;
    if !outcome.proved {
        prop_assert_eq!(outcome.termination, Termination::Stopped);
        prop_assert_eq!(
            &outcome.path,
            path,
            "what is not proved is the untouched input"
        );
        prop_assert!(published.is_empty() && outcome.nearest.is_none());
        return Ok(());
    }
    prop_assert!(outcome.length_after <= outcome.length_before);
    prop_assert!(
        outcome.nearest.is_none() || outcome.termination != Termination::Stopped,
        "looked on after the stop"
    );
    let mut length = outcome.length_before;
    for (better, its_length) in published {
        prop_assert!(*its_length < length, "published paths get strictly shorter");
        length = *its_length;
        keeps_what_it_must(model, path, settings, better)?;
        prop_assert!(
            is_proved_afresh(model, better, settings, outcome),
            "a published path is not provable"
        );
    }
    let last = published.last().map_or(path, |(best, _)| best);
    prop_assert!(
        is_last(last, outcome, length),
        "the best path is the last one published"
    );
    prop_assert!(
        is_proved_afresh(model, &outcome.path, settings, outcome),
        "the answer is not provable"
    );
    keeps_what_it_must(model, path, settings, &outcome.path)
}

/// Ends, fixed waypoints, what may not move, and limits.
fn keeps_what_it_must(
    model: &CollisionModel,
    path: &Path,
    settings: &Settings,
    better: &Path,
) -> Result<(), TestCaseError> {
    let fixed = |i: usize| {
        settings
            .fixed_waypoints
            .as_ref()
            .is_some_and(|fixed| fixed[i])
    };
    let mut rest = better.waypoints();
    for (i, waypoint) in path.waypoints().enumerate() {
        if i == 0 || i + 1 == path.len() || fixed(i) {
            prop_assert!(
                rest.any(|row| row == waypoint),
                "waypoint {i} is gone or out of order"
            );
        }
    }
    prop_assert_eq!(better.waypoint(0), path.waypoint(0));
    prop_assert_eq!(
        better.waypoint(better.len() - 1),
        path.waypoint(path.len() - 1)
    );
    for waypoint in better.waypoints() {
        for (x, variable) in waypoint.iter().zip(model.robot().variables()) {
            prop_assert!(
                (variable.lower..=variable.upper).contains(x),
                "{} = {x}",
                variable.name
            );
        }
    }
    match &settings.moving {
        Some(moving) => moves_as_before(model.robot().space(), path, better, moving),
        None => Ok(()),
    }
}

/// Whether a validator that knows nothing yet proves the path at the request's floors.
fn is_proved_afresh(
    model: &CollisionModel,
    path: &Path,
    settings: &Settings,
    outcome: &Outcome,
) -> bool {
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
        settings.clearance_m,
        &mut scratch,
    );
    for lowered in &outcome.floors_lowered {
        let of_name =
            |requirement: &Requirement| requirement.named(model, &[]) == lowered.requirement;
        requirements(model)
            .filter(of_name)
            .for_each(|requirement| validator.set_floor(requirement, lowered.floor));
    }
    matches!(
        path_proof::prove(&mut validator, path, &mut || false),
        PathVerdict::Proved(_)
    )
}

/// All that a model requires.
fn requirements(model: &CollisionModel) -> impl Iterator<Item = Requirement> + use<> {
    (0..model.pairs().len()).map(Requirement::Clearance)
}

/// The motion of the coordinates that may not move, with what they have travelled at each waypoint.
struct Still<'a> {
    space: &'a ConfigurationSpace,
    path: &'a Path,
    moving: &'a [bool],
    travelled: Vec<f64>,
}

impl<'a> Still<'a> {
    fn new(space: &'a ConfigurationSpace, path: &'a Path, moving: &'a [bool]) -> Self {
        let mut still = Self {
            space,
            path,
            moving,
            travelled: vec![0.0],
        };
        for i in 1..path.len() {
            let step = still.distance(path.waypoint(i - 1), path.waypoint(i));
            still
                .travelled
                .push(still.travelled[i - 1] + step);
        }
        still
    }

    fn distance(&self, from: &[f64], to: &[f64]) -> f64 {
        let mut velocity = vec![0.0; self.space.nv()];
        self.space.difference(to, from, &mut velocity);
        velocity
            .iter()
            .zip(self.moving)
            .filter(|(_, moves)| !**moves)
            .map(|(v, _)| v * v)
            .sum::<f64>()
            .sqrt()
    }

    /// Where they are after so much travel.
    fn at(&self, travelled: f64) -> Vec<f64> {
        let after = self
            .travelled
            .partition_point(|&t| t < travelled)
            .clamp(1, self.path.len().max(2) - 1);
        let last = self.path.len() - 1;
        let from = self.path.waypoint((after - 1).min(last));
        let to = self.path.waypoint(after.min(last));
        let step = self.travelled[after.min(last)] - self.travelled[(after - 1).min(last)];
        let ratio = if step > 0.0 {
            ((travelled - self.travelled[after - 1]) / step).clamp(0.0, 1.0)
        } else {
            0.0
        };
        self.space.between(from, to, ratio)
    }
}

/// What may not move goes the same way as before, at every place of it.
fn moves_as_before(
    space: &ConfigurationSpace,
    before: &Path,
    after: &Path,
    moving: &[bool],
) -> Result<(), TestCaseError> {
    let before = Still::new(space, before, moving);
    let after = Still::new(space, after, moving);
    let total = [&before, &after].map(|still| still.travelled.last().copied().unwrap_or(0.0));
    prop_assert!(
        (total[0] - total[1]).abs() < ROUNDING,
        "{} of still motion became {}",
        total[0],
        total[1]
    );
    for (one, other) in [(&before, &after), (&after, &before)] {
        for (waypoint, &travelled) in one.path.waypoints().zip(&one.travelled) {
            let away = one.distance(waypoint, &other.at(travelled));
            prop_assert!(
                away < ROUNDING.sqrt() * 1e-2,
                "{away} off the way after {travelled}"
            );
        }
    }
    Ok(())
}

/// Turns of circles and signs of quaternions may differ between the caller's rows and an
/// optimizer's; motions may not.
fn has_only_lines(model: &CollisionModel) -> bool {
    model
        .robot()
        .space()
        .components()
        .iter()
        .all(|component| matches!(component, Component::Line { .. }))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases()))]

    #[test]
    fn promises_hold_at_any_work_budget(seed: u64, mode in 0usize..5, budget in 1u64..200_000) {
        let Some((model, path, settings)) = request(seed, OPTIMIZERS[mode]) else { return Ok(()) };
        // Small budgets more often than large ones.
        let work_budget = 1 + budget * budget / 200_000;
        let settings = Settings { work_budget, ..settings };
        keeps_its_promises(&model, &path, &settings, &whole(&model, &path, &settings))?;
    }

    #[test]
    fn promises_hold_at_any_stop(seed: u64, mode in 0usize..5, part in 0.0f64..1.0) {
        let Some((model, path, settings)) = request(seed, OPTIMIZERS[mode]) else { return Ok(()) };
        let polls = whole(&model, &path, &settings).polls;
        let last = (part * part * polls as f64) as u64;
        let run = run_until(&model, &path, &settings, &mut Workspace::default(), last);
        keeps_its_promises(&model, &path, &settings, &run)?;
    }

    /// A weighted metric is another problem; the same promises hold.
    #[test]
    fn promises_hold_in_any_metric(seed: u64, mode in 0usize..5) {
        let Some((model, path, mut settings)) = request(seed, OPTIMIZERS[mode]) else { return Ok(()) };
        let mut rng = fastrand::Rng::with_seed(seed);
        let mut weights: Vec<f64> = (0..model.robot().space().nv()).map(|_| (4.0 * rng.f64() - 2.0).exp()).collect();
        for component in model.robot().space().components() {
            if let Component::Rotation { v, .. } = *component {
                weights.copy_within(v..v + 1, v + 1);
                weights.copy_within(v..v + 1, v + 2);
            }
        }
        settings.weights = Some(weights);
        keeps_its_promises(&model, &path, &settings, &whole(&model, &path, &settings))?;
    }

    #[test]
    fn answers_do_not_depend_on_what_ran_before_nor_on_the_lanes(seed: u64, mode in 0usize..5, other: u64) {
        let Some((model, path, settings)) = request(seed, OPTIMIZERS[mode]) else { return Ok(()) };
        let budget = Settings { work_budget: 200_000, ..settings };
        let first = whole(&model, &path, &budget).outcome;
        let mut workspace = Workspace::default();
        if let Some((model, path, settings)) = request(other, OPTIMIZERS[(other % 5) as usize]) {
            run_until(&model, &path, &settings, &mut workspace, other % 1000);
        }
        let second = run_until(&model, &path, &budget, &mut workspace, u64::MAX).outcome;
        prop_assert_eq!(format!("{first:?}"), format!("{second:?}"));
        let portable = Settings { layers: Layers { portable_lanes: true, ..Layers::default() }, ..budget };
        let third = whole(&model, &path, &portable).outcome;
        prop_assert_eq!(format!("{first:?}"), format!("{third:?}"));
    }

    /// What is said to be nearest is where it is said to be, on the caller's own path, whose
    /// waypoints may repeat.
    #[test]
    fn contacts_are_of_the_path_that_is_returned(seed: u64, mode in 0usize..6) {
        let mode = OPTIMIZERS.get(mode).copied().unwrap_or(Mode::Check);
        let Some((model, path, settings)) = request(seed, mode) else { return Ok(()) };
        if !has_only_lines(&model) {
            return Ok(());
        }
        let mut rng = fastrand::Rng::with_seed(seed);
        let repeated = path.waypoints().flat_map(|row| row.repeat(rng.usize(1..3)));
        let path = Path::from_rows(path.nq(), repeated.collect()).expect("whole rows");
        let settings = Settings { fixed_waypoints: None, ..settings };
        let outcome = whole(&model, &path, &settings).outcome;
        let nearest = outcome.nearest.expect("nothing stopped it");
        let held: Vec<f64> = model.robot().held().iter().map(|held| held.default).collect();
        let mut scratch = Scratch::default();
        let mut validator = Validator::new(&model, model.robot().space(), &held, settings.clearance_m, &mut scratch);
        for hold in nearest.holds.iter().chain(&nearest.smallest) {
            let next = (hold.segment + 1).min(outcome.path.len() - 1);
            let ends = [hold.segment, next].map(|end| outcome.path.waypoint(end));
            let of_name = |requirement: &Requirement| requirement.named(&model, &[]) == hold.requirement;
            let amounts = requirements(&model).filter(of_name).map(|requirement| validator.measure(requirement, ends, hold.t).amount);
            let closest = amounts.map(|amount| (amount - hold.amount).abs()).fold(f64::INFINITY, f64::min);
            prop_assert!(closest < 1e-9, "{hold:?} is off by {closest}");
        }
    }
}
