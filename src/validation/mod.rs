//! Certified validation: a segment is proved free for every instant of its motion, never by
//! samples.

pub mod certificate;
#[cfg(test)]
pub(crate) mod clouds {
    mod soundness;
    pub(crate) mod tests;
}
mod constrained;
pub mod continuous;
pub mod corridor;
mod demand;
pub mod discretized;
mod examine;
mod examiner;
pub mod filter;
mod first_contact;
mod first_hit;
mod floors;
mod in_order;
mod input_proof;
pub mod interval;
mod ledger;
mod measure;
pub mod motion;
pub mod nearest;
pub mod path_proof;
pub mod polynomial;
#[cfg(test)]
mod probe;
#[cfg(test)]
mod properties;
mod proved;
pub mod reach;
pub mod reference;
mod requirement;
mod runs;
pub mod segment_motion;
#[cfg(test)]
pub(crate) mod soundness;
pub mod timed;
mod undecided;
pub mod validator;
mod way;
mod waypoints;

pub use certificate::{
    Certificate, ConstraintClaims, Interpolation, LimitClaim, SegmentClaim, TimedClaims,
};
pub use constrained::kept::{HOLDING_PART, Kept};
pub use corridor::Corridor;
pub use floors::Floors;
pub use measure::Enclosed;
pub use nearest::{Near, Nearest};
pub use proved::{Proved, RowsVerdict};
pub use requirement::{
    LoweredFloor, Measure, NamedRequirement, Requirement, RequirementKind, Unit,
};
pub use validator::{Scratch, Validator};

pub use crate::solid::Contact;

/// What a validator may use; all of it, unless a test or a measurement wants to know what a layer
/// is worth. Verdicts agree with and without each wherever the clearance is not between 1 and 1.5
/// floors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layers {
    /// The eight-wide filter; without it every pair is decided exactly.
    pub filter: bool,
    /// The bound along the normal with the bend; without it the plain bound V h.
    pub along_normal: bool,
    /// The memory of proved segments.
    pub reuse: bool,
    /// Lanes without the machine's vector instructions: the same numbers, slower.
    pub portable_lanes: bool,
}

impl Default for Layers {
    fn default() -> Self {
        Self {
            filter: true,
            along_normal: true,
            reuse: true,
            portable_lanes: false,
        }
    }
}

/// Tests that a validator has made, by layer. A test of the filter is of eight intervals at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Queries {
    /// Broad phase: balls around whole bodies against nodes over obstacles, and against each other.
    pub far: u64,
    /// Parts of two bodies in the filter.
    pub near: u64,
    /// Balls and pieces of two bodies, exactly.
    pub exact: u64,
}

/// What is known of one straight segment.
#[derive(Clone, Debug, PartialEq)]
pub enum SegmentVerdict {
    /// Every requirement keeps its floor everywhere on the segment.
    Proved(SegmentProof),
    /// Of one less is kept than must be.
    Refused(Hit),
    /// `stop` said so before there was a verdict.
    Stopped,
}

/// What is known of several segments that were looked at together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SegmentsVerdict {
    /// All are proved.
    Proved,
    /// One is refused; not always the first that would be.
    Refused(SegmentRefusal),
    /// `stop` said so before there was a verdict.
    Stopped,
}

/// Where one of several segments is refused, without a measure, which would cost more than finding
/// the place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentRefusal {
    /// The segment, by its number.
    pub segment: usize,
    /// Ratio on the segment, in [0, 1].
    pub t: f64,
    /// What is not kept.
    pub requirement: Requirement,
    /// Why.
    pub reason: HitReason,
}

/// A proof, in short.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentProof {
    /// Distance that every pair keeps on the whole segment (m); at least the smallest floor, ∞
    /// where nothing is near.
    pub clearance_m: f64,
    /// Intervals that the proof is made of.
    pub intervals: u32,
}

impl SegmentProof {
    /// Nothing proved yet: no interval, nothing near.
    const EMPTY: Self = Self {
        clearance_m: f64::INFINITY,
        intervals: 0,
    };
}

/// Why a segment is not proved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HitReason {
    /// The bodies touch or overlap.
    Collision,
    /// Less is kept than 1.5 times the floor.
    TooClose,
    /// The node limit of a lowered floor is spent.
    Uncertified,
    /// A constraint is violated.
    Outside,
}

impl HitReason {
    /// Name in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Collision => "COLLISION",
            Self::TooClose => "TOO_CLOSE",
            Self::Uncertified => "UNCERTIFIED",
            Self::Outside => "OUTSIDE",
        }
    }
}

/// Where a segment is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Why.
    pub reason: HitReason,
    /// Ratio on the segment, in [0, 1].
    pub t: f64,
    /// What is not kept.
    pub requirement: Requirement,
    /// How much of it is kept there.
    pub measure: Measure,
    /// Everything on the segment before this ratio is proved (0 unless the first hit was asked
    /// for).
    pub proved_until: f64,
}
