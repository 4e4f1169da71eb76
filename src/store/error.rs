//! Why the store refuses.

use super::MOST_PINNED;

/// Why something cannot be loaded, changed, unloaded or asked for.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StoreError {
    /// A label names other content.
    #[error(
        "{kind} {label:?} is loaded with hash {held:016x}, not {new:016x}; choose another label, unload it, or ask to replace it"
    )]
    LabelTaken {
        /// Robot or scene.
        kind: &'static str,
        /// The label.
        label: String,
        /// What it names.
        held: u64,
        /// What it should name.
        new: u64,
    },
    /// A label names the same robot with other motors.
    #[error(
        "robot {0:?} is loaded with other limits of velocity or effort; choose another label, unload it, or ask to replace it"
    )]
    OtherMotors(String),
    /// Two labels with one id.
    #[error("label {label:?} has the same id as {other:?}; choose another label")]
    SameId {
        /// The label.
        label: String,
        /// The one that is loaded.
        other: String,
    },
    /// No such robot.
    #[error("no robot {asked} is loaded; loaded: {known}")]
    UnknownRobot {
        /// What was asked for.
        asked: String,
        /// What there is.
        known: String,
    },
    /// No such scene.
    #[error("no scene {asked} is loaded; loaded: {known}")]
    UnknownScene {
        /// What was asked for.
        asked: String,
        /// What there is.
        known: String,
    },
    /// The label names other content than the request expects.
    #[error(
        "{kind} {label:?} has hash {held:016x}, the request is for {wanted:016x}; describe it again"
    )]
    HashConflict {
        /// Robot or scene.
        kind: &'static str,
        /// The label.
        label: String,
        /// What the request expects.
        wanted: u64,
        /// What the label names.
        held: u64,
    },
    /// A diff against a version that is not the newest.
    #[error(
        "scene {label:?} has version {held}, the diff is against version {wanted}; make it against the newest"
    )]
    VersionConflict {
        /// The label.
        label: String,
        /// What the diff is made against.
        wanted: u64,
        /// The newest.
        held: u64,
    },
    /// A version for a content that is not above those that the label had.
    #[error(
        "scene {label:?} had version {held}, and other content is to be version {wanted}; versions only go up"
    )]
    VersionTaken {
        /// The label.
        label: String,
        /// What was to be its version.
        wanted: u64,
        /// The newest that it had.
        held: u64,
    },
    /// A version that is not kept, or never was.
    #[error(
        "scene {label:?} has no version {wanted} any more, or not yet; it has version {kept}; 0 is the newest"
    )]
    UnknownVersion {
        /// The label.
        label: String,
        /// What is wanted.
        wanted: u64,
        /// What there is.
        kept: String,
    },
    /// A version that is to be unpinned and is not pinned.
    #[error("version {version} of scene {label:?} is not pinned; pinned: {pinned}")]
    NotPinned {
        /// The label.
        label: String,
        /// The version.
        version: u64,
        /// What is pinned.
        pinned: String,
    },
    /// A scene that is to be unloaded and has pinned versions.
    #[error("scene {label:?} has pinned versions: {pinned}; unpin them before it is unloaded")]
    Pinned {
        /// The label.
        label: String,
        /// What is pinned.
        pinned: String,
    },
    /// As many versions are pinned as may be.
    #[error(
        "scene {label:?} has {MOST_PINNED} pinned versions, which is the most: {pinned}; unpin one"
    )]
    TooManyPinned {
        /// The label.
        label: String,
        /// What is pinned.
        pinned: String,
    },
}

impl StoreError {
    pub(super) fn version_taken(label: &str, wanted: Option<u64>, held: u64) -> Self {
        Self::VersionTaken {
            label: label.to_owned(),
            wanted: wanted.unwrap_or_default(),
            held,
        }
    }

    pub(super) fn taken(kind: &'static str, label: &str, held: u64, new: u64) -> Self {
        Self::LabelTaken {
            kind,
            label: label.to_owned(),
            held,
            new,
        }
    }
}

/// Labels for a message, cut where there are many.
pub(super) fn list<'a>(labels: impl ExactSizeIterator<Item = &'a String>) -> String {
    const MOST: usize = 20;
    let count = labels.len();
    let shown: Vec<&str> = labels.take(MOST).map(String::as_str).collect();
    match count {
        0 => "none".to_owned(),
        1..=MOST => shown.join(", "),
        _ => format!("{}, … ({count} in all)", shown.join(", ")),
    }
}
