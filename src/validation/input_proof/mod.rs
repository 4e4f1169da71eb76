//! Proof of a request's input. Its verdict is the worst thing on the path: a collision anywhere
//! goes before whatever is too close or not provable anywhere, and of all collisions the first
//! along the path is the one that is told.
//!
//! A path that is proved at the floors asked for costs nothing beyond that proof. Of any other, all
//! [`waypoints`](super::waypoints) are looked at: nothing that follows one that collides counts. Up
//! to there segments are proved in order, in [`runs`](super::runs) where a collision is known, and
//! with floors lowered where that is allowed; one that cannot be proved is searched for contact of
//! any pair ([`first_contact`](super::first_contact)). A stop leaves the collision that is known by
//! then, which need not be the first, or no verdict.

use super::continuous::{Attempt, FINEST};
use super::first_contact::{FirstContact, Touch};
use super::path_proof::{PathVerdict, ends, lowered_floor, segments};
use super::runs::Runs;
use super::waypoints::Colliding;
use super::{
    Contact, Enclosed, Hit, HitReason, Proved, RowsVerdict, SegmentProof, SegmentVerdict, Validator,
};
use crate::path::Path;
use crate::solid::TOUCHING_M;

/// Segments that are proved together: what is left of them is looked at again after one that needs
/// lower floors.
const BATCH: usize = 128;
/// Where a collision is known, what is before it is proved in runs of up to so many segments.
const LONGEST_RUN: usize = 64;
/// Of a path of more waypoints, its ends are looked at before anything is proved: that costs next
/// to nothing then. A look at all of them costs as much as their proof.
const MANY_WAYPOINTS: usize = 128;

/// Proves a request's input. Where `may_lower`, the floor of each pair that comes closer is
/// lowered: to the largest of δ/4, δ/16, …, and last
/// [`LEAST_FLOOR_M`](super::path_proof::LEAST_FLOOR_M), at which it can be proved. Every later path
/// keeps these floors.
pub fn prove_input<'p>(
    validator: &mut Validator,
    path: &'p Path,
    may_lower: bool,
    stop: &mut dyn FnMut() -> bool,
) -> PathVerdict<'p> {
    match validator.enclosed_at(path.waypoint(0), stop) {
        Enclosed::Nothing => {}
        Enclosed::Pair(pair, contact) => return refused_at_start(pair, contact),
        Enclosed::Stopped => return PathVerdict::Stopped,
    }
    let mut proof = InputProof {
        validator,
        path,
        may_lower,
        proofs: Vec::new(),
        collision: None,
        unproved: None,
    };
    let is_finished = proof.search(stop).is_some();
    proof.verdict(is_finished)
}

fn refused_at_start(pair: usize, contact: Contact) -> PathVerdict<'static> {
    let hit = Hit {
        reason: HitReason::Collision,
        t: 0.0,
        pair,
        contact,
        proved_until: 0.0,
    };
    PathVerdict::Refused {
        segment: 0,
        hit,
        proved_prefix: 0.0,
    }
}

/// A contact on the path.
#[derive(Clone, Copy, Debug)]
struct Collision {
    segment: usize,
    touch: Touch,
}

struct InputProof<'v, 'm, 'p> {
    validator: &'v mut Validator<'m>,
    path: &'p Path,
    may_lower: bool,
    /// Of the segments before the first that is not proved, at least.
    proofs: Vec<SegmentProof>,
    /// The first that is known.
    collision: Option<Collision>,
    /// The first segment that is not proved, and where it is first refused.
    unproved: Option<(usize, Option<Hit>)>,
}

