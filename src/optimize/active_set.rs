//! The step of the quadratic model under half-spaces: `min_p gᵀp + ½ pᵀHp` subject to `J p ≥ b`.
//!
//! The dual active set method of Goldfarb and Idnani (*A numerically stable dual method for solving
//! strictly convex quadratic programs*, 1983) on the closed form of H⁻¹ ([`Cost::compliance`]):
//! `p = H⁻¹(Jᵀν − g)`, ν ≥ 0, where only the active rows have ν > 0. It starts from the minimum
//! without rows, takes in the row that is violated most, and releases a row as soon as its
//! multiplier would change sign. Only `M = J H⁻¹ Jᵀ` is ever looked at, so that the number of
//! waypoints hardly counts; rows that come later are added to the solution that there is.

use super::cost::Cost;
use super::factor::{Factor, dot};
use super::gram::Gram;
use super::rows::{Row, Rows};

/// A row is violated when its slack is below minus this, in units of the step that one unit of
/// force would make.
const VIOLATED: f64 = 1e-10;

/// Of a row that depends on the active ones, this much is left (squared, relative): more than what
/// rounding leaves where some of these nearly depend on each other.
const DEPENDENT: f64 = 1e-8;

/// Exchanges for each row, after which rounding is going round in circles.
const EXCHANGES_PER_ROW: usize = 20;

/// Why there is no step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unsolved {
    /// No step satisfies this row together with those active against it.
    Infeasible {
        /// The row that cannot be satisfied.
        row: usize,
    },
    /// `stop` said so.
    Stopped,
}

/// A row on its way into the active set.
struct Entering {
    row: usize,
    /// Its entry on the diagonal of M.
    diagonal: f64,
    /// ν so far.
    multiplier: f64,
    /// Below 0 until the multiplier is large enough.
    slack: f64,
}

impl Entering {
    /// How much its multiplier must grow yet; infinitely much where it cannot be satisfied alone.
    fn until_satisfied(&self, curvature: f64) -> f64 {
        // A row that depends on the active ones is never satisfied by its own multiplier: the quotient
        // would be rounding.
        if curvature > DEPENDENT * self.diagonal {
            -self.slack / curvature
        } else {
            f64::INFINITY
        }
    }
}

/// How far the multiplier of a row that enters is raised at once.
struct Exchange {
    by: f64,
    /// By how much its slack grows for each unit of it.
    curvature: f64,
    /// The active row whose multiplier comes to 0 there.
    released: Option<usize>,
}

/// A row that is not satisfied.
struct Violation {
    row: usize,
    slack: f64,
    /// −slack, in units of the step that one unit of force would make.
    by: f64,
}

/// Half-spaces, which of them hold the step, and scratch.
#[derive(Clone, Debug, Default)]
pub struct ActiveSet {
    rows: Rows,
    /// M.
    gram: Gram,
    /// `J p − b` of each row for the step without rows.
    free_slack: Vec<f64>,
    /// −H⁻¹ g.
    free_step: Vec<f64>,
    active: Vec<usize>,
    /// ν of each active row, in the same order.
    multipliers: Vec<f64>,
    /// Of M between active rows, in the same order.
    factor: Factor,
    column: Vec<f64>,
    direction: Vec<f64>,
    force: Vec<f64>,
    /// What the active rows add to the slack of each row.
    pushed: Vec<f64>,
}

impl ActiveSet {
    /// No rows, on velocities of `nv` coordinates.
    pub fn new(nv: usize) -> Self {
        Self {
            rows: Rows::new(nv),
            ..Self::default()
        }
    }

    /// Starts anew with the model of this cost and gradient (one row of nv numbers for each
    /// waypoint).
    pub fn begin(&mut self, cost: &Cost<'_>, gradient: &[f64]) {
        self.clear();
        self.update_free_step(cost, gradient);
    }

    fn update_free_step(&mut self, cost: &Cost<'_>, gradient: &[f64]) {
        self.free_step.resize(gradient.len(), 0.0);
        cost.apply_inverse_hessian(gradient, &mut self.free_step);
        self.free_step.iter_mut().for_each(|p| *p = -*p);
    }

    fn clear(&mut self) {
        self.rows.truncate(0);
        self.gram.clear();
        self.free_slack.clear();
        self.deactivate();
    }

    /// No row is active.
    fn deactivate(&mut self) {
        self.active.clear();
        self.multipliers.clear();
        self.factor.truncate(0);
    }

    /// The rows so far.
    pub fn rows(&self) -> &Rows {
        &self.rows
    }

    /// The rows that hold the step, and their multipliers ν > 0.
    pub fn active(&self) -> impl Iterator<Item = (usize, f64)> {
        self.active
            .iter()
            .copied()
            .zip(self.multipliers.iter().copied())
    }

