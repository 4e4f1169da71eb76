//! The active set method against Clarabel.

use super::*;
use crate::collision::CollisionModel;
use crate::optimize::cost::segment_lengths;
use crate::optimize::testing::{self, Instance};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SupportedConeT};
use proptest::prelude::*;

const JOINTS: usize = 3;
const WAYPOINTS: usize = 7;

/// A path of prismatic joints near their limits, and collision rows that push it about.
struct Case {
    model: CollisionModel,
    instance: Instance,
    rows: Vec<(usize, f64, Vec<f64>, f64)>,
}

impl Case {
    fn random(seed: u64) -> Self {
        let instance = testing::lines(seed, WAYPOINTS, JOINTS);
        let mut random = fastrand::Rng::with_seed(seed);
        let mut row = || {
            let jacobian = (0..JOINTS)
                .map(|_| random.f64() - 0.5)
                .collect();
            (
                random.usize(..WAYPOINTS - 1),
                random.f64(),
                jacobian,
                0.6 * (random.f64() - 0.5),
            )
        };
        let rows = (0..3).map(|_| row()).collect();
        Self {
            model: testing::sliders(JOINTS, (-0.1, 1.05)),
            instance,
            rows,
        }
    }

    fn task(&self) -> Task<'_> {
        let Instance {
            space,
            metric,
            fixed,
            moving,
            ..
        } = &self.instance;
        Task {
            model: &self.model,
            space,
            metric,
            held: &[],
            constraints: Vec::new(),
            fixed,
            fixed_rows: &[],
            moving,
            keep_goal: false,
            seed: 0,
            work_budget: u64::MAX,
        }
    }

    /// Step, part and the collision rows that were taken.
    fn solve(&self) -> (Vec<f64>, f64, usize) {
        let task = self.task();
        let path = &self.instance.rows;
        let cost = Cost::new(task.space, task.metric, path, task.fixed, task.moving);
        let mut quadratic = QuadraticStep::new(&cost);
        for (segment, ratio, jacobian, right_hand_side) in &self.rows {
            let segment = *segment;
            let ratio = *ratio;
            let right_hand_side = *right_hand_side;
            let _ = quadratic.append(
                &cost,
                Row {
                    segment,
                    ratio,
                    jacobian,
                    right_hand_side,
                },
            );
        }
        let mut gradient = vec![0.0; path.len()];
        let mut step = vec![0.0; path.len()];
        cost.gradient(path, &mut [0.0; JOINTS], &mut gradient);
        let count = quadratic.rows().len();
        let part = Limits::new(&task, task.fixed).solve(
            &mut quadratic,
            count,
            Model {
                cost: &cost,
                path,
                gradient: &gradient,
            },
            &mut step,
            &mut || false,
        );
        (step, part.expect("nobody stops it"), count)
    }

    /// The same by Clarabel; `None` where no step keeps rows and limits.
    fn clarabel(&self) -> Option<Vec<f64>> {
        let Instance {
            space,
            metric,
            rows: path,
            fixed,
            ..
        } = &self.instance;
        let n = path.len();
        let free: Vec<usize> = (0..WAYPOINTS).filter(|&i| !fixed[i]).collect();
        let tridiagonal = testing::tridiagonal(&segment_lengths(space, metric, path), fixed);
        let mut hessian = vec![vec![0.0; n]; n];
        for (a, &i) in free.iter().enumerate() {
            for (b, &j) in free.iter().enumerate() {
                for v in 0..JOINTS {
                    hessian[i * JOINTS + v][j * JOINTS + v] =
                        tridiagonal[(a, b)] * metric.weights()[v].powi(2);
                }
            }
        }
        let unit = |place: usize, value: f64| {
            (0..n)
                .map(|k| if k == place { value } else { 0.0 })
                .collect()
        };
        let mut lines: Vec<Vec<f64>> = Vec::new();
        let mut right = Vec::new();
        for place in (0..n).filter(|place| fixed[place / JOINTS]) {
            lines.push(unit(place, 1.0));
            right.push(0.0);
        }
        for (segment, ratio, jacobian, b) in &self.rows {
            let row = Row {
                segment: *segment,
                ratio: *ratio,
                jacobian,
                right_hand_side: *b,
            };
            let entry = |k: usize| {
                if fixed[k / JOINTS] {
                    0.0
                } else {
                    row.of_step(&unit(k, 1.0))
                }
            };
            let line: Vec<f64> = (0..n).map(entry).collect();
            if line.iter().any(|x| *x != 0.0) {
                lines.push(line);
                right.push(*b);
            }
        }
        let equalities = lines.len();
        for k in (0..n).filter(|k| !fixed[k / JOINTS]) {
            lines.extend([unit(k, 1.0), unit(k, -1.0)]);
            right.extend([1.05 - path[k], path[k] + 0.1]);
        }
        let cones = [
            SupportedConeT::ZeroConeT(equalities),
            SupportedConeT::NonnegativeConeT(lines.len() - equalities),
        ];
        let cost = Cost::new(space, metric, path, fixed, &[true; JOINTS]);
        let mut gradient = vec![0.0; n];
        cost.gradient(path, &mut [0.0; JOINTS], &mut gradient);
        let settings = DefaultSettings {
            verbose: false,
            tol_gap_abs: 1e-12,
            tol_gap_rel: 1e-12,
            tol_feas: 1e-11,
            ..DefaultSettings::default()
        };
        let upper = CscMatrix::from(&hessian).to_triu();
        let matrix = CscMatrix::from(&lines);
        let mut solver =
            DefaultSolver::new(&upper, &gradient, &matrix, &right, &cones, settings).expect("a QP");
        solver.solve();
        let solved = solver.solution.status == clarabel::solver::SolverStatus::Solved;
        solved.then(|| solver.solution.x.clone())
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn the_step_is_the_minimum_under_rows_and_limits(seed: u64) {
        let case = Case::random(seed);
        let (step, part, count) = case.solve();
        if let Some(expected) = case.clarabel() && count == case.rows.len() && part == 1.0 {
            for (p, e) in step.iter().zip(&expected) {
                prop_assert!((p - e).abs() < 1e-3, "{p} instead of {e}");
            }
        }
    }

    #[test]
    fn the_part_of_the_step_keeps_the_limits(seed: u64) {
        let case = Case::random(seed);
        let (step, part, _) = case.solve();
        prop_assert!((0.0..=1.0).contains(&part));
        for (x, p) in case.instance.rows.iter().zip(&step) {
            prop_assert!((-0.1 - 1e-8..=1.05 + 1e-8).contains(&(x + part * p)), "{}", x + part * p);
        }
    }
}