impl<'p> InputProof<'_, '_, 'p> {
    /// `None` where stopped.
    fn search(&mut self, stop: &mut dyn FnMut() -> bool) -> Option<()> {
        if self.path.len() > MANY_WAYPOINTS {
            self.look_at_waypoints([0, self.path.len() - 1].into_iter(), stop)?;
        }
        if self.collision.is_none() {
            self.all_together(stop)?;
            if self.proofs.len() == segments(self.path) {
                return Some(());
            }
            self.look_at_waypoints(0..self.path.len(), stop)?;
        }
        match self.collision {
            None => self.prove_up_to(segments(self.path), stop),
            // What stands at the start needs no proof of anything.
            Some(Collision {
                touch: Touch { t: 0.0, .. },
                ..
            }) => Some(()),
            Some(Collision { segment, .. }) => self.prove_up_to(segment + 1, stop),
        }
    }

    /// Proves segment after segment up to the first collision.
    fn prove_up_to(&mut self, end: usize, stop: &mut dyn FnMut() -> bool) -> Option<()> {
        let runs = self
            .collision
            .and_then(|_| Runs::new(self.validator, self.path));
        let longest = if runs.is_some() { LONGEST_RUN } else { 1 };
        let mut next = 0;
        let mut most = longest;
        while next < end {
            let (reached, is_refused) = match &runs {
                Some(runs) => {
                    self.validator
                        .prove_runs(runs, next..end, most, &mut self.proofs, stop)?
                }
                None => {
                    let batch = end.min(next + BATCH);
                    let reached = self.validator.prove_in_order(
                        self.path,
                        next..batch,
                        &mut self.proofs,
                        stop,
                    )?;
                    (reached, reached < batch)
                }
            };
            next = reached;
            if !is_refused {
                most = longest.min(2 * most);
            } else if most > 1 {
                most /= 4.min(most);
            } else if self.is_settled_by(next, stop)? {
                return Some(());
            } else {
                next += 1;
            }
        }
        Some(())
    }

    /// Where all is well this is all that a proof costs.
    fn all_together(&mut self, stop: &mut dyn FnMut() -> bool) -> Option<()> {
        match self.validator.prove(self.path.as_flat(), stop) {
            RowsVerdict::Proved(proved) => self.proofs = proved.into_proofs(),
            // What is proved of it all the same is not proved again.
            RowsVerdict::Refused(_) => self.validator.remember_proved(),
            RowsVerdict::Stopped => return None,
        }
        Some(())
    }

