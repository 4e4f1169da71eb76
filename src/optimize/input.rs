//! What is checked of a request before anything is computed, and the form that optimizers work on.

use super::canonical::{Canonical, norm, rotations};
use super::outcome::ColumnTurns;
use super::request_error::{LIMIT_TOLERANCE, QUATERNION_TOLERANCE, RequestError};
use super::settings::Settings;
use super::steps::{check_motion, check_turns, keeps_goal};
use crate::collision::CollisionModel;
use crate::constraint::{Constraint, constraints};
use crate::path::{Metric, Path};
use crate::robot::configuration::turns_between;
use crate::robot::{ConfigurationSpace, HeldVariable, RobotModel, Variable};
use crate::validation::path_proof::LEAST_FLOOR_M;
use crate::warning::Warning;

/// A checked request.
#[derive(Debug)]
pub(super) struct Input {
    pub space: ConfigurationSpace,
    pub metric: Metric,
    pub keep_goal: bool,
    pub held: Vec<f64>,
    /// What the path must keep besides clearances.
    pub constraints: Vec<Constraint>,
    pub moving: Vec<bool>,
    /// The caller's path with each angle's numbers saying how it moves; `None` where they do as
    /// they stand.
    pub unrolled: Option<Path>,
    /// The path as optimizers take it: unrolled, no equal neighbours, unit quaternions.
    pub path: Path,
    /// One entry per waypoint of `path`.
    pub fixed: Vec<bool>,
    /// The caller's rows of the fixed ones, laid end to end.
    pub fixed_rows: Vec<f64>,
    /// For each waypoint of `path`, the caller's waypoint that it stands for.
    pub origins: Vec<usize>,
    /// For each of the caller's waypoints, the waypoint of `path` that stands for it.
    pub standing_for: Vec<usize>,
    pub warnings: Vec<Warning>,
}

impl Input {
    pub fn new(
        model: &CollisionModel,
        path: &Path,
        settings: &Settings,
        reach_weights: &[f64],
    ) -> Result<Self, RequestError> {
        let robot = model.robot();
        check_columns(robot, path)?;
        check_clearance(settings.clearance_m)?;
        let space = space(robot, settings.unwrapped);
        let weights = settings.weights.clone();
        let metric = Metric::new(&space, weights.unwrap_or_else(|| reach_weights.to_vec()))?;
        let held = held_values(robot, settings)?;
        let constraints = constraints_of(model, settings)?;
        let moving = sized("mask of moving coordinates", &settings.moving, space.nv())?;
        let moving = moving.unwrap_or_else(|| vec![true; space.nv()]);
        let fixed = fixed_waypoints(settings, path.len())?;
        let mut warnings = check_values(robot, path)?;
        warnings.extend(held_outside_limits(robot, &held));
        warnings.extend(settings.constraints.warnings());
        check_turns(robot, &space, path)?;
        check_motion(robot, &space, path)?;
        let unrolled = unrolled(&space, path);
        if let Some(unrolled) = unrolled.as_ref().filter(|_| settings.keep_goal) {
            keeps_goal(robot, &space, path, unrolled)?;
        }
        let canonical = Canonical::new(&space, unrolled.as_ref().unwrap_or(path), &fixed);
        Ok(Self {
            space,
            metric,
            keep_goal: settings.keep_goal,
            held,
            constraints,
            moving,
            unrolled,
            fixed_rows: canonical.fixed_rows(path),
            path: canonical.path,
            fixed: canonical.fixed,
            origins: canonical.origins,
            standing_for: canonical.standing_for,
            warnings,
        })
    }
}

impl Input {
    /// The caller's waypoints with numbers that say how they are moved between.
    pub fn given<'a>(&'a self, path: &'a Path) -> &'a Path {
        self.unrolled.as_ref().unwrap_or(path)
    }

    /// Length of the path that optimizers work on.
    pub fn length(&self) -> f64 {
        let mut velocity = vec![0.0; self.space.nv()];
        self.metric
            .length(&self.space, self.path.as_flat(), &mut velocity)
    }

    /// Columns of which the answer says other numbers than the caller, and how many whole turns the
    /// goal's is on; 0 where it is the same and only numbers before it moved.
    pub fn turned(&self, robot: &RobotModel, path: &Path, answer: &Path) -> Vec<ColumnTurns> {
        let goal = path.waypoint(path.len() - 1);
        let end = answer.waypoint(answer.len() - 1);
        let column = |q: usize| {
            let turns = turns_between(goal[q], end[q]);
            (turns != 0 || self.is_unrolled(path, q)).then(|| ColumnTurns {
                variable: robot.variables()[q].name.clone(),
                turns,
            })
        };
        self.space
            .circles()
            .filter_map(column)
            .collect()
    }

