//! The proof in short: what was proved, of what, by which checker, and by how much.
//!
//! Anyone can make a certificate, so it counts only as far as the [reference
//! checker](super::reference) finds it true. The digest is no signature: it shows that numbers were
//! changed after the proof, even where they would still be true, and does not keep anybody from
//! computing it anew.

use serde::{Deserialize, Serialize};

use super::{LoweredFloor, RequirementKind, SegmentProof};
use crate::collision::CollisionModel;
use crate::constraint::ConstraintsFile;
use crate::hash::ContentHasher;
use crate::path::Path;

/// Claims that are hashed by one call.
const PORTION: usize = 4096;

/// Raised whenever the checker proves or refuses anything differently.
pub const CHECKER_VERSION: u32 = 3;
/// From this checker version on a step of an angle column means its numbers, and no proved path has
/// one of more than half a turn; before, every step meant the shortest arc.
pub const FIRST_BY_NUMBERS: u32 = 3;
/// Certificates of this checker version and later carry a digest.
pub const FIRST_WITH_DIGEST: u32 = 2;

/// A claim that a path or a trajectory is free, small enough to travel with every answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Certificate {
    /// [`CHECKER_VERSION`] of the checker that made it.
    pub checker_version: u32,
    /// Content hash of the path, or of the trajectory where it is about one.
    #[serde(with = "hex")]
    pub path_hash: u64,
    /// Content hash of the robot.
    #[serde(with = "hex")]
    pub robot_hash: u64,
    /// Content hash of the scene.
    #[serde(with = "hex")]
    pub scene_hash: u64,
    /// Floor of every pair that is not listed (m).
    pub clearance_m: f64,
    /// Requirements with a lowered floor.
    pub lowered: Vec<LoweredFloor>,
    /// Columns of continuous joints are taken as they stand, not as angles on the circle.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub unwrapped: bool,
    /// Values of the robot's held variables (m or rad); `None` = their defaults.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held: Option<Vec<f64>>,
    /// What it keeps besides clearances; `None` = nothing is claimed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub constraints: Option<ConstraintClaims>,
    /// What it claims of times; `None` = it is about a path.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub timed: Option<TimedClaims>,
    /// One claim per segment of the path (of a trajectory: from a point to the next), also of one that does not move; a path of one waypoint
    /// has one.
    pub segments: Vec<SegmentClaim>,
    /// [`Self::content`] when it was made; `None` before checker version [`FIRST_WITH_DIGEST`].
    #[serde(default, skip_serializing_if = "Option::is_none", with = "hex_or_none")]
    pub digest: Option<u64>,
}

/// What a path keeps besides clearances.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConstraintClaims {
    /// What is asked for.
    pub asked: ConstraintsFile,
    /// For each segment, what is left of the tolerance of each constraint (rad or m): negative by no
    /// more than its tolerance is raised.
    pub left: Vec<Vec<f64>>,
}

/// What is claimed of a trajectory, besides what is claimed of paths.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimedClaims {
    /// What a controller goes by from each point to the next.
    pub interpolation: Vec<Interpolation>,
    /// Limits that the curve keeps at every instant.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub limits: Vec<LimitClaim>,
}

/// What ros2_control's `joint_trajectory_controller` goes by from a point to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Interpolation {
    /// Straight: one of the points has no velocities.
    Linear,
    /// A cubic: both have velocities.
    Cubic,
    /// A quintic: both have accelerations too.
    Quintic,
}

/// The limits that a variable keeps, each from the least to the greatest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LimitClaim {
    /// Its name.
    pub variable: String,
    /// m or rad per second.
    pub velocity: [f64; 2],
    /// m or rad per second squared.
    pub acceleration: [f64; 2],
}

/// What is claimed of one segment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SegmentClaim {
    /// Distance that every pair keeps on the segment (m); `None` where there is nothing to collide
    /// with.
    pub clearance_m: Option<f64>,
    /// Intervals of the proof.
    pub intervals: u32,
}

impl ConstraintClaims {
    /// What is claimed to be left of a constraint, by its index, wherever the path is: ∞ where nothing
    /// is claimed.
    pub fn least(&self, constraint: usize) -> f64 {
        let left = self.left.iter();
        left.filter_map(|left| left.get(constraint))
            .copied()
            .fold(f64::INFINITY, f64::min)
    }

    fn hash(&self, hasher: &mut ContentHasher) {
        let asked = serde_json::to_string(&self.asked);
        hasher.text(&asked.expect("numbers and names are written"));
        for left in &self.left {
            hasher.floats(left);
        }
    }
}

impl Interpolation {
    /// Name in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Cubic => "cubic",
            Self::Quintic => "quintic",
        }
    }
}

impl TimedClaims {
    fn hash(&self, hasher: &mut ContentHasher) {
        hasher.text("trajectory");
        for interpolation in &self.interpolation {
            hasher.text(interpolation.name());
        }
        for limit in &self.limits {
            hasher.name(&limit.variable);
            hasher
                .floats(&limit.velocity)
                .floats(&limit.acceleration);
        }
    }
}

impl SegmentClaim {
    /// What a proof says; ∞ has no place in JSON.
    fn of(proof: &SegmentProof) -> Self {
        Self {
            clearance_m: proof
                .clearance_m
                .is_finite()
                .then_some(proof.clearance_m),
            intervals: proof.intervals,
        }
    }

