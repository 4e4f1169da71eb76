//! The configuration space: ⊕, ⊖ and straight interpolation, the only operations on configurations.
//!
//! A configuration is a row of a path as the planner sent it: one column per variable. The space is
//! a product of lines, circles and rotations (MoveIt's and OMPL's convention): a planar joint is
//! line × line × circle, a floating one line³ × SO(3).
//!
//! **A step means its numbers.** Planners write angles, controllers execute numbers. A step of an
//! angle column moves as its numbers say up to half a turn and [`ROUNDED_RAD`] (files are rounded:
//! 3.1416). What is longer than that is an angle written anew, means the shortest arc, and is
//! written as such before anything is proved ([`ConfigurationSpace::unroll`]): no path that is
//! proved has a longer step.

use std::f64::consts::{PI, TAU};

use crate::math::{Quat, Vec3, quat_exp, quat_log};

/// One factor of the configuration space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Component {
    /// A real number (m or rad): column `q`, velocity coordinate `v`.
    Line {
        /// Column.
        q: usize,
        /// Velocity coordinate.
        v: usize,
    },
    /// An angle on the circle (rad); see [`step`] for what a difference is.
    Circle {
        /// Column.
        q: usize,
        /// Velocity coordinate.
        v: usize,
    },
    /// A rotation: unit quaternion (x, y, z, w) in `q..q + 4`, rotation vector in `v..v + 3`.
    Rotation {
        /// First column.
        q: usize,
        /// First velocity coordinate.
        v: usize,
    },
}

/// Product of [`Component`]s: knows how configurations differ and how they move.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct ConfigurationSpace {
    components: Vec<Component>,
    nq: usize,
    nv: usize,
}

/// How much longer than half a turn a step of an angle column is that still moves as its numbers
/// say (rad); rotations that are as near to half a turn name no way.
pub const ROUNDED_RAD: f64 = 1e-3;

/// The longest step of an angle column that moves as its numbers say (rad).
pub const LONGEST_STEP_RAD: f64 = PI + ROUNDED_RAD;

/// What rounding may add to a step when its ends move by whole turns, with room to spare (rad).
const TURNED_RAD: f64 = 1e-6;

/// An angle further out has too few digits left for whole turns to be told apart (rad).
pub const FARTHEST_ANGLE_RAD: f64 = 1e9;

/// How an angle column moves from `from` to `to`: as the numbers say up to [`LONGEST_STEP_RAD`]
/// (and what turning them may have rounded), else the shortest arc.
pub fn step(from: f64, to: f64) -> f64 {
    let step = to - from;
    if step.abs() <= LONGEST_STEP_RAD + TURNED_RAD {
        step
    } else {
        shortest_arc(from, to)
    }
}

/// Whole turns to add to `to` so that the numbers say how the column moves; mostly 0.
pub fn turns_to_add(from: f64, to: f64) -> f64 {
    let step = to - from;
    if step.abs() <= LONGEST_STEP_RAD {
        0.0
    } else {
        ((shortest_arc(from, to) - step) / TAU).round()
    }
}

/// Whole turns from `from` to `to`, two numbers of one angle.
pub fn turns_between(from: f64, to: f64) -> i64 {
    ((to - from) / TAU).round() as i64
}

/// Shortest arc from `from` to `to`, in (−π, π]; exactly half a turn goes positive.
pub fn shortest_arc(from: f64, to: f64) -> f64 {
    let arc = (to - from) % TAU;
    if arc > PI {
        arc - TAU
    } else if arc <= -PI {
        arc + TAU
    } else {
        arc
    }
}

impl ConfigurationSpace {
    /// Product of `components`, whose columns and coordinates follow each other without gaps.
    pub(crate) fn new(components: Vec<Component>) -> Self {
        let (nq, nv) = components
            .iter()
            .fold((0, 0), |(nq, nv), c| match c {
                Component::Rotation { .. } => (nq + 4, nv + 3),
                Component::Line { .. } | Component::Circle { .. } => (nq + 1, nv + 1),
            });
        Self { components, nq, nv }
    }

    /// Columns of a configuration.
    pub fn nq(&self) -> usize {
        self.nq
    }

    /// Coordinates of a velocity.
    pub fn nv(&self) -> usize {
        self.nv
    }

    /// The factors, in column order.
    pub fn components(&self) -> &[Component] {
        &self.components
    }

