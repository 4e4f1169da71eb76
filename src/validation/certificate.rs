//! The proof in short: what was proved, of what, by which checker, and by how much.

use serde::{Deserialize, Serialize};

use super::SegmentProof;
use crate::collision::CollisionModel;
use crate::path::Path;

/// Raised whenever the checker proves or refuses anything differently.
pub const CHECKER_VERSION: u32 = 1;

/// A claim that a path is free, small enough to travel with every answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Certificate {
    /// [`CHECKER_VERSION`] of the checker that made it.
    pub checker_version: u32,
    /// Content hash of the path.
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
    /// Pairs with a lowered floor: names of the bodies and floor (m).
    pub lowered: Vec<(String, String, f64)>,
    /// One claim per segment.
    pub segments: Vec<SegmentClaim>,
}

/// What is claimed of one segment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SegmentClaim {
    /// Distance that every pair keeps on the segment (m); `None` where nothing comes near.
    pub clearance_m: Option<f64>,
    /// Intervals of the proof.
    pub intervals: u32,
}

impl Certificate {
    /// Certificate of a path proved with these results, one per segment.
    pub(crate) fn new(
        model: &CollisionModel,
        path: &Path,
        clearance_m: f64,
        lowered: Vec<(String, String, f64)>,
        proofs: &[SegmentProof],
    ) -> Self {
        let claim = |proof: &SegmentProof| SegmentClaim {
            clearance_m: proof.clearance_m.is_finite().then_some(proof.clearance_m),
            intervals: proof.intervals,
        };
        Self {
            checker_version: CHECKER_VERSION,
            path_hash: path.hash(),
            robot_hash: model.robot().hash(),
            scene_hash: model.scene().hash(),
            clearance_m,
            lowered,
            segments: proofs.iter().map(claim).collect(),
        }
    }

    /// Smallest clearance claimed of any segment (m); `None` where nothing comes near.
    pub fn clearance_m(&self) -> Option<f64> {
        self.segments.iter().filter_map(|segment| segment.clearance_m).min_by(f64::total_cmp)
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
