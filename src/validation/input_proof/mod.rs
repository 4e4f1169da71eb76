//! Proof of a request's input. Its verdict is the worst thing on the path: a collision anywhere
//! goes before whatever is too close or not provable anywhere, and of all collisions the first
//! along the path is the one that is told.
//!
//! Constraints come first: where the input strays further than they allow, and that is allowed, their
//! tolerances are raised to what it keeps.
//!
//! A path that is proved at the floors asked for costs nothing beyond that proof. Of any other, all
//! [`waypoints`](super::waypoints) are looked at: nothing that follows one that collides counts. Up
//! to there segments are proved in order, in [`runs`](super::runs) where a collision is known, and
//! with floors lowered where that is allowed; one that cannot be proved is searched for contact of
//! any pair ([`first_contact`](super::first_contact)). A stop leaves the collision that is known by
//! then, which need not be the first, or no verdict.

use std::ops::Range;

use super::continuous::Attempt;
use super::first_contact::{FirstContact, Touch};
use super::path_proof::{PathVerdict, ends, segments};
use super::requirement::{Measure, Requirement};
use super::runs::Runs;
use super::validator::FINEST;
use super::waypoints::Colliding;
use super::{
    Enclosed, Hit, HitReason, Proved, RowsVerdict, SegmentProof, SegmentRefusal, SegmentVerdict,
    Validator,
};
use crate::path::Path;

/// Segments that are proved together: what is left of them is looked at again after one that needs
/// lower floors.
const BATCH: usize = 128;
/// Where a collision is known, what is before it is proved in runs of up to so many segments.
const LONGEST_RUN: usize = 64;
/// Of a path of more waypoints, its ends are looked at before anything is proved: that costs next
/// to nothing then. A look at all of them costs as much as their proof.
const MANY_WAYPOINTS: usize = 128;

/// Proves a request's input. Where `may_lower`, the floor of each requirement of which less is kept
/// is lowered: to the largest of δ/4, δ/16, …, and last
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
        Enclosed::Broken(requirement, measure) => {
            let touch = Touch {
                t: 0.0,
                requirement,
            };
            return PathVerdict::refused(0, collision(touch, measure));
        }
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

fn collision(touch: Touch, measure: Measure) -> Hit {
    Hit {
        reason: HitReason::Collision,
        t: touch.t,
        requirement: touch.requirement,
        measure,
        proved_until: 0.0,
    }
}

/// A contact on the path.
#[derive(Clone, Copy, Debug)]
struct Collision {
    segment: usize,
    touch: Touch,
}

impl Collision {
    /// Whether it is strictly before another on the path.
    fn is_before(&self, other: &Self) -> bool {
        let place = |it: &Self| (it.segment, it.touch.t);
        place(other) > place(self)
    }
}

