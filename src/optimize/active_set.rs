//! The step of the quadratic model under half-spaces: `min_p gᵀp + ½ pᵀHp` subject to `J p ≥ b`.
//!
//! The dual active set method of Goldfarb and Idnani (*A numerically stable dual method for solving
//! strictly convex quadratic programs*, 1983) on the closed form of H⁻¹ ([`Cost::compliance`]):
//! `p = H⁻¹(Jᵀν − g)`, ν ≥ 0, where only the active rows have ν > 0. It starts from the minimum
//! without rows, takes in the row that is violated most, and releases a row as soon as its
//! multiplier would change sign. Only `M = J H⁻¹ Jᵀ` is ever looked at, so that the number of
//! waypoints hardly counts; rows that come later are added to the solution that there is.

use super::cost::Cost;
use super::factor::Factor;
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

/// Half-spaces, which of them hold the step, and scratch.
#[derive(Clone, Debug)]
pub struct ActiveSet {
    rows: Rows,
    /// M, lower triangle, line after line.
    gram: Vec<f64>,
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
}

impl ActiveSet {
    /// No rows, on velocities of `nv` coordinates.
    pub fn new(nv: usize) -> Self {
        Self {
            rows: Rows::new(nv),
            gram: Vec::new(),
            free_slack: Vec::new(),
            free_step: Vec::new(),
            active: Vec::new(),
            multipliers: Vec::new(),
            factor: Factor::default(),
            column: Vec::new(),
            direction: Vec::new(),
            force: Vec::new(),
        }
    }

