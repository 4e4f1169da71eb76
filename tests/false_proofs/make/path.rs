//! Random paths of planners: wandering ones that are free, and steps that nobody looked at.

use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

use fastrand::Rng;

use super::{direction, one_in, pick, quaternion, uniform};
use crate::execute;
use crate::pose::{Quaternion, normalised};
use crate::robot::{Column, Kind, Robot};
use crate::world::World;

/// What is odd about the steps of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Step {
    /// A wandering path that keeps clear.
    Walk,
    /// One that winds about its continuous joints.
    Winding,
    /// A straight line that nobody has looked at.
    Blind,
    /// A straight line to where something is hit.
    Into,
    /// A place where something is just hit.
    Graze,
    /// Numbers cut to four digits, or to f32.
    Rounded,
    /// Half a turn, exact or rounded.
    HalfTurn,
    /// More than half a turn.
    Long,
    /// Whole turns added to some waypoints.
    Rewound,
    /// Orientations half a turn apart, or nearly.
    HalfQuaternion,
    /// Quaternions of changing sign.
    Signs,
}

/// A path, and what is odd about it. One with a constraint is the straight line of a request.
#[derive(Clone, Debug)]
pub struct Made {
    pub rows: Vec<Vec<f64>>,
    pub steps: BTreeSet<Step>,
    pub constraint: Option<Constraint>,
}

/// A column that must stay where it starts.
#[derive(Clone, Copy, Debug)]
pub struct Constraint {
    pub column: usize,
    pub tolerance: f64,
}

/// Keeps this far clear (m).
const CLEAR_M: f64 = 2e-3;
/// Tries to find a free row, or one that hits something.
const TRIES: usize = 40;
/// Tries to find a step that hits something one way only.
const TELLING_TRIES: usize = 6;

/// A row within the limits.
pub fn row(rng: &mut Rng, robot: &Robot) -> Vec<f64> {
    let mut row: Vec<f64> = robot
        .columns
        .iter()
        .map(|column| number(rng, robot, *column))
        .collect();
    for q in turns(robot) {
        row[q..q + 4].copy_from_slice(&quaternion(rng));
    }
    row
}

fn number(rng: &mut Rng, robot: &Robot, column: Column) -> f64 {
    let joint = &robot.joints[column.joint];
    match joint.kind {
        Kind::Revolute | Kind::Prismatic => {
            let (lower, upper) = if one_in(rng, 8) {
                joint.bounds()
            } else {
                joint.soft_bounds()
            };
            // A mimic that has a column of its own may have limits that its leader leaves; 0 is
            // within all.
            uniform(rng, lower, upper)
        }
        Kind::Planar if column.part < 2 => uniform(rng, -0.4, 0.4),
        Kind::Continuous | Kind::Planar => uniform(rng, -4.0, 4.0),
        Kind::Fixed | Kind::Floating => uniform(rng, -0.4, 0.4),
    }
}

/// First columns of quaternions.
pub fn turns(robot: &Robot) -> Vec<usize> {
    let is_first = |&q: &usize| {
        let column = robot.columns[q];
        robot.joints[column.joint].kind == Kind::Floating && column.part == 3
    };
    (0..robot.columns.len())
        .filter(is_first)
        .collect()
}

/// Columns that turn without limits.
pub fn endless(robot: &Robot) -> Vec<usize> {
    let is_endless = |&q: &usize| match robot.joints[robot.columns[q].joint].kind {
        Kind::Continuous => true,
        Kind::Planar => robot.columns[q].part == 2,
        Kind::Fixed | Kind::Revolute | Kind::Prismatic | Kind::Floating => false,
    };
    (0..robot.columns.len())
        .filter(is_endless)
        .collect()
}

pub fn free_row(rng: &mut Rng, world: &World) -> Option<Vec<f64>> {
    (0..TRIES)
        .map(|_| row(rng, &world.robot))
        .find(|row| execute::is_free(world, row, row, CLEAR_M))
}

