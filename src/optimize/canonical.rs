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

impl Canonical {
    /// Drops neighbours that are equal (unless both are fixed) and normalises quaternions.
    pub fn new(space: &ConfigurationSpace, path: &Path, fixed: &[bool]) -> Self {
        let nq = space.nq();
        let mut rows: Vec<f64> = Vec::with_capacity(path.as_flat().len());
        let mut kept: Vec<bool> = Vec::new();
        let mut origins: Vec<usize> = Vec::new();
        let mut standing_for = Vec::with_capacity(path.len());
        let mut velocity = vec![0.0; space.nv()];
        let mut row = vec![0.0; nq];
        for (index, waypoint) in path.waypoints().enumerate() {
            let previous = rows.len().checked_sub(nq).map(|start| &rows[start..]);
            row.copy_from_slice(waypoint);
            normalise_rotations(space, &mut row);
            if let (Some(previous), Some(last)) = (previous, kept.last_mut()) {
                space.difference(&row, previous, &mut velocity);
                if velocity.iter().all(|v| *v == 0.0) && !(*last && fixed[index]) {
                    if fixed[index] {
                        *last = true;
                        origins[kept.len() - 1] = index;
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
        let path = Path::from_rows(nq, rows).expect("a path has at least one whole row");
        Self {
            path,
            fixed: kept,
            origins,
            standing_for,
        }
    }
}

fn normalise_rotations(space: &ConfigurationSpace, row: &mut [f64]) {
    for component in space.components() {
        if let Component::Rotation { q, .. } = *component {
            normalise(&mut row[q..q + 4]);
        }
    }
}

fn normalise(quaternion: &mut [f64]) {
    let norm = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
    for x in quaternion {
        *x /= norm;
    }
}
