//! The step of the quadratic model under linear rows: `min_p gᵀp + ½ pᵀHp` subject to `J p = b`.
//!
//! `p = −H⁻¹(g + Jᵀμ)` with `M μ = −(b + J H⁻¹ g)`, `M = J H⁻¹ Jᵀ`. Because H⁻¹ is known in closed
//! form ([`Cost::compliance`]) an entry of M is a handful of multiplications, whatever the number
//! of waypoints. The Cholesky factor of M grows by one line for each row, and the pivot of that
//! line tells whether the row depends on the others.

use super::cost::Cost;
use super::factor::Factor;
use super::rows::{Row, Rows};

/// Rows, the factor of their M, and scratch.
#[derive(Clone, Debug)]
pub struct QuadraticStep {
    rows: Rows,
    factor: Factor,
    multipliers: Vec<f64>,
    column: Vec<f64>,
    force: Vec<f64>,
}

impl QuadraticStep {
    /// No rows yet.
    pub fn new(cost: &Cost<'_>) -> Self {
        let force = vec![0.0; cost.waypoints() * cost.nv()];
        let rows = Rows::new(cost.nv());
        Self {
            rows,
            factor: Factor::default(),
            multipliers: Vec::new(),
            column: Vec::new(),
            force,
        }
    }

    /// The rows so far.
    pub fn rows(&self) -> &Rows {
        &self.rows
    }
    /// μ of each row, after [`Self::solve`].
    pub fn multipliers(&self) -> &[f64] {
        &self.multipliers
    }
    /// Keeps the first `count` rows.
    pub fn truncate(&mut self, count: usize) {
        self.rows.truncate(count);
        self.factor.truncate(count);
    }

    /// Takes one more row unless it depends on those before it, or moves nothing; says whether it
    /// did.
    #[must_use]
    pub fn append(&mut self, cost: &Cost<'_>, row: Row<'_>) -> bool {
        let couplings = self
            .rows
            .iter()
            .map(|other| row.coupling(&other, cost));
        self.column.clear();
        self.column.extend(couplings);
        let independent = self
            .factor
            .append(&self.column, row.coupling(&row, cost));
        if independent {
            self.rows.push(row);
        }
        independent
    }

    /// Writes p for the gradient g, both one row of nv numbers for each waypoint.
    pub fn solve(&mut self, cost: &Cost<'_>, gradient: &[f64], step: &mut [f64]) {
        cost.apply_inverse_hessian(gradient, step);
        self.update_multipliers(step);
        self.force.copy_from_slice(gradient);
        for (row, multiplier) in self.rows.iter().zip(&self.multipliers) {
            row.add_force(*multiplier, &mut self.force);
        }
        cost.apply_inverse_hessian(&self.force, step);
        step.iter_mut().for_each(|p| *p = -*p);
    }

