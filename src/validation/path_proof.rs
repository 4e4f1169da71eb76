//! Proof of a whole path, and the floors that a request's input sets.

use super::{Contact, Enclosed, Hit, HitReason, SegmentProof, SegmentVerdict, SegmentsVerdict, Validator};
use crate::collision::query::TOUCHING_M;
use crate::path::Path;

/// The lowest floor that is ever promised (m).
pub const LEAST_FLOOR_M: f64 = 1e-6;

/// What is known of a path.
#[derive(Clone, Debug, PartialEq)]
pub enum PathVerdict {
    /// Every segment is proved, in order.
    Proved(Vec<SegmentProof>),
    /// A segment is refused; where several are, a collision goes before what is merely not provable.
    Refused {
        /// The segment, from 0.
        segment: usize,
        /// Why and where.
        hit: Hit,
    },
    /// `stop` said so.
    Stopped,
}

/// Proves every segment at the validator's floors. A path of one waypoint is a segment that does not move.
pub fn prove(validator: &mut Validator, path: &Path, stop: &mut dyn FnMut() -> bool) -> PathVerdict {
    // All segments together first: where all is well, each is then remembered.
    if validator.remembers() && validator.segments(path.segments(), stop) == SegmentsVerdict::Stopped {
        return PathVerdict::Stopped;
    }
    let mut proofs = Vec::with_capacity(segments(path));
    for segment in 0..segments(path) {
        let (from, to) = ends(path, segment);
        match validator.segment(from, to, stop) {
            SegmentVerdict::Proved(proof) => proofs.push(proof),
            SegmentVerdict::Refused(hit) => return PathVerdict::Refused { segment, hit },
            SegmentVerdict::Stopped => return PathVerdict::Stopped,
        }
    }
    PathVerdict::Proved(proofs)
}

/// Proves a request's input, lowering the floor of each pair that comes closer: to the largest of δ/4,
/// δ/16, …, and last [`LEAST_FLOOR_M`], at which it can be proved. Every later path keeps these floors.
///
/// A pair that even the last floor does not prove is reported only after the rest of the path was
/// searched for collisions.
pub fn prove_input(validator: &mut Validator, path: &Path, stop: &mut dyn FnMut() -> bool) -> PathVerdict {
    match validator.enclosed_at(path.waypoint(0), stop) {
        Enclosed::Nothing => {}
        Enclosed::Pair(pair, contact) => return refused_at_start(pair, contact),
        Enclosed::Stopped => return PathVerdict::Stopped,
    }
    if validator.remembers() && validator.segments(path.segments(), stop) == SegmentsVerdict::Stopped {
        return PathVerdict::Stopped;
    }
    let mut proofs = Vec::with_capacity(segments(path));
    let mut unprovable = None;
    for segment in 0..segments(path) {
        let (from, to) = ends(path, segment);
        match prove_lowering(validator, from, to, stop) {
            SegmentVerdict::Proved(proof) => proofs.push(proof),
            SegmentVerdict::Stopped => return PathVerdict::Stopped,
            SegmentVerdict::Refused(hit) if hit.reason == HitReason::Collision => {
                return PathVerdict::Refused { segment, hit };
            }
            SegmentVerdict::Refused(hit) => unprovable = unprovable.or(Some(PathVerdict::Refused { segment, hit })),
        }
    }
    unprovable.unwrap_or(PathVerdict::Proved(proofs))
}

/// One segment of an input: lowers floors until the segment is proved or refused for good.
fn prove_lowering(
    validator: &mut Validator,
    from: &[f64],
    to: &[f64],
    stop: &mut dyn FnMut() -> bool,
) -> SegmentVerdict {
    loop {
        let verdict = match validator.segment(from, to, stop) {
            // The person who reads a collision wants its first place, and what is proved before it.
            SegmentVerdict::Refused(hit) if hit.reason == HitReason::Collision => validator.first_hit(from, to, stop),
            verdict => verdict,
        };
        match verdict {
            SegmentVerdict::Refused(hit) if hit.reason == HitReason::TooClose && lower(validator, &hit) => {}
            SegmentVerdict::Refused(hit) if hit.reason != HitReason::Collision => {
                return SegmentVerdict::Refused(sampled_collision(validator, from, to, hit, stop));
            }
            settled => return settled,
        }
    }
}

/// Least step between the places at which a pair that is not provable is looked at for a collision.
const COLLISION_STEP: f64 = 1.0 / 1024.0;

/// A pair that comes too close for the last floor often touches a little farther on: then that is the
/// verdict, which only samples can find here. Where the pair is farther apart than it can come in a step, longer
/// ones are taken.
fn sampled_collision(
    validator: &mut Validator,
    from: &[f64],
    to: &[f64],
    hit: Hit,
    stop: &mut dyn FnMut() -> bool,
) -> Hit {
    let mut t = 0.0;
    while t <= 1.0 && !stop() {
        let (contact, speed) = validator.contact_and_speed(hit.pair, from, to, t);
        if contact.distance <= TOUCHING_M {
            return Hit { reason: HitReason::Collision, t, contact, ..hit };
        }
        t += (contact.distance / speed).max(COLLISION_STEP);
    }
    hit
}

/// Lowers the floor of the pair that was too close to what the distance seen leaves hope for.
fn lower(validator: &mut Validator, hit: &Hit) -> bool {
    let Some(floor) = lowered_floor(validator.floors()[hit.pair], hit.contact.distance) else { return false };
    validator.set_floor(hit.pair, floor);
    true
}

/// The next floor (m) at which a pair may be proved that was seen at this distance; `None` below the last.
pub(super) fn lowered_floor(mut floor: f64, distance: f64) -> Option<f64> {
    if floor <= LEAST_FLOOR_M {
        return None;
    }
    while floor > LEAST_FLOOR_M {
        floor = (floor / 4.0).max(LEAST_FLOOR_M);
        if distance >= 1.5 * floor {
            break;
        }
    }
    Some(floor)
}

fn refused_at_start(pair: usize, contact: Contact) -> PathVerdict {
    let hit = Hit { reason: HitReason::Collision, t: 0.0, pair, contact, proved_until: 0.0 };
    PathVerdict::Refused { segment: 0, hit }
}

fn segments(path: &Path) -> usize {
    (path.len() - 1).max(1)
}

fn ends(path: &Path, segment: usize) -> (&[f64], &[f64]) {
    (path.waypoint(segment), path.waypoint((segment + 1).min(path.len() - 1)))
}
