//! Convex programs by Clarabel.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

use super::along::Place;
use super::blend::Stretch;
use super::limits::{ColumnLimits, Limits};
use super::ramp;

/// How long places are apart.
fn widths(stretches: &[Stretch], places: &[Place]) -> Vec<f64> {
    let pairs = places.windows(2);
    pairs
        .map(|pair| pair[0].end(&pair[1], stretches) - pair[0].length)
        .collect()
}

pub fn duration(stretches: &[Stretch], places: &[Place]) -> f64 {
    let widths = widths(stretches, places);
    let pairs = places.windows(2).zip(widths);
    pairs
        .map(|(pair, width)| 2.0 * width / (pair[0].square.sqrt() + pair[1].square.sqrt()))
        .sum()
}

/// Rows of a program: coefficients by variable, right hand side.
#[derive(Default)]
struct Program {
    rows: Vec<(Vec<(usize, f64)>, f64)>,
    cones: Vec<SupportedConeT<f64>>,
}

impl Program {
    /// Σ c x ≤ limit.
    fn at_most(&mut self, terms: &[(usize, f64)], limit: f64) {
        self.rows.push((terms.to_vec(), limit));
        self.cones
            .push(SupportedConeT::NonnegativeConeT(1));
    }

    /// Σ c x = value.
    fn equal(&mut self, terms: &[(usize, f64)], value: f64) {
        self.rows.push((terms.to_vec(), value));
        self.cones.push(SupportedConeT::ZeroConeT(1));
    }

    /// ‖(2 a, b − c)‖ ≤ b + c: a² ≤ b c. Each is terms and a constant.
    fn product(&mut self, [a, b, c]: [(&[(usize, f64)], f64); 3]) {
        let scaled = |(terms, constant): (&[(usize, f64)], f64), by: f64| {
            let terms: Vec<_> = terms
                .iter()
                .map(|(at, value)| (*at, -value * by))
                .collect();
            (terms, constant * by)
        };
        let sum = |b: (Vec<(usize, f64)>, f64), c: (Vec<(usize, f64)>, f64)| {
            ([b.0, c.0].concat(), b.1 + c.1)
        };
        self.rows
            .push(sum(scaled(b, 1.0), scaled(c, 1.0)));
        self.rows.push(scaled(a, 2.0));
        self.rows
            .push(sum(scaled(b, 1.0), scaled(c, -1.0)));
        self.cones
            .push(SupportedConeT::SecondOrderConeT(3));
    }

    fn solve(&self, cost: &[f64]) -> Option<Vec<f64>> {
        let count = cost.len();
        let mut rows = Vec::new();
        let mut columns = Vec::new();
        let mut values = Vec::new();
        for (row, (terms, _)) in self.rows.iter().enumerate() {
            for (column, value) in terms {
                rows.push(row);
                columns.push(*column);
                values.push(*value);
            }
        }
        let a = CscMatrix::new_from_triplets(self.rows.len(), count, rows, columns, values);
        let b: Vec<f64> = self
            .rows
            .iter()
            .map(|(_, right)| *right)
            .collect();
        let settings = DefaultSettings {
            verbose: false,
            ..DefaultSettings::default()
        };
        let p = CscMatrix::zeros((count, count));
        let mut solver = DefaultSolver::new(&p, cost, &a, &b, &self.cones, settings).unwrap();
        solver.solve();
        let is_solved = matches!(
            solver.solution.status,
            SolverStatus::Solved | SolverStatus::AlmostSolved
        );
        is_solved.then(|| solver.solution.x.clone())
    }
}

