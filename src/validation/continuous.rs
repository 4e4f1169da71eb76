//! The certified check of one segment: bisection with one forward kinematics per interval, shared by all
//! pairs, and a list of undecided pairs that shrinks on the way down.
//!
//! At an interval, for each pair in its list: a lower bound of the distance over the whole interval
//! reaches the pair's floor → the pair is done; the bodies touch in the middle → collision; they are
//! closer than 1.5 floors → too close; otherwise both halves look again. Pairs that go on are at least
//! 1.5 floors apart in the middle, so they end when their displacement bound falls to half a floor:
//! everything clearer than 1.5 floors is proved, everything proved is at least one floor clear.

use std::collections::VecDeque;
use std::ops::Range;

use super::interval::{IntervalVerdict, Looks, ROUNDING_M};
use super::ledger::Ledger;
use super::segment_motion::SegmentMotion;
use super::{Contact, Hit, HitReason, SegmentProof, SegmentVerdict};
use crate::collision::query::{self, TOUCHING_M};
use crate::collision::{BodyPair, CollisionModel};
use crate::robot::{ConfigurationSpace, Kinematics};

/// Intervals that one pair at a lowered floor may take on one segment before it counts as not provable.
pub const LOWERED_FLOOR_INTERVALS: u32 = 100_000;

/// Reusable memory of a validator; nothing in it outlives a segment but its capacity.
#[derive(Debug, Default)]
pub struct Scratch {
    motion: SegmentMotion,
    kinematics: Kinematics,
    /// Lists of undecided pairs, each a range of this.
    lists: Vec<u32>,
    queue: VecDeque<Interval>,
    /// Intervals spent by each pair with a lowered floor, on this segment.
    spent: Vec<u32>,
    /// What this request's validator has proved.
    ledger: Ledger,
}

/// Whether a body is inside a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Enclosed {
    /// None is.
    Nothing,
    /// This pair, with a point inside and the depth to the nearest surface.
    Pair(usize, Contact),
    /// `stop` said so before all pairs were asked.
    Stopped,
}

/// `[middle − half, middle + half]` of a segment, and the pairs that are undecided there.
#[derive(Clone, Copy, Debug)]
struct Interval {
    middle: f64,
    half: f64,
    first: usize,
    last: usize,
}

/// What a search for a refusal found first.
enum Found {
    Nothing,
    Refusal(Interval, usize, HitReason),
    Stopped,
}

/// Proves segments for one request: one robot and scene, one set of floors.
pub struct Validator<'a> {
    model: &'a CollisionModel,
    space: &'a ConfigurationSpace,
    held: &'a [f64],
    scratch: &'a mut Scratch,
    clearance: f64,
    floors: Vec<f64>,
    work: u64,
    /// The pair that was refused last is looked at first.
    suspect: u32,
}

impl<'a> Validator<'a> {
    /// A validator whose floors are all `clearance` (m); `held` are the values of the robot's held variables.
    pub fn new(
        model: &'a CollisionModel,
        space: &'a ConfigurationSpace,
        held: &'a [f64],
        clearance: f64,
        scratch: &'a mut Scratch,
    ) -> Self {
        scratch.spent.clear();
        scratch.spent.resize(model.pairs().len(), 0);
        scratch.ledger.clear();
        let floors = vec![clearance; model.pairs().len()];
        Self { model, space, held, scratch, clearance, floors, work: 0, suspect: 0 }
    }