    /// Whether numbers of a column had to move for them to say how it moves.
    fn is_unrolled(&self, path: &Path, q: usize) -> bool {
        let mut waypoints = self
            .given(path)
            .waypoints()
            .zip(path.waypoints());
        waypoints.any(|(a, b)| a[q] != b[q])
    }
}

/// Distance of the ends of a path: none between them is shorter. Unless the goal's numbers are to
/// stay, a path may end whole turns away.
pub fn lower_bound(
    space: &ConfigurationSpace,
    metric: &Metric,
    path: &Path,
    keep_goal: bool,
) -> f64 {
    let start = path.waypoint(0);
    let goal = path.waypoint(path.len() - 1);
    let mut velocity = vec![0.0; space.nv()];
    if keep_goal {
        space
            .unwrapped()
            .difference(goal, start, &mut velocity);
    } else {
        space.shortest_difference(goal, start, &mut velocity);
    }
    metric.norm(&velocity)
}

fn sized<T: Clone>(
    what: &'static str,
    list: &Option<Vec<T>>,
    expected: usize,
) -> Result<Option<Vec<T>>, RequestError> {
    match list {
        Some(list) if list.len() != expected => Err(RequestError::Count {
            what,
            got: list.len(),
            expected,
        }),
        list => Ok(list.clone()),
    }
}

fn check_columns(robot: &RobotModel, path: &Path) -> Result<(), RequestError> {
    let expected = robot.space().nq();
    if path.nq() == expected {
        return Ok(());
    }
    let variables = robot.variables().iter();
    let names: Vec<&str> = variables
        .map(|variable| variable.name.as_str())
        .collect();
    Err(RequestError::Columns {
        got: path.nq(),
        expected,
        robot: robot.name().to_owned(),
        variables: names.join(", "),
    })
}

/// What the path must keep besides clearances.
fn constraints_of(
    model: &CollisionModel,
    settings: &Settings,
) -> Result<Vec<Constraint>, RequestError> {
    let constraints = constraints(&settings.constraints, model.robot(), model.scene())?;
    match settings.corridor && !constraints.is_empty() {
        true => Err(RequestError::WithConstraints { what: "a corridor" }),
        false => Ok(constraints),
    }
}

fn check_clearance(clearance: f64) -> Result<(), RequestError> {
    if clearance.is_finite() && clearance >= LEAST_FLOOR_M {
        Ok(())
    } else {
        Err(RequestError::Clearance(clearance))
    }
}

fn space(robot: &RobotModel, unwrapped: bool) -> ConfigurationSpace {
    match unwrapped {
        true => robot.space().unwrapped(),
        false => robot.space().clone(),
    }
}

/// Where the held variables stand: as the request says, else at their defaults.
fn held_values(robot: &RobotModel, settings: &Settings) -> Result<Vec<f64>, RequestError> {
    let defaults = || {
        robot
            .held()
            .iter()
            .map(|variable| variable.default)
            .collect()
    };
    let held = sized("held values", &settings.held, robot.held().len())?;
    let held: Vec<f64> = held.unwrap_or_else(defaults);
    check_held(robot, &held)?;
    Ok(held)
}

fn check_held(robot: &RobotModel, held: &[f64]) -> Result<(), RequestError> {
    for (variable, &value) in robot.held().iter().zip(held) {
        if !value.is_finite() {
            let variable = variable.name.clone();
            return Err(RequestError::NotFinite {
                waypoint: 0,
                variable,
                value,
            });
        }
    }
    Ok(())
}

/// Which waypoints stay as they are: those that the request says, and the two ends.
fn fixed_waypoints(settings: &Settings, count: usize) -> Result<Vec<bool>, RequestError> {
    let fixed = sized("mask of fixed waypoints", &settings.fixed_waypoints, count)?;
    let mut fixed = fixed.unwrap_or_else(|| vec![false; count]);
    fixed[0] = true;
    fixed[count - 1] = true;
    Ok(fixed)
}

/// A path whose numbers say how it moves, where those given do not.
fn unrolled(space: &ConfigurationSpace, path: &Path) -> Option<Path> {
    space.circles().next()?;
    let mut rows = path.as_flat().to_vec();
    space
        .unroll(&mut rows)
        .then(|| Path::from_rows(path.nq(), rows))?
}

/// A warning for every held variable that the robot cannot hold where it is.
fn held_outside_limits(robot: &RobotModel, held: &[f64]) -> Vec<Warning> {
    let values = robot.held().iter().zip(held);
    let text = |(variable, value): (&HeldVariable, &f64)| held_outside(variable, *value);
    values
        .filter_map(text)
        .map(Warning::uncovered)
        .collect()
}