/// A wandering path; where it winds, its endless columns keep on turning one way.
pub fn walk(rng: &mut Rng, world: &World, waypoints: usize, winds: bool) -> Option<Made> {
    let mut rows = vec![free_row(rng, world)?];
    let way = pick(rng, &[1.0, -1.0]);
    for _ in 0..3 * waypoints {
        let last = rows.last().expect("a walk has a start");
        let next = step(rng, &world.robot, last, winds.then_some(way));
        if next != *last && execute::is_free(world, last, &next, CLEAR_M) {
            rows.push(next);
        }
        if rows.len() == waypoints {
            break;
        }
    }
    let kind = if winds { Step::Winding } else { Step::Walk };
    (rows.len() > 1).then(|| Made::new(rows, kind))
}

fn step(rng: &mut Rng, robot: &Robot, from: &[f64], way: Option<f64>) -> Vec<f64> {
    let mut row = from.to_vec();
    let endless = endless(robot);
    let stride = pick(rng, &[0.15, 0.4, 0.8]);
    for (q, column) in robot.columns.iter().enumerate() {
        let joint = &robot.joints[column.joint];
        let (lower, upper) = joint.bounds();
        let is_angle =
            matches!(joint.kind, Kind::Revolute | Kind::Continuous) || endless.contains(&q);
        let by = if is_angle { stride } else { 0.2 * stride };
        row[q] = match way {
            Some(way) if endless.contains(&q) => row[q] + way * uniform(rng, 0.3, 1.2),
            _ if one_in(rng, 3) => row[q],
            _ => (row[q] + uniform(rng, -by, by)).clamp(lower, upper),
        };
    }
    for q in turns(robot) {
        let old = [from[q], from[q + 1], from[q + 2], from[q + 3]];
        let by = uniform(rng, -stride, stride);
        row[q..q + 4].copy_from_slice(&turned(rng, old, by));
    }
    row
}

/// A quaternion turned by an angle about some axis of its own.
fn turned(rng: &mut Rng, q: Quaternion, by: f64) -> Quaternion {
    let axis = direction(rng);
    let (sine, w) = (0.5 * by).sin_cos();
    let [x, y, z] = axis.map(|a| a * sine);
    let [a, b, c, d] = q;
    normalised([
        d * x + a * w + b * z - c * y,
        d * y - a * z + b * w + c * x,
        d * z + a * y - b * x + c * w,
        d * w - a * x - b * y - c * z,
    ])
}

/// A straight line to anywhere, from where it is free.
pub fn blind(rng: &mut Rng, world: &World) -> Option<Made> {
    let from = free_row(rng, world)?;
    let mut to = row(rng, &world.robot);
    within_half_a_turn(rng, &world.robot, &from, &mut to);
    Some(Made::new(vec![from, to], Step::Blind))
}

/// Takes the numbers of endless columns to within half a turn.
fn within_half_a_turn(rng: &mut Rng, robot: &Robot, from: &[f64], to: &mut [f64]) {
    for q in endless(robot) {
        to[q] = from[q] + uniform(rng, -3.1, 3.1);
    }
}

/// A straight line from where it is free to where something is hit, or that place alone.
pub fn into(rng: &mut Rng, world: &World) -> Option<Made> {
    let (from, to) = hit(rng, world)?;
    let rows = if rng.bool() {
        vec![from, to]
    } else {
        vec![to.clone(), to]
    };
    Some(Made::new(rows, Step::Into))
}

/// A free row, and one where a body of those that are not links is hit by one other, if such a row
/// is found.
fn hit(rng: &mut Rng, world: &World) -> Option<(Vec<f64>, Vec<f64>)> {
    let from = free_row(rng, world)?;
    let objects: Vec<usize> = (0..world.bodies.len())
        .filter(|&body| !world.bodies[body].is_link)
        .collect();
    let target = some(rng, &objects);
    let mut any = None;
    for _ in 0..2 * TRIES {
        let mut to = row(rng, &world.robot);
        within_half_a_turn(rng, &world.robot, &from, &mut to);
        match execute::overlapping(world, &to).as_slice() {
            [] => {}
            [pair] if target.is_none_or(|target| pair.a == target || pair.b == target) => {
                return Some((from, to));
            }
            _ => any = any.or(Some(to)),
        }
    }
    any.map(|to| (from, to))
}

