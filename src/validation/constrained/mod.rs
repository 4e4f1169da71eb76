//! What a constraint keeps on an interval of a segment: the theorem of [`crate::constraint`], with the
//! acceleration that [`motion`](super::motion) bounds.

#[cfg(test)]
mod tests;

use super::motion::MotionBounds;
use crate::constraint::{Held, Stand};

/// What rounding may take from a depth (m, or rad): some thousand times the last bit of a few metres.
const ROUNDING: f64 = 1e-12;

/// Depth that a vector keeps in one of its regions on the interval of this half width about where
/// the robot stands, at the segment's velocity; `bounds` are of its chain on the segment.
pub(super) fn kept(held: &Held, stand: &Stand, bounds: &MotionBounds, half: f64) -> f64 {
    let at = held.watched.at(stand);
    let way = held.watched.rate(stand) * half;
    let bend = 0.5 * half * half * bounds.acceleration(0);
    held.kept([at - way, at + way], bend + ROUNDING)
}
