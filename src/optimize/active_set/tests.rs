//! The step against its own optimality conditions and against Clarabel.

use super::*;
use crate::math::DVector;
use crate::optimize::testing::{self, Dense, Instance};
use proptest::prelude::*;

/// Segment, ratio, jacobian and right-hand side of a row.
type Given = (usize, f64, Vec<f64>, f64);

/// Rows that all but depend on each other need such forces, of a model whose forces are about 1;
/// whether they do depend is then no longer seen.
const ROUNDING_DECIDES: f64 = 1e7;
/// No path is as long as a step that goes so far.
const FAR_AWAY: f64 = 1e3;

/// A random instance with random half-spaces.
struct Case {
    instance: Instance,
    gradient: Vec<f64>,
    given: Vec<Given>,
    random: fastrand::Rng,
}

/// What came of it.
struct Solved {
    set: ActiveSet,
    step: Vec<f64>,
}

impl Case {
    fn random(seed: u64, waypoints: usize) -> Self {
        let on_lines = seed.is_multiple_of(3);
        let instance = if on_lines {
            testing::lines(seed, waypoints, 3)
        } else {
            testing::instance(seed, waypoints)
        };
        let nv = instance.space.nv();
        let mut path = instance.rows.clone();
        testing::shake(&instance.space, &mut path, seed);
        let mut gradient = vec![0.0; waypoints * nv];
        cost(&instance).gradient(&path, &mut vec![0.0; nv], &mut gradient);
        Self {
            instance,
            gradient,
            given: Vec::new(),
            random: fastrand::Rng::with_seed(seed ^ 0x5eed),
        }
    }

    /// The same with so many half-spaces that one random step is in all of; some of them it only
    /// just is in.
    fn with_feasible(mut self, count: usize) -> Self {
        let inside = self.random_step();
        for _ in 0..count {
            let mut given = self.random_row();
            let slack = if self.random.f64() < 0.3 {
                0.0
            } else {
                0.3 * self.random.f64()
            };
            given.3 = row(&given).of_step(&inside) - slack;
            self.given.push(given);
        }
        self
    }

    /// The same with so many half-spaces that ask for anything.
    fn with_any(mut self, count: usize) -> Self {
        for _ in 0..count {
            let given = self.random_row();
            self.given.push(given);
        }
        self
    }

    fn random_step(&mut self) -> Vec<f64> {
        let Instance { fixed, moving, .. } = &self.instance;
        let may_move = |place: usize| !fixed[place / moving.len()] && moving[place % moving.len()];
        let random = &mut self.random;
        (0..self.gradient.len())
            .map(|k| if may_move(k) { random.f64() - 0.5 } else { 0.0 })
            .collect()
    }

    fn random_row(&mut self) -> Given {
        let random = &mut self.random;
        let jacobian = (0..self.instance.space.nv())
            .map(|_| random.f64() - 0.5)
            .collect();
        let ratio = [0.0, 1.0, random.f64(), random.f64()][random.usize(..4)];
        (
            random.usize(..self.instance.fixed.len() - 1),
            ratio,
            jacobian,
            random.f64() - 0.5,
        )
    }

    /// The model of this case, without rows.
    fn begin(&self) -> ActiveSet {
        let mut set = ActiveSet::new(self.instance.space.nv());
        set.begin(&cost(&self.instance), &self.gradient);
        set
    }

    /// The same with all rows that move anything.
    fn with_rows(&self) -> ActiveSet {
        let mut set = self.begin();
        for given in &self.given {
            set.push(&cost(&self.instance), row(given));
        }
        set
    }

    fn step(&self, set: &mut ActiveSet) -> Vec<f64> {
        let mut step = vec![f64::NAN; self.gradient.len()];
        set.step(&cost(&self.instance), &mut step);
        step
    }

    fn solve(&self) -> Solved {
        let mut set = self.with_rows();
        set.solve(&mut || false)
            .expect("a step is in all half-spaces");
        let step = self.step(&mut set);
        Solved { set, step }
    }

    fn dense(&self, set: &ActiveSet) -> Dense {
        Dense::new(&self.instance, set.rows(), &self.gradient)
    }

    /// `J p ≥ b`, ν ≥ 0, ν (J p − b) = 0, H p + g = Jᵀ ν; fixed waypoints stay. Rows of `ignored`
    /// ask for nothing.
    fn is_optimal(&self, set: &mut ActiveSet, ignored: &[usize]) -> Result<(), TestCaseError> {
        let step = self.step(set);
        let dense = self.dense(set);
        let p = DVector::from_iterator(
            dense.places.len(),
            dense.places.iter().map(|&place| step[place]),
        );
        let travel: f64 = step.iter().map(|p| p * p).sum();
        prop_assert!(
            (travel - p.norm_squared()).abs() <= 1e-12 * travel,
            "what may not move moves"
        );
        let mut multipliers = DVector::zeros(set.rows().len());
        for (row, multiplier) in set.active() {
            prop_assert!(
                multiplier >= 0.0 && !ignored.contains(&row),
                "row {row} pulls by {multiplier}"
            );
            multipliers[row] = multiplier;
        }
        let slack = &dense.jacobian * &p - &dense.right_hand_side;
        let tolerance = 1e-6 * (1.0 + p.amax());
        for (row, &slack) in slack
            .iter()
            .enumerate()
            .filter(|(row, _)| !ignored.contains(row))
        {
            prop_assert!(slack > -tolerance, "row {row} is left by {slack}");
            prop_assert!(
                multipliers[row] == 0.0 || slack < tolerance,
                "row {row} holds from {slack} away"
            );
        }
        let force =
            &dense.hessian * &p + &dense.gradient - dense.jacobian.transpose() * &multipliers;
        let forces = 1.0 + multipliers.amax() + dense.hessian.amax() * p.amax();
        prop_assert!(
            force.amax() < 1e-7 * forces,
            "{} left of {}",
            force.amax(),
            forces
        );
        Ok(())
    }
}

