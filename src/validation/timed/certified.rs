//! The proof of a trajectory in short: its certificate.

use super::curve::interpolation;
use super::{Point, TimedProof};
use crate::constraint::ConstraintsFile;
use crate::hash::ContentHasher;
use crate::validation::certificate::{LimitClaim, Subject, Terms, TimedClaims};
use crate::validation::{Certificate, ConstraintClaims, LoweredFloor, Validator};

/// What is claimed of a trajectory besides what its proof says.
#[derive(Clone, Debug, Default)]
pub struct Claims {
    /// What the proof's constraints were asked for by.
    pub constraints: ConstraintsFile,
    /// Limits of velocity and acceleration that its curve keeps.
    pub limits: Vec<LimitClaim>,
}

/// Content hash of a trajectory: times, positions, velocities and accelerations by their exact bits, and
/// which of them are there.
pub fn hash_of(points: &[Point]) -> u64 {
    let mut hasher = ContentHasher::default();
    hasher.text("trajectory").count(points.len());
    for point in points {
        hasher.floats(&[point.time_s]);
        for list in [&point.positions, &point.velocities, &point.accelerations] {
            hasher.count(list.len()).floats(list);
        }
    }
    hasher.finish()
}

/// The certificate of a trajectory that this validator has proved so.
pub fn certificate(
    validator: &Validator,
    points: &[Point],
    proof: &TimedProof,
    claims: Claims,
) -> Certificate {
    let lowered = proof.lowered.iter();
    let terms = Terms {
        clearance_m: validator.floors().common(),
        lowered: lowered
            .map(|&(requirement, floor)| LoweredFloor {
                requirement: validator.named(requirement),
                floor,
            })
            .collect(),
        unwrapped: true,
        held: Some(validator.held().to_vec()).filter(|held| !held.is_empty()),
        constraints: validator
            .left_everywhere()
            .map(|left| ConstraintClaims {
                asked: claims.constraints,
                left: vec![left; proof.segments.len()],
            }),
    };
    let subject = Subject {
        hash: hash_of(points),
        timed: Some(TimedClaims {
            interpolation: points
                .windows(2)
                .map(|ends| interpolation(&ends[0], &ends[1]))
                .collect(),
            limits: claims.limits,
        }),
    };
    Certificate::new(validator.model(), subject, terms, &proof.segments)
}
