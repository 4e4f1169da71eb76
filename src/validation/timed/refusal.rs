//! Where a piece of a timed trajectory is refused, on the curve itself.

use super::{Piece, Prover, TimedHit};
use crate::validation::first_contact::{FirstContact, Touch, UNSEEN_DEPTH_M};
use crate::validation::{Hit, HitReason, Requirement};

/// Least step of the search for the first touch, as part of the piece.
const STEP: f64 = 1.0 / 1024.0;
/// Parts of a piece that are searched for contact before those that are left are taken as they are.
const MOST_PARTS: u32 = 4096;

/// A touch, with the closest points of a later look at a collision: the bodies are deeper in each
/// other there.
fn deeper(touch: TimedHit, seen: &TimedHit) -> TimedHit {
    match seen.reason {
        HitReason::Collision => TimedHit {
            time_s: touch.time_s,
            ..seen.clone()
        },
        _ => touch,
    }
}

impl Prover<'_, '_, '_> {
    /// The collision of a pair on the curve of a piece, where it touches at the time at which the
    /// chord was refused.
    pub(super) fn touch(&mut self, piece: &Piece, hit: &Hit) -> Option<TimedHit> {
        let seen = self.seen(piece, hit);
        self.if_touching(piece, seen)
    }

    /// Where a pair first touches that touches when it is seen.
    fn if_touching(&mut self, piece: &Piece, seen: TimedHit) -> Option<TimedHit> {
        let touches = seen.measure.touches();
        touches.then(|| self.traced_back(piece, seen))
    }

    /// The refusal of a piece that is not provable: where the pair touches after all, or where the
    /// chord was refused.
    pub(super) fn refusal(&mut self, piece: &Piece, hit: &Hit) -> TimedHit {
        let seen = self.seen(piece, hit);
        self.traced_back(piece, seen)
    }

    /// Where the pair first touches on the piece, if it does: it may do so before it was seen.
    fn traced_back(&mut self, piece: &Piece, seen: TimedHit) -> TimedHit {
        self.first_touch(piece, &seen).unwrap_or(seen)
    }

    /// A requirement at a time after the piece's point.
    fn hit_at(
        &mut self,
        piece: &Piece,
        requirement: Requirement,
        at: f64,
        reason: HitReason,
    ) -> TimedHit {
        let time_s = self.curve.time(piece.point) + at;
        TimedHit {
            reason,
            point: piece.point,
            time_s,
            requirement,
            seen_s: time_s,
            measure: self
                .validator
                .measure_at(requirement, &self.curve.at(piece.point, at)),
        }
    }

    /// The curve when the chord was refused.
    fn seen(&mut self, piece: &Piece, hit: &Hit) -> TimedHit {
        let at = piece.from + hit.t * piece.width();
        let seen = self.hit_at(piece, hit.requirement, at, hit.reason);
        let reason = match hit.reason {
            _ if seen.measure.touches() => HitReason::Collision,
            // Only the chord touches.
            HitReason::Collision => HitReason::TooClose,
            reason => reason,
        };
        TimedHit { reason, ..seen }
    }

    /// Goes along the curve, each step as long as the pair cannot touch before its end, but no
    /// shorter than [`STEP`].
    fn first_touch(&mut self, piece: &Piece, seen: &TimedHit) -> Option<TimedHit> {
        let speeds = self
            .curve
            .speeds(piece.point, piece.from, piece.to);
        let speed = self.reach.cost(&speeds);
        let mut at = piece.from;
        while at <= piece.to {
            let hit = self.hit_at(piece, seen.requirement, at, HitReason::Collision);
            if hit.measure.touches() {
                return Some(deeper(hit, seen));
            }
            at += (hit.measure.amount / speed).max(STEP * piece.width());
        }
        None
    }
    /// The first collision of any pair on the curve of a piece, `known` among them. `None` where
    /// stopped.
    ///
    /// The piece is searched by its chord, in parts from which the curve strays no farther than
    /// bodies may get into each other unseen.
    pub(super) fn first_collision(
        &mut self,
        piece: &Piece,
        known: Option<&TimedHit>,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Option<TimedHit>> {
        let is_before = |touch: &TimedHit| known.is_none_or(|known| touch.time_s < known.time_s);
        let mut open = vec![*piece];
        let mut parts = 0;
        while let Some(part) = open.pop() {
            parts += 1;
            let can_be_halved = parts < MOST_PARTS && self.can_be_halved(&part);
            if self.deviation(&part) > UNSEEN_DEPTH_M && can_be_halved {
                open.extend(part.halves());
                continue;
            }
            match self.contact_on(&part, stop) {
                FirstContact::Nothing => {}
                FirstContact::At(touch) | FirstContact::Stopped(Some(touch)) => {
                    if let Some(touch) = self.touch_at(&part, touch) {
                        return Some(
                            Some(touch)
                                .filter(is_before)
                                .or_else(|| known.cloned()),
                        );
                    }
                    // Only the chord touches.
                    if can_be_halved {
                        open.extend(part.halves());
                    }
                }
                // What is known is a collision, if perhaps not the first.
                FirstContact::Stopped(None) => return known.cloned().map(Some),
            }
        }
        Some(known.cloned())
    }

    /// The first contact on the chord of a piece.
    fn contact_on(&mut self, piece: &Piece, stop: &mut dyn FnMut() -> bool) -> FirstContact {
        let [from, to] = self.chord(piece);
        self.validator.first_contact([&from, &to], stop)
    }

    /// A contact on the chord of a piece, where it is one on the curve.
    fn touch_at(&mut self, piece: &Piece, touch: Touch) -> Option<TimedHit> {
        let at = piece.from + touch.t * piece.width();
        let touch = self.hit_at(piece, touch.requirement, at, HitReason::Collision);
        self.if_touching(piece, touch)
    }
}