/// Where something is hit by hardly more than nothing, or missed by as much.
pub fn graze(rng: &mut Rng, world: &World) -> Option<Made> {
    let (from, to) = hit(rng, world)?;
    let mut free = 0.0;
    let mut hit = 1.0;
    let mut row = Vec::new();
    for _ in 0..20 {
        let t = 0.5 * (free + hit);
        execute::between(&world.robot, &from, &to, t, false, &mut row);
        if execute::overlapping(world, &row).is_empty() {
            free = t
        } else {
            hit = t
        }
    }
    let by = pick(rng, &[1e-5, 1e-4, 5e-4, 2e-3]) * if one_in(rng, 4) { -1.0 } else { 1.0 };
    execute::between(
        &world.robot,
        &from,
        &to,
        (hit + by).clamp(0.0, 1.0),
        false,
        &mut row,
    );
    Some(Made::new(vec![row.clone(), row], Step::Graze))
}

/// Half a turn of an endless column, as files have it.
pub fn half_turn(rng: &mut Rng, world: &World) -> Option<Made> {
    telling(rng, world, Step::HalfTurn, |rng, from| {
        let q = some(rng, &endless(&world.robot))?;
        let half = pick(rng, &[PI, cut(PI, 4), cut(PI, 5), f64::from(PI as f32)])
            * pick(rng, &[1.0, -1.0]);
        let quarter = pick(
            rng,
            &[FRAC_PI_2, cut(FRAC_PI_2, 4), f64::from(FRAC_PI_2 as f32)],
        ) * pick(rng, &[1.0, -1.0]);
        let (start, end) = match rng.usize(0..3) {
            0 => (quarter, -quarter),
            1 => (0.0, half),
            _ => (from[q], from[q] + half),
        };
        from[q] = start;
        Some((q, end))
    })
}

/// A step longer than half a turn of an endless column, or of one of those that are no angles if
/// `is_line`.
pub fn long(rng: &mut Rng, world: &World, is_line: bool) -> Option<Made> {
    let robot = &world.robot;
    let columns = endless(robot)
        .into_iter()
        .filter(|&q| !is_line || !robot.is_angle(robot.columns[q]));
    let columns: Vec<usize> = columns.collect();
    telling(rng, world, Step::Long, |rng, from| {
        let q = some(rng, &columns)?;
        let by = match rng.usize(0..4) {
            0 => TAU,
            1 => uniform(rng, 10.0, 40.0),
            _ => uniform(rng, 3.2, 9.0),
        };
        Some((q, from[q] + by * pick(rng, &[1.0, -1.0])))
    })
}

/// A step of one column to a number, which hits something while the same step some whole turns less
/// does not, if one is found: who goes the other way is then found out.
fn telling(
    rng: &mut Rng,
    world: &World,
    kind: Step,
    mut end: impl FnMut(&mut Rng, &mut Vec<f64>) -> Option<(usize, f64)>,
) -> Option<Made> {
    let mut any = None;
    for _ in 0..TELLING_TRIES {
        let mut from = free_row(rng, world)?;
        let (q, to_number) = end(rng, &mut from)?;
        let mut to = if rng.bool() {
            from.clone()
        } else {
            step(rng, &world.robot, &from, None)
        };
        to[q] = to_number;
        let mut other = to.clone();
        let turns = (to_number - from[q]) / TAU;
        other[q] -= TAU
            * if turns.abs() < 0.51 {
                turns.signum()
            } else {
                turns.round()
            };
        let is_telling = !execute::is_free(world, &from, &to, CLEAR_M)
            && execute::is_free(world, &from, &other, CLEAR_M);
        any = Some(Made::new(vec![from, to], kind));
        if is_telling {
            break;
        }
    }
    any
}

