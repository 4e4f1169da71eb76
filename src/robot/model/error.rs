//! Why a robot was refused, and how names are told.

use std::collections::BTreeSet;

use crate::shape::MeshError;

/// Why a robot was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RobotError {
    /// Two links, joints or variables of one name.
    #[error("{kind} {name:?} is defined twice; names must be unique")]
    Duplicate {
        /// Link, joint or variable.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// A name that nothing carries.
    #[error("{what} names {kind} {name:?}, which does not exist; known: {known}")]
    Unknown {
        /// Who names it.
        what: String,
        /// Link, joint or variable.
        kind: &'static str,
        /// The name.
        name: String,
        /// The valid names.
        known: String,
    },
    /// The joints do not form one tree.
    #[error("the joints do not form a tree: {0}")]
    NotATree(String),
    /// A number that is no number, or out of its range.
    #[error("{what} is {value}; {rule}")]
    BadValue {
        /// What.
        what: String,
        /// Its value.
        value: String,
        /// What it must be.
        rule: &'static str,
    },
    /// A text that is not the format it should be, with line and column where known.
    #[error("{0}")]
    Syntax(String),
    /// A collision mesh.
    #[error("link {link}: {source}")]
    Mesh {
        /// Link that wants the mesh.
        link: String,
        /// What is wrong.
        source: MeshError,
    },
}

/// Refuses names that stand twice.
pub(super) fn unique<'a>(
    kind: &'static str,
    names: impl Iterator<Item = &'a str>,
) -> Result<(), RobotError> {
    let mut seen = BTreeSet::new();
    for name in names {
        if !seen.insert(name) {
            return Err(RobotError::Duplicate {
                kind,
                name: name.to_owned(),
            });
        }
    }
    Ok(())
}

/// Comma-separated names for a message, cut where there are many.
pub(super) fn list<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<_> = names.collect();
    match names.len() {
        0 => "none".to_owned(),
        1..=40 => names.join(", "),
        n => format!("{}, … ({n} in all)", names[..40].join(", ")),
    }
}
