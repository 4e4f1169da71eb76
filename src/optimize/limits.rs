//! Joint limits as rows of the quadratic step: bounds on single variables at single waypoints.
//!
//! A limit never cuts a step that is already computed, which would break the other rows. Where the step
//! would leave a limit, a row holds that variable at that waypoint at the limit and the step is computed
//! again; a row that pulls away from its limit is dropped. The primal-dual active set method for bounds
//! (Hintermüller, Ito, Kunisch 2002) does both at once, and starts from the rows of the last step.

use super::cost::Cost;
use super::quadratic_step::QuadraticStep;
use super::rows::Row;
use super::task::Task;
use crate::path::Path;
use crate::robot::Component;

/// Rounds of the active set method; it ends in a handful, this ends a cycle.
const ROUNDS: usize = 40;

/// A step may pass a limit by this much [m or rad]: what rounding leaves of a row.
const ROUNDING: f64 = 1e-9;

/// A variable of the path that has limits.
#[derive(Clone, Copy, Debug)]
struct Limited {
    q: usize,
    v: usize,
    lower: f64,
    upper: f64,
}

/// A variable held at a limit at one waypoint.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Held {
    waypoint: usize,
    limited: usize,
    side: Side,
}

/// Which limit.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Side {
    Lower,
    Upper,
}

impl Limited {
    /// How far the variable may still move towards a side from `x` (signed); 0 outside, where it may not move on out.
    fn room(&self, side: Side, x: f64) -> f64 {
        match side {
            Side::Lower => (self.lower - x).min(0.0),
            Side::Upper => (self.upper - x).max(0.0),
        }
    }
}

/// The limits of a robot's variables, and those that hold the step now.
#[derive(Clone, Debug)]
pub struct Limits {
    nq: usize,
    nv: usize,
    limited: Vec<Limited>,
    free: Vec<usize>,
    active: Vec<Held>,
    next: Vec<Held>,
    unit: Vec<f64>,
}

impl Limits {
    /// The limits that a task's variables have.
    pub fn new(task: &Task<'_>) -> Self {
        let variables = task.model.robot().variables();
        let limited = |component: &Component| match *component {
            Component::Line { q, v } if task.moving[v] => {
                let (lower, upper) = (variables[q].lower, variables[q].upper);
                (lower.is_finite() || upper.is_finite()).then_some(Limited { q, v, lower, upper })
            }
            _ => None,
        };
        Self {
            nq: task.space.nq(),
            nv: task.space.nv(),
            limited: task.space.components().iter().filter_map(limited).collect(),
            free: (0..task.fixed.len()).filter(|&i| !task.fixed[i]).collect(),
            active: Vec::new(),
            next: Vec::new(),
            unit: vec![0.0; task.space.nv()],
        }
    }

    /// Writes the step of the first `collision_rows` rows of `quadratic` and of those limits that hold it;
    /// `path` is flat rows. Limit rows of the last step are dropped and found again.
    ///
    /// Returns the largest part of the step that keeps all limits: 1 unless the rows leave no such step.
    pub fn solve(
        &mut self,
        quadratic: &mut QuadraticStep,
        collision_rows: usize,
        cost: &Cost<'_>,
        path: &[f64],
        gradient: &[f64],
        step: &mut [f64],
    ) -> f64 {
        for _ in 0..ROUNDS {
            quadratic.truncate(collision_rows);
            let wanted = self.active.len();
            self.append_active(quadratic, cost, path);
            quadratic.solve(cost, gradient, step);
            self.choose_next(&quadratic.multipliers()[collision_rows..], path, step);
            let settled = self.next == self.active;
            let nothing_new = self.next.len() == wanted && self.active.len() < wanted;
            std::mem::swap(&mut self.active, &mut self.next);
            if settled || nothing_new {
                break;
            }
        }
        self.largest_part(path, step)
    }

    /// Brings what rounding left outside its limits back to them; `from` is the path that the step began at.
    pub fn settle(&self, from: &Path, path: &mut Path) {
        for &waypoint in &self.free {
            let (from, row) = (from.waypoint(waypoint), path.waypoint_mut(waypoint));
            for &Limited { q, lower, upper, .. } in &self.limited {
                row[q] = row[q].clamp(lower.min(from[q]), upper.max(from[q]));
            }
        }
    }

    /// Appends the rows of the active limits; those that depend on others are dropped.
    fn append_active(&mut self, quadratic: &mut QuadraticStep, cost: &Cost<'_>, path: &[f64]) {
        let (nq, limited, unit) = (self.nq, &self.limited, &mut self.unit);
        self.active.retain(|held| {
            let variable = &limited[held.limited];
            unit[variable.v] = 1.0;
            let right_hand_side = variable.room(held.side, path[held.waypoint * nq + variable.q]);
            let row = Row { segment: held.waypoint, ratio: 0.0, jacobian: unit, right_hand_side };
            let independent = quadratic.append(cost, row);
            unit[variable.v] = 0.0;
            independent
        });
    }

