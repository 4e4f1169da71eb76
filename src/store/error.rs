//! Why the store refuses.

/// Why something cannot be loaded, unloaded or asked for.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
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
    #[error("{kind} {label:?} has hash {held:016x}, the request is for {wanted:016x}; describe it again")]
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
    /// The scene has another version than the request expects.
    #[error("scene {label:?} has version {held}, the request is for version {wanted}; send it for the newest")]
    VersionConflict {
        /// The label.
        label: String,
        /// What the request expects.
        wanted: u64,
        /// What there is.
        held: u64,
    },
}

impl StoreError {
    pub(super) fn taken(kind: &'static str, label: &str, held: u64, new: u64) -> Self {
        Self::LabelTaken { kind, label: label.to_owned(), held, new }
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
