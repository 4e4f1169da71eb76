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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Share {
    /// Those that collide.
    pub collide: usize,
    /// All of them.
    pub of: usize,
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
        let mut recorded: BTreeMap<String, Share> = BTreeMap::new();
        for (name, collides) in rows.iter().flat_map(|row| &row.mesh_check) {
            let share = recorded
                .entry(name.clone())
                .or_insert(Share { collide: 0, of: 0 });
            share.collide += usize::from(*collides);
            share.of += 1;
        }
        let checked = || {
            rows.iter()
                .filter(|row| !row.mesh_check.is_empty() && row.geometry == "given")
        };
        let proved = |mode: &&'static str| {
            let answers = checked().filter_map(|row| row.answers.get(mode));
            // None of them collides: that is what is proved of the same meshes.
            (
                *mode,
                Share {
                    collide: 0,
                    of: answers.filter(|figures| figures.proved).count(),
                },
            )
        };
        let ours = if checked().next().is_some() {
            modes.iter().map(proved).collect()
        } else {
            BTreeMap::new()
        };
        (!recorded.is_empty()).then_some(Self { recorded, ours })
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
