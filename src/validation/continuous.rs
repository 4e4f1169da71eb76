//! The certified check of segments: intervals, eight at a time, and lists of undecided pairs that shrink on
//! the way down.
//!
//! A segment is cut into intervals; eight of them, of whatever segments, are looked at together by the
//! [filter](super::rake). What it does not prove is undecided. Where it saw an undecided pair at least 1.5
//! floors apart in the middle, the interval is split; where not, the exact bodies decide: a lower bound of
//! the distance over the whole interval reaches the pair's floor → the pair is done; the bodies touch in the
//! middle → collision; they are closer than 1.5 floors → too close; otherwise it is split. Parts of a split
//! interval look only at the pairs that are undecided there. These are at least 1.5 floors apart in the
//! middle, so they end when their displacement bound falls to half a floor: everything clearer than 1.5
//! floors is proved, everything proved is at least one floor clear.

use std::collections::VecDeque;
use std::ops::RangeInclusive;

use super::interval::{IntervalVerdict, Looks};
use super::ledger::Ledger;
use super::rake::{Pairs, Proving, Rake, RakeScratch};
use super::segment_motion::SegmentMotion;
use super::{Contact, Hit, HitReason, Layers, SegmentProof, SegmentVerdict};
use crate::collision::filter::REMOTE_M;
use crate::collision::query::{self, TOUCHING_M};
use crate::collision::{BodyPair, CollisionModel};
use crate::lanes::{EightWide, InstructionSet, LANES};
use crate::path::Path;
use crate::robot::lane_kinematics::{LaneInterval, LaneSegments};
use crate::robot::{ConfigurationSpace, Kinematics};

/// Intervals that one pair at a lowered floor may take on one segment before it counts as not provable.
pub const LOWERED_FLOOR_INTERVALS: u32 = 100_000;

/// Joint-space motion of the first intervals (rad; translations are divided by the robot's reach).
const START_WIDTH: f64 = 0.35;

/// Reusable memory of a validator; nothing in it outlives a request but its capacity.
#[derive(Debug, Default)]
pub struct Scratch {
    motion: SegmentMotion,
    kinematics: Kinematics,
    pub(super) rake: RakeScratch,
    instructions: InstructionSet,
    segments: Segments,
    /// Lists of undecided pairs, each a range of this.
    lists: Vec<u32>,
    /// The pairs of a rake, each with the lanes that look at it, and where each pair stands in it.
    merged: Vec<(u32, u8)>,
    slots: Vec<u32>,
    queue: VecDeque<Interval>,
    floors: Vec<f64>,
    /// Intervals spent by each pair with a lowered floor, on the segments at hand.
    spent: Vec<u32>,
    /// What this request's validator has proved.
    ledger: Ledger,
}

/// The segments that are being proved.
#[derive(Debug, Default)]
struct Segments {
    /// Both ends of each, one after the other.
    ends: Vec<f64>,
    velocity: Vec<f64>,
    lanes: LaneSegments,
    proofs: Vec<SegmentProof>,
    /// Some end is outside of the limits that remote obstacles count on.
    is_unconfined: bool,
    /// Segment for which the exact motion was prepared, and the place where its bodies stand.
    exact: Option<(usize, Option<f64>)>,
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
#[derive(Clone, Copy, Debug, Default)]
struct Interval {
    segment: usize,
    middle: f64,
    half: f64,
    pairs: List,
}

/// Pairs that are undecided on an interval.
#[derive(Clone, Copy, Debug, Default)]
enum List {
    /// All of the model.
    #[default]
    All,
    /// A range of the lists.
    Of(usize, usize),
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
    pub(super) scratch: &'a mut Scratch,
    layers: Layers,
    clearance: f64,
    highest_floor: f64,
    work: u64,
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
        let pairs = model.pairs().len();
        scratch.floors.clear();
        scratch.floors.resize(pairs, clearance);
        scratch.spent.clear();
        scratch.spent.resize(pairs, 0);
        scratch.slots.clear();
        scratch.slots.resize(pairs, 0);
        scratch.ledger.clear();
        scratch.rake.reset(model.filter(), space, held);
        Self { model, space, held, scratch, layers: Layers::default(), clearance, highest_floor: clearance, work: 0 }
    }

    /// The same with some layers switched off.
    #[must_use]
    pub fn with_layers(mut self, layers: Layers) -> Self {
        self.layers = layers;
        if layers.portable_lanes {
            self.scratch.instructions = InstructionSet::Portable;
        }
        self
    }

