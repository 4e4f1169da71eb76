//! Joint limits as rows of the quadratic step: bounds on single variables at single waypoints.
//!
//! A limit never cuts a step that is already computed, which would break the other rows. Where the
//! step would leave a limit, a row holds that variable at that waypoint at the limit and the step
//! is computed again; a row that pulls away from its limit is dropped. The primal-dual active set
//! method for bounds (Hintermüller, Ito, Kunisch 2002) does both at once, and starts from the rows
//! of the last step.

use super::active_set::ActiveSet;
use super::cost::Cost;
use super::quadratic_step::QuadraticStep;
use super::rows::Row;
use super::task::Task;
use crate::path::Path;
use crate::robot::Component;

/// Rounds in which all limits may change at once; nearly always a handful suffices.
const ROUNDS_AT_ONCE: usize = 12;

/// Rounds in all; in the later ones a single limit changes at a time, which breaks cycles.
const ROUNDS: usize = 60;

/// Limits that may hold one step: rows cost the cube of their number, and a path of many thousand
/// waypoints may leave its limits at each of them. Where more would, the step is cut
/// ([`Limits::largest_part`]).
const MOST_HELD: usize = 512;

/// A step may pass a limit by this much (m or rad): what rounding leaves of a row.
const ROUNDING: f64 = 1e-9;

/// A variable of the path that has limits.
#[derive(Clone, Copy, Debug)]
struct Limited {
    q: usize,
    v: usize,
    lower: f64,
    upper: f64,
}

/// How a limit that holds a variable is written as a row on that variable alone.
#[derive(Clone, Copy)]
struct LimitRow {
    waypoint: usize,
    v: usize,
    /// The one entry of the Jacobian.
    entry: f64,
    right_hand_side: f64,
}

impl LimitRow {
    /// Calls `take` with the row; `unit` is scratch of nv zeros.
    fn with<T>(&self, unit: &mut [f64], take: impl FnOnce(Row<'_>) -> T) -> T {
        unit[self.v] = self.entry;
        let taken = take(self.on(unit));
        unit[self.v] = 0.0;
        taken
    }

    fn on<'j>(&self, jacobian: &'j [f64]) -> Row<'j> {
        Row {
            segment: self.waypoint,
            ratio: 0.0,
            jacobian,
            right_hand_side: self.right_hand_side,
        }
    }
}

/// A variable held at a limit at one waypoint.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Held {
    waypoint: usize,
    limited: usize,
    side: Side,
}

impl Held {
    /// The force that the row exerts outwards, towards its limit: H p + g + μ = 0, so μ > 0 pushes
    /// down.
    fn pull(&self, multiplier: f64) -> f64 {
        match self.side {
            Side::Lower => multiplier,
            Side::Upper => -multiplier,
        }
    }
}

/// Which limit.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Side {
    Lower,
    Upper,
}

impl Side {
    /// The sign of a step away from the limit.
    fn inwards(self) -> f64 {
        match self {
            Self::Lower => 1.0,
            Self::Upper => -1.0,
        }
    }

    /// The limit that a step goes towards.
    fn ahead(p: f64) -> Self {
        if p > 0.0 { Self::Upper } else { Self::Lower }
    }
}

impl Limited {
    /// Brings a value back that lies farther outside than it did in `from`.
    fn settle(&self, from: &[f64], row: &mut [f64]) {
        let before = from[self.q];
        let value = &mut row[self.q];
        *value = value.clamp(self.lower.min(before), self.upper.max(before));
    }
    /// On circles and rotations there is no way out of a limit that a straight line could leave by:
    /// only lines have limits.
    fn of(component: &Component, task: &Task<'_>) -> Option<Self> {
        let Component::Line { q, v } = *component else {
            return None;
        };
        let variable = &task.model.robot().variables()[q];
        let lower = variable.lower;
        let upper = variable.upper;
        let is_limited = task.moving[v] && (lower.is_finite() || upper.is_finite());
        is_limited.then_some(Self { q, v, lower, upper })
    }

    /// How far the variable may still move towards a side from `x` (signed); 0 outside, where it
    /// may not move on out.
    fn room(&self, side: Side, x: f64) -> f64 {
        match side {
            Side::Lower => (self.lower - x).min(0.0),
            Side::Upper => (self.upper - x).max(0.0),
        }
    }
}