    /// Adds a half-space and returns its number; `None` where no waypoint that may move is in it.
    pub fn push(&mut self, cost: &Cost, row: Row) -> Option<usize> {
        let diagonal = row.coupling(&row, cost);
        (diagonal > 0.0).then(|| self.add(cost, row, diagonal))
    }

    fn add(&mut self, cost: &Cost<'_>, row: Row<'_>, diagonal: f64) -> usize {
        self.append_line(cost, &row, diagonal);
        let slack = row.of_step(&self.free_step) - row.right_hand_side;
        self.free_slack.push(slack);
        self.rows.push(row);
        self.rows.len() - 1
    }

    /// Appends the line of M that belongs to a new row.
    fn append_line(&mut self, cost: &Cost<'_>, row: &Row<'_>, diagonal: f64) {
        let couplings = self
            .rows
            .iter()
            .map(|other| row.coupling(&other, cost));
        self.gram.push(couplings, diagonal);
    }

    /// Asks less (or more) of a row that is not active: `J p ≥ right_hand_side`.
    pub fn relax(&mut self, row: usize, right_hand_side: f64) {
        debug_assert!(!self.active.contains(&row));
        self.free_slack[row] += self.rows.get(row).right_hand_side - right_hand_side;
        self.rows
            .set_right_hand_side(row, right_hand_side);
    }

    /// Starts with these rows as active, as far as they are independent and their multipliers
    /// positive: those of the last path, whose rows were much the same. Call it before any
    /// [`Self::solve`].
    pub fn warm_start(&mut self, rows: impl Iterator<Item = usize>) {
        for row in rows {
            if self.append(row) {
                self.active.push(row);
            }
        }
        // Only a multiplier that pushes is one of the dual method's: each of its iterates is optimal
        // for the rows that are active.
        while let Some(pulling) = self.most_pulling() {
            self.release(pulling);
        }
    }

    /// Solves for the multipliers of the active rows; where some are negative, the least one.
    fn most_pulling(&mut self) -> Option<usize> {
        self.satisfy_active();
        let nu = &self.multipliers;
        let least = (0..nu.len()).min_by(|&a, &b| nu[a].total_cmp(&nu[b]));
        least.filter(|&least| nu[least] < 0.0)
    }

    /// The multipliers that leave no active row any slack.
    fn satisfy_active(&mut self) {
        self.multipliers.clear();
        let missing = self
            .active
            .iter()
            .map(|&row| -self.free_slack[row]);
        self.multipliers.extend(missing);
        self.factor.solve(&mut self.multipliers);
    }

    /// Goes on until no row is violated; `stop` is asked before each row that is taken in.
    ///
    /// # Errors
    /// A row that cannot be satisfied together with the active ones; the state is that before it
    /// was taken in. Or `stop` said so.
    pub fn solve(&mut self, stop: &mut dyn FnMut() -> bool) -> Result<(), Unsolved> {
        // In exact arithmetic the dual cost rises with each exchange, so that none comes back; the bound
        // is for rounding.
        for _ in 0..EXCHANGES_PER_ROW * (self.rows.len() + 1) {
            if stop() {
                return Err(Unsolved::Stopped);
            }
            match self.most_violated() {
                Some(violation) => self.take_in(&violation)?,
                None => break,
            }
        }
        Ok(())
    }

    /// Writes p.
    pub fn step(&mut self, cost: &Cost<'_>, step: &mut [f64]) {
        self.add_up_forces(step.len());
        cost.apply_inverse_hessian(&self.force, step);
        let free = step.iter_mut().zip(&self.free_step);
        free.for_each(|(p, free)| *p += free);
    }

    /// `force` ← Jᵀν.
    fn add_up_forces(&mut self, size: usize) {
        self.force.clear();
        self.force.resize(size, 0.0);
        for (row, multiplier) in self.active.iter().zip(&self.multipliers) {
            self.rows
                .get(*row)
                .add_force(*multiplier, &mut self.force);
        }
    }

    fn diagonal(&self, row: usize) -> f64 {
        self.gram.entry(row, row)
    }

    /// `column` ← M between the active rows and one.
    fn fill_column(&mut self, row: usize) {
        let line = self.gram.line(row);
        self.column.clear();
        self.column
            .extend(self.active.iter().map(|active| line[*active]));
    }

    /// Adds the line of a row to the factor; false where it depends on the active ones.
    fn append(&mut self, row: usize) -> bool {
        self.fill_column(row);
        let diagonal = self.diagonal(row);
        self.factor.append(&self.column, diagonal)
    }

