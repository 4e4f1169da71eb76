//! What a controller makes of a trajectory's points: between two of them a polynomial of time.
//!
//! As ros2_control's `joint_trajectory_controller` does it: straight where a point of the two has
//! no velocities, cubic where both have velocities, quintic where both have accelerations too.
//! Columns are taken as they stand: a controller does not know which joints turn all the way round.

use super::polynomial::{Knot, Polynomial};
use crate::robot::{Component, RobotModel, Variable};

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
                    let standing = unit(robot, &points[0].positions, q)?;
                    curve
                        .polynomials
                        .iter_mut()
                        .for_each(|columns| columns[q..q + 4].copy_from_slice(&standing));
                    curve.coordinates[q..q + 4].fill(None);
                }
            }
        }
        Ok(curve)
    }

    /// The curve through points whose columns are all joints of one value.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of_lines(columns: usize, points: &[Point]) -> Result<Self, CurveError> {
        if points.len() < 2 {
            return Err(CurveError::Points(points.len()));
        }
        for (index, point) in points.iter().enumerate() {
            check(index, point, columns)?;
            let before_s = index
                .checked_sub(1)
                .map_or(f64::NEG_INFINITY, |before| points[before].time_s);
            if point.time_s <= before_s {
                return Err(CurveError::Time {
                    point: index,
                    time_s: point.time_s,
                    before_s,
                });
            }
        }
        let times = points.iter().map(|point| point.time_s).collect();
        let polynomials = points
            .windows(2)
            .map(|ends| between(&ends[0], &ends[1]))
            .collect();
        Ok(Self {
            times,
            polynomials,
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
    /// From the first point to the last (s).
    pub fn total_s(&self) -> f64 {
        self.times[self.times.len() - 1] - self.times[0]
    }

    /// The configuration so many seconds after a point.
    pub fn at(&self, point: usize, t: f64) -> Vec<f64> {
        self.polynomials[point]
            .iter()
            .map(|polynomial| polynomial.at(t))
            .collect()
    }

    /// Least and greatest value of each column on the whole curve.
    pub fn ranges(&self) -> Vec<[f64; 2]> {
        let of_column = |column: usize| {
            let extremes = (0..self.segments())
                .map(|point| self.polynomials[point][column].extremes(0.0, self.duration(point)));
            extremes.fold(
                [f64::INFINITY, f64::NEG_INFINITY],
                |[low, high], [(least, _), (most, _)]| [low.min(least), high.max(most)],
            )
        };
        (0..self.columns()).map(of_column).collect()
    }

    /// e_j of a piece between two times after a point, for each velocity coordinate (m or rad).
    pub fn deviations(&self, point: usize, from: f64, to: f64) -> Vec<f64> {
        let share = (to - from).powi(2) / 8.0 * (1.0 + 1e-9);
        self.per_coordinate(point, |polynomial| {
            share * polynomial.derivative().derivative().largest(from, to)
        })
    }

    /// The greatest speed of each velocity coordinate between two times after a point (m or rad per
    /// s).
    pub fn speeds(&self, point: usize, from: f64, to: f64) -> Vec<f64> {
        self.per_coordinate(point, |polynomial| {
            polynomial.derivative().largest(from, to)
        })
    }

    fn per_coordinate(&self, point: usize, of: impl Fn(&Polynomial) -> f64) -> Vec<f64> {
        let mut values = vec![0.0; self.nv];
        for (polynomial, coordinate) in self.polynomials[point].iter().zip(&self.coordinates) {
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
        for (point, polynomials) in self.polynomials.iter().enumerate() {
            for (column, (polynomial, variable)) in
                polynomials.iter().zip(robot.variables()).enumerate()
            {
                let (lower, upper) = limits(variable);
                for (value, t) in polynomial.extremes(0.0, self.duration(point)) {
                    let by = (lower - value).max(value - upper);
                    if by > worst.as_ref().map_or(0.0, |worst| worst.by) {
                        worst = Some(Outside {
                            point,
                            time_s: self.times[point] + t,
                            column,
                            value,
                            by,
                        });
                    }
                }
            }
        }
        worst
    }
}

fn check(index: usize, point: &Point, expected: usize) -> Result<(), CurveError> {
    let lists = [
        ("positions", &point.positions, false),
        ("velocities", &point.velocities, true),
        ("accelerations", &point.accelerations, true),
    ];
    for (what, list, may_be_empty) in lists {
        if list.len() != expected && !(may_be_empty && list.is_empty()) {
            return Err(CurveError::Count {
                point: index,
                what,
                got: list.len(),
                expected,
            });
        }
        if let Some(&value) = list.iter().find(|value| !value.is_finite()) {
            return Err(CurveError::NotFinite {
                point: index,
                what,
                value,
            });
        }
    }
    if !point.time_s.is_finite() {
        return Err(CurveError::NotFinite {
            point: index,
            what: "times",
            value: point.time_s,
        });
    }
    let says_nothing = point.velocities.is_empty() && !point.accelerations.is_empty();
    if says_nothing {
        Err(CurveError::Accelerations(index))
    } else {
        Ok(())
    }
}

/// A quaternion is no joint of one value: what lies between two of them a controller does not say.
fn check_still(robot: &RobotModel, points: &[Point], q: usize) -> Result<(), CurveError> {
    let columns = q..q + 4;
    let is_still = |point: &Point| {
        let rates = [&point.velocities, &point.accelerations];
        point.positions[columns.clone()] == points[0].positions[columns.clone()]
            && rates.iter().all(|list| {
                list.get(columns.clone())
                    .is_none_or(|list| list.iter().all(|rate| *rate == 0.0))
            })
    };
    match points.iter().position(|point| !is_still(point)) {
        None => Ok(()),
        Some(point) => Err(CurveError::Rotation {
            point,
            variable: robot.variables()[q].name.clone(),
        }),
    }
}

/// The quaternion that starts at a column, as four columns that stand still.
fn unit(robot: &RobotModel, positions: &[f64], q: usize) -> Result<[Polynomial; 4], CurveError> {
    let norm = positions[q..q + 4]
        .iter()
        .map(|x| x * x)
        .sum::<f64>()
        .sqrt();
    if (norm - 1.0).abs() > NORM_TOLERANCE {
        return Err(CurveError::Quaternion {
            variable: robot.variables()[q].name.clone(),
            norm,
        });
    }
    Ok(std::array::from_fn(|k| {
        Polynomial::constant(positions[q + k] / norm)
    }))
}

fn between(a: &Point, b: &Point) -> Vec<Polynomial> {
    let both = |list: fn(&Point) -> &Vec<f64>| !list(a).is_empty() && !list(b).is_empty();
    let make = match (
        both(|point| &point.velocities),
        both(|point| &point.accelerations),
    ) {
        (false, _) => Polynomial::linear,
        (true, false) => Polynomial::cubic,
        (true, true) => Polynomial::quintic,
    };
    let knot = |point: &Point, column: usize| Knot {
        position: point.positions[column],
        velocity: point.velocities.get(column).copied().unwrap_or(0.0),
        acceleration: point.accelerations.get(column).copied().unwrap_or(0.0),
    };
    let duration = b.time_s - a.time_s;
    (0..a.positions.len())
        .map(|column| make(knot(a, column), knot(b, column), duration))
        .collect()
}