    /// Columns of angles on the circle.
    pub fn circles(&self) -> impl Iterator<Item = usize> {
        self.components
            .iter()
            .filter_map(|component| match *component {
                Component::Circle { q, .. } => Some(q),
                Component::Line { .. } | Component::Rotation { .. } => None,
            })
    }

    /// Writes angles so that consecutive rows, laid end to end, say by their numbers how they move:
    /// from the first longer step of a column on, its numbers move by whole turns. Returns whether
    /// any did.
    pub fn unroll(&self, rows: &mut [f64]) -> bool {
        let mut has_moved = false;
        for q in self.circles() {
            let mut turns = 0.0;
            let mut before = rows[q];
            for number in rows.iter_mut().skip(q).step_by(self.nq) {
                turns += turns_to_add(before, *number);
                before = *number;
                if turns != 0.0 {
                    *number += turns * TAU;
                    has_moved = true;
                }
            }
        }
        has_moved
    }

    /// First column of a rotation between two configurations that is half a turn, within
    /// [`ROUNDED_RAD`]: two ways lead there, and the numbers name neither.
    pub fn half_turn(&self, from: &[f64], to: &[f64]) -> Option<usize> {
        self.components
            .iter()
            .find_map(|component| match *component {
                Component::Rotation { q, .. } => {
                    let cosine: f64 = (q..q + 4).map(|i| from[i] * to[i]).sum();
                    (cosine.abs() < 0.5 * ROUNDED_RAD).then_some(q)
                }
                Component::Line { .. } | Component::Circle { .. } => None,
            })
    }

    /// Velocity of the shortest motion between two configurations, whatever the numbers say.
    pub fn shortest_difference(&self, to: &[f64], from: &[f64], velocity: &mut [f64]) {
        self.difference(to, from, velocity);
        for component in &self.components {
            if let Component::Circle { q, v } = *component {
                velocity[v] = shortest_arc(from[q], to[q]);
            }
        }
    }

    /// The same space with circles taken as lines: the numbers of the path count as they stand.
    pub fn unwrapped(&self) -> Self {
        let line = |c: &Component| match *c {
            Component::Circle { q, v } => Component::Line { q, v },
            other @ (Component::Line { .. } | Component::Rotation { .. }) => other,
        };
        Self {
            components: self.components.iter().map(line).collect(),
            ..*self
        }
    }

    /// `to ⊖ from`: the velocity that leads from `from` to `to` in unit time.
    pub fn difference(&self, to: &[f64], from: &[f64], velocity: &mut [f64]) {
        for component in &self.components {
            match *component {
                Component::Line { q, v } => velocity[v] = to[q] - from[q],
                Component::Circle { q, v } => velocity[v] = step(from[q], to[q]),
                Component::Rotation { q, v } => {
                    let relative = quat(from, q).conjugate() * quat(to, q);
                    velocity[v..v + 3].copy_from_slice(&quat_log(relative).to_array());
                }
            }
        }
    }

    /// The configuration at a ratio of the straight segment between two.
    pub fn between(&self, from: &[f64], to: &[f64], ratio: f64) -> Vec<f64> {
        let mut velocity = vec![0.0; self.nv];
        let mut at = vec![0.0; self.nq];
        self.difference(to, from, &mut velocity);
        self.integrate(from, &velocity, ratio, &mut at);
        at
    }

    /// `from ⊕ t·velocity`. Circles are not wrapped, so values follow each other continuously.
    pub fn integrate(&self, from: &[f64], velocity: &[f64], t: f64, out: &mut [f64]) {
        for component in &self.components {
            match *component {
                Component::Line { q, v } | Component::Circle { q, v } => {
                    out[q] = from[q] + t * velocity[v]
                }
                Component::Rotation { q, v } => {
                    let turn = Vec3::new(velocity[v], velocity[v + 1], velocity[v + 2]) * t;
                    let rotation = (quat(from, q) * quat_exp(turn)).normalize();
                    out[q..q + 4].copy_from_slice(&rotation.to_array());
                }
            }
        }
    }
}