    /// Floor of each pair (m).
    pub fn floors(&self) -> &[f64] {
        &self.scratch.floors
    }
    /// Sets the floor of one pair (m).
    pub fn set_floor(&mut self, pair: usize, floor: f64) {
        if floor > self.scratch.floors[pair] {
            // What was proved at the lower floor says nothing of the higher one.
            self.scratch.ledger.clear();
        }
        self.highest_floor = self.highest_floor.max(floor);
        self.scratch.floors[pair] = floor;
    }
    /// Tests of two bodies or parts of them since the validator was made: what work is counted in.
    pub fn work(&self) -> u64 {
        self.work + self.scratch.rake.looks
    }
    /// The model that is checked.
    pub fn model(&self) -> &'a CollisionModel {
        self.model
    }

    /// Proves the straight segment between two configurations, or refuses it as soon as anything is found.
    ///
    /// Intervals are looked at from wide to narrow, so that a refusal is much cheaper than a proof.
    /// `stop` is asked at every eight intervals, and within them where the search is long.
    pub fn segment(&mut self, from: &[f64], to: &[f64], stop: &mut dyn FnMut() -> bool) -> SegmentVerdict {
        if let Some(proof) = self.known(from, to) {
            return SegmentVerdict::Proved(proof);
        }
        self.begin();
        self.add(from, to);
        match self.search(stop) {
            Found::Nothing => SegmentVerdict::Proved(self.scratch.segments.proofs[0]),
            Found::Refusal(interval, pair, reason) => SegmentVerdict::Refused(self.hit(&interval, pair, reason)),
            Found::Stopped => SegmentVerdict::Stopped,
        }
    }

    /// Whether [`Self::segment`] would prove the segment; `None` where stopped. Cheaper than asking for the
    /// verdict, because a refusal's exact contact often costs more than finding the refusal.
    pub fn proves(&mut self, from: &[f64], to: &[f64], stop: &mut dyn FnMut() -> bool) -> Option<bool> {
        if self.known(from, to).is_some() {
            return Some(true);
        }
        self.begin();
        self.add(from, to);
        match self.search(stop) {
            Found::Nothing => Some(true),
            Found::Refusal(..) => Some(false),
            Found::Stopped => None,
        }
    }

    /// Whether every segment of a path is proved, all looked at together; `None` where stopped. What is
    /// proved is remembered for [`Self::segment`].
    pub fn proves_path(&mut self, path: &Path, stop: &mut dyn FnMut() -> bool) -> Option<bool> {
        self.begin();
        for segment in 1..path.len() {
            let (from, to) = (path.waypoint(segment - 1), path.waypoint(segment));
            if self.known(from, to).is_none() {
                self.add(from, to);
            }
        }
        match self.search(stop) {
            Found::Nothing => Some(true),
            Found::Refusal(..) => Some(false),
            Found::Stopped => None,
        }
    }

    fn known(&self, from: &[f64], to: &[f64]) -> Option<SegmentProof> {
        self.layers.reuse.then(|| self.scratch.ledger.get(from, to)).flatten()
    }

    /// Looks at all that is queued, wide intervals first; remembers the segments if all are proved.
    fn search(&mut self, stop: &mut dyn FnMut() -> bool) -> Found {
        while !self.scratch.queue.is_empty() {
            let (rake, count) = self.next_rake();
            let Some(examined) = self.examine(&rake[..count], Until::FirstRefusal, stop) else {
                return Found::Stopped;
            };
            if let Some((lane, pair, reason)) = examined.refused {
                return Found::Refusal(rake[lane], pair, reason);
            }
            for (interval, undecided) in rake.iter().zip(&examined.undecided) {
                self.scratch.queue.extend(interval.split(undecided));
            }
        }
        let nq = self.space.nq();
        let segments = &self.scratch.segments;
        if self.layers.reuse {
            for (ends, proof) in segments.ends.chunks((2 * nq).max(1)).zip(&segments.proofs) {
                self.scratch.ledger.insert(&ends[..nq], &ends[nq..], *proof);
            }
        }
        Found::Nothing
    }

    /// Up to eight intervals from the queue, either all new or all parts of others.
    fn next_rake(&mut self) -> ([Interval; LANES], usize) {
        let queue = &mut self.scratch.queue;
        let mut rake = [Interval::default(); LANES];
        let mut count = 0;
        while count < LANES {
            let Some(next) = queue.front().filter(|next| count == 0 || next.pairs.is_all() == rake[0].pairs.is_all())
            else {
                break;
            };
            rake[count] = *next;
            count += 1;
            queue.pop_front();
        }
        (rake, count)
    }

    /// The same verdict as [`Self::segment`], but a refusal is the first along the segment, found to
    /// [`FINEST`]: everything before its `proved_until` is proved.
    pub fn first_hit(&mut self, from: &[f64], to: &[f64], stop: &mut dyn FnMut() -> bool) -> SegmentVerdict {
        self.begin();
        self.add(from, to);
        // A stack on which what is farthest left is next; a hit makes all that waits to its right idle.
        self.scratch.queue.make_contiguous().reverse();
        let mut earliest = None;
        while let Some(interval) = self.scratch.queue.pop_back() {
            let Some(examined) = self.examine(&[interval], Until::EveryPair, stop) else {
                return SegmentVerdict::Stopped;
            };
            let list = &examined.undecided[0];
            if let Some((_, pair, reason)) = examined.refused {
                earliest = Some((interval, pair, reason));
                self.scratch.queue.clear();
                let half = interval.half / 2.0;
                let left = Interval { middle: interval.middle - half, half, pairs: list.pairs, ..interval };
                self.scratch.queue.extend(Some(left).filter(|left| left.half > FINEST));
            } else {
                self.scratch.queue.extend(interval.split(list).rev());
            }
        }
        let Some((interval, pair, reason)) = earliest else {
            return SegmentVerdict::Proved(self.scratch.segments.proofs[0]);
        };
        // The contact is exact and dear: only of the hit that counts.
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
        self.scratch.segments.exact = None;
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

    /// Forgets the segments at hand.
    pub(super) fn begin(&mut self) {
        let scratch = &mut *self.scratch;
        scratch.segments.ends.clear();
        scratch.segments.lanes.clear();
        scratch.segments.proofs.clear();
        scratch.segments.is_unconfined = false;
        scratch.segments.exact = None;
        scratch.lists.clear();
        scratch.queue.clear();
        if scratch.floors.iter().any(|floor| *floor < self.clearance) {
            scratch.spent.fill(0);
        }
    }

    /// Adds a segment to those at hand, and its first intervals to the queue; returns the size of its motion (rad).
    pub(super) fn add(&mut self, from: &[f64], to: &[f64]) -> f64 {
        let (filter, segments) = (self.model.filter(), &mut self.scratch.segments);
        segments.velocity.resize(self.space.nv(), 0.0);
        self.space.difference(to, from, &mut segments.velocity);
        segments.lanes.push(&filter.skeleton, from, &segments.velocity, self.held);
        segments.ends.extend_from_slice(from);
        segments.ends.extend_from_slice(to);
        let is_outside =
            |(q, range): &(usize, RangeInclusive<f64>)| !range.contains(&from[*q]) || !range.contains(&to[*q]);
        segments.is_unconfined |= filter.confines.iter().any(is_outside);
        let segment = segments.proofs.len();
        segments.proofs.push(SegmentProof::EMPTY);
        let motion = filter.skeleton.motion(&segments.velocity, filter.reach);
        let count = (motion / START_WIDTH).ceil().max(1.0);
        let half = 0.5 / count;
        for part in 0..count as usize {
            let middle = half * (2 * part + 1) as f64;
            self.scratch.queue.push_back(Interval { segment, middle, half, pairs: List::All });
        }
        motion
    }

    /// Decides what can be decided on intervals that look at the same pairs; the pairs left over become a
    /// list for each interval. `None` where stopped.
    fn examine(&mut self, rake: &[Interval], until: Until, stop: &mut dyn FnMut() -> bool) -> Option<Examined> {
        if stop() {
            return None;
        }
        self.filter(rake);
        for (lane, interval) in rake.iter().enumerate() {
            let proof = &mut self.scratch.segments.proofs[interval.segment];
            proof.intervals += 1;
            proof.clearance_m = proof.clearance_m.min(f64::from(self.scratch.rake.kept[lane]));
        }
        let mut examined = Examined::default();
        // Nearest first: if anything is refused, it is most likely there.
        if until == Until::FirstRefusal
            && let Some((entry, lane)) = self.nearest()
        {
            if let Some(reason) = self.settle(&rake[lane], entry, lane, stop)? {
                examined.refused = Some((lane, self.scratch.rake.unproved[entry].pair as usize, reason));
                return Some(examined);
            }
        }
        for lane in 0..rake.len() {
            let (first, mut excess) = (self.scratch.lists.len(), 0.0_f32);
            for entry in 0..self.scratch.rake.unproved.len() {
                if self.scratch.rake.unproved[entry].lanes >> lane & 1 == 0 {
                    continue;
                }
                let reason = self.settle(&rake[lane], entry, lane, stop)?;
                let unproved = &self.scratch.rake.unproved[entry];
                if unproved.lanes >> lane & 1 == 1 {
                    self.scratch.lists.push(unproved.pair);
                    excess = excess.max(unproved.excess[lane]);
                }
                if let Some(reason) = reason {
                    examined.refused = examined.refused.or(Some((lane, unproved.pair as usize, reason)));
                    if until == Until::FirstRefusal {
                        return Some(examined);
                    }
                }
            }
            let parts = excess.ceil().clamp(2.0, LANES as f32) as usize;
            examined.undecided[lane] = Undecided { pairs: List::Of(first, self.scratch.lists.len()), parts };
        }
        Some(examined)
    }

    /// Runs the filter on up to eight intervals.
    fn filter(&mut self, rake: &[Interval]) {
        let lanes = ((1_u16 << rake.len()) - 1) as u8;
        let Scratch { rake: filter, lists, merged, slots, .. } = &mut *self.scratch;
        merged.clear();
        for (lane, interval) in rake.iter().enumerate() {
            let List::Of(first, last) = interval.pairs else { break };
            for &pair in &lists[first..last] {
                let slot = &mut slots[pair as usize];
                match merged.get_mut(*slot as usize) {
                    Some((known, lanes)) if *known == pair => *lanes |= 1 << lane,
                    _ => {
                        *slot = merged.len() as u32;
                        merged.push((pair, 1 << lane));
                    }
                }
            }
        }
        if !self.layers.filter {
            return match rake[0].pairs {
                List::All => filter.leave((0..self.model.pairs().len() as u32).map(|pair| (pair, lanes))),
                List::Of(..) => filter.leave(merged.iter().copied()),
            };
        }
        let interval = |lane: usize| {
            let Interval { segment, middle, half, .. } = rake[lane.min(rake.len() - 1)];
            LaneInterval { segment, middle, half }
        };
        self.run(Proving, std::array::from_fn(interval), lanes, rake[0].pairs.is_all());
    }

    /// Runs the filter's kernel, proving or sampling.
    #[inline]
    pub(super) fn run<'s, W: EightWide<Output = ()>>(
        &'s mut self,
        what: impl FnOnce(Rake<'s>) -> W,
        intervals: [LaneInterval; LANES],
        lanes: u8,
        all_pairs: bool,
    ) {
        let Scratch { rake: scratch, segments, merged, floors, instructions, .. } = &mut *self.scratch;
        let pairs = match all_pairs {
            true => Pairs::All { with_remote: segments.is_unconfined || 1.5 * self.highest_floor >= REMOTE_M },
            false => Pairs::Of(merged),
        };
        let filter = self.model.filter();
        let (segments, highest_floor) = (&segments.lanes, self.highest_floor);
        let rake =
            Rake { filter, space: self.space, segments, intervals, lanes, pairs, floors, highest_floor, scratch };
        instructions.run(what(rake));
    }

    /// The undecided pair and lane that the filter saw nearest.
    fn nearest(&self) -> Option<(usize, usize)> {
        let mut nearest = None;
        let mut least = f32::INFINITY;
        for (entry, unproved) in self.scratch.rake.unproved.iter().enumerate() {
            for lane in (0..LANES).filter(|lane| unproved.lanes >> lane & 1 == 1) {
                if unproved.gap[lane] < least {
                    (nearest, least) = (Some((entry, lane)), unproved.gap[lane]);
                }
            }
        }
        nearest
    }

    /// Settles one undecided pair on one interval, exactly if the filter saw it too near to be split
    /// unseen; a pair that is proved leaves the lane. `None` where stopped, `Some(reason)` where refused.
    fn settle(
        &mut self,
        interval: &Interval,
        entry: usize,
        lane: usize,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Option<HitReason>> {
        let unproved = self.scratch.rake.unproved[entry];
        let pair = unproved.pair as usize;
        let mut verdict = IntervalVerdict::Split;
        // Where the filter's rounding exceeds half a floor, halving alone would go on without an end.
        if f64::from(unproved.gap[lane]) < 1.5 * self.scratch.floors[pair] || interval.half < FINEST {
            self.place(interval);
            verdict = self.decide(pair, interval.half, stop);
        }
        Some(match verdict {
            IntervalVerdict::Stopped => return None,
            IntervalVerdict::Proved(kept) => {
                self.scratch.rake.unproved[entry].lanes &= !(1 << lane);
                let proof = &mut self.scratch.segments.proofs[interval.segment];
                proof.clearance_m = proof.clearance_m.min(kept);
                None
            }
            IntervalVerdict::Collision => Some(HitReason::Collision),
            IntervalVerdict::TooClose => Some(HitReason::TooClose),
            IntervalVerdict::Split => self.spend(pair).then_some(HitReason::Uncertified),
        })
    }

    /// Stands all bodies where they are in the middle of an interval.
    fn place(&mut self, interval: &Interval) {
        let Scratch { motion, segments, .. } = &mut *self.scratch;
        let nq = self.space.nq();
        let (from, to) = segments.ends[2 * nq * interval.segment..][..2 * nq].split_at(nq);
        if segments.exact.is_none_or(|(segment, _)| segment != interval.segment) {
            motion.begin(self.model, self.space, from, to, self.held);
            segments.exact = Some((interval.segment, None));
        }
        if segments.exact != Some((interval.segment, Some(interval.middle))) {
            motion.place(self.model, self.space, from, interval.middle, self.held);
            segments.exact = Some((interval.segment, Some(interval.middle)));
        }
    }

    /// Counts an interval against a pair with a lowered floor; true once it has had its share.
    fn spend(&mut self, pair: usize) -> bool {
        if self.scratch.floors[pair] >= self.clearance {
            return false;
        }
        self.scratch.spent[pair] += 1;
        self.scratch.spent[pair] > LOWERED_FLOOR_INTERVALS
    }

    fn decide(&mut self, pair: usize, half: f64, stop: &mut dyn FnMut() -> bool) -> IntervalVerdict {
        let (model, motion, floor) = (self.model, &self.scratch.motion, self.scratch.floors[pair]);
        let mut interval = motion.pair_interval(model, &model.pairs()[pair], half, floor);
        if !self.layers.along_normal {
            interval.bend = f64::INFINITY;
        }
        let mut looks = Looks::new(stop);
        let verdict = interval.decide(&mut looks);
        self.work += looks.count;
        verdict
    }

    fn hit(&mut self, interval: &Interval, pair: usize, reason: HitReason) -> Hit {
        self.place(interval);
        let contact = self.scratch.motion.contact(self.model, &self.model.pairs()[pair]);
        // What decided may have seen another part of the bodies; the closest points have the last word.
        let reason = if contact.distance <= TOUCHING_M { HitReason::Collision } else { reason };
        Hit { reason, t: interval.middle, pair, contact, proved_until: interval.middle - interval.half }
    }
}

#[cfg(test)]
impl Validator<'_> {
    /// What the filter leaves undecided of eight intervals of a segment, and what the rest keeps in each lane.
    pub(crate) fn filtered(
        &mut self,
        from: &[f64],
        to: &[f64],
        intervals: [LaneInterval; LANES],
    ) -> (Vec<(u32, u8)>, [f32; LANES]) {
        self.begin();
        self.add(from, to);
        self.run(Proving, intervals, u8::MAX, true);
        let unproved = &self.scratch.rake.unproved;
        (unproved.iter().map(|unproved| (unproved.pair, unproved.lanes)).collect(), self.scratch.rake.kept)
    }

    /// Where the filter sees the frames on eight intervals of a segment.
    pub(crate) fn filtered_frames(
        &mut self,
        from: &[f64],
        to: &[f64],
        intervals: [LaneInterval; LANES],
    ) -> Vec<crate::robot::lane_kinematics::LaneFrame> {
        self.filtered(from, to, intervals);
        self.scratch.rake.frames().to_vec()
    }

    /// Margin for the size of the values of the last segment (m).
    pub(crate) fn rounding_of_values(&self) -> f32 {
        self.scratch.segments.lanes.rounding(0)
    }

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
        self.scratch.segments.exact = None;
        self.scratch.motion.begin(self.model, self.space, from, to, self.held);
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

#[derive(Default)]
struct Examined {
    /// Lane, pair and reason.
    refused: Option<(usize, usize, HitReason)>,
    /// What is left of each lane.
    undecided: [Undecided; LANES],
}

/// Pairs that an interval leaves undecided, and the number of parts that should settle them.
#[derive(Clone, Copy, Default)]
struct Undecided {
    pairs: List,
    parts: usize,
}

impl List {
    fn is_all(&self) -> bool {
        matches!(self, Self::All)
    }

    fn is_empty(&self) -> bool {
        matches!(self, Self::Of(first, last) if first == last)
    }
}

impl Interval {
    /// Equal parts from left to right, which look at what is undecided; none where nothing is.
    fn split(&self, undecided: &Undecided) -> impl DoubleEndedIterator<Item = Self> + use<> {
        let parts = if undecided.pairs.is_empty() { 0 } else { undecided.parts };
        let (interval, pairs, half) = (*self, undecided.pairs, self.half / parts.max(1) as f64);
        let start = self.middle - self.half;
        (0..parts).map(move |part| Self { middle: start + half * (2 * part + 1) as f64, half, pairs, ..interval })
    }
}
