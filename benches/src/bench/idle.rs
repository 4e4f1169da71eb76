//! Motion that the task does not ask for: of coordinates that end where they start.

use taut::path::Path;
use taut::robot::{Component, ConfigurationSpace};

/// A coordinate whose ends differ by less is idle (rad or m).
const SAME: f64 = 1e-6;

/// Which factors of the space are at the end of a path where they are at its start.
pub(super) struct Idle<'a> {
    space: &'a ConfigurationSpace,
    factors: Vec<Component>,
}

impl<'a> Idle<'a> {
    /// The idle factors of a path's ends.
    pub(super) fn of(space: &'a ConfigurationSpace, path: &Path) -> Self {
        let mut velocity = vec![0.0; space.nv()];
        space.difference(
            path.waypoint(path.len() - 1),
            path.waypoint(0),
            &mut velocity,
        );
        let is_idle = |component: &Component| travel(component, &velocity) < SAME;
        Self {
            space,
            factors: space
                .components()
                .iter()
                .copied()
                .filter(is_idle)
                .collect(),
        }
    }

    /// How far they move along a path, in plain rad and m.
    pub(super) fn travel(&self, path: &Path) -> f64 {
        let mut velocity = vec![0.0; self.space.nv()];
        let mut sum = 0.0;
        for [from, to] in path.segments() {
            self.space.difference(to, from, &mut velocity);
            sum += self
                .factors
                .iter()
                .map(|factor| travel(factor, &velocity))
                .sum::<f64>();
        }
        sum
    }
}

/// How far one factor moves: a distance or an angle. The coordinates of a rotation mean nothing one
/// by one.
fn travel(component: &Component, velocity: &[f64]) -> f64 {
    match *component {
        Component::Line { v, .. } | Component::Circle { v, .. } => velocity[v].abs(),
        Component::Rotation { v, .. } => velocity[v..v + 3]
            .iter()
            .map(|part| part * part)
            .sum::<f64>()
            .sqrt(),
    }
}