    /// Starts anew with the model of this cost and gradient (one row of nv numbers for each
    /// waypoint).
    pub fn begin(&mut self, cost: &Cost<'_>, gradient: &[f64]) {
        self.rows.truncate(0);
        self.gram.clear();
        self.free_slack.clear();
        self.active.clear();
        self.multipliers.clear();
        self.factor.truncate(0);
        self.free_step.resize(gradient.len(), 0.0);
        cost.apply_inverse_hessian(gradient, &mut self.free_step);
        self.free_step.iter_mut().for_each(|p| *p = -*p);
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
    pub fn push(&mut self, cost: &Cost<'_>, row: Row<'_>) -> Option<usize> {
        let diagonal = row.coupling(&row, cost);
        if diagonal <= 0.0 {
            return None;
        }
        self.gram
            .extend(self.rows.iter().map(|other| row.coupling(&other, cost)));
        self.gram.push(diagonal);
        self.free_slack
            .push(row.of_step(&self.free_step) - row.right_hand_side);
        self.rows.push(row);
        Some(self.rows.len() - 1)
    }

    /// Asks less (or more) of a row that is not active: `J p ≥ right_hand_side`.
    pub fn relax(&mut self, row: usize, right_hand_side: f64) {
        debug_assert!(!self.active.contains(&row));
        self.free_slack[row] += self.rows.get(row).right_hand_side - right_hand_side;
        self.rows.set_right_hand_side(row, right_hand_side);
    }

    /// Starts with these rows as active, as far as they are independent and their multipliers
    /// positive: those of the last path, whose rows were much the same. Call it before any
    /// [`Self::solve`].
    pub fn warm_start(&mut self, rows: impl Iterator<Item = usize>) {
        for row in rows {
            self.fill_column(row);
            if self.factor.append(&self.column, self.entry(row, row)) {
                self.active.push(row);
            }
        }
        loop {
            self.multipliers.clear();
            self.multipliers
                .extend(self.active.iter().map(|&row| -self.free_slack[row]));
            self.factor.solve(&mut self.multipliers);
            let least = (0..self.active.len())
                .min_by(|&a, &b| self.multipliers[a].total_cmp(&self.multipliers[b]));
            match least.filter(|&least| self.multipliers[least] < 0.0) {
                Some(least) => self.release(least),
                None => return,
            }
        }
    }

    /// Goes on until no row is violated; `stop` is asked before each row that is taken in.
    ///
    /// # Errors
    /// A row that cannot be satisfied together with the active ones; the state is that before it
    /// was taken in. Or `stop` said so.
    pub fn solve(&mut self, stop: &mut dyn FnMut() -> bool) -> Result<(), Unsolved> {
        for _ in 0..EXCHANGES_PER_ROW * (self.rows.len() + 1) {
            if stop() {
                return Err(Unsolved::Stopped);
            }
            match self.most_violated() {
                Some((row, slack)) => self.take_in(row, slack)?,
                None => break,
            }
        }
        Ok(())
    }

    /// Writes p.
    pub fn step(&mut self, cost: &Cost<'_>, step: &mut [f64]) {
        self.force.clear();
        self.force.resize(step.len(), 0.0);
        for (row, multiplier) in self.active.iter().zip(&self.multipliers) {
            self.rows.get(*row).add_force(*multiplier, &mut self.force);
        }
        cost.apply_inverse_hessian(&self.force, step);
        step.iter_mut()
            .zip(&self.free_step)
            .for_each(|(p, free)| *p += free);
    }

    fn entry(&self, a: usize, b: usize) -> f64 {
        let low = a.min(b);
        let high = a.max(b);
        self.gram[high * (high + 1) / 2 + low]
    }

    /// `column` ← M between the active rows and one.
    fn fill_column(&mut self, row: usize) {
        let mut column = std::mem::take(&mut self.column);
        column.clear();
        column.extend(self.active.iter().map(|&active| self.entry(active, row)));
        self.column = column;
    }

    fn slack(&self, row: usize) -> f64 {
        let held = self
            .active
            .iter()
            .zip(&self.multipliers)
            .map(|(&active, nu)| self.entry(active, row) * nu);
        self.free_slack[row] + held.sum::<f64>()
    }

    /// The row that asks for the longest step, and its slack.
    fn most_violated(&self) -> Option<(usize, f64)> {
        let mut worst = (None, VIOLATED);
        for row in 0..self.rows.len() {
            let slack = self.slack(row);
            let violation = -slack / self.entry(row, row).sqrt();
            if violation > worst.1 && !self.active.contains(&row) {
                worst = (Some((row, slack)), violation);
            }
        }
        worst.0
    }

    /// Raises the multiplier of a row until it is satisfied, releasing those whose multipliers come
    /// to 0 on the way.
    fn take_in(&mut self, row: usize, mut slack: f64) -> Result<(), Unsolved> {
        let before = (self.active.clone(), self.multipliers.clone());
        let diagonal = self.entry(row, row);
        let mut multiplier = 0.0;
        loop {
            self.fill_column(row);
            // For each unit of the row's multiplier the others fall by this, and the slack grows by
            // the curvature.
            self.direction.clear();
            self.direction.extend_from_slice(&self.column);
            self.factor.solve(&mut self.direction);
            let known: f64 = self
                .direction
                .iter()
                .zip(&self.column)
                .map(|(u, m)| u * m)
                .sum();
            let curvature = diagonal - known;
            let whole = if curvature > DEPENDENT * diagonal {
                -slack / curvature
            } else {
                f64::INFINITY
            };
            let blocking = self.blocking().filter(|(_, most)| *most < whole);
            let by = blocking.map_or(whole, |(_, most)| most);
            if by == f64::INFINITY {
                self.restore(before);
                return Err(Unsolved::Infeasible { row });
            }
            multiplier += by;
            slack += by * curvature;
            self.multipliers
                .iter_mut()
                .zip(&self.direction)
                .for_each(|(nu, u)| *nu -= by * u);
            let Some((index, _)) = blocking else { break };
            self.release(index);
        }
        let column = std::mem::take(&mut self.column);
        if self.factor.append(&column, diagonal) {
            self.active.push(row);
            self.multipliers.push(multiplier);
        }
        self.column = column;
        Ok(())
    }

    /// The active row whose multiplier comes to 0 first along `direction`, and after how much.
    fn blocking(&self) -> Option<(usize, f64)> {
        let falling = self
            .direction
            .iter()
            .zip(&self.multipliers)
            .enumerate()
            .filter(|(_, (u, _))| **u > 0.0);
        falling
            .map(|(index, (u, nu))| (index, nu.max(0.0) / u))
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }

    fn release(&mut self, index: usize) {
        self.active.remove(index);
        if index < self.multipliers.len() {
            self.multipliers.remove(index);
        }
        self.factor.remove(index);
    }

    fn restore(&mut self, (active, multipliers): (Vec<usize>, Vec<f64>)) {
        self.factor.truncate(0);
        self.active.clear();
        self.multipliers.clear();
        for (row, multiplier) in active.into_iter().zip(multipliers) {
            self.fill_column(row);
            if self.factor.append(&self.column, self.entry(row, row)) {
                self.active.push(row);
                self.multipliers.push(multiplier);
            }
        }
    }
}

#[cfg(test)]
mod tests;