    /// `pushed` ← M between all rows and the active ones, times ν.
    fn add_up_pushes(&mut self) {
        self.pushed.clear();
        self.pushed.resize(self.rows.len(), 0.0);
        // Line after line, so that many rows are added to at once.
        for (active, nu) in self.active.iter().zip(&self.multipliers) {
            let line = self.gram.line(*active);
            let pushed = self.pushed.iter_mut().zip(line);
            pushed.for_each(|(pushed, entry)| *pushed += entry * nu);
        }
    }

    /// The row that asks for the longest step.
    fn most_violated(&mut self) -> Option<Violation> {
        self.add_up_pushes();
        let violations = (0..self.rows.len()).map(|row| self.violation(row));
        violations
            .filter(|violation| self.is_missed(violation))
            .reduce(|worst, next| if next.by > worst.by { next } else { worst })
    }

    fn is_missed(&self, violation: &Violation) -> bool {
        // An active row is satisfied by its multiplier; what rounding leaves of it is not taken in twice.
        violation.by > VIOLATED && !self.active.contains(&violation.row)
    }

    fn violation(&self, row: usize) -> Violation {
        let slack = self.free_slack[row] + self.pushed[row];
        Violation {
            row,
            slack,
            by: -slack / self.diagonal(row).sqrt(),
        }
    }

    /// Raises the multiplier of a row until it is satisfied, releasing those whose multipliers come
    /// to 0 on the way.
    fn take_in(&mut self, violation: &Violation) -> Result<(), Unsolved> {
        let row = violation.row;
        let before = (self.active.clone(), self.multipliers.clone());
        let mut entering = Entering {
            row,
            diagonal: self.diagonal(row),
            multiplier: 0.0,
            slack: violation.slack,
        };
        loop {
            let exchange = self.find_exchange(&entering);
            // No multiplier satisfies the row, and none of the active ones gives way.
            if exchange.by == f64::INFINITY {
                self.restore(before);
                return Err(Unsolved::Infeasible { row });
            }
            self.exchange(&exchange, &mut entering);
            let Some(released) = exchange.released else {
                break;
            };
            self.release(released);
        }
        self.activate(&entering);
        Ok(())
    }

    /// How far the multiplier can be raised until the row is satisfied or an active one is released.
    fn find_exchange(&mut self, entering: &Entering) -> Exchange {
        let curvature = self.aim(entering);
        let whole = entering.until_satisfied(curvature);
        match self
            .blocking()
            .filter(|(_, most)| *most < whole)
        {
            Some((released, by)) => Exchange {
                by,
                curvature,
                released: Some(released),
            },
            None => Exchange {
                by: whole,
                curvature,
                released: None,
            },
        }
    }

    /// `direction` ← by how much the active multipliers fall for each unit of that of the row; returns
    /// by how much its slack grows.
    fn aim(&mut self, entering: &Entering) -> f64 {
        self.fill_column(entering.row);
        self.direction.clone_from(&self.column);
        self.factor.solve(&mut self.direction);
        entering.diagonal - dot(&self.direction, &self.column)
    }

    fn exchange(&mut self, exchange: &Exchange, entering: &mut Entering) {
        let by = exchange.by;
        entering.multiplier += by;
        entering.slack += by * exchange.curvature;
        let falls = self.multipliers.iter_mut().zip(&self.direction);
        falls.for_each(|(nu, u)| *nu -= by * u);
    }

    /// `column` is that of the row already.
    fn activate(&mut self, entering: &Entering) {
        if self
            .factor
            .append(&self.column, entering.diagonal)
        {
            self.active.push(entering.row);
            self.multipliers.push(entering.multiplier);
        }
    }

    /// The active row whose multiplier comes to 0 first along `direction`, and after how much.
    fn blocking(&self) -> Option<(usize, f64)> {
        let most = self.until_released().enumerate();
        let falling = most.filter_map(|(index, most)| Some((index, most?)));
        falling.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// How much each active multiplier can be let fall along `direction`; `None` where it does not.
    fn until_released(&self) -> impl Iterator<Item = Option<f64>> {
        // Rounding may have left a multiplier just below 0: it blocks at once, it is not raised.
        let falls = self.direction.iter().zip(&self.multipliers);
        falls.map(|(u, nu)| (*u > 0.0).then(|| nu.max(0.0) / u))
    }

    fn release(&mut self, index: usize) {
        self.active.remove(index);
        if index < self.multipliers.len() {
            self.multipliers.remove(index);
        }
        self.factor.remove(index);
    }

    fn restore(&mut self, (active, multipliers): (Vec<usize>, Vec<f64>)) {
        self.deactivate();
        for (row, multiplier) in active.into_iter().zip(multipliers) {
            if self.append(row) {
                self.active.push(row);
                self.multipliers.push(multiplier);
            }
        }
    }
}

#[cfg(test)]
mod tests;
