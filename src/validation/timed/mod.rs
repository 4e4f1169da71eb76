//! Timed trajectories: what a controller executes between the points that it gets is proved, not
//! the points.
//!
//! Between two points a controller follows a polynomial of time in each column (`curve`). That is a
//! segment like any other: the theorem of [`motion`](super::motion) has a form for polynomials, so that
//! the curve itself is proved, pair by pair and in intervals as wide as each may be.
//!
//! All segments are looked at together. Where that is not enough, each in its order: a requirement of
//! which too little is kept has its floor lowered, unless that is forbidden. A collision anywhere goes
//! before whatever is not provable anywhere, and of all collisions the first is told.

pub mod certified;
pub mod curve;
pub mod inside;
#[cfg(test)]
mod soundness;
#[cfg(test)]
pub(super) mod tests;

pub use certified::{Claims, certificate};
pub use curve::{Curve, CurveError, Outside, Point};

use super::continuous::Attempt;
use super::first_contact::{FirstContact, Touch};
use super::polynomial::Polynomial;
use super::requirement::{Measure, Requirement};
use super::validator::Validator;
use super::way::Way;
use super::{Enclosed, HitReason, Nearest, SegmentProof, SegmentsVerdict};

/// What is known of a timed trajectory.
#[derive(Clone, Debug, PartialEq)]
pub enum TimedVerdict {
    /// Every requirement keeps its floor at every instant.
    Proved(TimedProof),
    /// It does not.
    Refused(TimedHit),
    /// `stop` said so.
    Stopped,
}

/// A proof of a timed trajectory.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedProof {
    /// Of each segment, from a point to the next.
    pub segments: Vec<SegmentProof>,
    /// Requirements with a lowered floor, and that floor.
    pub lowered: Vec<(Requirement, f64)>,
}

impl TimedProof {
    /// Distance that every pair keeps at every instant (m); ∞ where nothing is near.
    pub fn clearance_m(&self) -> f64 {
        let segments = self.segments.iter();
        segments
            .map(|proof| proof.clearance_m)
            .fold(f64::INFINITY, f64::min)
    }

    /// Intervals that the proof is made of.
    pub fn intervals(&self) -> u64 {
        let segments = self.segments.iter();
        segments
            .map(|proof| u64::from(proof.intervals))
            .sum()
    }
}

/// Where a timed trajectory is refused.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedHit {
    /// Why.
    pub reason: HitReason,
    /// The point before it, from 0.
    pub point: usize,
    /// When it is first so (s), on the trajectory's clock.
    pub time_s: f64,
    /// What is not kept.
    pub requirement: Requirement,
    /// When it was measured (s): a little later, where bodies are deeper in each other.
    pub seen_s: f64,
    /// How much was kept then.
    pub measure: Measure,
}

impl TimedHit {
    /// Bodies are in each other when the curve begins.
    fn at_start(curve: &Curve, requirement: Requirement, measure: Measure) -> Self {
        let time_s = curve.time(0);
        Self {
            reason: HitReason::Collision,
            point: 0,
            time_s,
            requirement,
            seen_s: time_s,
            measure,
        }
    }
}

/// Proves that a trajectory keeps every requirement at every instant from its first point to its last,
/// at the validator's floors; where not `strict`, floors of what keeps less are lowered, as
/// [`prove_input`](super::path_proof::prove_input) does.
///
/// Columns are taken as they stand: a controller does so.
pub fn prove(
    validator: &mut Validator,
    curve: &Curve,
    strict: bool,
    stop: &mut dyn FnMut() -> bool,
) -> TimedVerdict {
    let verdict = match validator.enclosed_at(&curve.at(0, 0.0), stop) {
        Enclosed::Nothing => proved(validator, curve, strict, stop),
        Enclosed::Stopped => TimedVerdict::Stopped,
        Enclosed::Broken(requirement, measure) => {
            TimedVerdict::Refused(TimedHit::at_start(curve, requirement, measure))
        }
    };
    with_depth(validator, curve, verdict)
}

fn proved(
    validator: &mut Validator,
    curve: &Curve,
    strict: bool,
    stop: &mut dyn FnMut() -> bool,
) -> TimedVerdict {
    match proof(validator, curve, stop) {
        Some(Some(proof)) => return TimedVerdict::Proved(proof),
        Some(None) => {}
        None => return TimedVerdict::Stopped,
    }
    let columns = curve.by_ratio();
    let mut prover = Prover {
        curve,
        columns: &columns,
        validator,
        strict,
    };
    prover.one_by_one(stop)
}

fn with_floors(validator: &Validator, segments: Vec<SegmentProof>) -> TimedVerdict {
    TimedVerdict::Proved(TimedProof {
        segments,
        lowered: validator.floors().lowered().collect(),
    })
}

/// The proof of a trajectory at the validator's floors as they are, `Some(None)` where it is refused and
/// `None` where stopped: cheaper than a verdict, for those that only ask whether it is free. It must go on
/// from what is proved: whether it begins inside of a mesh is not looked at.
pub fn proof(
    validator: &mut Validator,
    curve: &Curve,
    stop: &mut dyn FnMut() -> bool,
) -> Option<Option<TimedProof>> {
    let columns = curve.by_ratio();
    let segments = columns.iter().map(Vec::as_slice);
    match validator.curves(segments, stop) {
        SegmentsVerdict::Proved => Some(Some(TimedProof {
            segments: validator.examiner.proofs_in_order(),
            lowered: validator.floors().lowered().collect(),
        })),
        SegmentsVerdict::Refused(_) => Some(None),
        SegmentsVerdict::Stopped => None,
    }
}

