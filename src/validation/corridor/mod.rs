//! The corridor of a proved path: how far what is executed may stray from it.
//!
//! A certificate claims of each segment a clearance c that every pair keeps on it. With the
//! [`Reach`] of each coordinate that makes a promise for configurations beside the path: for every
//! configuration p of the segment and every q with Σ_j reach_j |(q ⊖ p)_j| ≤ c − floor = slack,
//! every pair keeps the floor at q, and on the straight way from p to q. A pair whose own floor is
//! higher keeps c − slack too, but perhaps not its own.
//!
//! A proof stops as soon as floors are kept, and its claims are little more than the floors.
//! [`Validator::widen`] proves each segment again at larger clearances.

#[cfg(test)]
mod tests;

use super::demand::{Demand, Directions};
use super::interval::ROUNDING_M;
use super::path_proof::ends;
use super::reach::{Ranges, Reach};
use super::validator::Validator;
use super::{Certificate, SegmentProof, SegmentVerdict};
use crate::collision::CollisionModel;
use crate::path::Path;

/// No corridor is wider than this (m): beyond, nobody asks, and obstacles that are always farther
/// are left out.
pub const WIDEST_M: f64 = 0.1;
/// A clearance is proved only where bodies are this many times as far apart in the middle of an
/// interval; nearer to 1 the corridor is wider and dearer.
const MARGIN: f64 = 1.1;
/// The search for the largest clearance ends where the next would be less than this many times the
/// one proved.
const FINEST_STEP: f64 = 1.1;
/// A clearance that is refused is followed by one that is at most this many times as large.
const SHRINK: f64 = 0.8;

/// How far configurations may be from a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Corridor {
    /// Distance that every pair keeps within the corridor (m).
    pub floor_m: f64,
    /// How far bodies move at most against each other, per unit of each velocity coordinate (m per
    /// rad or m).
    pub reach: Vec<f64>,
    /// For each segment the largest Σ_j reach_j |(q ⊖ p)_j| (m), in [0, [`WIDEST_M`]].
    pub slack_m: Vec<f64>,
}

impl Corridor {
    /// The corridor that a certificate of this model and path gives.
    pub fn new(model: &CollisionModel, path: &Path, certificate: &Certificate) -> Self {
        let defaults = model
            .robot()
            .held()
            .iter()
            .map(|variable| variable.default);
        let held: Vec<f64> = certificate
            .held
            .clone()
            .unwrap_or_else(|| defaults.collect());
        let mut ranges = Ranges::none(path.nq());
        path.waypoints()
            .for_each(|waypoint| ranges.add(waypoint));
        Self {
            floor_m: certificate.floor_m(),
            reach: Reach::new(model, &held, &ranges, WIDEST_M)
                .all()
                .to_vec(),
            slack_m: slack_m(certificate),
        }
    }
}

/// What each segment of a certificate keeps above its least floor (m), in [0, [`WIDEST_M`]].
pub fn slack_m(certificate: &Certificate) -> Vec<f64> {
    let floor = certificate.floor_m() + ROUNDING_M;
    let segments = certificate.segments.iter();
    segments
        .map(|segment| slack(segment.clearance_m, floor))
        .collect()
}

/// What a clearance leaves above a floor; all of it where nothing is near.
fn slack(clearance: Option<f64>, floor: f64) -> f64 {
    clearance.map_or(WIDEST_M, |kept| (kept - floor).clamp(0.0, WIDEST_M))
}

impl Validator<'_> {
    /// Proves each segment of a proved path again, at the largest clearance below [`WIDEST_M`] that
    /// can be found, and puts that in its proof. What is proved and where pairs were seen apart
    /// stay as they were.
    ///
    /// Where `stop` says so or the search costs more than it may, the segments that are left keep
    /// the proofs they have.
    pub fn widen(
        &mut self,
        path: &Path,
        proofs: &mut [SegmentProof],
        stop: &mut dyn FnMut() -> bool,
    ) {
        let most_work = self.work() + 500_000 + 100_000 * path.len() as u64;
        let mut directions = Directions::default();
        for (segment, proof) in proofs.iter_mut().enumerate() {
            if !self.widen_segment(ends(path, segment), proof, most_work, &mut directions, stop) {
                break;
            }
        }
    }

    /// False where it was ended.
    fn widen_segment(
        &mut self,
        ends: [&[f64]; 2],
        proof: &mut SegmentProof,
        most_work: u64,
        directions: &mut Directions,
        stop: &mut dyn FnMut() -> bool,
    ) -> bool {
        let mut clearance = WIDEST_M;
        while clearance >= FINEST_STEP * proof.clearance_m {
            if stop() || self.work() > most_work {
                return false;
            }
            match self.prove_keeping(ends, clearance, directions, stop) {
                SegmentVerdict::Proved(wider) => {
                    let clearance_m = wider.clearance_m.max(clearance);
                    *proof = SegmentProof {
                        clearance_m,
                        ..wider
                    };
                    return true;
                }
                // The bodies that refused it come as near as this: what is wider is refused there too.
                SegmentVerdict::Refused(hit) => {
                    clearance = (hit.measure.amount / MARGIN).min(SHRINK * clearance)
                }
                SegmentVerdict::Stopped => return false,
            }
        }
        true
    }

    /// Proves a segment at this clearance in the place of every floor; nothing is remembered.
    fn prove_keeping(
        &mut self,
        ends: [&[f64]; 2],
        clearance: f64,
        directions: &mut Directions,
        stop: &mut dyn FnMut() -> bool,
    ) -> SegmentVerdict {
        let pairs = self.model().pairs().len();
        self.other_floors.reset(pairs, clearance);
        let mut demand = Demand {
            margin: MARGIN,
            ..Demand::proof(self.other_floors, directions)
        };
        let verdict = self
            .examiner
            .segment(&mut demand, ends.into(), stop);
        // What is known of it is known at that clearance.
        self.examiner.forget();
        verdict
    }
}
