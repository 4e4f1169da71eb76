//! What is expected of an answer that says "proved", and what is found against it.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::case::Case;
use super::execute::{self, Executed, ROUNDING_M};
use super::library::Refused;
use super::make::path::{Constraint, Made, Step, turns};
use super::pose::quaternion_dot;
use super::theme::Theme;

/// Bodies that are farther apart than this (m) do not collide, whatever the rounding.
const FALSE_COLLISION_M: f64 = 1e-5;

/// An answer that says "proved".
#[derive(Debug)]
pub struct Proved {
    /// In the order of the robot's columns.
    pub rows: Vec<Vec<f64>>,
    /// What every pair keeps (m), but those whose floor was lowered.
    pub clearance_m: f64,
    pub lowered: BTreeMap<[String; 2], f64>,
    /// Whether it may leave waypoints out.
    pub is_shortened: bool,
    /// Whether it warns of orientations half a turn apart.
    pub is_said: bool,
}

/// What an answer does when it is executed, and the first thing that refutes it.
pub struct Verdict {
    pub executed: Executed,
    pub against: Option<String>,
}

pub fn of(case: &Case, asked: &Made, proved: &Proved) -> Verdict {
    let input = &asked.rows;
    let floors = case
        .world
        .floors(proved.clearance_m, &proved.lowered);
    let executed = execute::path(&case.world, &proved.rows, &floors, proved.is_said);
    let hit = executed.refutation.as_ref().map(|found| {
        let [a, b] = &found.bodies;
        let distance = found.distance_m * 1e3;
        let floor = found.floor_m * 1e3;
        let what = if found.is_overlap {
            "overlap"
        } else {
            "come nearer than promised"
        };
        let place = format!("segment {}, t = {:.4}", found.segment, found.t);
        format!("{a} × {b} {what}, {place}: {distance:.4} mm, promised {floor:.4} mm")
    });
    let against = hit
        .or_else(|| another_path(case, input, proved))
        .or_else(|| beyond_limits(case, input, proved));
    let against = against.or_else(|| constraint_left(case, asked, proved));
    Verdict { executed, against }
}

/// Why a collision that taut reports is none: at that very place the bodies are apart, or may
/// touch. Only where the way of every step is beyond doubt, and all files say what they should.
pub fn false_collision(case: &Case, asked: &Made, refused: &Refused) -> Option<String> {
    let odd = [
        Step::HalfTurn,
        Step::Long,
        Step::Rewound,
        Step::HalfQuaternion,
    ];
    let (segment, t, bodies) = refused.collision.as_ref()?;
    if case.theme == Theme::Misspelt
        || odd
            .iter()
            .any(|step| asked.steps.contains(step))
    {
        return None;
    }
    let ends = [*segment, segment + 1].map(|index| &asked.rows[index.min(asked.rows.len() - 1)]);
    let distance = execute::distance_at(&case.world, ends, *t, bodies);
    let [a, b] = bodies;
    let place = format!("segment {segment}, t = {t:.4}");
    match distance {
        None => Some(format!(
            "{a} × {b} are said to collide, {place}, but may touch"
        )),
        Some(far) if far > FALSE_COLLISION_M => Some(format!(
            "{a} × {b} are said to collide, {place}, but are {:.4} mm apart",
            far * 1e3
        )),
        Some(_) => None,
    }
}

/// Ends that are not the input's, or waypoints of a path that was only to be checked; whole turns
/// of angles, the norm and the sign of quaternions tell nothing apart.
fn another_path(case: &Case, input: &[Vec<f64>], proved: &Proved) -> Option<String> {
    let rows = &proved.rows;
    let last = |rows: &[Vec<f64>]| rows.len() - 1;
    let places: Vec<(usize, usize)> = if proved.is_shortened {
        vec![(0, 0), (last(input), last(rows))]
    } else if rows.len() != input.len() {
        return Some(format!(
            "{} waypoints were asked about, {} came back",
            input.len(),
            rows.len()
        ));
    } else {
        (0..rows.len())
            .map(|index| (index, index))
            .collect()
    };
    let differ = places
        .into_iter()
        .find(|&(asked, answered)| !is_same_place(case, &input[asked], &rows[answered]));
    differ.map(|(asked, answered)| {
        format!("waypoint {answered} is not waypoint {asked} of the input")
    })
}

fn is_same_place(case: &Case, asked: &[f64], answered: &[f64]) -> bool {
    let robot = &case.world.robot;
    let quaternions = turns(robot);
    let is_turn = |q: usize| {
        quaternions
            .iter()
            .any(|&first| (first..first + 4).contains(&q))
    };
    let numbers = robot
        .columns
        .iter()
        .enumerate()
        .filter(|(q, _)| !is_turn(*q))
        .all(|(q, column)| {
            let by = answered[q] - asked[q];
            let rest = if robot.is_angle(*column) {
                by - (by / TAU).round() * TAU
            } else {
                by
            };
            rest.abs() < 1e-9
        });
    let unit = |row: &[f64], q: usize| {
        super::pose::normalised([row[q], row[q + 1], row[q + 2], row[q + 3]])
    };
    numbers
        && quaternions
            .iter()
            .all(|&q| quaternion_dot(unit(asked, q), unit(answered, q)).abs() > 1.0 - 1e-12)
}

/// A joint that is farther outside of where it may be than it is anywhere on the input.
fn beyond_limits(case: &Case, input: &[Vec<f64>], proved: &Proved) -> Option<String> {
    let robot = &case.world.robot;
    for (q, column) in robot.columns.iter().enumerate() {
        let (lower, upper) = robot.joints[column.joint].soft_bounds();
        let outside = |rows: &[Vec<f64>]| {
            rows.iter()
                .map(|row| (lower - row[q]).max(row[q] - upper))
                .fold(0.0, f64::max)
        };
        let before = outside(input);
        let after = outside(&proved.rows);
        if after > before + ROUNDING_M {
            return Some(format!(
                "{} is {after:.4} outside of its limits, {before:.4} before",
                case.names[q]
            ));
        }
    }
    None
}

fn constraint_left(case: &Case, asked: &Made, proved: &Proved) -> Option<String> {
    let Constraint {
        column: q,
        tolerance,
    } = asked.constraint?;
    let start = proved.rows[0][q];
    let most = proved
        .rows
        .iter()
        .map(|row| (row[q] - start).abs())
        .fold(0.0, f64::max);
    // Ends that are outside by a hundredth are taken, and said to be.
    (most > 1.01 * tolerance + 1e-9).then(|| {
        format!(
            "{} leaves its constraint by {:.4}",
            case.names[q],
            most - tolerance
        )
    })
}
