//! What a controller makes of a trajectory's points, read anew: pieces, and whether they keep the limits
//! that are claimed.

use super::column::Column;
use super::course::Course;
use super::objection::{Exceeded, Objection};
use super::{check_count, normalise};
use crate::robot::{Component, ConfigurationSpace, RobotModel};
use crate::validation::Interpolation;
use crate::validation::certificate::{LimitClaim, TimedClaims};
use crate::validation::timed::Point;

/// The part of a limit by which rounding may exceed it.
const ROUNDING: f64 = 1e-6;

/// From a point to the next.
pub(super) struct Piece {
    interpolation: Interpolation,
    start_s: f64,
    duration_s: f64,
    columns: Vec<Column>,
}

impl Piece {
    fn between(ends: [&Point; 2]) -> Self {
        let interpolation = interpolation(ends);
        let start_s = ends[0].time_s;
        let duration_s = ends[1].time_s - start_s;
        let columns = 0..ends[0].positions.len();
        let column = |index| Column::between(interpolation, ends, index, duration_s);
        Self {
            interpolation,
            start_s,
            duration_s,
            columns: columns.map(column).collect(),
        }
    }

    fn end_s(&self) -> f64 {
        self.start_s + self.duration_s
    }

    /// A column's velocity at a ratio (per second).
    fn velocity(&self, column: usize, ratio: f64) -> f64 {
        self.columns[column].derivative().at(ratio) / self.duration_s
    }

    /// The configuration at its first point.
    pub(super) fn start(&self) -> Vec<f64> {
        let columns = self.columns.iter();
        columns.map(|column| column.at(0.0)).collect()
    }

    /// How its columns go, by the ratio on it.
    pub(super) fn course<'a>(&'a self, space: &'a ConfigurationSpace) -> Course<'a> {
        Course::Curved {
            space,
            columns: &self.columns,
        }
    }
}

/// ros2_control's rule: what both points say counts.
fn interpolation([a, b]: [&Point; 2]) -> Interpolation {
    let is_said = |list: fn(&Point) -> &Vec<f64>| {
        ![a, b]
            .iter()
            .any(|point| list(point).is_empty())
    };
    match (
        is_said(|point| &point.velocities),
        is_said(|point| &point.accelerations),
    ) {
        (false, _) => Interpolation::Linear,
        (true, false) => Interpolation::Cubic,
        (true, true) => Interpolation::Quintic,
    }
}

/// The pieces between points.
pub(super) fn pieces(robot: &RobotModel, points: &[Point]) -> Result<Vec<Piece>, Objection> {
    for point in points {
        check_lists(robot, point)?;
    }
    let mut pieces = Vec::new();
    for (index, ends) in points.windows(2).enumerate() {
        let duration_s = ends[1].time_s - ends[0].time_s;
        if !(duration_s > 0.0 && duration_s.is_finite()) {
            return Err(Objection::Time(index + 1));
        }
        pieces.push(Piece::between([&ends[0], &ends[1]]));
    }
    for component in robot.space().components() {
        if let Component::Rotation { q, .. } = *component {
            let stands = standing(points, q).ok_or_else(|| Objection::Turns {
                variable: robot.variables()[q].name.clone(),
            })?;
            for piece in &mut pieces {
                piece.columns[q..q + 4].clone_from_slice(&stands);
            }
        }
    }
    Ok(pieces)
}

fn check_lists(robot: &RobotModel, point: &Point) -> Result<(), Objection> {
    let columns = robot.space().nq();
    check_count("columns", point.positions.len(), columns)?;
    for list in [&point.velocities, &point.accelerations] {
        if !list.is_empty() {
            check_count("columns", list.len(), columns)?;
        }
    }
    Ok(())
}

/// The quaternion that starts at a column, of length 1, where it is the same at all points and nothing
/// says that it moves.
fn standing(points: &[Point], q: usize) -> Option<[Column; 4]> {
    let first = &points[0].positions[q..q + 4];
    let stands = |point: &Point| {
        let rates = [&point.velocities, &point.accelerations];
        let mut rates = rates
            .into_iter()
            .flat_map(|list| list.iter().skip(q).take(4));
        point.positions[q..q + 4] == *first && rates.all(|rate| *rate == 0.0)
    };
    points.iter().all(stands).then(|| {
        let mut unit: [f64; 4] = std::array::from_fn(|k| first[k]);
        normalise(&mut unit);
        unit.map(Column::standing)
    })
}

