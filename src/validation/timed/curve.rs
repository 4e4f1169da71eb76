//! What a controller makes of a trajectory's points: between two of them a polynomial of time.
//!
//! As ros2_control's `joint_trajectory_controller` does it: straight where a point of the two has
//! no velocities, cubic where both have velocities, quintic where both have accelerations too.
//! Columns are taken as they stand: a controller does not know which joints turn all the way round.

use std::ops::Range;

use crate::robot::{Component, RobotModel, Variable};
use crate::validation::Interpolation;
use crate::validation::polynomial::{Knot, Polynomial};

/// How far the norm of a quaternion may be from 1.
const NORM_TOLERANCE: f64 = 1e-3;

/// A point of a timed trajectory: one number per column, or none where it says nothing of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Point {
    /// When, from the trajectory's start (s).
    pub time_s: f64,
    /// m or rad.
    pub positions: Vec<f64>,
    /// Per second; may be empty.
    pub velocities: Vec<f64>,
    /// Per second squared; may be empty.
    pub accelerations: Vec<f64>,
}

/// A trajectory that no controller can execute as it stands, or of which nothing can be proved.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CurveError {
    /// Fewer than two points.
    #[error("the trajectory has {0} points; it needs at least 2")]
    Points(usize),
    /// A list of the wrong length.
    #[error("point {point}: {got} {what} given, {expected} needed")]
    Count {
        /// Point, from 0.
        point: usize,
        /// Which list.
        what: &'static str,
        /// Numbers given.
        got: usize,
        /// Numbers needed.
        expected: usize,
    },
    /// A number that is not one.
    #[error("point {point}: {what} hold {value}; they must be finite")]
    NotFinite {
        /// Point, from 0.
        point: usize,
        /// Which list.
        what: &'static str,
        /// The number.
        value: f64,
    },
    /// Time that stands still or runs back.
    #[error(
        "point {point}: its time is {time_s} s, that of the point before {before_s} s; times must grow"
    )]
    Time {
        /// Point, from 0.
        point: usize,
        /// Its time (s).
        time_s: f64,
        /// The one before (s).
        before_s: f64,
    },
    /// Accelerations without velocities.
    #[error(
        "point {0}: it has accelerations but no velocities; a controller does not say what it makes of that"
    )]
    Accelerations(usize),
    /// A quaternion of the wrong norm.
    #[error(
        "the quaternion that starts at {variable} has norm {norm}; it must be 1 within {NORM_TOLERANCE}"
    )]
    Quaternion {
        /// First variable of the quaternion.
        variable: String,
        /// Its norm.
        norm: f64,
    },
    /// A quaternion that moves.
    #[error(
        "point {point}: the quaternion that starts at {variable} turns; only joints of one value can be timed"
    )]
    Rotation {
        /// Point, from 0.
        point: usize,
        /// First variable of the quaternion.
        variable: String,
    },
}

/// A timed trajectory as it is executed.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Time of each point (s).
    times: Vec<f64>,
    /// For each segment a polynomial per column.
    polynomials: Vec<Vec<Polynomial>>,
    /// Of each segment, whether it is straight because its points have no velocities.
    straight: Vec<bool>,
    /// What the first point says of velocities.
    start_velocities: Vec<f64>,
    /// For each column its velocity coordinate; `None` for a quaternion, which stands still.
    coordinates: Vec<Option<usize>>,
    nv: usize,
}

/// Where a trajectory is farthest outside a variable's limits.
#[derive(Clone, Debug, PartialEq)]
pub struct Outside {
    /// The point before it, from 0.
    pub point: usize,
    /// When (s).
    pub time_s: f64,
    /// Index of the variable.
    pub column: usize,
    /// Its value (m or rad).
    pub value: f64,
    /// How far that is outside (m or rad).
    pub by: f64,
}

impl Curve {
    /// The curve through points whose columns are the robot's variables.
    ///
    /// # Errors
    /// Lists of the wrong length, numbers that are not finite, times that do not grow, a quaternion
    /// that moves.
    pub fn new(robot: &RobotModel, points: &[Point]) -> Result<Self, CurveError> {
        let space = robot.space();
        let mut curve = Self::of_lines(space.nq(), points)?;
        curve.nv = space.nv();
        for component in space.components() {
            match *component {
                Component::Line { q, v } | Component::Circle { q, v } => {
                    curve.coordinates[q] = Some(v)
                }
                Component::Rotation { q, .. } => {
                    check_still(robot, points, q)?;
                    curve.stand_still(q, &unit(robot, &points[0].positions, q)?);
                }
            }
        }
        Ok(curve)
    }

    /// The quaternion that starts at a column stands still.
    fn stand_still(&mut self, q: usize, standing: &[Polynomial; 4]) {
        let segments = self.polynomials.iter_mut();
        segments.for_each(|columns| columns[q..q + 4].copy_from_slice(standing));
        self.coordinates[q..q + 4].fill(None);
    }

