//! Scenes whose home is elsewhere.

use crate::live::locked;
use crate::message::Refused;
use std::collections::{BTreeMap, HashMap};
use std::sync::Mutex;
use taut_ipc::control::SceneSummary;
use taut_ipc::wire::Code;

/// A scene that is a copy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Copy {
    pub(super) label: String,
    pub(super) home: String,
    pub(super) version: u64,
    hash: u64,
    /// The home counts lower now: it began anew, and what is here is nothing of its.
    is_astray: bool,
    /// Its home was not reached yet: it may be none.
    is_supposed: bool,
}

/// The copies of a gateway.
#[derive(Debug, Default)]
pub(super) struct Copies(Mutex<Known>);

#[derive(Debug, Default)]
struct Known {
    /// By id of the scene.
    copies: HashMap<u64, Copy>,
    /// Homes that were not reached since the gateway began: any scene here may be a copy of theirs.
    unreached: Vec<String>,
    /// Label and version of the scenes here while there are such homes; `None` = not known either.
    here: Option<BTreeMap<u64, (String, u64)>>,
}

impl Copies {
    /// Of these homes.
    pub(super) fn new(homes: &[String]) -> Self {
        let unreached = homes.to_vec();
        Self(Mutex::new(Known {
            unreached,
            ..Known::default()
        }))
    }

    pub(super) fn of(&self, scene: u64) -> Option<Copy> {
        locked(&self.0).of(scene)
    }

    pub(super) fn labelled(&self, label: &str) -> Option<Copy> {
        let known = locked(&self.0);
        let noted = known
            .copies
            .values()
            .find(|copy| copy.label == label);
        noted
            .cloned()
            .or_else(|| known.supposed_labelled(label))
    }

    pub(super) fn is_as(&self, scene: u64, version: u64, hash: u64) -> bool {
        let known = locked(&self.0);
        let copy = known.copies.get(&scene);
        copy.is_some_and(|copy| (copy.version, copy.hash) == (version, hash))
    }

    pub(super) fn note(&self, home: &str, scene: &SceneSummary) {
        let copy = Copy {
            label: scene.label.clone(),
            home: home.to_owned(),
            version: scene.version,
            hash: scene.scene_hash,
            is_astray: false,
            is_supposed: false,
        };
        locked(&self.0)
            .copies
            .insert(scene.scene_id, copy);
    }

    /// The home counts lower than the scene here. Where that is a copy and its content another, it is
    /// not what the home has, nor ever will be.
    pub(super) fn note_astray(&self, here: &SceneSummary, there: &SceneSummary) {
        let mut known = locked(&self.0);
        if let Some(copy) = known.copies.get_mut(&here.scene_id) {
            copy.is_astray = here.scene_hash != there.scene_hash;
        }
    }

    /// The scenes here, before every home was reached.
    pub(super) fn suppose(&self, here: &[SceneSummary]) {
        let mut known = locked(&self.0);
        if known.unreached.is_empty() {
            return;
        }
        let scenes = here.iter();
        let here = scenes.map(|scene| (scene.scene_id, (scene.label.clone(), scene.version)));
        known.here = Some(here.collect());
    }

    /// A home was reached, and what it has is noted.
    pub(super) fn reached(&self, home: &str) {
        let mut known = locked(&self.0);
        known.unreached.retain(|other| other != home);
        if known.unreached.is_empty() {
            known.here = None;
        }
    }

    /// Those of a home that it does not have any more; they are copies no longer.
    pub(super) fn take_gone(&self, home: &str, there: &[SceneSummary]) -> Vec<Copy> {
        let is_gone = |id: &u64, copy: &mut Copy| {
            copy.home == home && there.iter().all(|scene| scene.scene_id != *id)
        };
        let mut known = locked(&self.0);
        let gone = known.copies.extract_if(is_gone);
        gone.map(|(_, copy)| copy).collect()
    }
}

impl Known {
    fn of(&self, scene: u64) -> Option<Copy> {
        let noted = self.copies.get(&scene).cloned();
        noted.or_else(|| match &self.here {
            None => self.supposed(&format!("{scene:016x}"), 0),
            Some(here) => {
                let (label, version) = here.get(&scene)?;
                self.supposed(label, *version)
            }
        })
    }

    fn supposed_labelled(&self, label: &str) -> Option<Copy> {
        let mut labels = self.here.iter().flat_map(BTreeMap::values);
        let may_be_here = self.here.is_none() || labels.any(|(other, _)| other == label);
        self.supposed(label, 0).filter(|_| may_be_here)
    }