fn cost(instance: &Instance) -> Cost<'_> {
    Cost::new(
        &instance.space,
        &instance.metric,
        &instance.rows,
        &instance.fixed,
        &instance.moving,
    )
}

fn row((segment, ratio, jacobian, right_hand_side): &Given) -> Row<'_> {
    Row {
        segment: *segment,
        ratio: *ratio,
        jacobian,
        right_hand_side: *right_hand_side,
    }
}

/// Largest difference, for a largest step of 1.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    let scale = a
        .iter()
        .fold(1.0, |scale: f64, a| scale.max(a.abs()));
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
        / scale
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn the_conditions_of_a_minimum_hold(seed: u64, waypoints in 3usize..14, rows in 0usize..30) {
        let case = Case::random(seed, waypoints).with_feasible(rows);
        case.is_optimal(&mut case.solve().set, &[])?;
    }

    #[test]
    fn clarabel_agrees(seed: u64, waypoints in 3usize..9, rows in 1usize..16) {
        let case = Case::random(seed, waypoints).with_feasible(rows);
        let Solved { set, step } = case.solve();
        prop_assume!(!set.rows().is_empty());
        let dense = case.dense(&set);
        // Clarabel is right to about the root of its tolerance.
        if let Some(expected) = dense.step_of_clarabel(Dense::HALF_SPACES) {
            let found: Vec<f64> = dense.places.iter().map(|&place| step[place]).collect();
            prop_assert!(apart(&found, &expected) < 1e-5, "{found:?} instead of {expected:?}");
        }
    }

    #[test]
    fn a_warm_start_changes_nothing_but_the_way(seed: u64, waypoints in 3usize..14, rows in 0usize..30) {
        let mut case = Case::random(seed, waypoints).with_feasible(rows);
        let cold = case.solve();
        let known: Vec<usize> = cold.set.active().map(|(row, _)| row).collect();
        let any: Vec<usize> = (0..cold.set.rows().len()).filter(|_| case.random.bool()).collect();
        for start in [known, any] {
            let mut warm = case.with_rows();
            warm.warm_start(start.into_iter());
            prop_assert!(warm.active().all(|(_, multiplier)| multiplier >= 0.0));
            prop_assert_eq!(warm.solve(&mut || false), Ok(()));
            prop_assert!(apart(&cold.step, &case.step(&mut warm)) < 1e-8);
        }
    }

    #[test]
    fn rows_that_come_later_are_as_good_as_rows_from_the_start(seed: u64, waypoints in 3usize..14, rows in 0usize..30) {
        let case = Case::random(seed, waypoints).with_feasible(rows);
        let mut set = case.begin();
        for given in &case.given {
            set.push(&cost(&case.instance), row(given));
            prop_assert_eq!(set.solve(&mut || false), Ok(()));
        }
        prop_assert!(apart(&case.solve().step, &case.step(&mut set)) < 1e-8);
    }

    #[test]
    fn rows_that_depend_on_others_change_nothing(seed: u64, waypoints in 3usize..14, rows in 1usize..12) {
        let mut case = Case::random(seed, waypoints).with_feasible(rows);
        let once = case.solve();
        for index in 0..rows {
            let (segment, ratio, jacobian, right_hand_side) = case.given[index].clone();
            // The same row, the same in other units, and one that asks for less.
            let doubled: Vec<f64> = jacobian.iter().map(|j| 2.0 * j).collect();
            let less = right_hand_side - 0.1;
            case.given.push((segment, ratio, jacobian.clone(), right_hand_side));
            case.given.push((segment, ratio, doubled, 2.0 * right_hand_side));
            case.given.push((segment, ratio, jacobian, less));
        }
        case.random.shuffle(&mut case.given);
        let mut more = case.solve();
        prop_assert!(apart(&once.step, &more.step) < 1e-8);
        case.is_optimal(&mut more.set, &[])?;
    }

    /// What is said to be infeasible is, and without the row that is named all is as if it had
    /// never come.
    #[test]
    fn infeasible_sets_are_reported_and_can_be_relaxed(seed: u64, waypoints in 3usize..7, rows in 1usize..40) {
        let case = Case::random(seed, waypoints).with_any(rows);
        let (mut set, mut ignored) = (case.with_rows(), Vec::new());
        prop_assume!(!set.rows().is_empty());
        loop {
            let solved = set.solve(&mut || false);
            if set.active().any(|(_, multiplier)| multiplier > ROUNDING_DECIDES) {
                return Ok(());
            }
            let Err(Unsolved::Infeasible { row }) = solved else { break };
            let held: Vec<usize> = set.active().map(|(row, _)| row).collect();
            prop_assert!(!held.contains(&row) && set.active().all(|(_, multiplier)| multiplier >= 0.0));
            let (step, mut dense) = (case.step(&mut set), case.dense(&set));
            let scale = step.iter().fold(0.0, |most: f64, p| most.max(p.abs()));
            for row in &held {
                let Row { right_hand_side, .. } = set.rows().get(*row);
                let slack = set.rows().get(*row).of_step(&step) - right_hand_side;
                prop_assert!(slack.abs() < 1e-6 * (1.0 + scale), "active row {} is {} away", row, slack);
            }
            let blamed: Vec<usize> = held.into_iter().chain([row]).collect();
            dense.jacobian = dense.jacobian.select_rows(&blamed);
            dense.right_hand_side = dense.right_hand_side.select_rows(&blamed);
            // Rows that nearly depend on each other count as dependent: they could be met, but only
            // far away.
            let met = dense.step_of_clarabel(Dense::HALF_SPACES);
            let most = met.map(|step| step.iter().fold(0.0, |most: f64, p| most.max(p.abs())));
            prop_assert!(most.is_none_or(|most| most > FAR_AWAY), "{:?} are feasible within {:?}", blamed, most);
            set.relax(row, f64::NEG_INFINITY);
            ignored.push(row);
        }
        case.is_optimal(&mut set, &ignored)?;
    }

    #[test]
    fn a_row_that_pulls_the_other_way_gives_way_without_a_trace(seed: u64, waypoints in 3usize..14, rows in 1usize..20) {
        let case = Case::random(seed, waypoints).with_feasible(rows);
        let Solved { mut set, step } = case.solve();
        let Some((strongest, _)) = set.active().max_by(|a, b| a.1.total_cmp(&b.1)) else { return Ok(()) };
        let Row { segment, ratio, jacobian, right_hand_side } = set.rows().get(strongest);
        let opposite: Vec<f64> = jacobian.iter().map(|j| -j).collect();
        let given = (segment, ratio, opposite, 0.1 - right_hand_side);
        let pushed = set.push(&cost(&case.instance), row(&given)).expect("it moves what the other moves");
        prop_assert_eq!(set.solve(&mut || false), Err(Unsolved::Infeasible { row: pushed }));
        prop_assert!(apart(&step, &case.step(&mut set)) < 1e-8, "a refused row leaves its mark");
        set.relax(pushed, -right_hand_side);
        prop_assert_eq!(set.solve(&mut || false), Ok(()));
        prop_assert!(apart(&step, &case.step(&mut set)) < 1e-8);
    }
}