    /// The number of its intervals as text, closed by a zero byte, and the bits of its clearance.
    fn write_content(&self, bytes: &mut Vec<u8>) {
        let clearance = self.clearance_m.unwrap_or(f64::INFINITY);
        bytes.extend_from_slice(self.intervals.to_string().as_bytes());
        bytes.push(0);
        bytes.extend_from_slice(&clearance.to_bits().to_le_bytes());
    }
}

/// What a certificate is about.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Subject {
    /// Content hash of the path or trajectory.
    pub hash: u64,
    /// What is claimed of times, of a trajectory.
    pub timed: Option<TimedClaims>,
}

impl From<&Path> for Subject {
    fn from(path: &Path) -> Self {
        Self {
            hash: path.hash(),
            timed: None,
        }
    }
}

/// What the paths of a request are proved to keep.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Terms {
    /// Floor of every pair that is not listed (m).
    pub clearance_m: f64,
    /// The others.
    pub lowered: Vec<LoweredFloor>,
    /// Whether columns of continuous joints are taken as they stand.
    pub unwrapped: bool,
    /// Values of the held variables, where they are not the defaults.
    pub held: Option<Vec<f64>>,
    /// What they keep besides clearances.
    pub constraints: Option<ConstraintClaims>,
}

impl Certificate {
    /// Certificate of what was proved with these results, one per segment.
    pub(crate) fn new(
        model: &CollisionModel,
        subject: Subject,
        terms: Terms,
        proofs: &[SegmentProof],
    ) -> Self {
        let certificate = Self {
            checker_version: CHECKER_VERSION,
            path_hash: subject.hash,
            robot_hash: model.robot().hash(),
            scene_hash: model.scene().hash(),
            clearance_m: terms.clearance_m,
            lowered: terms.lowered,
            unwrapped: terms.unwrapped,
            held: terms.held,
            constraints: terms.constraints,
            timed: subject.timed,
            segments: proofs.iter().map(SegmentClaim::of).collect(),
            digest: None,
        };
        certificate.sealed()
    }

    /// Smallest clearance claimed of any segment (m); `None` where nothing comes near.
    pub fn clearance_m(&self) -> Option<f64> {
        self.segments
            .iter()
            .filter_map(|segment| segment.clearance_m)
            .min_by(f64::total_cmp)
    }

    /// Smallest floor of any clearance (m).
    pub fn floor_m(&self) -> f64 {
        let clearances = self
            .lowered
            .iter()
            .filter(|lowered| lowered.requirement.kind == RequirementKind::Clearance);
        clearances
            .map(|lowered| lowered.floor)
            .fold(self.clearance_m, f64::min)
    }

    /// The same with the digest of what it says now.
    #[must_use]
    pub fn sealed(self) -> Self {
        Self {
            digest: Some(self.content()),
            ..self
        }
    }

    /// Hash of everything but the digest, by the exact bits of its numbers.
    pub fn content(&self) -> u64 {
        let mut hasher = ContentHasher::default();
        self.hash_subject(&mut hasher);
        self.hash_terms(&mut hasher);
        self.hash_claims(&mut hasher);
        hasher.finish()
    }

    fn hash_claims(&self, hasher: &mut ContentHasher) {
        for claims in self.segments.chunks(PORTION) {
            let mut bytes = Vec::new();
            for claim in claims {
                claim.write_content(&mut bytes);
            }
            hasher.bytes(&bytes);
        }
    }

    /// By which checker, and of what.
    fn hash_subject(&self, hasher: &mut ContentHasher) {
        let checker = u64::from(self.checker_version);
        for number in [checker, self.path_hash, self.robot_hash, self.scene_hash] {
            hasher.text(&format!("{number:016x}"));
        }
    }

    /// Floors, the reading of angles, and the held variables.
    fn hash_terms(&self, hasher: &mut ContentHasher) {
        self.hash_floors(hasher);
        hasher.text(if self.unwrapped {
            "unwrapped"
        } else {
            "wrapped"
        });
        match &self.held {
            Some(held) => hasher.text("held").floats(held),
            None => hasher.text("defaults"),
        };
        if let Some(claims) = &self.constraints {
            claims.hash(hasher);
        }
        if let Some(claims) = &self.timed {
            claims.hash(hasher);
        }
    }

    fn hash_floors(&self, hasher: &mut ContentHasher) {
        hasher.floats(&[self.clearance_m]);
        for LoweredFloor { requirement, floor } in &self.lowered {
            // A clearance's kind is not hashed: certificates of checker version 3 have no other.
            if requirement.kind != RequirementKind::Clearance {
                hasher.text(requirement.kind.name());
            }
            for name in &requirement.names {
                hasher.text(name);
            }
            hasher.floats(&[*floor]);
        }
    }
}

/// Hashes as 16 hex digits: JSON readers lose the last bits of a number as large.
mod hex {
    use serde::{Deserialize, Deserializer, Serializer, de};

    pub fn serialize<S: Serializer>(hash: &u64, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&format_args!("{hash:016x}"))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u64, D::Error> {
        let text = String::deserialize(deserializer)?;
        u64::from_str_radix(&text, 16)
            .map_err(|_| de::Error::custom(format!("{text:?} is not a hash of 16 hex digits")))
    }
}

/// The same where there may be none.
mod hex_or_none {
    use serde::{Deserializer, Serializer};

    pub fn serialize<S: Serializer>(hash: &Option<u64>, serializer: S) -> Result<S::Ok, S::Error> {
        match hash {
            Some(hash) => super::hex::serialize(hash, serializer),
            None => serializer.serialize_none(),
        }
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Option<u64>, D::Error> {
        super::hex::deserialize(deserializer).map(Some)
    }
}