/// What a refused requirement is found to be.
enum Weighed {
    /// Its floor is lowered: the segment may be provable now.
    Lowered,
    Touching,
    /// Apart, but closer than can be proved.
    Apart,
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
            Some(collision) if collision.touch.t == 0.0 => Some(()),
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
                None => self.prove_batch(next..end, stop)?,
            };
            next = reached;
            if !is_refused {
                most = longest.min(2 * most);
            } else if most > 1 {
                // A run is refused more easily than its segments: shorter ones stray less.
                most /= 4.min(most);
            } else if self.is_settled_by(next, stop)? {
                return Some(());
            } else {
                next += 1;
            }
        }
        Some(())
    }

    /// Proves the next segments together; where that ended, and whether by a refusal.
    fn prove_batch(
        &mut self,
        segments: Range<usize>,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<(usize, bool)> {
        let batch = segments.start..segments.end.min(segments.start + BATCH);
        let end = batch.end;
        let reached = self
            .validator
            .prove_in_order(self.path, batch, &mut self.proofs, stop)?;
        Some((reached, reached < end))
    }

    /// Where all is well this is all that a proof costs.
    fn all_together(&mut self, stop: &mut dyn FnMut() -> bool) -> Option<()> {
        loop {
            match self.validator.prove(self.path.as_flat(), stop) {
                RowsVerdict::Proved(proved) => self.proofs = proved.into_proofs(),
                RowsVerdict::Refused(refusal) if self.raises_tolerance(&refusal) => continue,
                // What is proved of it all the same is not proved again.
                RowsVerdict::Refused(_) => self.validator.remember_proved(),
                RowsVerdict::Stopped => return None,
            }
            return Some(());
        }
    }

    /// Raises the tolerance of a constraint that the input does not keep, where that is allowed. Nothing
    /// else is looked at before the input keeps all of them.
    fn raises_tolerance(&mut self, refusal: &SegmentRefusal) -> bool {
        let SegmentRefusal {
            segment,
            t,
            requirement,
            ..
        } = *refusal;
        if !self.may_lower || matches!(requirement, Requirement::Clearance(_)) {
            return false;
        }
        let measure = self
            .validator
            .measure(requirement, ends(self.path, segment), t);
        self.lower(requirement, measure.amount)
    }

    fn look_at_waypoints(
        &mut self,
        waypoints: impl Iterator<Item = usize>,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<()> {
        let colliding = self
            .validator
            .colliding_waypoint(self.path, waypoints, stop)?;
        colliding
            .into_iter()
            .for_each(|colliding| self.meet_at(colliding));
        Some(())
    }

    /// Takes note of a collision at a waypoint: at the end of the segment before it.
    fn meet_at(&mut self, colliding: Colliding) {
        let Colliding {
            waypoint,
            requirement,
        } = colliding;
        let t = if waypoint == 0 { 0.0 } else { 1.0 };
        self.meet(waypoint.saturating_sub(1), Touch { t, requirement });
    }

    /// A segment that is refused as it stands: lowers floors, or looks for what collides on it.
    /// Whether that is the first collision of the path.
    fn is_settled_by(&mut self, segment: usize, stop: &mut dyn FnMut() -> bool) -> Option<bool> {
        if self.proves_lowering(segment, stop)? {
            return Some(false);
        }
        self.find_contact(segment, stop)?;
        if self.unproved.is_none() {
            self.find_first_refusal(segment, stop)?;
        }
        let here = self
            .collision
            .filter(|collision| collision.segment == segment);
        Some(here.is_some_and(|collision| collision.touch.t < 1.0))
    }

    /// Looks for what collides first on a segment; `None` where stopped.
    fn find_contact(&mut self, segment: usize, stop: &mut dyn FnMut() -> bool) -> Option<()> {
        let found = self
            .validator
            .first_contact(ends(self.path, segment).into(), stop);
        let (touch, is_finished) = match found {
            FirstContact::Nothing => (None, true),
            FirstContact::At(touch) => (Some(touch), true),
            FirstContact::Stopped(touch) => (touch, false),
        };
        touch
            .into_iter()
            .for_each(|touch| self.meet(segment, touch));
        is_finished.then_some(())
    }

    /// Takes note of a contact, if none before it is known.
    fn meet(&mut self, segment: usize, mut touch: Touch) {
        if segment == 0 && touch.t <= FINEST && self.stands_in(touch.requirement) {
            touch.t = 0.0;
        }
        let met = Collision { segment, touch };
        if self
            .collision
            .is_none_or(|known| met.is_before(&known))
        {
            self.collision = Some(met);
        }
    }

    /// Whether bodies touch where the path begins.
    fn stands_in(&mut self, requirement: Requirement) -> bool {
        self.validator
            .is_broken_at(requirement, self.path.waypoint(0))
    }

    /// Lowers floors until the segment is proved; false where it is refused for good.
    fn proves_lowering(&mut self, segment: usize, stop: &mut dyn FnMut() -> bool) -> Option<bool> {
        let ends = ends(self.path, segment);
        loop {
            match self.validator.attempt(ends.into(), stop) {
                Attempt::Stopped => return None,
                Attempt::Proved(proof) => {
                    self.proofs.push(proof);
                    return Some(true);
                }
                Attempt::Refused {
                    t,
                    requirement,
                    reason,
                } => {
                    let touch = Touch { t, requirement };
                    match self.weigh(ends, touch, reason) {
                        Weighed::Lowered => {}
                        Weighed::Apart => return Some(false),
                        Weighed::Touching => {
                            self.meet(segment, touch);
                            return Some(false);
                        }
                    }
                }
            }
        }
    }

    /// Looks at what was refused: lowers its floor where that is allowed and may help.
    fn weigh(
        &mut self,
        ends: [&[f64]; 2],
        Touch { t, requirement }: Touch,
        reason: HitReason,
    ) -> Weighed {
        match reason {
            HitReason::Collision => Weighed::Touching,
            HitReason::Uncertified | HitReason::Outside => Weighed::Apart,
            HitReason::TooClose => {
                let measure = self.validator.measure(requirement, ends, t);
                if measure.touches() {
                    Weighed::Touching
                } else if self.may_lower && self.lower(requirement, measure.amount) {
                    Weighed::Lowered
                } else {
                    Weighed::Apart
                }
            }
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
                SegmentVerdict::Refused(hit) if self.lowers_for(&hit) => {}
                SegmentVerdict::Refused(hit) => {
                    self.note_refusal(segment, hit);
                    return Some(());
                }
            }
        }
    }

    /// Lowers the floor of what keeps too little, if that is allowed and may help.
    fn lowers_for(&mut self, hit: &Hit) -> bool {
        let is_too_close = hit.reason == HitReason::TooClose && self.may_lower;
        is_too_close && self.lower(hit.requirement, self.hope(hit))
    }

    fn note_refusal(&mut self, segment: usize, hit: Hit) {
        if hit.reason == HitReason::Collision {
            let Hit { t, requirement, .. } = hit;
            self.meet(segment, Touch { t, requirement });
        }
        self.unproved = Some((segment, Some(hit)));
    }

    /// What may be kept of what keeps too little: nothing, if it is known to collide.
    fn hope(&self, hit: &Hit) -> f64 {
        let collides = self
            .collision
            .is_some_and(|collision| collision.touch.requirement == hit.requirement);
        if collides { 0.0 } else { hit.measure.amount }
    }

    fn lower(&mut self, requirement: Requirement, amount: f64) -> bool {
        let Some(floor) = self.validator.next_floor(requirement, amount) else {
            return false;
        };
        self.validator.set_floor(requirement, floor);
        true
    }

    fn verdict(mut self, is_finished: bool) -> PathVerdict<'p> {
        let proved_prefix = self.proved_prefix();
        if let Some(Collision { segment, touch }) = self.collision {
            return PathVerdict::Refused {
                segment,
                hit: self.collision_at(segment, touch),
                proved_prefix: proved_prefix.min(segment as f64 + touch.t),
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

    /// Segment + ratio up to which the path is proved.
    fn proved_prefix(&self) -> f64 {
        match self.unproved {
            Some((segment, hit)) => segment as f64 + hit.map_or(0.0, |hit| hit.proved_until),
            None => self.proofs.len() as f64,
        }
    }

    fn collision_at(&mut self, segment: usize, touch: Touch) -> Hit {
        let ends = ends(self.path, segment);
        let measure = self
            .validator
            .measure(touch.requirement, ends, touch.t);
        collision(touch, measure)
    }
}

#[cfg(test)]
mod tests;
