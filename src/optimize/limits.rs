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

impl Limited {
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
        let variables = task.model.robot().variables();
        let limited = |component: &Component| match *component {
            Component::Line { q, v } if task.moving[v] => {
                let lower = variables[q].lower;
                let upper = variables[q].upper;
                (lower.is_finite() || upper.is_finite()).then_some(Limited { q, v, lower, upper })
            }
            _ => None,
        };
        Self {
            nq: task.space.nq(),
            nv: task.space.nv(),
            limited: task.space.components().iter().filter_map(limited).collect(),
            free: (0..fixed.len()).filter(|&i| !fixed[i]).collect(),
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
        let Model {
            cost,
            path,
            gradient,
        } = model;
        for round in 0..ROUNDS {
            quadratic.truncate(collision_rows);
            let wanted = self.active.len();
            self.append_active(quadratic, cost, path, stop)?;
            quadratic.solve(cost, gradient, step);
            let multipliers = &quadratic.multipliers()[collision_rows..];
            if round < ROUNDS_AT_ONCE {
                self.exchange_all(multipliers, path, step);
            } else {
                self.exchange_one(multipliers, path, step);
            }
            let settled = self.next == self.active;
            let nothing_new = self.next.len() == wanted && self.active.len() < wanted;
            std::mem::swap(&mut self.active, &mut self.next);
            if settled || nothing_new {
                break;
            }
        }
        Some(self.largest_part(path, step))
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
        let mut left = std::mem::take(&mut self.next);
        let active = &self.active;
        left.clear();
        self.for_each_left(path, step, |held, _| {
            if active.len() + left.len() < MOST_HELD && !active.contains(&held) {
                left.push(held);
            }
        });
        for held in &left {
            if stop() {
                return None;
            }
            let variable = &self.limited[held.limited];
            let room = variable.room(held.side, path[held.waypoint * self.nq + variable.q]);
            let inwards = if held.side == Side::Lower { 1.0 } else { -1.0 };
            self.unit[variable.v] = inwards;
            let row = Row {
                segment: held.waypoint,
                ratio: 0.0,
                jacobian: &self.unit,
                right_hand_side: inwards * room,
            };
            set.push(cost, row);
            self.unit[variable.v] = 0.0;
        }
        self.active.extend_from_slice(&left);
        self.next = left;
        Some(!self.next.is_empty())
    }

    /// Brings what rounding left outside its limits back to them; `from` is the path that the step
    /// began at.
    pub fn settle(&self, from: &Path, path: &mut Path) {
        for &waypoint in &self.free {
            let from = from.waypoint(waypoint);
            let row = path.waypoint_mut(waypoint);
            for &Limited {
                q, lower, upper, ..
            } in &self.limited
            {
                row[q] = row[q].clamp(lower.min(from[q]), upper.max(from[q]));
            }
        }
    }

    /// Appends the rows of the active limits; those that depend on others are dropped. `None` where
    /// stopped.
    fn append_active(
        &mut self,
        quadratic: &mut QuadraticStep,
        cost: &Cost<'_>,
        path: &[f64],
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<()> {
        let mut is_stopped = false;
        let nq = self.nq;
        let limited = &self.limited;
        let unit = &mut self.unit;
        self.active.retain(|held| {
            is_stopped = is_stopped || stop();
            if is_stopped {
                return true;
            }
            let variable = &limited[held.limited];
            unit[variable.v] = 1.0;
            let right_hand_side = variable.room(held.side, path[held.waypoint * nq + variable.q]);
            let row = Row {
                segment: held.waypoint,
                ratio: 0.0,
                jacobian: unit,
                right_hand_side,
            };
            let independent = quadratic.append(cost, row);
            unit[variable.v] = 0.0;
            independent
        });
        (!is_stopped).then_some(())
    }

    /// `next` = the active limits that push inwards, and all that the step leaves.
    fn exchange_all(&mut self, multipliers: &[f64], path: &[f64], step: &[f64]) {
        self.next.clear();
        let inwards = self
            .active
            .iter()
            .zip(multipliers)
            .filter(|(held, multiplier)| held.pull(**multiplier) <= 0.0);
        self.next.extend(inwards.map(|(held, _)| *held));
        let mut next = std::mem::take(&mut self.next);
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
        let mut furthest: Option<(Held, f64)> = None;
        self.for_each_left(path, step, |held, by| {
            if furthest.is_none_or(|(_, most)| by > most) {
                furthest = Some((held, by));
            }
        });
        self.next.clone_from(&self.active);
        if let Some((held, _)) = furthest {
            self.next.push(held);
            return;
        }
        let pulls = self
            .active
            .iter()
            .zip(multipliers)
            .map(|(held, multiplier)| held.pull(*multiplier));
        let strongest = pulls
            .enumerate()
            .filter(|(_, pull)| *pull > 0.0)
            .max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((index, _)) = strongest {
            self.next.remove(index);
        }
    }

    /// Calls `found` with each limit that the step leaves, and by how much.
    fn for_each_left(&self, path: &[f64], step: &[f64], mut found: impl FnMut(Held, f64)) {
        for &waypoint in &self.free {
            for (index, limited) in self.limited.iter().enumerate() {
                let x = path[waypoint * self.nq + limited.q];
                let p = step[waypoint * self.nv + limited.v];
                let side = if p > 0.0 { Side::Upper } else { Side::Lower };
                let by = p.abs() - limited.room(side, x).abs();
                if by > ROUNDING {
                    found(
                        Held {
                            waypoint,
                            limited: index,
                            side,
                        },
                        by,
                    );
                }
            }
        }
    }

    /// The largest part of the step that leaves no limit.
    pub fn largest_part(&self, path: &[f64], step: &[f64]) -> f64 {
        let mut part = 1.0_f64;
        self.for_each_left(
            path,
            step,
            |Held {
                 waypoint,
                 limited,
                 side,
             },
             _| {
                let Limited { q, v, .. } = self.limited[limited];
                let room = self.limited[limited].room(side, path[waypoint * self.nq + q]);
                part = part.min(room / step[waypoint * self.nv + v]);
            },
        );
        part
    }
}

#[cfg(test)]
mod tests;
