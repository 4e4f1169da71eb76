//! The configuration space: ⊕, ⊖ and straight interpolation, the only operations on configurations.
//!
//! A configuration is a row of a path as the planner sent it: one column per variable. The space is
//! a product of lines, circles and rotations (`method.md` §1 of the design; the convention is
//! MoveIt's and OMPL's): a planar joint is line × line × circle, a floating one line³ × SO(3).

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
    /// An angle on the circle (rad); differences are the shortest arc, in (−π, π].
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
        let (nq, nv) = components.iter().fold((0, 0), |(nq, nv), c| match c {
            Component::Rotation { .. } => (nq + 4, nv + 3),
            _ => (nq + 1, nv + 1),
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

    /// The same space with circles taken as lines: the numbers of the path count as they stand.
    pub fn unwrapped(&self) -> Self {
        let line = |c: &Component| match *c {
            Component::Circle { q, v } => Component::Line { q, v },
            other => other,
        };
        Self { components: self.components.iter().map(line).collect(), ..*self }
    }

    /// `to ⊖ from`: the velocity that leads from `from` to `to` in unit time.
    pub fn difference(&self, to: &[f64], from: &[f64], velocity: &mut [f64]) {
        for component in &self.components {
            match *component {
                Component::Line { q, v } => velocity[v] = to[q] - from[q],
                Component::Circle { q, v } => velocity[v] = shortest_arc(from[q], to[q]),
                Component::Rotation { q, v } => {
                    let relative = quat(from, q).conjugate() * quat(to, q);
                    velocity[v..v + 3].copy_from_slice(&quat_log(relative).to_array());
                }
            }
        }
    }

    /// The configuration at a ratio of the straight segment between two.
    pub fn between(&self, from: &[f64], to: &[f64], ratio: f64) -> Vec<f64> {
        let (mut velocity, mut at) = (vec![0.0; self.nv], vec![0.0; self.nq]);
        self.difference(to, from, &mut velocity);
        self.integrate(from, &velocity, ratio, &mut at);
        at
    }

    /// `from ⊕ t·velocity`. Circles are not wrapped, so values follow each other continuously.
    pub fn integrate(&self, from: &[f64], velocity: &[f64], t: f64, out: &mut [f64]) {
        for component in &self.components {
            match *component {
                Component::Line { q, v } | Component::Circle { q, v } => out[q] = from[q] + t * velocity[v],
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
    Quat::from_xyzw(configuration[q], configuration[q + 1], configuration[q + 2], configuration[q + 3])
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
    fn integrating_a_difference_arrives() {
        let space = ConfigurationSpace::new(vec![
            Component::Line { q: 0, v: 0 },
            Component::Circle { q: 1, v: 1 },
            Component::Rotation { q: 2, v: 2 },
        ]);
        let from = [1.0, 3.0, 0.0, 0.0, 0.0, 1.0];
        let to = [-2.0, -3.0, 0.5, 0.5, 0.5, 0.5];
        let (mut velocity, mut arrived) = ([0.0; 5], [0.0; 6]);
        space.difference(&to, &from, &mut velocity);
        space.integrate(&from, &velocity, 1.0, &mut arrived);
        assert!((arrived[1] - (TAU - 3.0)).abs() < 1e-12, "continuous past half a turn");
        assert!(arrived[2..].iter().zip(&to[2..]).all(|(a, b)| (a - b).abs() < 1e-12));
    }
}
