//! The form of a path that optimizers work on: equal neighbours count as one, quaternions have the
//! norm 1.

use crate::path::Path;
use crate::robot::{Component, ConfigurationSpace};

/// The form of a path that optimizers work on.
pub(super) struct Canonical {
    pub path: Path,
    pub fixed: Vec<bool>,
    pub origins: Vec<usize>,
    pub standing_for: Vec<usize>,
}

/// A canonical form as its waypoints come in.
struct Builder<'s> {
    space: &'s ConfigurationSpace,
    rows: Vec<f64>,
    fixed: Vec<bool>,
    origins: Vec<usize>,
    standing_for: Vec<usize>,
    velocity: Vec<f64>,
}

impl<'s> Builder<'s> {
    fn new(space: &'s ConfigurationSpace, path: &Path) -> Self {
        Self {
            space,
            rows: Vec::with_capacity(path.as_flat().len()),
            fixed: Vec::new(),
            origins: Vec::new(),
            standing_for: Vec::with_capacity(path.len()),
            velocity: vec![0.0; space.nv()],
        }
    }

    /// Takes the caller's next waypoint, with its quaternions normalised.
    fn push(&mut self, row: &[f64], is_fixed: bool) {
        let is_needless = self.equals_last(row) && !(is_fixed && self.fixed.ends_with(&[true]));
        match is_needless {
            true => self.merge(is_fixed),
            false => self.keep(row, is_fixed),
        }
    }

    fn equals_last(&mut self, row: &[f64]) -> bool {
        let Some(start) = self.rows.len().checked_sub(row.len()) else {
            return false;
        };
        self.space
            .difference(row, &self.rows[start..], &mut self.velocity);
        self.velocity.iter().all(|v| *v == 0.0)
    }

    /// The last waypoint stands for this one too.
    fn merge(&mut self, is_fixed: bool) {
        let last = self.fixed.len() - 1;
        if is_fixed {
            // It is this one whose bits the caller wants back.
            self.fixed[last] = true;
            self.origins[last] = self.standing_for.len();
        }
        self.standing_for.push(last);
    }

    fn keep(&mut self, row: &[f64], is_fixed: bool) {
        self.rows.extend_from_slice(row);
        self.origins.push(self.standing_for.len());
        self.standing_for.push(self.fixed.len());
        self.fixed.push(is_fixed);
    }

    fn finish(self) -> Canonical {
        let path = Path::from_rows(self.space.nq(), self.rows);
        Canonical {
            path: path.expect("a path has at least one whole row"),
            fixed: self.fixed,
            origins: self.origins,
            standing_for: self.standing_for,
        }
    }
}

impl Canonical {
    /// Drops neighbours that are equal (unless both are fixed) and normalises quaternions.
    pub fn new(space: &ConfigurationSpace, path: &Path, fixed: &[bool]) -> Self {
        let mut builder = Builder::new(space, path);
        let mut row = vec![0.0; space.nq()];
        for (waypoint, is_fixed) in path.waypoints().zip(fixed) {
            row.copy_from_slice(waypoint);
            normalise_rotations(space, &mut row);
            builder.push(&row, *is_fixed);
        }
        builder.finish()
    }

    /// The caller's rows of the fixed waypoints, laid end to end.
    pub fn fixed_rows(&self, given: &Path) -> Vec<f64> {
        let waypoints = self.origins.iter().zip(&self.fixed);
        waypoints
            .filter(|(_, is_fixed)| **is_fixed)
            .flat_map(|(&origin, _)| given.waypoint(origin))
            .copied()
            .collect()
    }
}

fn normalise_rotations(space: &ConfigurationSpace, row: &mut [f64]) {
    for q in rotations(space) {
        normalise(&mut row[q..q + 4]);
    }
}

/// First columns of the quaternions.
pub(super) fn rotations(space: &ConfigurationSpace) -> impl Iterator<Item = usize> {
    space
        .components()
        .iter()
        .filter_map(|component| match *component {
            Component::Rotation { q, .. } => Some(q),
            Component::Line { .. } | Component::Circle { .. } => None,
        })
}

/// Length of a quaternion.
pub(super) fn norm(quaternion: &[f64]) -> f64 {
    quaternion
        .iter()
        .map(|x| x * x)
        .sum::<f64>()
        .sqrt()
}

fn normalise(quaternion: &mut [f64]) {
    let norm = norm(quaternion);
    quaternion.iter_mut().for_each(|x| *x /= norm);
}