/// Each piece is what is claimed.
pub(super) fn check_interpolation(pieces: &[Piece], claims: &TimedClaims) -> Result<(), Objection> {
    let claimed = &claims.interpolation;
    check_count("interpolations", claimed.len(), pieces.len())?;
    let mut both = pieces.iter().zip(claimed).enumerate();
    let other = both.find(|(_, (piece, claimed))| piece.interpolation != **claimed);
    match other {
        None => Ok(()),
        Some((segment, (piece, claimed))) => Err(Objection::Interpolation {
            segment,
            claimed: claimed.name(),
            given: piece.interpolation.name(),
        }),
    }
}

/// Velocities and accelerations are within the limits that are claimed; `start` are the velocities that
/// the first point says.
///
/// Where straight pieces meet others velocities jump: what changes in the mean of both durations counts
/// as an acceleration, and so it does at the start, where nothing is said from rest, and at the end, to rest.
pub(super) fn check_limits(
    robot: &RobotModel,
    pieces: &[Piece],
    start: &[f64],
    limits: &[LimitClaim],
) -> Result<(), Objection> {
    for limit in limits {
        let mut variables = robot.variables().iter();
        let column = variables
            .position(|variable| variable.name == limit.variable)
            .ok_or_else(|| Objection::NoVariable(limit.variable.clone()))?;
        for piece in pieces {
            check_limit(piece, column, limit)?;
        }
        let own_start = start.get(column).copied().unwrap_or(0.0);
        check_jumps(pieces, column, own_start, limit)?;
    }
    Ok(())
}

fn check_jumps(
    pieces: &[Piece],
    column: usize,
    start: f64,
    limit: &LimitClaim,
) -> Result<(), Objection> {
    let Some((first, last)) = pieces.first().zip(pieces.last()) else {
        return Ok(());
    };
    let at_ends = [
        (
            first.start_s,
            first.velocity(column, 0.0) - start,
            first.duration_s,
        ),
        (last.end_s(), -last.velocity(column, 1.0), last.duration_s),
    ];
    let between = pieces.windows(2).filter_map(|two| {
        let [before, after] = [&two[0], &two[1]];
        let change = after.velocity(column, 0.0) - before.velocity(column, 1.0);
        let in_s = 0.5 * (before.duration_s + after.duration_s);
        [before, after]
            .iter()
            .any(|piece| piece.interpolation == Interpolation::Linear)
            .then_some((after.start_s, change, in_s))
    });
    let [least, most] = limit
        .acceleration
        .map(|end| end * (1.0 + ROUNDING));
    let mut jumps = at_ends.into_iter().chain(between);
    match jumps.find(|(_, change, in_s)| !(least..=most).contains(&(change / in_s))) {
        None => Ok(()),
        Some((time_s, change, in_s)) => Err(Objection::Limit(Exceeded {
            variable: limit.variable.clone(),
            what: "acceleration",
            value: change / in_s,
            time_s,
            claimed: limit.acceleration,
        })),
    }
}

fn check_limit(piece: &Piece, column: usize, limit: &LimitClaim) -> Result<(), Objection> {
    let mut derivative = piece.columns[column].clone();
    let mut unit = 1.0;
    for (what, claimed) in [
        ("velocity", limit.velocity),
        ("acceleration", limit.acceleration),
    ] {
        derivative = derivative.derivative();
        unit *= piece.duration_s;
        let allowed = claimed.map(|end| end * (1.0 + ROUNDING) * unit);
        if let Some((ratio, value)) = derivative.outside(allowed) {
            return Err(Objection::Limit(Exceeded {
                variable: limit.variable.clone(),
                what,
                value: value / unit,
                time_s: piece.start_s + ratio * piece.duration_s,
                claimed,
            }));
        }
    }
    Ok(())
}