fn held_outside(variable: &HeldVariable, value: f64) -> Option<String> {
    let HeldVariable {
        name,
        lower,
        upper,
        hard_lower,
        hard_upper,
        ..
    } = variable;
    let is_outside = |lower: f64, upper: f64| outside(value, lower, upper) > LIMIT_TOLERANCE;
    if is_outside(*hard_lower, *hard_upper) {
        return Some(format!(
            "{name} is held at {value}, outside [{hard_lower}, {hard_upper}]"
        ));
    }
    is_outside(*lower, *upper)
        .then(|| format!("{name} is held at {value}, outside its soft limits [{lower}, {upper}]"))
}

/// How far a value is outside its limits; not positive inside.
fn outside(value: f64, lower: f64, upper: f64) -> f64 {
    (lower - value).max(value - upper)
}

/// Checks every number; returns a warning where limits are exceeded by a little, and one where soft
/// limits are.
fn check_values(robot: &RobotModel, path: &Path) -> Result<Vec<Warning>, RequestError> {
    let mut farthest = Farthest::default();
    for (waypoint, row) in path.waypoints().enumerate() {
        for (variable, &value) in robot.variables().iter().zip(row) {
            let outside = check_value(waypoint, variable, value)?;
            farthest.see(waypoint, variable, outside);
        }
        check_rotations(robot, waypoint, row)?;
    }
    let just_outside = farthest.text.map(Warning::uncovered);
    Ok(just_outside
        .into_iter()
        .chain(outside_soft_limits(robot, path))
        .collect())
}

/// The value that is farthest outside its limits.
#[derive(Default)]
struct Farthest {
    by: f64,
    text: Option<String>,
}

impl Farthest {
    fn see(&mut self, waypoint: usize, variable: &Variable, by: f64) {
        if by > self.by {
            self.by = by;
            let name = &variable.name;
            self.text = Some(format!(
                "waypoint {waypoint}: {name} is outside its limits by {by:.1e}"
            ));
        }
    }
}

/// How far a value is outside its limits, which may be a little.
fn check_value(waypoint: usize, variable: &Variable, value: f64) -> Result<f64, RequestError> {
    let name = || variable.name.clone();
    if !value.is_finite() {
        return Err(RequestError::NotFinite {
            waypoint,
            variable: name(),
            value,
        });
    }
    let lower = variable.hard_lower;
    let upper = variable.hard_upper;
    match outside(value, lower, upper) {
        outside if outside > LIMIT_TOLERANCE => Err(RequestError::Limits {
            waypoint,
            variable: name(),
            value,
            lower,
            upper,
        }),
        outside => Ok(outside),
    }
}

fn check_rotations(robot: &RobotModel, waypoint: usize, row: &[f64]) -> Result<(), RequestError> {
    for q in rotations(robot.space()) {
        let norm = norm(&row[q..q + 4]);
        if (norm - 1.0).abs() > QUATERNION_TOLERANCE {
            let variable = robot.variables()[q].name.clone();
            return Err(RequestError::Quaternion {
                waypoint,
                variable,
                norm,
            });
        }
    }
    Ok(())
}

/// One warning that names each variable which is somewhere between its soft limits and its limits,
/// and by how much at most. No optimizer moves it further out.
fn outside_soft_limits(robot: &RobotModel, path: &Path) -> Option<Warning> {
    let variables = robot.variables().iter().enumerate();
    let soft = variables.filter(|(_, variable)| variable.has_soft_limits());
    let named: Vec<String> = soft
        .filter_map(|(column, variable)| farthest_outside(path, column, variable))
        .collect();
    let text = "the path leaves soft limits (safety_controller), and is not moved further out";
    (!named.is_empty()).then(|| Warning::uncovered(format!("{text}: {}", named.join(", "))))
}

/// By how much, and where, a column is farthest outside the limits of its variable.
fn farthest_outside(path: &Path, column: usize, variable: &Variable) -> Option<String> {
    let Variable {
        name, lower, upper, ..
    } = variable;
    let by = |row: &[f64]| outside(row[column], *lower, *upper);
    let (waypoint, by) = path
        .waypoints()
        .map(by)
        .enumerate()
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    (by > 0.0).then(|| {
        format!(
            "{name} by {} of [{lower}, {upper}] (waypoint {waypoint})",
            amount(by)
        )
    })
}

fn amount(by: f64) -> String {
    if by < 1e-3 {
        format!("{by:.1e}")
    } else {
        format!("{by:.3}")
    }
}
