//! What the reference checker may have against a certificate.

use crate::validation::certificate::{CHECKER_VERSION, FIRST_BY_NUMBERS};

/// Why a certificate is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Objection {
    /// Made by a checker that is not known here.
    #[error(
        "it was made by checker version {0}, this build verifies 1 to {CHECKER_VERSION}; verify it with the taut that made it"
    )]
    Version(u32),
    /// The digest is missing.
    #[error(
        "it has no digest, which certificates of checker version {0} have; it was changed after the proof"
    )]
    NoDigest(u32),
    /// The digest does not fit.
    #[error(
        "its digest is {digest:016x}, its content has {content:016x}; it was changed after the proof"
    )]
    Edited {
        /// Digest that the certificate names.
        digest: u64,
        /// Digest of what it says.
        content: u64,
    },
    /// About something else.
    #[error(
        "it is about the {kind} with hash {claimed:016x}, the {kind} given has {given:016x}; give the {kind} that was proved, bit for bit"
    )]
    Other {
        /// Robot, scene or path.
        kind: &'static str,
        /// Hash in the certificate.
        claimed: u64,
        /// Hash of what was given.
        given: u64,
    },
    /// A step that does not say how it moves.
    #[error(
        "segment {}: {variable} steps from {from} to {to}, more than half a turn; {}", segment + 1,
        if *version < FIRST_BY_NUMBERS {
            "checker version 2 and before took the short way round, whatever a controller does: prove the path again"
        } else {
            "what is proved is written without such steps, so this is another path"
        }
    )]
    LongStep {
        /// Segment, from 0.
        segment: usize,
        /// Column.
        variable: String,
        /// Its number before.
        from: f64,
        /// Its number after.
        to: f64,
        /// Checker version of the certificate.
        version: u32,
    },
    /// A rotation that does not say how it moves.
    #[error("segment {}: the quaternion that starts at {variable} turns by half a turn, and two ways lead there", segment + 1)]
    HalfTurn {
        /// Segment, from 0.
        segment: usize,
        /// First column of the quaternion.
        variable: String,
    },
    /// A list of the wrong length.
    #[error("it has {got} {what}, {expected} are needed")]
    Count {
        /// What is counted.
        what: &'static str,
        /// Entries of the certificate.
        got: usize,
        /// Entries that robot or path need.
        expected: usize,
    },
    /// A floor or clearance that no proof has.
    #[error("{what} is {value} m; a proof has {least} to {most}")]
    Number {
        /// Which number.
        what: String,
        /// Its value (m).
        value: f64,
        /// Least valid value (m).
        least: f64,
        /// Greatest valid value (m).
        most: f64,
    },
    /// A lowered floor of a pair that is not checked.
    #[error("it lowers the floor of {a} × {b}, which are no pair of this robot and scene")]
    UnknownPair {
        /// First body.
        a: String,
        /// Second body.
        b: String,
    },
    /// The robot has no geometry.
    #[error("it proves nothing: {0}")]
    NoGeometry(String),
    /// Two bodies overlap where the path starts.
    #[error("{} overlaps {} at the first waypoint", bodies[0], bodies[1])]
    StandsIn {
        /// Their names.
        bodies: [String; 2],
    },
    /// A pair is closer than claimed.
    #[error("{0}")]
    Closer(Closeness),
    /// A pair is nowhere seen closer than claimed, but not proved either.
    #[error("{0}, and not provably anything near it")]
    NotProved(Closeness),
    /// `stop` said so.
    #[error("stopped before all of it was verified")]
    Stopped,
}

/// Two bodies at one place of the path.
#[derive(Clone, Debug, PartialEq)]
pub struct Closeness {
    /// Segment, from 0.
    pub segment: usize,
    /// Ratio on the segment.
    pub t: f64,
    /// Names of the two bodies.
    pub bodies: [String; 2],
    /// Their distance there (m), negative where they overlap.
    pub distance_m: f64,
    /// Distance that they are claimed to keep (m).
    pub claimed_m: f64,
}

impl std::fmt::Display for Closeness {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            segment,
            t,
            bodies: [a, b],
            distance_m,
            claimed_m,
        } = self;
        let segment = segment + 1;
        match claimed_m.is_finite() {
            true => {
                write!(
                    f,
                    "segment {segment}, t = {t:.6}: {a} × {b} are {distance_m} m apart, claimed {claimed_m} m"
                )
            }
            false => write!(
                f,
                "segment {segment}: it claims that nothing can collide, but {a} × {b} can"
            ),
        }
    }
}