/// The quadratic model of the cost at a path.
#[derive(Clone, Copy)]
pub struct Model<'a> {
    /// H.
    pub cost: &'a Cost<'a>,
    /// The path, flat rows.
    pub path: &'a [f64],
    /// g there, one row of nv numbers for each waypoint.
    pub gradient: &'a [f64],
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
    pub fn new(task: &Task<'_>, fixed: &[bool]) -> Self {
        let components = task.space.components().iter();
        let limited = components.filter_map(|component| Limited::of(component, task));
        Self {
            nq: task.space.nq(),
            nv: task.space.nv(),
            limited: limited.collect(),
            free: (0..fixed.len())
                .filter(|&i| !fixed[i])
                .collect(),
            active: Vec::new(),
            next: Vec::new(),
            unit: vec![0.0; task.space.nv()],
        }
    }

    /// Writes the step of the first `collision_rows` rows of `quadratic` and of those limits that
    /// hold it. Limit rows of the last step are dropped and found again.
    ///
    /// Returns the largest part of the step that keeps all limits: 1 unless the rows leave no such
    /// step. `None` where stopped: `stop` is asked at every row.
    pub fn solve(
        &mut self,
        quadratic: &mut QuadraticStep,
        collision_rows: usize,
        model: Model<'_>,
        step: &mut [f64],
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<f64> {
        for round in 0..ROUNDS {
            quadratic.truncate(collision_rows);
            let wanted = self.active.len();
            self.append_active(quadratic, &model, stop)?;
            quadratic.solve(model.cost, model.gradient, step);
            let multipliers = &quadratic.multipliers()[collision_rows..];
            if round < ROUNDS_AT_ONCE {
                self.exchange_all(multipliers, model.path, step);
            } else {
                self.exchange_one(multipliers, model.path, step);
            }
            if self.settles(wanted) {
                break;
            }
        }
        Some(self.largest_part(model.path, step))
    }

    /// Takes the next active limits; whether they are those of this round, or but for dependent ones
    /// those that were wanted.
    fn settles(&mut self, wanted: usize) -> bool {
        let settled = self.next == self.active;
        let nothing_new = self.next.len() == wanted && self.active.len() < wanted;
        std::mem::swap(&mut self.active, &mut self.next);
        settled || nothing_new
    }

    /// Forgets the limits that hold the step.
    pub fn release(&mut self) {
        self.active.clear();
    }

    /// Adds a half-space for every limit that the step leaves and that has none yet; false where
    /// there is none, `None` where stopped.
    pub fn push_left(
        &mut self,
        set: &mut ActiveSet,
        cost: &Cost<'_>,
        path: &[f64],
        step: &[f64],
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<bool> {
        self.find_new_left(path, step);
        for index in 0..self.next.len() {
            if stop() {
                return None;
            }
            let row = self.half_space(&self.next[index], path);
            row.with(&mut self.unit, |row| set.push(cost, row));
        }
        self.active.extend_from_slice(&self.next);
        Some(!self.next.is_empty())
    }

    /// `next` ← the limits that the step leaves and that do not hold it yet.
    fn find_new_left(&mut self, path: &[f64], step: &[f64]) {
        let mut left = std::mem::take(&mut self.next);
        let active = &self.active;
        left.clear();
        self.for_each_left(path, step, |held, _| {
            if active.len() + left.len() < MOST_HELD && !active.contains(&held) {
                left.push(held);
            }
        });
        self.next = left;
    }

    /// `± p ≥ ± room`: inwards.
    fn half_space(&self, held: &Held, path: &[f64]) -> LimitRow {
        self.row(held, path, held.side.inwards())
    }

    /// The row whose one entry is this.
    fn row(&self, held: &Held, path: &[f64], entry: f64) -> LimitRow {
        LimitRow {
            waypoint: held.waypoint,
            v: self.limited[held.limited].v,
            entry,
            right_hand_side: entry * self.room(held, path),
        }
    }

    /// `p = room`.
    fn equation(&self, held: &Held, path: &[f64]) -> LimitRow {
        self.row(held, path, 1.0)
    }

    /// How far the variable may still move towards its limit (signed).
    fn room(&self, held: &Held, path: &[f64]) -> f64 {
        let variable = &self.limited[held.limited];
        variable.room(held.side, path[held.waypoint * self.nq + variable.q])
    }

    /// Brings what rounding left outside its limits back to them; `from` is the path that the step
    /// began at.
    pub fn settle(&self, from: &Path, path: &mut Path) {
        for &waypoint in &self.free {
            for limited in &self.limited {
                limited.settle(from.waypoint(waypoint), path.waypoint_mut(waypoint));
            }
        }
    }

    /// Appends the rows of the active limits; those that depend on others are dropped. `None` where
    /// stopped.
    fn append_active(
        &mut self,
        quadratic: &mut QuadraticStep,
        model: &Model<'_>,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<()> {
        let wanted = std::mem::take(&mut self.active);
        for held in &wanted {
            if stop() {
                self.active = wanted;
                return None;
            }
            let row = self.equation(held, model.path);
            if row.with(&mut self.unit, |row| quadratic.append(model.cost, row)) {
                self.active.push(*held);
            }
        }
        Some(())
    }

    /// `next` = the active limits that push inwards, and all that the step leaves.
    fn exchange_all(&mut self, multipliers: &[f64], path: &[f64], step: &[f64]) {
        let held = self.active.iter().zip(multipliers);
        let inwards = held.filter(|(held, multiplier)| held.pull(**multiplier) <= 0.0);
        let mut next = std::mem::take(&mut self.next);
        next.clear();
        next.extend(inwards.map(|(held, _)| *held));
        self.for_each_left(path, step, |held, _| {
            if next.len() < MOST_HELD && !next.contains(&held) {
                next.push(held);
            }
        });
        self.next = next;
    }

    /// `next` = the active limits and the one that the step leaves furthest; where it leaves none,
    /// without the one that pulls outwards most.
    fn exchange_one(&mut self, multipliers: &[f64], path: &[f64], step: &[f64]) {
        self.next.clone_from(&self.active);
        if let Some(held) = self.furthest_left(path, step) {
            self.next.push(held);
        } else if let Some(index) = self.strongest_pull(multipliers) {
            self.next.remove(index);
        }
    }

    /// The limit that the step leaves furthest, the first of equals.
    fn furthest_left(&self, path: &[f64], step: &[f64]) -> Option<Held> {
        let mut furthest: Option<(Held, f64)> = None;
        self.for_each_left(path, step, |held, by| {
            if furthest.is_none_or(|(_, most)| by > most) {
                furthest = Some((held, by));
            }
        });
        furthest.map(|(held, _)| held)
    }

    /// The active limit that pulls outwards most.
    fn strongest_pull(&self, multipliers: &[f64]) -> Option<usize> {
        let outwards = self
            .pulls(multipliers)
            .enumerate()
            .filter(|(_, pull)| *pull > 0.0);
        let strongest = outwards.max_by(|a, b| a.1.total_cmp(&b.1));
        strongest.map(|(index, _)| index)
    }

    /// What each active limit pulls outwards.
    fn pulls(&self, multipliers: &[f64]) -> impl Iterator<Item = f64> {
        let held = self.active.iter().zip(multipliers);
        held.map(|(held, multiplier)| held.pull(*multiplier))
    }

    /// Calls `found` with each limit that the step leaves, and by how much.
    fn for_each_left(&self, path: &[f64], step: &[f64], mut found: impl FnMut(Held, f64)) {
        for &waypoint in &self.free {
            for limited in 0..self.limited.len() {
                let (held, by) = self.ahead(waypoint, limited, path, step);
                if by > ROUNDING {
                    found(held, by);
                }
            }
        }
    }

    /// The limit that a variable's step goes towards, and how far beyond it the step goes.
    #[inline]
    fn ahead(&self, waypoint: usize, limited: usize, path: &[f64], step: &[f64]) -> (Held, f64) {
        let p = self.moved(waypoint, limited, step);
        let held = Held {
            waypoint,
            limited,
            side: Side::ahead(p),
        };
        let by = p.abs() - self.room(&held, path).abs();
        (held, by)
    }

    /// p of a limited variable at a waypoint.
    fn moved(&self, waypoint: usize, limited: usize, step: &[f64]) -> f64 {
        step[waypoint * self.nv + self.limited[limited].v]
    }

    /// The largest part of the step that leaves no limit.
    pub fn largest_part(&self, path: &[f64], step: &[f64]) -> f64 {
        let mut part = 1.0_f64;
        self.for_each_left(path, step, |held, _| {
            let moved = self.moved(held.waypoint, held.limited, step);
            part = part.min(self.room(&held, path) / moved);
        });
        part
    }
}

#[cfg(test)]
mod tests;