    /// Floor of each pair (m).
    pub fn floors(&self) -> &[f64] {
        &self.floors
    }
    /// Sets the floor of one pair (m).
    pub fn set_floor(&mut self, pair: usize, floor: f64) {
        if floor > self.floors[pair] {
            // What was proved at the lower floor says nothing of the higher one.
            self.scratch.ledger.clear();
        }
        self.floors[pair] = floor;
    }
    /// Pairs of balls looked at since the validator was made: what work is counted in.
    pub fn work(&self) -> u64 {
        self.work
    }
    /// The model that is checked.
    pub fn model(&self) -> &'a CollisionModel {
        self.model
    }

    /// Proves the straight segment between two configurations, or refuses it as soon as anything is found.
    ///
    /// Intervals are looked at from wide to narrow, so that a refusal is much cheaper than a proof.
    /// `stop` is asked at every interval, and within it where the search is long.
    pub fn segment(&mut self, from: &[f64], to: &[f64], stop: &mut dyn FnMut() -> bool) -> SegmentVerdict {
        let mut proof = SegmentProof::EMPTY;
        match self.search(from, to, stop, &mut proof) {
            Found::Nothing => SegmentVerdict::Proved(proof),
            Found::Refusal(interval, pair, reason) => SegmentVerdict::Refused(self.hit(&interval, pair, reason)),
            Found::Stopped => SegmentVerdict::Stopped,
        }
    }

    /// Whether [`Self::segment`] would prove the segment; `None` where stopped. Cheaper than asking for the
    /// verdict, because a refusal's exact contact often costs more than finding the refusal.
    pub fn proves(&mut self, from: &[f64], to: &[f64], stop: &mut dyn FnMut() -> bool) -> Option<bool> {
        let mut proof = SegmentProof::EMPTY;
        match self.search(from, to, stop, &mut proof) {
            Found::Nothing => Some(true),
            Found::Refusal(..) => Some(false),
            Found::Stopped => None,
        }
    }

    fn search(&mut self, from: &[f64], to: &[f64], stop: &mut dyn FnMut() -> bool, proof: &mut SegmentProof) -> Found {
        if let Some(known) = self.scratch.ledger.get(from, to) {
            *proof = known;
            return Found::Nothing;
        }
        let whole = self.begin(from, to);
        self.scratch.queue.push_back(whole);
        while let Some(interval) = self.scratch.queue.pop_front() {
            let Some(examined) = self.examine(from, &interval, Until::FirstRefusal, proof, stop) else {
                return Found::Stopped;
            };
            if let Some((pair, reason)) = examined.refused {
                return Found::Refusal(interval, pair, reason);
            }
            self.scratch.queue.extend(interval.halves(examined.undecided).into_iter().flatten());
        }
        self.scratch.ledger.insert(from, to, *proof);
        Found::Nothing
    }

    /// The same verdict as [`Self::segment`], but a refusal is the first along the segment, found to
    /// [`FINEST`]: everything before its `proved_until` is proved.
    pub fn first_hit(&mut self, from: &[f64], to: &[f64], stop: &mut dyn FnMut() -> bool) -> SegmentVerdict {
        let whole = self.begin(from, to);
        self.scratch.queue.push_back(whole);
        let (mut proof, mut earliest) = (SegmentProof::EMPTY, None);
        // A stack on which the left half is always next; a hit makes all that waits to its right idle.
        while let Some(interval) = self.scratch.queue.pop_back() {
            let Some(examined) = self.examine(from, &interval, Until::EveryPair, &mut proof, stop) else {
                return SegmentVerdict::Stopped;
            };
            let [left, right] = interval.halves(examined.undecided);
            if let Some((pair, reason)) = examined.refused {
                earliest = Some((interval, pair, reason));
                self.scratch.queue.clear();
                self.scratch.queue.extend(left.filter(|left| left.half > FINEST));
            } else {
                self.scratch.queue.extend(right.into_iter().chain(left));
            }
        }
        let Some((interval, pair, reason)) = earliest else { return SegmentVerdict::Proved(proof) };
        // The contact is exact and dear: only of the hit that counts.
        self.scratch.motion.place(self.model, self.space, from, interval.middle, self.held);
        SegmentVerdict::Refused(self.hit(&interval, pair, reason))
    }

    /// Closest points of a pair at one configuration, exact, in the world.
    pub fn contact(&mut self, pair: usize, configuration: &[f64]) -> Contact {
        let robot = self.model.robot();
        self.scratch.kinematics.update(robot, configuration, self.held);
        let BodyPair { a, b, .. } = self.model.pairs()[pair];
        let (a, b) = (&self.model.bodies()[a], &self.model.bodies()[b]);
        query::closest(a, &a.placed(&self.scratch.kinematics), b, &b.placed(&self.scratch.kinematics))
    }

    /// The same at a ratio of a segment.
    pub fn contact_between(&mut self, pair: usize, from: &[f64], to: &[f64], t: f64) -> Contact {
        self.scratch.motion.begin(self.model, self.space, from, to, self.held);
        self.scratch.motion.place(self.model, self.space, from, t, self.held);
        self.scratch.motion.contact(self.model, &self.model.pairs()[pair])
    }

    /// The first pair of which one body has a part wholly inside a mesh of the other: no surfaces meet there,
    /// and a proof that goes on from such a configuration would be of no worth. Asked once per request, of the
    /// configuration that everything proved is connected to. `stop` is asked at every pair.
    pub fn enclosed_at(&mut self, configuration: &[f64], stop: &mut dyn FnMut() -> bool) -> Enclosed {
        self.scratch.kinematics.update(self.model.robot(), configuration, self.held);
        let (bodies, kinematics) = (self.model.bodies(), &self.scratch.kinematics);
        for (index, pair) in self.model.pairs().iter().enumerate() {
            let (a, b) = (&bodies[pair.a], &bodies[pair.b]);
            if !(a.hollow || b.hollow) {
                continue;
            }
            if stop() {
                return Enclosed::Stopped;
            }
            if let Some(contact) = query::enclosed(a, &a.placed(kinematics), b, &b.placed(kinematics)) {
                return Enclosed::Pair(index, contact);
            }
        }
        Enclosed::Nothing
    }

    /// Prepares the motion bounds of a segment; returns its whole interval with every pair undecided.
    fn begin(&mut self, from: &[f64], to: &[f64]) -> Interval {
        let scratch = &mut *self.scratch;
        scratch.motion.begin(self.model, self.space, from, to, self.held);
        let pairs = self.model.pairs().len() as u32;
        scratch.lists.clear();
        scratch.lists.extend(Some(self.suspect).filter(|&pair| pair < pairs));
        scratch.lists.extend((0..pairs).filter(|&pair| pair != self.suspect));
        scratch.spent.fill(0);
        scratch.queue.clear();
        Interval { middle: 0.5, half: 0.5, first: 0, last: scratch.lists.len() }
    }

    /// Decides what can be decided on an interval; the pairs left over become a new list. `None` where stopped.
    fn examine(
        &mut self,
        from: &[f64],
        interval: &Interval,
        until: Until,
        proof: &mut SegmentProof,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Examined> {
        if stop() {
            return None;
        }
        proof.intervals += 1;
        self.scratch.motion.place(self.model, self.space, from, interval.middle, self.held);
        let first = self.scratch.lists.len();
        let mut refused = None;
        for slot in interval.first..interval.last {
            let pair = self.scratch.lists[slot];
            let reason = match self.decide(pair as usize, interval.half, stop) {
                IntervalVerdict::Stopped => return None,
                IntervalVerdict::Proved(kept) => {
                    proof.clearance_m = proof.clearance_m.min(kept);
                    continue;
                }
                IntervalVerdict::Collision => Some(HitReason::Collision),
                IntervalVerdict::TooClose => Some(HitReason::TooClose),
                IntervalVerdict::Split => self.spend(pair as usize).then_some(HitReason::Uncertified),
            };
            self.scratch.lists.push(pair);
            if let Some(reason) = reason {
                self.suspect = pair;
                refused = refused.or(Some((pair as usize, reason)));
                if until == Until::FirstRefusal {
                    break;
                }
            }
        }
        Some(Examined { refused, undecided: first..self.scratch.lists.len() })
    }

    /// Counts an interval against a pair with a lowered floor; true once it has had its share.
    fn spend(&mut self, pair: usize) -> bool {
        if self.floors[pair] >= self.clearance {
            return false;
        }
        self.scratch.spent[pair] += 1;
        self.scratch.spent[pair] > LOWERED_FLOOR_INTERVALS
    }

    fn decide(&mut self, pair: usize, half: f64, stop: &mut dyn FnMut() -> bool) -> IntervalVerdict {
        let (model, motion, floor) = (self.model, &self.scratch.motion, self.floors[pair]);
        let pair = &model.pairs()[pair];
        let kept = motion.kept_by_whole_bodies(model, pair, half);
        if kept >= floor + ROUNDING_M {
            self.work += 1;
            return IntervalVerdict::Proved(kept);
        }
        let mut looks = Looks::new(stop);
        let verdict = motion.pair_interval(model, pair, half, floor).decide(&mut looks);
        self.work += looks.count;
        verdict
    }

    fn hit(&mut self, interval: &Interval, pair: usize, reason: HitReason) -> Hit {
        let contact = self.scratch.motion.contact(self.model, &self.model.pairs()[pair]);
        // What decided may have seen another part of the bodies; the closest points have the last word.
        let reason = if contact.distance <= TOUCHING_M { HitReason::Collision } else { reason };
        Hit { reason, t: interval.middle, pair, contact, proved_until: interval.middle - interval.half }
    }
}

