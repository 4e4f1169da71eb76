//! Proof of a whole path, and the floors that a request's input sets.

use super::validator::CLOSE_MARGIN;
use super::{Hit, Proved, RowsVerdict, SegmentVerdict, Validator};
use crate::path::Path;

pub use super::input_proof::prove_input;

/// The lowest floor that is ever promised (m).
pub const LEAST_FLOOR_M: f64 = 1e-6;

/// What is known of a path.
#[derive(Clone, Debug, PartialEq)]
pub enum PathVerdict<'p> {
    /// Every segment is proved.
    Proved(Proved<'p>),
    /// A segment is refused.
    Refused {
        /// The segment, from 0.
        segment: usize,
        /// Why and where.
        hit: Hit,
        /// Everything before this segment + ratio is proved; what follows need not be.
        proved_prefix: f64,
    },
    /// `stop` said so.
    Stopped,
}

impl PathVerdict<'_> {
    /// A segment is refused, and all before it are proved.
    pub(super) fn refused(segment: usize, hit: Hit) -> Self {
        Self::Refused {
            segment,
            hit,
            proved_prefix: segment as f64,
        }
    }
}

/// Proves every segment at the validator's floors. A path of one waypoint is a segment that does
/// not move.
pub fn prove<'p>(
    validator: &mut Validator,
    path: &'p Path,
    stop: &mut dyn FnMut() -> bool,
) -> PathVerdict<'p> {
    match validator.prove(path.as_flat(), stop) {
        RowsVerdict::Proved(proved) => PathVerdict::Proved(proved),
        RowsVerdict::Refused(_) => first_refused(validator, path, stop),
        RowsVerdict::Stopped => PathVerdict::Stopped,
    }
}

/// The first segment that is refused, of a path that is not proved.
fn first_refused<'p>(
    validator: &mut Validator,
    path: &'p Path,
    stop: &mut dyn FnMut() -> bool,
) -> PathVerdict<'p> {
    let mut proofs = Vec::with_capacity(segments(path));
    for segment in 0..segments(path) {
        let [from, to] = ends(path, segment);
        match validator.segment(from, to, stop) {
            SegmentVerdict::Proved(proof) => proofs.push(proof),
            SegmentVerdict::Refused(hit) => return PathVerdict::refused(segment, hit),
            SegmentVerdict::Stopped => return PathVerdict::Stopped,
        }
    }
    PathVerdict::Proved(Proved::new(path.as_flat(), proofs))
}

/// The next floor (m) at which a requirement may be proved of which this was seen to be kept; `None`
/// below the last.
pub(super) fn lowered_floor(mut floor: f64, amount: f64) -> Option<f64> {
    if floor <= LEAST_FLOOR_M {
        return None;
    }
    while floor > LEAST_FLOOR_M {
        floor = (floor / 4.0).max(LEAST_FLOOR_M);
        if amount >= 1.5 * floor {
            break;
        }
    }
    Some(floor)
}

/// The same for close proofs: a little below the highest at which what is kept may be proved.
pub(super) fn close_floor(floor: f64, amount: f64) -> Option<f64> {
    const LESS: f64 = 0.99;
    let next = LESS * amount / CLOSE_MARGIN;
    (LEAST_FLOOR_M..floor)
        .contains(&next)
        .then_some(next)
}

/// Segments of a path: one that does not move, where there is only one waypoint.
pub(super) fn segments(path: &Path) -> usize {
    (path.len() - 1).max(1)
}

/// Both ends of a segment.
pub(super) fn ends(path: &Path, segment: usize) -> [&[f64]; 2] {
    [segment, (segment + 1).min(path.len() - 1)].map(|waypoint| path.waypoint(waypoint))
}