/// Where a trajectory that is proved comes nearest to anything, as
/// [`Validator::nearest`](super::Validator::nearest) finds it on a path: segments are those from a point to
/// the next, ratios those of the time on them ([`Curve::time_of`]).
pub fn nearest(
    validator: &mut Validator,
    curve: &Curve,
    stop: &mut dyn FnMut() -> bool,
) -> Option<Nearest> {
    let columns = curve.by_ratio();
    let ways: Vec<Way> = columns
        .iter()
        .map(|columns| Way::Curved(columns))
        .collect();
    validator.nearest_along(&ways, stop)
}

/// A collision with its penetration depth, which the search for it does without.
fn with_depth(validator: &mut Validator, curve: &Curve, verdict: TimedVerdict) -> TimedVerdict {
    match verdict {
        TimedVerdict::Refused(hit) if hit.reason == HitReason::Collision => {
            let at = curve.at(hit.point, hit.seen_s - curve.time(hit.point));
            let measure = validator.measure_depth(hit.requirement, [&at, &at], 0.0);
            TimedVerdict::Refused(TimedHit { measure, ..hit })
        }
        verdict => verdict,
    }
}

/// What becomes of a segment.
enum Settled {
    Proved(SegmentProof),
    /// The bodies touch.
    Collision(TimedHit),
    /// They do not, but less is kept than can be proved.
    Unprovable(TimedHit),
    /// `stop` said so.
    Stopped,
}

/// What a proof in order needs.
struct Prover<'c, 'v, 'm> {
    curve: &'c Curve,
    /// Of each segment, for t in [0, 1].
    columns: &'c [Vec<Polynomial>],
    validator: &'v mut Validator<'m>,
    strict: bool,
}

impl Prover<'_, '_, '_> {
    /// Segment by segment in the order of time, so that what is refused is refused where it is first.
    fn one_by_one(&mut self, stop: &mut dyn FnMut() -> bool) -> TimedVerdict {
        let mut proofs = Vec::new();
        let mut unprovable = None;
        for point in 0..self.columns.len() {
            match self.settle(point, stop) {
                Settled::Proved(proof) => proofs.push(proof),
                Settled::Collision(hit) => return TimedVerdict::Refused(hit),
                Settled::Unprovable(hit) => unprovable = unprovable.or(Some(hit)),
                Settled::Stopped => return TimedVerdict::Stopped,
            }
        }
        match unprovable {
            Some(hit) => TimedVerdict::Refused(hit),
            None => with_floors(self.validator, proofs),
        }
    }

    /// Proves a segment, with floors lowered where that is allowed and helps, or finds what becomes of
    /// it.
    fn settle(&mut self, point: usize, stop: &mut dyn FnMut() -> bool) -> Settled {
        let way = Way::Curved(&self.columns[point]);
        loop {
            let (touch, reason) = match self.validator.attempt(way, stop) {
                Attempt::Proved(proof) => return Settled::Proved(proof),
                Attempt::Stopped => return Settled::Stopped,
                Attempt::Refused {
                    t,
                    requirement,
                    reason,
                } => (Touch { t, requirement }, reason),
            };
            let seen = self.hit_at(point, touch, reason);
            if !self.lowers_for(&seen) {
                return self.refused(seen, stop);
            }
        }
    }

    /// Lowers the floor of what keeps too little, if that is allowed and may help.
    fn lowers_for(&mut self, seen: &TimedHit) -> bool {
        let may_help = match seen.requirement {
            Requirement::Clearance(_) => seen.reason == HitReason::TooClose,
            Requirement::Constraint(_) => true,
        };
        if self.strict || !may_help {
            return false;
        }
        let floor = self
            .validator
            .next_floor(seen.requirement, seen.measure.amount);
        floor.into_iter().for_each(|floor| {
            self.validator
                .set_floor(seen.requirement, floor)
        });
        floor.is_some()
    }

    /// A place of a segment, measured.
    fn hit_at(&mut self, point: usize, touch: Touch, reason: HitReason) -> TimedHit {
        let Touch { t, requirement } = touch;
        let at = t * self.curve.duration(point);
        let time_s = self.curve.time(point) + at;
        let measure = self
            .validator
            .measure_at(requirement, &self.curve.at(point, at));
        let touches = matches!(requirement, Requirement::Clearance(_)) && measure.touches();
        TimedHit {
            // What decided may have seen another part of the bodies; the closest points have the last
            // word.
            reason: if touches {
                HitReason::Collision
            } else {
                reason
            },
            point,
            time_s,
            requirement,
            seen_s: time_s,
            measure,
        }
    }

    /// A segment that is refused here: what collides on it first goes before that.
    fn refused(&mut self, seen: TimedHit, stop: &mut dyn FnMut() -> bool) -> Settled {
        let way = Way::Curved(&self.columns[seen.point]);
        let touch = match self.validator.first_contact(way, stop) {
            FirstContact::At(touch) | FirstContact::Stopped(Some(touch)) => touch,
            _ if seen.reason == HitReason::Collision => return Settled::Collision(seen),
            FirstContact::Nothing => return Settled::Unprovable(seen),
            FirstContact::Stopped(None) => return Settled::Stopped,
        };
        let first = self.hit_at(seen.point, touch, HitReason::Collision);
        Settled::Collision(deeper(first, seen))
    }
}

/// A touch, with the measure of a later look at the same collision: the bodies are deeper in each other
/// there.
fn deeper(first: TimedHit, seen: TimedHit) -> TimedHit {
    let is_same = seen.reason == HitReason::Collision && seen.requirement == first.requirement;
    match is_same && seen.time_s >= first.time_s {
        true => TimedHit {
            time_s: first.time_s,
            ..seen
        },
        false => first,
    }
}