#[cfg(test)]
impl Validator<'_> {
    /// Support gap and displacement bound of the closest pieces of a pair on one interval, for the tests of
    /// the bound; `None` where the pieces are too close for a direction.
    pub(crate) fn closest_bound(
        &mut self,
        from: &[f64],
        to: &[f64],
        middle: f64,
        half: f64,
        pair: usize,
    ) -> Option<(f64, f64)> {
        self.begin(from, to);
        self.scratch.motion.place(self.model, self.space, from, middle, self.held);
        let pair = &self.model.pairs()[pair];
        self.scratch.motion.pair_interval(self.model, pair, half, self.clearance).weakest_pieces()
    }
}

/// Width to which [`Validator::first_hit`] narrows a refusal down.
pub const FINEST: f64 = 1.0 / 2048.0;

/// When an interval has been looked at enough.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Until {
    /// One refusal settles the segment.
    FirstRefusal,
    /// The left half needs all that is undecided.
    EveryPair,
}

struct Examined {
    refused: Option<(usize, HitReason)>,
    undecided: Range<usize>,
}

impl Interval {
    /// Both halves with the pairs of `list`, left first; nothing where the list is empty.
    fn halves(&self, list: Range<usize>) -> [Option<Self>; 2] {
        let half = self.half / 2.0;
        let side = |middle| (!list.is_empty()).then_some(Self { middle, half, first: list.start, last: list.end });
        [side(self.middle - half), side(self.middle + half)]
    }
}