#[test]
fn where_there_is_such_a_step_it_is_nearly_always_found() {
    // Rows and limits that depend on each other can hide it; then a part of another step is taken.
    let cases = (0..400).map(Case::random);
    let solvable: Vec<Case> = cases
        .filter(|case| case.clarabel().is_some())
        .collect();
    let found = solvable
        .iter()
        .filter(|case| case.solve().1 == 1.0)
        .count();
    assert!(
        found * 100 >= solvable.len() * 98,
        "{found} of {}",
        solvable.len()
    );
}

#[test]
fn what_starts_outside_never_moves_further_out() {
    let mut case = Case::random(1);
    case.instance
        .rows
        .iter_mut()
        .for_each(|x| *x += 1.0);
    let (step, part, _) = case.solve();
    for (x, p) in case.instance.rows.iter().zip(&step) {
        assert!(x + part * p <= x.max(1.05) + 1e-8);
    }
}

#[test]
fn where_more_limits_are_left_than_rows_are_worth_the_step_is_cut() {
    let instance = testing::lines(7, 4 * MOST_HELD, JOINTS);
    let model = testing::sliders(JOINTS, (-0.1, 1.05));
    let Instance {
        space,
        metric,
        rows: path,
        fixed,
        moving,
    } = &instance;
    let task = Task {
        model: &model,
        space,
        metric,
        held: &[],
        constraints: Vec::new(),
        fixed,
        fixed_rows: &[],
        moving,
        keep_goal: false,
        seed: 0,
        work_budget: u64::MAX,
    };
    let cost = Cost::new(space, metric, path, fixed, moving);
    let mut quadratic = QuadraticStep::new(&cost);
    let mut step = vec![0.0; path.len()];
    let mut limits = Limits::new(&task, fixed);
    // It pushes every waypoint out.
    let gradient = vec![-1e3; path.len()];
    let part = limits
        .solve(
            &mut quadratic,
            0,
            Model {
                cost: &cost,
                path,
                gradient: &gradient,
            },
            &mut step,
            &mut || false,
        )
        .expect("nobody stops it");
    assert_eq!(limits.active.len(), MOST_HELD);
    let kept = path
        .iter()
        .zip(&step)
        .all(|(x, p)| x + part * p <= x.max(1.05) + 1e-6);
    assert!((0.0..1.0).contains(&part) && kept, "{part}");
}
