//! Why bytes from the other side were refused.

use crate::limits::{MAX_PATH_NUMBERS, MAX_VARIABLES, MAX_WAYPOINTS, WIRE_VERSION};

/// Why a header or payload was refused. Each maps to a [code](super::Code).
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WireError {
    /// The other side speaks another version.
    #[error(
        "wire version {0}, this side speaks {WIRE_VERSION}; use client and daemon of the same release"
    )]
    Version(u32),
    /// `header_len` is not the size of the header.
    #[error("header of {found} bytes, expected {expected}")]
    HeaderLength {
        /// What the header says.
        found: u32,
        /// What it has to be.
        expected: u32,
    },
    /// An integer that names no variant, or a flag nobody defined.
    #[error("{field} has the unknown value {value:#x}")]
    UnknownValue {
        /// Name of the field.
        field: &'static str,
        /// What it held.
        value: i64,
    },
    /// A section reaches outside the payload or starts at an unaligned byte.
    #[error(
        "section {section} ({count} entries at byte {offset}) does not fit the payload of {payload} bytes or is not 8-aligned"
    )]
    SectionBounds {
        /// Name of the section.
        section: &'static str,
        /// Its first byte.
        offset: u32,
        /// Its entries.
        count: u32,
        /// Bytes of the payload.
        payload: usize,
    },
    /// A section has another number of entries than the header implies.
    #[error("section {section} has {found} entries, expected {expected}")]
    SectionCount {
        /// Name of the section.
        section: &'static str,
        /// Entries it has.
        found: usize,
        /// What the rest of the header implies.
        expected: usize,
    },
    /// More entries than the limit.
    #[error("section {section} has {found} entries, at most {limit} are allowed")]
    SectionLimit {
        /// Name of the section.
        section: &'static str,
        /// Entries it has.
        found: usize,
        /// The limit.
        limit: usize,
    },
    /// Text that is not UTF-8.
    #[error("section {0} is not UTF-8 text")]
    Text(&'static str),
    /// The path is larger than the service takes.
    #[error(
        "a path of {waypoints} waypoints x {variables} variables is outside 1..={MAX_WAYPOINTS} x 1..={MAX_VARIABLES}, at most {MAX_PATH_NUMBERS} numbers; split it or drop waypoints"
    )]
    PathSize {
        /// Waypoints asked for.
        waypoints: u32,
        /// Variables asked for.
        variables: u32,
    },
    /// A payload larger than the service takes.
    #[error("a payload of {found} bytes, at most {limit} are allowed")]
    PayloadSize {
        /// Its bytes.
        found: usize,
        /// The limit.
        limit: usize,
    },
    /// A floating-point option that is not finite.
    #[error("{field} is {value}, it has to be finite and not negative")]
    NotFinite {
        /// Name of the field.
        field: &'static str,
        /// What it held.
        value: f64,
    },
}