    /// `M μ = −(b + J H⁻¹ g)`, given `H⁻¹ g`.
    fn update_multipliers(&mut self, downhill: &[f64]) {
        let asked = self
            .rows
            .iter()
            .map(|row| -(row.right_hand_side + row.of_step(downhill)));
        self.multipliers.clear();
        self.multipliers.extend(asked);
        self.factor.solve(&mut self.multipliers);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optimize::testing::{self, Dense, Instance};
    use proptest::prelude::*;

    /// A random instance with random independent rows, solved; returns the step and its dense twin.
    fn solved(
        seed: u64,
        waypoints: usize,
        row_count: usize,
    ) -> (Instance, QuadraticStep, Vec<f64>, Dense) {
        let mut instance = testing::instance(seed, waypoints);
        let input = instance.rows.clone();
        testing::shake(&instance.space, &mut instance.rows, seed);
        let cost = Cost::new(
            &instance.space,
            &instance.metric,
            &input,
            &instance.fixed,
            &instance.moving,
        );
        let nv = instance.space.nv();
        let mut random = fastrand::Rng::with_seed(seed ^ 0x5eed);
        let mut quadratic = QuadraticStep::new(&cost);
        for _ in 0..row_count {
            let jacobian: Vec<f64> = (0..nv).map(|_| random.f64() - 0.5).collect();
            let ratio = if random.bool() { random.f64() } else { 0.0 };
            let segment = random.usize(..waypoints - 1);
            let row = Row {
                segment,
                ratio,
                jacobian: &jacobian,
                right_hand_side: random.f64() - 0.5,
            };
            let _ = quadratic.append(&cost, row);
        }
        let mut velocity = vec![0.0; nv];
        let mut gradient = vec![0.0; waypoints * nv];
        cost.gradient(&instance.rows, &mut velocity, &mut gradient);
        let mut step = vec![f64::NAN; waypoints * nv];
        quadratic.solve(&cost, &gradient, &mut step);
        instance.rows = input;
        let dense = Dense::new(&instance, quadratic.rows(), &gradient);
        (instance, quadratic, step, dense)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn the_step_is_that_of_the_dense_system(seed: u64, waypoints in 3usize..14, rows in 0usize..12) {
            let (_, quadratic, step, dense) = solved(seed, waypoints, rows);
            let expected = dense.step();
            let scale = 1.0 + expected.amax();
            for (&place, e) in dense.places.iter().zip(expected.iter()) {
                prop_assert!((step[place] - e).abs() < 1e-8 * scale, "{} instead of {e}", step[place]);
            }
            for row in quadratic.rows().iter() {
                prop_assert!((row.of_step(&step) - row.right_hand_side).abs() < 1e-9 * scale);
            }
        }

        #[test]
        fn what_may_not_move_does_not_move_at_all(seed: u64, waypoints in 3usize..14, rows in 0usize..12) {
            let (instance, _, step, dense) = solved(seed, waypoints, rows);
            let free: std::collections::BTreeSet<usize> = dense.places.into_iter().collect();
            for place in (0..step.len()).filter(|place| !free.contains(place)) {
                prop_assert_eq!(step[place], 0.0, "coordinate {}", place % instance.space.nv());
            }
        }

        #[test]
        fn a_sum_of_rows_is_dependent(seed: u64, waypoints in 4usize..14) {
            let (instance, mut quadratic, _, _) = solved(seed, waypoints, 3);
            let cost =
                Cost::new(&instance.space, &instance.metric, &instance.rows, &instance.fixed, &instance.moving);
            let known = quadratic.rows().len();
            for index in 0..known {
                let Row { segment, ratio, jacobian, .. } = quadratic.rows().get(index);
                let jacobian: Vec<f64> = jacobian.iter().map(|j| -3.0 * j).collect();
                let row = Row { segment, ratio, jacobian: &jacobian, right_hand_side: 1.0 };
                prop_assert!(!quadratic.append(&cost, row));
            }
            prop_assert_eq!(quadratic.rows().len(), known);
        }
    }

    #[test]
    fn clarabel_agrees() {
        for seed in 0..8 {
            let (_, _, step, dense) = solved(seed, 7, 4);
            let expected = dense
                .step_of_clarabel(Dense::EQUALITIES)
                .expect("independent rows");
            for (&place, e) in dense.places.iter().zip(&expected) {
                assert!(
                    (step[place] - e).abs() < 1e-6 * (1.0 + e.abs()),
                    "seed {seed}: {} or {e}",
                    step[place]
                );
            }
        }
    }

    #[test]
    fn dropping_rows_leaves_the_factor_of_those_before() {
        let (instance, mut quadratic, step, dense) = solved(5, 8, 4);
        let cost = Cost::new(
            &instance.space,
            &instance.metric,
            &instance.rows,
            &instance.fixed,
            &instance.moving,
        );
        let mut gradient = vec![0.0; step.len()];
        dense
            .places
            .iter()
            .zip(dense.gradient.iter())
            .for_each(|(&place, g)| gradient[place] = *g);
        let count = quadratic.rows().len();
        let extra = vec![1.0; instance.space.nv()];
        let free = instance
            .fixed
            .iter()
            .position(|fixed| !fixed)
            .expect("a free waypoint");
        assert!(quadratic.append(
            &cost,
            Row {
                segment: free,
                ratio: 0.0,
                jacobian: &extra,
                right_hand_side: 0.1
            }
        ));
        quadratic.truncate(count);
        let mut again = vec![0.0; step.len()];
        quadratic.solve(&cost, &gradient, &mut again);
        assert!(
            step.iter()
                .zip(&again)
                .all(|(a, b)| (a - b).abs() < 1e-14)
        );
    }
}