/// Orientations half a turn apart, exactly, nearly or to the last bits; if one is found, such that
/// something is hit on one of the two ways only.
pub fn half_quaternion(rng: &mut Rng, world: &World) -> Option<Made> {
    let floors = vec![CLEAR_M; world.pairs.len()];
    let mut any = None;
    for _ in 0..TELLING_TRIES {
        let rows = half_quaternion_rows(rng, world)?;
        let is_refuted = |is_said| {
            execute::path(world, &rows, &floors, is_said)
                .refutation
                .is_some()
        };
        let is_telling = is_refuted(false) && !is_refuted(true);
        any = Some(Made::new(rows, Step::HalfQuaternion));
        if is_telling {
            break;
        }
    }
    any
}

fn half_quaternion_rows(rng: &mut Rng, world: &World) -> Option<Vec<Vec<f64>>> {
    let mut from = free_row(rng, world)?;
    let q = some(rng, &turns(&world.robot))?;
    if rng.bool() {
        from[q..q + 4].copy_from_slice(&[0.0, 0.0, 0.0, 1.0]);
    }
    let old = [from[q], from[q + 1], from[q + 2], from[q + 3]];
    let mut to = from.clone();
    let by = PI + pick(rng, &[0.0, 0.0, 1e-3, -1e-3, 1e-6, -1e-6]);
    to[q..q + 4].copy_from_slice(&turned(rng, old, by));
    Some(vec![from, to])
}

/// A number as files have it, with so many digits after the point.
fn cut(number: f64, digits: i32) -> f64 {
    let unit = 10_f64.powi(digits);
    (number * unit).round() / unit
}

fn some(rng: &mut Rng, of: &[usize]) -> Option<usize> {
    (!of.is_empty()).then(|| pick(rng, of))
}

impl Made {
    fn new(rows: Vec<Vec<f64>>, step: Step) -> Self {
        Self {
            rows,
            steps: [step].into(),
            constraint: None,
        }
    }

    /// Makes it the line of a request that must not move some column far.
    pub fn constrain(&mut self, rng: &mut Rng) {
        let last = self.rows.len() - 1;
        self.rows = vec![self.rows[0].clone(), self.rows[last].clone()];
        self.constraint = Some(Constraint {
            column: rng.usize(0..self.rows[0].len()),
            tolerance: 0.05,
        });
    }

    /// Adds whole turns to angles of some waypoints, as planners that wrap do.
    pub fn rewind(&mut self, rng: &mut Rng, robot: &Robot) {
        let columns: Vec<usize> = endless(robot)
            .into_iter()
            .filter(|&q| robot.is_angle(robot.columns[q]))
            .collect();
        for row in &mut self.rows[1..] {
            for &q in &columns {
                row[q] += TAU * pick(rng, &[0.0, 0.0, 1.0, -1.0]);
            }
        }
        if !columns.is_empty() {
            self.steps.insert(Step::Rewound);
        }
    }

    /// Cuts digits off, within the limits.
    pub fn round(&mut self, rng: &mut Rng, robot: &Robot) {
        let to_four = rng.bool();
        let quaternions: Vec<usize> = turns(robot)
            .into_iter()
            .flat_map(|q| q..q + 4)
            .collect();
        for row in &mut self.rows {
            for (q, number) in row.iter_mut().enumerate() {
                let (lower, upper) = robot.joints[robot.columns[q].joint].bounds();
                let is_exact = to_four && !quaternions.contains(&q);
                let kept = if is_exact {
                    cut(*number, 4)
                } else {
                    f64::from(*number as f32)
                };
                *number = if quaternions.contains(&q) {
                    kept
                } else {
                    kept.clamp(lower, upper)
                };
            }
        }
        self.steps.insert(Step::Rounded);
    }

    /// Turns some quaternions to their other sign.
    pub fn flip(&mut self, rng: &mut Rng, robot: &Robot) {
        for q in turns(robot) {
            for row in &mut self.rows {
                if one_in(rng, 3) {
                    row[q..q + 4].iter_mut().for_each(|x| *x = -*x);
                    self.steps.insert(Step::Signs);
                }
            }
        }
    }
}