    fn look_at_waypoints(
        &mut self,
        waypoints: impl Iterator<Item = usize>,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<()> {
        if let Some(Colliding { waypoint, pair }) = self
            .validator
            .colliding_waypoint(self.path, waypoints, stop)?
        {
            let t = if waypoint == 0 { 0.0 } else { 1.0 };
            self.meet(waypoint.saturating_sub(1), Touch { t, pair });
        }
        Some(())
    }

    /// A segment that is refused as it stands: lowers floors, or looks for what collides on it.
    /// Whether that is the first collision of the path.
    fn is_settled_by(&mut self, segment: usize, stop: &mut dyn FnMut() -> bool) -> Option<bool> {
        if self.proves_lowering(segment, stop)? {
            return Some(false);
        }
        match self.validator.first_contact(ends(self.path, segment), stop) {
            FirstContact::Nothing => {}
            FirstContact::At(touch) => self.meet(segment, touch),
            FirstContact::Stopped(found) => {
                found
                    .into_iter()
                    .for_each(|touch| self.meet(segment, touch));
                return None;
            }
        }
        if self.unproved.is_none() {
            self.find_first_refusal(segment, stop)?;
        }
        Some(
            self.collision
                .is_some_and(|collision| collision.segment == segment && collision.touch.t < 1.0),
        )
    }

    /// Takes note of a contact, if none before it is known.
    fn meet(&mut self, segment: usize, mut touch: Touch) {
        if segment == 0
            && touch.t <= FINEST
            && self.validator.touches(touch.pair, self.path.waypoint(0))
        {
            touch.t = 0.0;
        }
        let is_later = |known: Collision| (known.segment, known.touch.t) > (segment, touch.t);
        if self.collision.is_none_or(is_later) {
            self.collision = Some(Collision { segment, touch });
        }
    }

    /// Lowers floors until the segment is proved; false where it is refused for good.
    fn proves_lowering(&mut self, segment: usize, stop: &mut dyn FnMut() -> bool) -> Option<bool> {
        let [from, to] = ends(self.path, segment);
        loop {
            let (t, pair, reason) = match self.validator.attempt([from, to], stop) {
                Attempt::Stopped => return None,
                Attempt::Refused { t, pair, reason } => (t, pair, reason),
                Attempt::Proved(proof) => {
                    self.proofs.push(proof);
                    return Some(true);
                }
            };
            let touches = match reason {
                HitReason::Collision => true,
                HitReason::Uncertified => false,
                HitReason::TooClose => {
                    let distance = self.validator.contact_between(pair, from, to, t).distance;
                    if distance > TOUCHING_M && self.may_lower && self.lower(pair, distance) {
                        continue;
                    }
                    distance <= TOUCHING_M
                }
            };
            if touches {
                self.meet(segment, Touch { t, pair });
            }
            return Some(false);
        }
    }

    /// Where the first segment that is not proved is first refused: what is proved of the path ends
    /// there.
    fn find_first_refusal(&mut self, segment: usize, stop: &mut dyn FnMut() -> bool) -> Option<()> {
        self.unproved = Some((segment, None));
        let [from, to] = ends(self.path, segment);
        loop {
            match self.validator.first_hit(from, to, stop) {
                SegmentVerdict::Stopped => return None,
                SegmentVerdict::Proved(proof) => {
                    self.proofs.push(proof);
                    self.unproved = None;
                    return Some(());
                }
                SegmentVerdict::Refused(hit) => {
                    if hit.reason == HitReason::TooClose
                        && self.may_lower
                        && self.lower(hit.pair, self.hope(&hit))
                    {
                        continue;
                    }
                    if hit.reason == HitReason::Collision {
                        self.meet(
                            segment,
                            Touch {
                                t: hit.t,
                                pair: hit.pair,
                            },
                        );
                    }
                    self.unproved = Some((segment, Some(hit)));
                    return Some(());
                }
            }
        }
    }

    /// The distance that a pair which is too close may keep: none, if it is known to collide.
    fn hope(&self, hit: &Hit) -> f64 {
        let collides = self
            .collision
            .is_some_and(|collision| collision.touch.pair == hit.pair);
        if collides { 0.0 } else { hit.contact.distance }
    }

    fn lower(&mut self, pair: usize, distance: f64) -> bool {
        let Some(floor) = lowered_floor(self.validator.floors()[pair], distance) else {
            return false;
        };
        self.validator.set_floor(pair, floor);
        true
    }

    fn verdict(mut self, is_finished: bool) -> PathVerdict<'p> {
        let proved_prefix = match self.unproved {
            Some((segment, hit)) => segment as f64 + hit.map_or(0.0, |hit| hit.proved_until),
            None => self.proofs.len() as f64,
        };
        if let Some(Collision { segment, touch }) = self.collision {
            let hit = self.contact(segment, touch);
            let proved_prefix = proved_prefix.min(segment as f64 + touch.t);
            return PathVerdict::Refused {
                segment,
                hit,
                proved_prefix,
            };
        }
        match self.unproved {
            _ if !is_finished => PathVerdict::Stopped,
            Some((segment, Some(hit))) => PathVerdict::Refused {
                segment,
                hit,
                proved_prefix,
            },
            Some((segment, None)) => unreachable!("segment {segment} is refused nowhere"),
            None => PathVerdict::Proved(Proved::new(self.path.as_flat(), self.proofs)),
        }
    }

    fn contact(&mut self, segment: usize, Touch { t, pair }: Touch) -> Hit {
        let [from, to] = ends(self.path, segment);
        let contact = self.validator.contact_between(pair, from, to, t);
        Hit {
            reason: HitReason::Collision,
            t,
            pair,
            contact,
            proved_until: 0.0,
        }
    }
}

#[cfg(test)]
mod tests;