    /// The curve through points whose columns are all joints of one value.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of_lines(columns: usize, points: &[Point]) -> Result<Self, CurveError> {
        if points.len() < 2 {
            return Err(CurveError::Points(points.len()));
        }
        let mut before_s = f64::NEG_INFINITY;
        for (index, point) in points.iter().enumerate() {
            check(index, point, columns)?;
            check_time(index, point.time_s, before_s)?;
            before_s = point.time_s;
        }
        let segments = points.windows(2);
        let is_straight = |ends: &[Point]| !both_say([&ends[0].velocities, &ends[1].velocities]);
        Ok(Self {
            start_velocities: points[0].velocities.clone(),
            straight: segments.clone().map(is_straight).collect(),
            times: points
                .iter()
                .map(|point| point.time_s)
                .collect(),
            polynomials: segments
                .map(|ends| between(&ends[0], &ends[1]))
                .collect(),
            coordinates: (0..columns).map(Some).collect(),
            nv: columns,
        })
    }

    /// Columns.
    pub fn columns(&self) -> usize {
        self.coordinates.len()
    }
    /// Pairs of points that follow each other, at least one.
    pub fn segments(&self) -> usize {
        self.polynomials.len()
    }
    /// Time of a point (s).
    pub fn time(&self, point: usize) -> f64 {
        self.times[point]
    }
    /// Time from a point to the next (s).
    pub fn duration(&self, point: usize) -> f64 {
        self.times[point + 1] - self.times[point]
    }
    /// Time at a ratio of the way from a point to the next (s).
    pub fn time_of(&self, point: usize, ratio: f64) -> f64 {
        self.times[point] + ratio * self.duration(point)
    }
    /// From the first point to the last (s).
    pub fn total_s(&self) -> f64 {
        self.times[self.times.len() - 1] - self.times[0]
    }

    /// What a column does after a point, by time (s).
    pub fn column(&self, point: usize, column: usize) -> &Polynomial {
        &self.polynomials[point][column]
    }

    /// Whether a segment is straight because a point of the two has no velocities.
    pub fn is_straight(&self, point: usize) -> bool {
        self.straight[point]
    }

    /// The velocity of a column that the first point says, else 0 (per second).
    pub fn start_velocity(&self, column: usize) -> f64 {
        let said = self.start_velocities.get(column);
        said.copied().unwrap_or(0.0)
    }

    /// Whether a column moves.
    pub fn moves(&self, column: usize) -> bool {
        let columns = self.polynomials.iter();
        columns
            .map(|columns| &columns[column])
            .any(|column| !column.is_constant())
    }

    /// The configuration so many seconds after a point.
    pub fn at(&self, point: usize, t: f64) -> Vec<f64> {
        let columns = self.polynomials[point].iter();
        columns
            .map(|polynomial| polynomial.at(t))
            .collect()
    }

    /// The columns of each segment, by the ratio of the time from its point to the next.
    pub(super) fn by_ratio(&self) -> Vec<Vec<Polynomial>> {
        let segments = self.polynomials.iter().enumerate();
        segments
            .map(|(point, columns)| {
                let duration = self.duration(point);
                let columns = columns.iter();
                columns
                    .map(|column| column.stretch(0.0, duration))
                    .collect()
            })
            .collect()
    }

    /// e_j of a piece between two times after a point, for each velocity coordinate (m or rad).
    pub fn deviations(&self, point: usize, from: f64, to: f64) -> Vec<f64> {
        let share = (to - from).powi(2) / 8.0 * (1.0 + 1e-9);
        self.per_coordinate(point, |polynomial| {
            share
                * polynomial
                    .derivative()
                    .derivative()
                    .largest(from, to)
        })
    }

    fn per_coordinate(&self, point: usize, of: impl Fn(&Polynomial) -> f64) -> Vec<f64> {
        let mut values = vec![0.0; self.nv];
        for (polynomial, coordinate) in self.polynomials[point]
            .iter()
            .zip(&self.coordinates)
        {
            if let Some(coordinate) = *coordinate {
                values[coordinate] = of(polynomial);
            }
        }
        values
    }

    /// Where it is farthest outside the limits, if it is anywhere.
    pub fn outside(&self, robot: &RobotModel) -> Option<Outside> {
        self.farthest(robot, |variable| (variable.hard_lower, variable.hard_upper))
    }

    /// Where it is farthest outside the soft limits, if it is anywhere.
    pub fn outside_soft(&self, robot: &RobotModel) -> Option<Outside> {
        self.farthest(robot, |variable| (variable.lower, variable.upper))
    }

    fn farthest(
        &self,
        robot: &RobotModel,
        limits: impl Fn(&Variable) -> (f64, f64),
    ) -> Option<Outside> {
        let mut worst: Option<Outside> = None;
        for point in 0..self.segments() {
            for (column, variable) in robot.variables().iter().enumerate() {
                for outside in self.outside_of(point, column, limits(variable)) {
                    if outside.by > worst.as_ref().map_or(0.0, |worst| worst.by) {
                        worst = Some(outside);
                    }
                }
            }
        }
        worst
    }

    /// Where a column is least and greatest after a point, and how far outside of limits that is.
    fn outside_of(&self, point: usize, column: usize, limits: (f64, f64)) -> [Outside; 2] {
        let (lower, upper) = limits;
        let polynomial = &self.polynomials[point][column];
        polynomial
            .extremes(0.0, self.duration(point))
            .map(|(value, t)| Outside {
                point,
                time_s: self.times[point] + t,
                column,
                value,
                by: (lower - value).max(value - upper),
            })
    }
}