/// The least duration on the same places: variables x, c ≤ √x and d ≥ 1 / (c + c').
pub fn least(stretches: &[Stretch], places: &[Place], limits: &Limits) -> f64 {
    let count = places.len();
    let widths = widths(stretches, places);
    let [x, c, d] = [0, count, 2 * count];
    let mut program = Program::default();
    for (number, place) in places.iter().enumerate() {
        let is_rest = number == 0 || number + 1 == count;
        let stretch = &stretches[place.stretch];
        let before = number
            .checked_sub(1)
            .map(|before| &stretches[places[before].stretch]);
        let is_corner = before.is_some_and(|before| {
            let ends = before.slope_at(before.length);
            place.length == 0.0
                && ends
                    .iter()
                    .zip(&stretch.slope)
                    .any(|(a, b)| (a - b).abs() > 1e-9)
        });
        if is_rest || is_corner {
            program.equal(&[(x + number, 1.0)], 0.0);
        }
        for (slope, own) in stretch
            .slope_at(place.length)
            .iter()
            .zip(limits.columns())
        {
            let most = own.velocity.part(*slope);
            program.at_most(&[(x + number, most * most)], 1.0);
        }
        program.at_most(&[(x + number, -1.0)], 0.0);
        program.product([
            (&[(c + number, 1.0)], 0.0),
            (&[(x + number, 1.0)], 0.0),
            (&[], 1.0),
        ]);
    }
    let mut cost = vec![0.0; 3 * count - 1];
    for (number, width) in widths.iter().enumerate() {
        let stretch = &stretches[places[number].stretch];
        let length = places[number].length;
        for (at, place) in [(length, number), (length + width, number + 1)] {
            let slopes = stretch.slope_at(at);
            for (column, own) in limits.columns().iter().enumerate() {
                let by_u = slopes[column] / (2.0 * width);
                let terms = [
                    (x + number + 1, by_u),
                    (x + number, -by_u),
                    (x + place, stretch.bend[column]),
                ];
                program.at_most(&terms, own.acceleration.most);
                program.at_most(
                    &terms.map(|(at, value)| (at, -value)),
                    -own.acceleration.least,
                );
            }
        }
        program.product([
            (&[], 1.0),
            (&[(c + number, 1.0), (c + number + 1, 1.0)], 0.0),
            (&[(d + number, 1.0)], 0.0),
        ]);
        cost[d + number] = 2.0 * width;
    }
    let solution = program
        .solve(&cost)
        .expect("the program is solved");
    widths
        .iter()
        .enumerate()
        .map(|(number, width)| {
            let square = |at: usize| solution[x + at].max(0.0).sqrt();
            2.0 * width / (square(number) + square(number + 1))
        })
        .sum()
}

/// Whether a column can do it in this time, by accelerations that are constant in each of many steps:
/// as far as it can, or less far, up to a slack (m or rad).
pub fn column_can(ends: &ramp::Ends, limits: &ColumnLimits, time_s: f64, slack: f64) -> bool {
    const STEPS: usize = 200;
    let step = time_s / STEPS as f64;
    let [v0, v1] = ends.velocities;
    // Velocities at the ends of steps; the way is the sum of their means.
    let reached = |sign: f64| {
        let mut program = Program::default();
        for number in 0..=STEPS {
            program.at_most(&[(number, 1.0)], limits.velocity.most);
            program.at_most(&[(number, -1.0)], -limits.velocity.least);
        }
        for number in 0..STEPS {
            let terms = [(number + 1, 1.0), (number, -1.0)];
            program.at_most(&terms, step * limits.acceleration.most);
            program.at_most(
                &terms.map(|(at, value)| (at, -value)),
                -step * limits.acceleration.least,
            );
        }
        program.equal(&[(0, 1.0)], v0);
        program.equal(&[(STEPS, 1.0)], v1);
        let mut way = vec![step; STEPS + 1];
        way[0] *= 0.5;
        way[STEPS] *= 0.5;
        let cost: Vec<f64> = way.iter().map(|part| -sign * part).collect();
        let solution = program.solve(&cost)?;
        Some(
            solution
                .iter()
                .zip(&way)
                .map(|(v, part)| v * part)
                .sum::<f64>(),
        )
    };
    match (reached(-1.0), reached(1.0)) {
        (Some(least), Some(most)) => least - slack <= ends.way && ends.way <= most + slack,
        _ => false,
    }
}