/// The quaternion in columns `q..q + 4`.
pub(crate) fn quat(configuration: &[f64], q: usize) -> Quat {
    Quat::from_xyzw(
        configuration[q],
        configuration[q + 1],
        configuration[q + 2],
        configuration[q + 3],
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_arc_is_the_short_way_and_half_a_turn_goes_positive() {
        let degrees = PI / 180.0;
        assert!((shortest_arc(179.0 * degrees, -179.0 * degrees) - 2.0 * degrees).abs() < 1e-12);
        assert_eq!(shortest_arc(0.0, PI), PI);
        assert_eq!(shortest_arc(0.0, -PI), PI);
        assert!(shortest_arc(0.0, 3.0 * TAU).abs() < 1e-12);
    }

    #[test]
    fn a_step_means_its_numbers_up_to_half_a_turn_as_files_round_it() {
        // As files and messages have it: to so many digits, in single precision.
        let rounded = |digits: i32| (PI * 10_f64.powi(digits)).round() / 10_f64.powi(digits);
        for half in [PI, rounded(4), rounded(5), f64::from(std::f32::consts::PI)] {
            assert_eq!((step(0.0, half), step(0.0, -half)), (half, -half));
            assert!((step(0.5 * half, -0.5 * half) + half).abs() < 1e-15);
        }
        assert!((step(0.0, 6.0) - (6.0 - TAU)).abs() < 1e-15);
        assert!((step(0.0, 3.15) - (3.15 - TAU)).abs() < 1e-15);
        assert_eq!(
            (
                turns_to_add(0.0, 6.0),
                turns_to_add(6.0, 0.0),
                turns_to_add(1.0, 20.0)
            ),
            (-1.0, 1.0, -3.0)
        );
    }

    #[test]
    fn what_is_unrolled_has_no_longer_step_and_is_the_same_place() {
        let space = ConfigurationSpace::new(vec![
            Component::Line { q: 0, v: 0 },
            Component::Circle { q: 1, v: 1 },
        ]);
        let given = [0.0, 3.1, 9.0, -3.1, 0.0, 3.1, 0.0, 0.0, 0.0, 100.0];
        let mut rows = given;
        assert!(space.unroll(&mut rows));
        assert_eq!(rows[1], 3.1);
        assert!((rows[3] - (TAU - 3.1)).abs() < 1e-12);
        assert_eq!(
            rows[5].to_bits(),
            3.1_f64.to_bits(),
            "back at the first turn, back at the same bits"
        );
        assert!(
            rows.chunks(2)
                .zip(rows.chunks(2).skip(1))
                .all(|(a, b)| (b[1] - a[1]).abs() <= LONGEST_STEP_RAD)
        );
        assert!(
            rows.iter()
                .zip(&given)
                .all(|(a, b)| ((a - b) / TAU - ((a - b) / TAU).round()).abs() < 1e-12)
        );
        assert!(!space.unroll(&mut rows.clone()), "once is enough");
    }

    #[test]
    fn rotations_half_a_turn_apart_are_seen() {
        let space = ConfigurationSpace::new(vec![Component::Rotation { q: 0, v: 0 }]);
        let rest = [0.0, 0.0, 0.0, 1.0];
        let half = [0.0, 0.0, 1.0, 0.0003];
        assert_eq!(space.half_turn(&rest, &half), Some(0));
        assert_eq!(space.half_turn(&rest, &[0.0, 0.0, 1.0, -0.0003]), Some(0));
        assert_eq!(space.half_turn(&rest, &[0.0, 0.0, 0.999_999, 0.001]), None);
        assert_eq!(space.half_turn(&rest, &rest), None);
    }

    #[test]
    fn integrating_a_difference_arrives() {
        let space = ConfigurationSpace::new(vec![
            Component::Line { q: 0, v: 0 },
            Component::Circle { q: 1, v: 1 },
            Component::Rotation { q: 2, v: 2 },
        ]);
        let from = [1.0, 3.0, 0.0, 0.0, 0.0, 1.0];
        let to = [-2.0, -3.0, 0.5, 0.5, 0.5, 0.5];
        let mut velocity = [0.0; 5];
        let mut arrived = [0.0; 6];
        space.difference(&to, &from, &mut velocity);
        space.integrate(&from, &velocity, 1.0, &mut arrived);
        assert!(
            (arrived[1] - (TAU - 3.0)).abs() < 1e-12,
            "continuous past half a turn"
        );
        assert!(
            arrived[2..]
                .iter()
                .zip(&to[2..])
                .all(|(a, b)| (a - b).abs() < 1e-12)
        );
    }
}
