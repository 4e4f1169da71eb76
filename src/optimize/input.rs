//! What is checked of a request before anything is computed, and the form that optimizers work on.

use std::f64::consts::PI;

use super::settings::Settings;
use crate::path::{Metric, MetricError, Path};
use crate::robot::configuration::shortest_arc;
use crate::robot::{Component, ConfigurationSpace, HeldVariable, RobotModel};
use crate::validation::path_proof::LEAST_FLOOR_M;
use crate::warning::Warning;

/// How far outside its limits a path may start (m or rad).
pub const LIMIT_TOLERANCE: f64 = 1e-4;
/// How far the norm of a quaternion may be from 1.
pub const QUATERNION_TOLERANCE: f64 = 1e-3;

/// A request that cannot be computed as it stands.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RequestError {
    /// Wrong number of columns.
    #[error("the path has {got} columns, robot {robot:?} has {expected} variables: {variables}")]
    Columns {
        /// Columns given.
        got: usize,
        /// Columns needed.
        expected: usize,
        /// Robot.
        robot: String,
        /// Its variables.
        variables: String,
    },
    /// A number that is not one.
    #[error("waypoint {waypoint}: {variable} is {value}; it must be finite")]
    NotFinite {
        /// Waypoint, from 0.
        waypoint: usize,
        /// Variable.
        variable: String,
        /// Value.
        value: f64,
    },
    /// A quaternion of the wrong norm.
    #[error(
        "waypoint {waypoint}: the quaternion that starts at {variable} has norm {norm}; it must be 1 within {QUATERNION_TOLERANCE}"
    )]
    Quaternion {
        /// Waypoint, from 0.
        waypoint: usize,
        /// First variable of the quaternion.
        variable: String,
        /// Its norm.
        norm: f64,
    },
    /// Limits exceeded.
    #[error("waypoint {waypoint}: {variable} is {value}, outside [{lower}, {upper}] by more than {LIMIT_TOLERANCE}")]
    Limits {
        /// Waypoint, from 0.
        waypoint: usize,
        /// Variable.
        variable: String,
        /// Value.
        value: f64,
        /// Lower limit.
        lower: f64,
        /// Upper limit.
        upper: f64,
    },
    /// Weights.
    #[error(transparent)]
    Metric(#[from] MetricError),
    /// A list of the wrong length.
    #[error("{what}: {got} entries given, {expected} needed")]
    Count {
        /// Which list.
        what: &'static str,
        /// Entries given.
        got: usize,
        /// Entries needed.
        expected: usize,
    },
    /// A clearance that cannot be promised.
    #[error("clearance {0} m; it must be finite and at least {LEAST_FLOOR_M} m")]
    Clearance(f64),
}

/// A checked request.
#[derive(Debug)]
pub(super) struct Input {
    pub space: ConfigurationSpace,
    pub metric: Metric,
    pub held: Vec<f64>,
    pub moving: Vec<bool>,
    /// The path as optimizers take it: no equal neighbours, unit quaternions, circles without jumps.
    pub path: Path,
    /// One entry per waypoint of `path`.
    pub fixed: Vec<bool>,
    /// For each waypoint of `path`, the caller's waypoint that it stands for.
    pub origins: Vec<usize>,
    /// For each of the caller's waypoints, the waypoint of `path` that stands for it.
    pub standing_for: Vec<usize>,
    pub warnings: Vec<Warning>,
}

impl Input {
    pub fn new(
        robot: &RobotModel,
        path: &Path,
        settings: &Settings,
        reach_weights: &[f64],
    ) -> Result<Self, RequestError> {
        check_columns(robot, path)?;
        let clearance = settings.clearance_m;
        if !(clearance.is_finite() && clearance >= LEAST_FLOOR_M) {
            return Err(RequestError::Clearance(clearance));
        }
        let space = if settings.unwrapped { robot.space().unwrapped() } else { robot.space().clone() };
        let metric = Metric::new(&space, settings.weights.clone().unwrap_or_else(|| reach_weights.to_vec()))?;
        let held = sized("held values", &settings.held, robot.held().len())?;
        let held = held.unwrap_or_else(|| robot.held().iter().map(|variable| variable.default).collect());
        if let Some(bad) = held.iter().position(|value| !value.is_finite()) {
            let variable = robot.held()[bad].name.clone();
            return Err(RequestError::NotFinite { waypoint: 0, variable, value: held[bad] });
        }
        let moving = sized("mask of moving coordinates", &settings.moving, space.nv())?;
        let moving = moving.unwrap_or_else(|| vec![true; space.nv()]);
        let fixed = sized("mask of fixed waypoints", &settings.fixed_waypoints, path.len())?;
        let mut fixed = fixed.unwrap_or_else(|| vec![false; path.len()]);
        fixed[0] = true;
        fixed[path.len() - 1] = true;
        let mut warnings = check_values(robot, path)?;
        warnings.extend(held_outside_limits(robot, &held));
        let Canonical { path, fixed, origins, standing_for } = Canonical::new(&space, path, &fixed, &mut warnings);
        Ok(Self { space, metric, held, moving, path, fixed, origins, standing_for, warnings })
    }
}

fn sized<T: Clone>(what: &'static str, list: &Option<Vec<T>>, expected: usize) -> Result<Option<Vec<T>>, RequestError> {
    match list {
        Some(list) if list.len() != expected => Err(RequestError::Count { what, got: list.len(), expected }),
        list => Ok(list.clone()),
    }
}

