//! Recorded checks of planners' and peers' paths with the exact meshes, beside our proofs.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;

use super::row::Row;

/// Which recorded paths collide with the exact meshes, by their recorded names.
pub(super) fn collisions(recorded: &Value) -> BTreeMap<String, bool> {
    let collides = |check: &Value| Some(check.get("samples_in_collision")?.as_u64()? > 0);
    let checks = recorded.as_object().into_iter().flatten();
    checks
        .filter_map(|(name, check)| Some((name.clone(), collides(check)?)))
        .collect()
}

/// How many of how many.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub(super) struct Share {
    /// Those that collide.
    pub collide: usize,
    /// All of them.
    pub of: usize,
}

impl Share {
    /// Those that collide (%).
    pub(super) fn percent(&self) -> f64 {
        100.0 * self.collide as f64 / self.of.max(1) as f64
    }
}

/// The checks of a set.
#[derive(Debug, Serialize)]
pub(super) struct Meshes {
    /// Recorded ones by name; `raw` is the planner's path.
    pub recorded: BTreeMap<String, Share>,
    /// Our proved answers to the same problems by mode, where the robot's own shapes were taken.
    pub ours: BTreeMap<&'static str, Share>,
}

impl Meshes {
    /// `None` where nothing is recorded.
    pub(super) fn of(rows: &[&Row], modes: &[&'static str]) -> Option<Self> {
        let recorded = recorded(rows);
        (!recorded.is_empty()).then(|| Self {
            recorded,
            ours: ours(rows, modes),
        })
    }
}

fn recorded(rows: &[&Row]) -> BTreeMap<String, Share> {
    let mut recorded: BTreeMap<String, Share> = BTreeMap::new();
    for (name, collides) in rows.iter().flat_map(|row| &row.mesh_check) {
        let share = recorded.entry(name.clone()).or_default();
        share.collide += usize::from(*collides);
        share.of += 1;
    }
    recorded
}

fn ours(rows: &[&Row], modes: &[&'static str]) -> BTreeMap<&'static str, Share> {
    let mut checked = rows.to_vec();
    checked.retain(|row| !row.mesh_check.is_empty() && row.geometry == "given");
    let modes = modes.iter().filter(|_| !checked.is_empty());
    modes
        .map(|mode| (*mode, proved(&checked, mode)))
        .collect()
}

/// None of them collides: that is what is proved of the same meshes.
fn proved(rows: &[&Row], mode: &str) -> Share {
    let answers = rows
        .iter()
        .filter_map(|row| row.answers.get(mode));
    Share {
        collide: 0,
        of: answers.filter(|figures| figures.proved).count(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_collides_where_a_sample_does() {
        let recorded = serde_json::json!({
            "raw": { "samples_in_collision": 0, "samples": 9 },
            "peer": { "samples_in_collision": 2, "samples": 9 },
            "note": "not a check",
        });
        assert_eq!(
            collisions(&recorded),
            BTreeMap::from([("raw".to_owned(), false), ("peer".to_owned(), true)])
        );
        assert!(collisions(&Value::Null).is_empty());
    }
}
