//! What the reference checker may have against a certificate.

use crate::constraint::ConstraintError;
use crate::validation::certificate::{CHECKER_VERSION, FIRST_BY_NUMBERS};
use crate::validation::{NamedRequirement, RequirementKind};

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
    /// About something of another kind.
    #[error(
        "it is about {about}, and {given} was given; check trajectories with --timed, paths without"
    )]
    Kind {
        /// What it is about.
        about: &'static str,
        /// What was given.
        given: &'static str,
    },
    /// About something else.
    #[error(
        "it is about the {kind} with hash {claimed:016x}, the {kind} given has {given:016x}; give the {kind} that was proved, bit for bit"
    )]
    Other {
        /// Robot, scene, path or trajectory.
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
    /// Time that does not grow.
    #[error("point {0}: its time is not later than that of the point before")]
    Time(usize),
    /// A quaternion that moves.
    #[error(
        "the quaternion that starts at {variable} turns; only joints of one value can be timed"
    )]
    Turns {
        /// First column of the quaternion.
        variable: String,
    },
    /// A controller goes by something else.
    #[error(
        "segment {}: it claims that a controller goes by a {claimed} function, the points make it go by a {given} one",
        segment + 1
    )]
    Interpolation {
        /// Segment, from 0.
        segment: usize,
        /// What is claimed.
        claimed: &'static str,
        /// What the points say.
        given: &'static str,
    },
    /// Limits of a column that there is none of.
    #[error("it claims limits of {0:?}, which is no variable of the robot")]
    NoVariable(String),
    /// A limit that is not kept.
    #[error("{0}")]
    Limit(Exceeded),
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
    /// A lowered floor of something that is not required.
    #[error("it lowers the floor of {}, {}", .0, not_required(.0))]
    NotRequired(NamedRequirement),
    /// The robot has no geometry.
    #[error("it proves nothing: {0}")]
    NoGeometry(String),
    /// A requirement is not kept where the path starts.
    #[error("{} at the first waypoint", broken(.0))]
    Broken(NamedRequirement),
    /// What it says of constraints means nothing for this robot and scene.
    #[error(transparent)]
    Constraint(#[from] ConstraintError),
    /// Less of a requirement is kept than claimed.
    #[error("{0}")]
    Less(Shortfall),
    /// Nowhere less is seen to be kept than claimed, but it is not proved either.
    #[error("{0}, and not provably anything near it")]
    NotProved(Shortfall),
    /// `stop` said so.
    #[error("stopped before all of it was verified")]
    Stopped,
}

/// Why what a certificate names is not required of a path.
fn not_required(requirement: &NamedRequirement) -> &'static str {
    match requirement.kind {
        RequirementKind::Clearance => "which are no pair of this robot and scene",
        RequirementKind::Orientation | RequirementKind::Position | RequirementKind::Joint => {
            "which is no constraint of the certificate"
        }
    }
}

/// What it means that a requirement is not kept at all.
fn broken(requirement: &NamedRequirement) -> String {
    match requirement.kind {
        RequirementKind::Clearance => requirement.names.join(" overlaps "),
        RequirementKind::Orientation | RequirementKind::Position | RequirementKind::Joint => {
            format!("{requirement} is violated")
        }
    }
}

/// A velocity or acceleration outside of what is claimed.
#[derive(Clone, Debug, PartialEq)]
pub struct Exceeded {
    /// Variable.
    pub variable: String,
    /// Velocity or acceleration.
    pub what: &'static str,
    /// Its value (m or rad, per s or s²).
    pub value: f64,
    /// When (s).
    pub time_s: f64,
    /// The limits that are claimed.
    pub claimed: [f64; 2],
}

impl std::fmt::Display for Exceeded {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            variable,
            what,
            value,
            time_s,
            claimed: [least, most],
        } = self;
        write!(
            f,
            "the {what} of {variable} is {value} at {time_s:.6} s, claimed within {least} and {most}"
        )
    }
}

/// A requirement at one place of the path.
#[derive(Clone, Debug, PartialEq)]
pub struct Shortfall {
    /// Segment, from 0.
    pub segment: usize,
    /// Ratio on the segment.
    pub t: f64,
    /// What is required.
    pub requirement: NamedRequirement,
    /// How much of it is kept there, in its unit: of a clearance the distance, negative where the
    /// bodies overlap.
    pub amount: f64,
    /// How much is claimed to be kept.
    pub claimed: f64,
}

impl std::fmt::Display for Shortfall {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            segment,
            t,
            requirement,
            amount,
            claimed,
        } = self;
        let segment = segment + 1;
        let unit = requirement.unit.name();
        match requirement.kind {
            RequirementKind::Clearance if claimed.is_finite() => write!(
                f,
                "segment {segment}, t = {t:.6}: {requirement} are {amount} m apart, claimed {claimed} m"
            ),
            RequirementKind::Clearance => write!(
                f,
                "segment {segment}: it claims that nothing can collide, but {requirement} can"
            ),
            RequirementKind::Orientation | RequirementKind::Position | RequirementKind::Joint => {
                write!(
                    f,
                    "segment {segment}, t = {t:.6}: {requirement} has {amount} {unit} left, claimed {claimed} {unit}"
                )
            }
        }
    }
}