fn check_columns(robot: &RobotModel, path: &Path) -> Result<(), RequestError> {
    let expected = robot.space().nq();
    if path.nq() == expected {
        return Ok(());
    }
    let names: Vec<&str> = robot.variables().iter().map(|variable| variable.name.as_str()).collect();
    let (robot, variables) = (robot.name().to_owned(), names.join(", "));
    Err(RequestError::Columns { got: path.nq(), expected, robot, variables })
}

/// A warning for every held variable that the robot cannot hold where it is.
fn held_outside_limits(robot: &RobotModel, held: &[f64]) -> Vec<Warning> {
    let outside = robot
        .held()
        .iter()
        .zip(held)
        .filter(|(variable, value)| (variable.lower - **value).max(**value - variable.upper) > LIMIT_TOLERANCE);
    let text = |(variable, value): (&HeldVariable, &f64)| {
        let (name, lower, upper) = (&variable.name, variable.lower, variable.upper);
        Warning::uncovered(format!("{name} is held at {value}, outside [{lower}, {upper}]"))
    };
    outside.map(text).collect()
}

/// Checks every number; returns a warning where limits are exceeded by a little.
fn check_values(robot: &RobotModel, path: &Path) -> Result<Vec<Warning>, RequestError> {
    let mut worst: Option<(f64, String)> = None;
    for (waypoint, row) in path.waypoints().enumerate() {
        for (variable, &value) in robot.variables().iter().zip(row) {
            let name = || variable.name.clone();
            if !value.is_finite() {
                return Err(RequestError::NotFinite { waypoint, variable: name(), value });
            }
            let outside = (variable.lower - value).max(value - variable.upper);
            if outside > LIMIT_TOLERANCE {
                let (lower, upper) = (variable.lower, variable.upper);
                return Err(RequestError::Limits { waypoint, variable: name(), value, lower, upper });
            }
            if outside > 0.0 && worst.as_ref().is_none_or(|(most, _)| outside > *most) {
                let text = format!("waypoint {waypoint}: {} is outside its limits by {outside:.1e}", variable.name);
                worst = Some((outside, text));
            }
        }
        for component in robot.space().components() {
            if let Component::Rotation { q, .. } = *component {
                let norm = row[q..q + 4].iter().map(|x| x * x).sum::<f64>().sqrt();
                if (norm - 1.0).abs() > QUATERNION_TOLERANCE {
                    let variable = robot.variables()[q].name.clone();
                    return Err(RequestError::Quaternion { waypoint, variable, norm });
                }
            }
        }
    }
    Ok(worst.into_iter().map(|(_, text)| Warning::uncovered(text)).collect())
}

/// The form of a path that optimizers work on.
struct Canonical {
    path: Path,
    fixed: Vec<bool>,
    origins: Vec<usize>,
    standing_for: Vec<usize>,
}

impl Canonical {
    /// Drops neighbours that are equal (unless both are fixed), normalises quaternions, and writes each
    /// circle's values so that they follow each other without a jump.
    fn new(space: &ConfigurationSpace, path: &Path, fixed: &[bool], warnings: &mut Vec<Warning>) -> Self {
        let nq = space.nq();
        let mut rows: Vec<f64> = Vec::with_capacity(path.as_flat().len());
        let (mut kept, mut origins): (Vec<bool>, Vec<usize>) = (Vec::new(), Vec::new());
        let mut standing_for = Vec::with_capacity(path.len());
        let mut velocity = vec![0.0; space.nv()];
        for (index, waypoint) in path.waypoints().enumerate() {
            let previous = rows.len().checked_sub(nq).map(|start| &rows[start..]);
            let row = canonical_row(space, waypoint, previous);
            if let (Some(previous), Some(last)) = (previous, kept.last_mut()) {
                space.difference(&row, previous, &mut velocity);
                if velocity.iter().all(|v| *v == 0.0) && !(*last && fixed[index]) {
                    if fixed[index] {
                        (*last, origins[kept.len() - 1]) = (true, index);
                    }
                    standing_for.push(kept.len() - 1);
                    continue;
                }
            }
            rows.extend_from_slice(&row);
            standing_for.push(kept.len());
            kept.push(fixed[index]);
            origins.push(index);
        }
        warnings.extend(long_step(space, path));
        let path = Path::from_rows(nq, rows).expect("a path has at least one whole row");
        Self { path, fixed: kept, origins, standing_for }
    }
}

fn canonical_row(space: &ConfigurationSpace, waypoint: &[f64], previous: Option<&[f64]>) -> Vec<f64> {
    let mut row = waypoint.to_vec();
    for component in space.components() {
        match (*component, previous) {
            (Component::Rotation { q, .. }, _) => normalise(&mut row[q..q + 4]),
            (Component::Circle { q, .. }, Some(previous)) => {
                row[q] = previous[q] + shortest_arc(previous[q], waypoint[q]);
            }
            _ => {}
        }
    }
    row
}

/// A warning where the numbers of a continuous joint step by more than half a turn.
fn long_step(space: &ConfigurationSpace, path: &Path) -> Option<Warning> {
    let circles =
        || space.components().iter().filter_map(|c| if let Component::Circle { q, .. } = c { Some(*q) } else { None });
    let long = |k: &usize| circles().any(|q| (path.waypoint(*k)[q] - path.waypoint(k - 1)[q]).abs() > PI);
    (1..path.len()).find(long).map(|k| {
        Warning::uncovered(format!(
            "waypoint {k}: a continuous joint steps by more than half a turn; the short way round is taken \
             (use unwrapped to take the numbers as they stand)"
        ))
    })
}

fn normalise(quaternion: &mut [f64]) {
    let norm = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
    for x in quaternion {
        *x /= norm;
    }
}