fn check(index: usize, point: &Point, expected: usize) -> Result<(), CurveError> {
    check_list(index, "positions", &point.positions, expected)?;
    for (what, list) in [
        ("velocities", &point.velocities),
        ("accelerations", &point.accelerations),
    ] {
        if !list.is_empty() {
            check_list(index, what, list, expected)?;
        }
    }
    check_finite(index, "times", point.time_s)?;
    let says_nothing = point.velocities.is_empty() && !point.accelerations.is_empty();
    if says_nothing {
        Err(CurveError::Accelerations(index))
    } else {
        Ok(())
    }
}

fn check_list(
    point: usize,
    what: &'static str,
    list: &[f64],
    expected: usize,
) -> Result<(), CurveError> {
    let got = list.len();
    if got != expected {
        return Err(CurveError::Count {
            point,
            what,
            got,
            expected,
        });
    }
    list.iter()
        .try_for_each(|value| check_finite(point, what, *value))
}

fn check_finite(point: usize, what: &'static str, value: f64) -> Result<(), CurveError> {
    match value.is_finite() {
        true => Ok(()),
        false => Err(CurveError::NotFinite { point, what, value }),
    }
}

fn check_time(point: usize, time_s: f64, before_s: f64) -> Result<(), CurveError> {
    match time_s <= before_s {
        true => Err(CurveError::Time {
            point,
            time_s,
            before_s,
        }),
        false => Ok(()),
    }
}

/// A quaternion is no joint of one value: what lies between two of them a controller does not say.
fn check_still(robot: &RobotModel, points: &[Point], q: usize) -> Result<(), CurveError> {
    let is_still = |point: &Point| stands_at(point, &points[0].positions, q);
    match points.iter().position(|point| !is_still(point)) {
        None => Ok(()),
        Some(point) => Err(CurveError::Rotation {
            point,
            variable: robot.variables()[q].name.clone(),
        }),
    }
}

/// Whether the quaternion that starts at a column stands where it does in `positions`.
fn stands_at(point: &Point, positions: &[f64], q: usize) -> bool {
    let columns = q..q + 4;
    point.positions[columns.clone()] == positions[columns.clone()]
        && says_still(&point.velocities, columns.clone())
        && says_still(&point.accelerations, columns)
}

/// Whether a list of rates says 0 of these columns, or nothing.
fn says_still(rates: &[f64], columns: Range<usize>) -> bool {
    let rates = rates.get(columns);
    rates.is_none_or(|rates| rates.iter().all(|rate| *rate == 0.0))
}

/// The quaternion that starts at a column, as four columns that stand still.
fn unit(robot: &RobotModel, positions: &[f64], q: usize) -> Result<[Polynomial; 4], CurveError> {
    let quaternion = &positions[q..q + 4];
    let norm = quaternion
        .iter()
        .map(|x| x * x)
        .sum::<f64>()
        .sqrt();
    if (norm - 1.0).abs() > NORM_TOLERANCE {
        let variable = robot.variables()[q].name.clone();
        return Err(CurveError::Quaternion { variable, norm });
    }
    Ok(std::array::from_fn(|k| {
        Polynomial::constant(quaternion[k] / norm)
    }))
}

fn between(a: &Point, b: &Point) -> Vec<Polynomial> {
    let make = match interpolation(a, b) {
        Interpolation::Linear => Polynomial::linear,
        Interpolation::Cubic => Polynomial::cubic,
        Interpolation::Quintic => Polynomial::quintic,
    };
    let duration = b.time_s - a.time_s;
    let columns = 0..a.positions.len();
    columns
        .map(|column| make(a.knot(column), b.knot(column), duration))
        .collect()
}

/// What a controller interpolates two points by, after what both of them say.
pub(super) fn interpolation(a: &Point, b: &Point) -> Interpolation {
    if !both_say([&a.velocities, &b.velocities]) {
        Interpolation::Linear
    } else if !both_say([&a.accelerations, &b.accelerations]) {
        Interpolation::Cubic
    } else {
        Interpolation::Quintic
    }
}

fn both_say(lists: [&Vec<f64>; 2]) -> bool {
    lists.iter().all(|list| !list.is_empty())
}

impl Point {
    /// What it says of a column; 0 of what it says nothing of.
    fn knot(&self, column: usize) -> Knot {
        Knot {
            position: self.positions[column],
            velocity: self
                .velocities
                .get(column)
                .copied()
                .unwrap_or(0.0),
            acceleration: self
                .accelerations
                .get(column)
                .copied()
                .unwrap_or(0.0),
        }
    }
}