    /// `next` = the active limits that push inwards, and those that the step leaves.
    fn choose_next(&mut self, multipliers: &[f64], path: &[f64], step: &[f64]) {
        self.next.clear();
        // H p + g + μ = 0: a limit from above pushes down with μ > 0.
        let pushes_in = |held: &Held, multiplier: f64| match held.side {
            Side::Lower => multiplier <= 0.0,
            Side::Upper => multiplier >= 0.0,
        };
        let kept = self.active.iter().zip(multipliers).filter(|(held, multiplier)| pushes_in(held, **multiplier));
        self.next.extend(kept.map(|(held, _)| *held));
        for &waypoint in &self.free {
            for (index, limited) in self.limited.iter().enumerate() {
                let (x, p) = (path[waypoint * self.nq + limited.q], step[waypoint * self.nv + limited.v]);
                let side = if p > 0.0 { Side::Upper } else { Side::Lower };
                let held = Held { waypoint, limited: index, side };
                if p.abs() > limited.room(side, x).abs() + ROUNDING && !self.next.contains(&held) {
                    self.next.push(held);
                }
            }
        }
    }

    fn largest_part(&self, path: &[f64], step: &[f64]) -> f64 {
        let mut part = 1.0_f64;
        for &waypoint in &self.free {
            for limited in &self.limited {
                let (x, p) = (path[waypoint * self.nq + limited.q], step[waypoint * self.nv + limited.v]);
                let room = limited.room(if p > 0.0 { Side::Upper } else { Side::Lower }, x);
                if p.abs() > room.abs() + ROUNDING {
                    part = part.min(room / p);
                }
            }
        }
        part
    }
}

#[cfg(test)]
mod tests {
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
                let jacobian = (0..JOINTS).map(|_| random.f64() - 0.5).collect();
                (random.usize(..WAYPOINTS - 1), random.f64(), jacobian, 0.6 * (random.f64() - 0.5))
            };
            let rows = (0..3).map(|_| row()).collect();
            Self { model: testing::sliders(JOINTS, (-0.1, 1.05)), instance, rows }
        }

        fn task(&self) -> Task<'_> {
            let Instance { space, metric, fixed, moving, .. } = &self.instance;
            Task { model: &self.model, space, metric, held: &[], fixed, moving, seed: 0, work_budget: u64::MAX }
        }

        /// Step, part and the collision rows that were taken.
        fn solve(&self) -> (Vec<f64>, f64, usize) {
            let (task, path) = (self.task(), &self.instance.rows);
            let cost = Cost::new(task.space, task.metric, path, task.fixed, task.moving);
            let mut quadratic = QuadraticStep::new(&cost);
            for (segment, ratio, jacobian, right_hand_side) in &self.rows {
                let (segment, ratio, right_hand_side) = (*segment, *ratio, *right_hand_side);
                let _ = quadratic.append(&cost, Row { segment, ratio, jacobian, right_hand_side });
            }
            let (mut gradient, mut step) = (vec![0.0; path.len()], vec![0.0; path.len()]);
            cost.gradient(path, &mut [0.0; JOINTS], &mut gradient);
            let count = quadratic.rows().len();
            let part = Limits::new(&task).solve(&mut quadratic, count, &cost, path, &gradient, &mut step);
            (step, part, count)
        }

        /// The same by Clarabel; `None` where no step keeps rows and limits.
        fn clarabel(&self) -> Option<Vec<f64>> {
            let Instance { space, metric, rows: path, fixed, .. } = &self.instance;
            let n = path.len();
            let free: Vec<usize> = (0..WAYPOINTS).filter(|&i| !fixed[i]).collect();
            let tridiagonal = testing::tridiagonal(&segment_lengths(space, metric, path), fixed);
            let mut hessian = vec![vec![0.0; n]; n];
            for (a, &i) in free.iter().enumerate() {
                for (b, &j) in free.iter().enumerate() {
                    for v in 0..JOINTS {
                        hessian[i * JOINTS + v][j * JOINTS + v] = tridiagonal[(a, b)] * metric.weights()[v].powi(2);
                    }
                }
            }
            let unit = |place: usize, value: f64| (0..n).map(|k| if k == place { value } else { 0.0 }).collect();
            let mut lines: Vec<Vec<f64>> = Vec::new();
            let mut right = Vec::new();
            for place in (0..n).filter(|place| fixed[place / JOINTS]) {
                lines.push(unit(place, 1.0));
                right.push(0.0);
            }
            for (segment, ratio, jacobian, b) in &self.rows {
                let row = Row { segment: *segment, ratio: *ratio, jacobian, right_hand_side: *b };
                let entry = |k: usize| if fixed[k / JOINTS] { 0.0 } else { row.of_step(&unit(k, 1.0)) };
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
            let cones =
                [SupportedConeT::ZeroConeT(equalities), SupportedConeT::NonnegativeConeT(lines.len() - equalities)];
            let cost = Cost::new(space, metric, path, fixed, &[true; JOINTS]);
            let mut gradient = vec![0.0; n];
            cost.gradient(path, &mut [0.0; JOINTS], &mut gradient);
            let settings = DefaultSettings { verbose: false, ..DefaultSettings::default() };
            let (upper, matrix) = (CscMatrix::from(&hessian).to_triu(), CscMatrix::from(&lines));
            let mut solver = DefaultSolver::new(&upper, &gradient, &matrix, &right, &cones, settings).expect("a QP");
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
            if let Some(expected) = case.clarabel() && count == case.rows.len() {
                prop_assert_eq!(part, 1.0);
                for (p, e) in step.iter().zip(&expected) {
                    prop_assert!((p - e).abs() < 1e-4, "{p} instead of {e}");
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
    fn what_starts_outside_never_moves_further_out() {
        let mut case = Case::random(1);
        case.instance.rows.iter_mut().for_each(|x| *x += 1.0);
        let (step, part, _) = case.solve();
        for (x, p) in case.instance.rows.iter().zip(&step) {
            assert!(x + part * p <= x.max(1.05) + 1e-8);
        }
    }
}
