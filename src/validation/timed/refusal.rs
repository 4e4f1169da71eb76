//! Where a piece of a timed trajectory is refused, on the curve itself.

use super::{Piece, Prover, TimedHit};
use crate::solid::TOUCHING_M;
use crate::validation::first_contact::{FirstContact, Touch, UNSEEN_DEPTH_M};
use crate::validation::{Hit, HitReason};

/// Least step of the search for the first touch, as part of the piece.
const STEP: f64 = 1.0 / 1024.0;
/// Parts of a piece that are searched for contact before those that are left are taken as they are.
const MOST_PARTS: u32 = 4096;

impl Prover<'_, '_, '_> {
    /// The collision of a pair on the curve of a piece, where it touches at the time at which the
    /// chord was refused.
    pub(super) fn touch(&mut self, piece: &Piece, hit: &Hit) -> Option<TimedHit> {
        let seen = self.seen(piece, hit);
        (seen.contact.distance <= TOUCHING_M).then(|| {
            self.first_touch(piece, hit.pair, seen.clone())
                .unwrap_or(seen)
        })
    }

    /// The refusal of a piece that is not provable: where the pair touches after all, or where the
    /// chord was refused.
    pub(super) fn refusal(&mut self, piece: &Piece, hit: &Hit) -> TimedHit {
        let seen = self.seen(piece, hit);
        self.first_touch(piece, hit.pair, seen.clone())
            .unwrap_or(seen)
    }

    /// The curve when the chord was refused.
    fn seen(&mut self, piece: &Piece, hit: &Hit) -> TimedHit {
        let at = piece.from + hit.t * piece.width();
        let time_s = self.curve.time(piece.point) + at;
        let contact = self
            .validator
            .contact(hit.pair, &self.curve.at(piece.point, at));
        let reason = match hit.reason {
            _ if contact.distance <= TOUCHING_M => HitReason::Collision,
            // Only the chord touches.
            HitReason::Collision => HitReason::TooClose,
            reason => reason,
        };
        TimedHit {
            reason,
            point: piece.point,
            time_s,
            pair: hit.pair,
            seen_s: time_s,
            contact,
        }
    }

    /// Goes along the curve, each step as long as the pair cannot touch before its end, but no
    /// shorter than [`STEP`].
    fn first_touch(&mut self, piece: &Piece, pair: usize, seen: TimedHit) -> Option<TimedHit> {
        let speed = self
            .reach
            .cost(&self.curve.speeds(piece.point, piece.from, piece.to));
        let mut at = piece.from;
        while at <= piece.to {
            let contact = self
                .validator
                .contact(pair, &self.curve.at(piece.point, at));
            if contact.distance <= TOUCHING_M {
                let time_s = self.curve.time(piece.point) + at;
                let touching = TimedHit {
                    reason: HitReason::Collision,
                    time_s,
                    ..seen.clone()
                };
                let is_seen = seen.reason == HitReason::Collision;
                return Some(if is_seen {
                    touching
                } else {
                    TimedHit {
                        seen_s: time_s,
                        contact,
                        ..touching
                    }
                });
            }
            at += (contact.distance / speed).max(STEP * piece.width());
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
            let [from, to] = self.chord(&part);
            let touch = match self.validator.first_contact([&from, &to], stop) {
                FirstContact::Nothing => continue,
                FirstContact::At(touch) | FirstContact::Stopped(Some(touch)) => {
                    self.touch_at(&part, touch)
                }
                // What is known is a collision, if perhaps not the first.
                FirstContact::Stopped(None) => return known.cloned().map(Some),
            };
            if let Some(touch) = touch {
                return Some(Some(touch).filter(is_before).or_else(|| known.cloned()));
            }
            // Only the chord touches.
            if can_be_halved {
                open.extend(part.halves());
            }
        }
        Some(known.cloned())
    }

    /// A contact on the chord of a piece, where it is one on the curve.
    fn touch_at(&mut self, piece: &Piece, Touch { t, pair }: Touch) -> Option<TimedHit> {
        let at = piece.from + t * piece.width();
        let contact = self
            .validator
            .contact(pair, &self.curve.at(piece.point, at));
        let time_s = self.curve.time(piece.point) + at;
        let reason = HitReason::Collision;
        let touch = TimedHit {
            reason,
            point: piece.point,
            time_s,
            pair,
            seen_s: time_s,
            contact,
        };
        (contact.distance <= TOUCHING_M).then(|| {
            self.first_touch(piece, pair, touch.clone())
                .unwrap_or(touch)
        })
    }
}