#[test]
fn rows_that_move_nothing_are_refused() {
    for seed in 0..60 {
        let case = Case::random(seed, 8);
        let Instance { fixed, moving, .. } = &case.instance;
        let cost = cost(&case.instance);
        let mut set = case.begin();
        let all = vec![1.0; moving.len()];
        let still: Vec<f64> = moving
            .iter()
            .map(|moves| f64::from(u8::from(!moves)))
            .collect();
        for segment in 0..fixed.len() - 1 {
            for ratio in [0.0, 0.4, 1.0] {
                let moves =
                    (ratio < 1.0 && !fixed[segment]) || (ratio > 0.0 && !fixed[segment + 1]);
                let before = set.rows().len();
                let pushed = set.push(&cost, row(&(segment, ratio, all.clone(), 0.1)));
                assert_eq!(
                    pushed,
                    moves.then_some(before),
                    "ratio {ratio} of segment {segment}, seed {seed}"
                );
                assert_eq!(
                    set.push(&cost, row(&(segment, ratio, still.clone(), 0.1))),
                    None
                );
                assert_eq!(set.rows().len(), before + usize::from(moves));
            }
        }
        // The last waypoint has no successor, as the row of a limit there.
        assert_eq!(
            set.push(&cost, row(&(fixed.len() - 1, 0.0, all, 0.1))),
            None
        );
    }
}

/// Of rows that all but depend on each other one too many is taken for independent: more hold the
/// step than it has coordinates, with multipliers of 10¹⁶, and the step leaves rows that are said
/// to be active.
#[test]
#[ignore = "known: what is left of a dependent row is rounding above `DEPENDENT`"]
fn no_more_rows_are_active_than_the_step_has_coordinates() {
    for seed in 0..3000 {
        let case = Case::random(seed, 3 + seed as usize % 4).with_any(4 + (seed as usize / 4) % 36);
        let mut set = case.with_rows();
        while let Err(Unsolved::Infeasible { row }) = set.solve(&mut || false) {
            set.relax(row, f64::NEG_INFINITY);
        }
        let active = set.active().count();
        let coordinates = case.dense(&set).places.len();
        assert!(
            active <= coordinates,
            "seed {seed}: {active} rows on {coordinates} coordinates"
        );
    }
}
