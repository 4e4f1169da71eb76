//! What clients see of a daemon that goes away and comes back, and whether it comes back with what
//! it had.

use taut_ipc::Client;
use taut_ipc::control::{ControlRequest, Listing, SceneSummary};

use crate::error::Error;
use crate::load::control::control;
use crate::load::tally::{Loss, Tally};
use crate::load::times::Times;

/// Gives a scene new content under its label.
pub(super) fn load(client: &Client, number: u64) -> Result<(), Error> {
    let object = r#""primitives": [{"type": "sphere", "dimensions": [0.1]}], "primitive_poses": [{"position": [9, 9, 9]}]"#;
    let json = format!(r#"{{"objects": [{{"id": "s{number}", {object}}}]}}"#);
    let message = ControlRequest::LoadScene {
        label: "kept".to_owned(),
        json,
        base_dir: None,
        replace: true,
        files: None,
        version: None,
    };
    control(client, &message).map(|_| ())
}

/// Every robot and scene of before is there, by content, and no scene is older.
pub(super) fn is_same(before: &Listing, now: &Listing) -> bool {
    is_kept(before, now, |kept, scene| kept.version >= scene.version)
}

/// Every robot and scene of before is there, by content and version.
pub(super) fn is_equal(before: &Listing, now: &Listing) -> bool {
    is_kept(before, now, |kept, scene| kept.version == scene.version)
}

fn is_kept(
    before: &Listing,
    now: &Listing,
    is_version: impl Fn(&SceneSummary, &SceneSummary) -> bool,
) -> bool {
    let robots = before.robots.iter().all(|robot| {
        now.robots
            .iter()
            .any(|other| other.label == robot.label && other.robot_hash == robot.robot_hash)
    });
    let scenes = before.scenes.iter().all(|scene| {
        now.scenes.iter().any(|other| {
            other.label == scene.label
                && other.scene_hash == scene.scene_hash
                && is_version(other, scene)
        })
    });
    robots && scenes
}

/// Times from when a daemon was harmed to what its clients see of it.
#[derive(Default)]
pub(super) struct Found {
    /// Until they knew.
    pub known: Times,
    /// Until they had a proved answer again.
    pub good: Times,
    /// Until the first of them had one.
    pub first: Times,
    /// Clients that had none.
    pub never: u64,
}

impl Found {
    /// Of clients' losses, with the times at which daemons were harmed (ns).
    pub(super) fn of(tally: &Tally, harms: &[u64]) -> Self {
        let mut found = Self::default();
        for (index, &harm) in harms.iter().enumerate() {
            let next = harms
                .get(index + 1)
                .copied()
                .unwrap_or(u64::MAX);
            // A request of this daemon: sent before it was harmed, or while the system was at it.
            let hit = |loss: &&Loss| (harm..next).contains(&loss.known_ns);
            let losses: Vec<&Loss> = tally.losses.iter().filter(hit).collect();
            found.add(harm, &losses);
        }
        found
    }

    /// Those that it cut off.
    fn add(&mut self, harm: u64, losses: &[&Loss]) {
        for loss in losses {
            self.known.add(loss.known_ns - harm);
        }
        let good = losses.iter().map(|loss| loss.good_ns);
        let good: Vec<u64> = good.filter(|good_ns| *good_ns != 0).collect();
        self.never += (losses.len() - good.len()) as u64;
        for good_ns in &good {
            self.good.add(good_ns - harm);
        }
        if let Some(first_ns) = good.iter().min() {
            self.first.add(first_ns - harm);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn loss(known_ns: u64, good_ns: u64) -> Loss {
        Loss {
            sent_ns: 0,
            known_ns,
            good_ns,
        }
    }

    #[test]
    fn a_loss_belongs_to_the_harm_before_it() {
        let tally = Tally {
            losses: vec![loss(120, 150), loss(130, 190), loss(310, 0)],
            ..Tally::default()
        };
        let found = Found::of(&tally, &[100, 300]);
        assert_eq!(
            (found.known.len(), found.good.len(), found.first.len()),
            (3, 2, 1)
        );
        assert_eq!(found.never, 1);
        assert!((found.first.max() - 50e-9).abs() < 1e-12);
        assert!((found.good.max() - 90e-9).abs() < 1e-12);
    }

    fn listing(version: u64) -> Listing {
        let scene = SceneSummary {
            label: "kept".to_owned(),
            version,
            ..SceneSummary::default()
        };
        Listing {
            scenes: vec![scene],
            ..Listing::default()
        }
    }

    #[test]
    fn a_newer_version_is_kept_but_not_equal_and_a_missing_scene_is_neither() {
        let [old, new] = [1, 2].map(listing);
        assert!(is_same(&old, &new) && !is_equal(&old, &new));
        assert!(!is_same(&new, &old) && is_equal(&new, &new));
        let none = Listing::default();
        assert!(!is_same(&old, &none) && is_same(&none, &old));
    }
}