    /// What may be a copy, of whichever home was not reached yet.
    fn supposed(&self, label: &str, version: u64) -> Option<Copy> {
        let is_one = !self.unreached.is_empty();
        is_one.then(|| Copy {
            label: label.to_owned(),
            home: self.unreached.join(" or "),
            version,
            hash: 0,
            is_astray: false,
            is_supposed: true,
        })
    }
}

impl Copy {
    /// Why it is not changed here.
    pub(super) fn unchanged(&self) -> Refused {
        let Self { label, home, .. } = self;
        if !self.is_supposed {
            let line = format!("scene {label} has its home at {home}; change it there");
            return Refused::new(Code::VersionConflict, line);
        }
        Refused {
            code: Code::Loading,
            message: format!(
                "scene {label} may have its home at {home}, which was not reached yet; send it again, or start this gateway without --follow"
            ),
            retry_after_ms: 500,
        }
    }

    /// Whether it answers for a client that has seen this version.
    ///
    /// # Errors
    /// LOADING where it is older; VERSION_CONFLICT where it never gets equal.
    pub(super) fn check_seen(&self, seen: u64) -> Result<(), Refused> {
        let Self {
            label,
            home,
            version,
            ..
        } = self;
        if self.is_astray {
            let line = format!(
                "{home} began anew to count the versions of scene {label}, and here is another content as version {version}; ask {home}, and start the daemon here without its state"
            );
            return Err(Refused::new(Code::VersionConflict, line));
        }
        if *version >= seen {
            return Ok(());
        }
        Err(Refused {
            code: Code::Loading,
            message: format!(
                "version {seen} of scene {label} has not come from {home} yet, here is {version}"
            ),
            retry_after_ms: 50,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(label: &str, id: u64, version: u64) -> SceneSummary {
        SceneSummary {
            label: label.to_owned(),
            scene_id: id,
            version,
            scene_hash: version * 7,
            ..SceneSummary::default()
        }
    }

    #[test]
    fn copies_are_known_by_id_and_label_until_their_home_drops_them() {
        let copies = Copies::default();
        copies.note("a", &scene("shelf", 1, 3));
        copies.note("b", &scene("bin", 2, 1));
        assert!(copies.is_as(1, 3, 21) && !copies.is_as(1, 4, 28));
        assert_eq!(copies.labelled("shelf").unwrap().home, "a");
        assert!(
            copies
                .take_gone("a", &[scene("shelf", 1, 9)])
                .is_empty()
        );
        assert_eq!(copies.take_gone("a", &[]).len(), 1);
        assert!(copies.of(1).is_none() && copies.of(2).is_some());
    }

    #[test]
    fn until_homes_are_reached_every_scene_here_may_be_a_copy() {
        let copies = Copies::new(&["a".to_owned(), "b".to_owned()]);
        assert!(copies.of(1).unwrap().check_seen(1).is_err() && copies.labelled("new").is_some());
        copies.suppose(&[scene("shelf", 1, 3), scene("own", 2, 4)]);
        assert_eq!(copies.labelled("own").unwrap().home, "a or b");
        assert!(copies.labelled("new").is_none());
        assert_eq!(
            copies.labelled("own").unwrap().unchanged().code,
            Code::Loading
        );
        let refused = copies.of(1).unwrap().check_seen(5).unwrap_err();
        assert_eq!(refused.code, Code::Loading);
        assert!(copies.of(1).unwrap().check_seen(3).is_ok());
        copies.note("a", &scene("shelf", 1, 5));
        copies.reached("a");
        assert!(copies.of(1).unwrap().check_seen(5).is_ok());
        assert_eq!(copies.labelled("own").unwrap().home, "b");
        copies.reached("b");
        assert!(copies.labelled("own").is_none() && copies.of(2).is_none());
    }

    #[test]
    fn a_copy_that_its_home_counts_below_is_not_answered_from() {
        let copies = Copies::default();
        let [here, there] = [57, 2].map(|version| scene("shelf", 1, version));
        // A scene of this daemon's own stays as it is.
        copies.note_astray(&here, &there);
        assert!(copies.of(1).is_none());
        copies.note("a", &here);
        copies.note_astray(&here, &there);
        let refused = copies.of(1).unwrap().check_seen(1).unwrap_err();
        assert_eq!(refused.code, Code::VersionConflict);
        assert!(
            refused.message.contains("version 57"),
            "{}",
            refused.message
        );
    }
}
