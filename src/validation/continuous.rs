//! The certified check of segments: intervals, eight at a time, and lists of undecided pairs that
//! shrink on the way down.
//!
//! A segment is cut into intervals; eight of them, of whatever segments, are looked at together by
//! the [filter](super::filter). What it does not prove is undecided. Where it saw an undecided pair
//! at least 1.5 floors apart in the middle, the interval is split; where not, the exact bodies
//! decide: a lower bound of the distance over the whole interval reaches the pair's floor → the
//! pair is done; the bodies touch in the middle → collision; they are closer than 1.5 floors → too
//! close; otherwise it is split. Parts of a split interval look only at the pairs that are
//! undecided there. These are at least 1.5 floors apart in the middle, so they end when their
//! displacement bound falls to half a floor: everything clearer than 1.5 floors is proved,
//! everything proved is at least one floor clear.

use std::collections::VecDeque;
use std::ops::RangeInclusive;

use super::examine::{Examined, Until};
use super::floors::Floors;
use super::undecided::{Interval, Segments};
use super::validator::{ASKED_EVERY, Scratch, Validator};
use super::{Hit, HitReason, SegmentProof, SegmentRefusal, SegmentVerdict, SegmentsVerdict};
use crate::lanes::LANES;
use crate::solid::TOUCHING_M;

/// Joint-space motion of the first intervals (rad; translations are divided by the robot's reach).
const START_WIDTH: f64 = 0.35;

/// What a search for a refusal found first.
enum Found {
    Nothing,
    Refusal(Interval, usize, HitReason),
    Stopped,
}

/// What came of one segment.
pub(super) enum Attempt {
    Proved(SegmentProof),
    Refused {
        t: f64,
        pair: usize,
        reason: HitReason,
    },
    Stopped,
}

/// The same, with the interval that is refused.
enum Settled {
    Proved(SegmentProof),
    Refused(Interval, usize, HitReason),
    Stopped,
}

/// The intervals that the look at a segment begins with, for the size of its motion (rad).
fn first_intervals(segment: usize, motion: f64) -> impl Iterator<Item = Interval> {
    let count = (motion / START_WIDTH).ceil().max(1.0);
    let half = 0.5 / count;
    (0..count as usize).map(move |part| Interval::part(segment, part, half))
}

/// Whether both ends of a segment are within the limits that remote obstacles count on; so is then
/// all of it, because limits are of columns that go straight.
fn is_confined(confines: &[(usize, RangeInclusive<f64>)], from: &[f64], to: &[f64]) -> bool {
    [from, to]
        .iter()
        .all(|end| is_within(confines, end))
}

fn is_within(confines: &[(usize, RangeInclusive<f64>)], configuration: &[f64]) -> bool {
    confines
        .iter()
        .all(|(q, range)| range.contains(&configuration[*q]))
}

/// Which segments have an interval in the queue; none at all where it is empty.
fn open_segments(queue: &VecDeque<Interval>, count: usize) -> Vec<bool> {
    let mut open = Vec::new();
    for interval in queue {
        open.resize(count, false);
        open[interval.segment] = true;
    }
    open
}

impl Validator<'_> {
    /// Proves the straight segment between two configurations, or refuses it as soon as anything is
    /// found.
    ///
    /// Intervals are looked at from wide to narrow, so that a refusal is much cheaper than a proof.
    /// `stop` is asked at every eight intervals, and within them where the search is long.
    pub fn segment(
        &mut self,
        from: &[f64],
        to: &[f64],
        stop: &mut dyn FnMut() -> bool,
    ) -> SegmentVerdict {
        match self.settle_segment(from, to, stop) {
            Settled::Proved(proof) => SegmentVerdict::Proved(proof),
            Settled::Refused(interval, pair, reason) => SegmentVerdict::Refused(Hit {
                // Wide intervals come first: nothing is known of what lies before.
                proved_until: 0.0,
                ..self.hit(&interval, pair, reason)
            }),
            Settled::Stopped => SegmentVerdict::Stopped,
        }
    }

    /// Proves a segment, or finds what refuses it.
    fn settle_segment(
        &mut self,
        from: &[f64],
        to: &[f64],
        stop: &mut dyn FnMut() -> bool,
    ) -> Settled {
        if let Some(proof) = self.known(from, to) {
            return Settled::Proved(proof);
        }
        self.begin();
        self.add(from, to);
        match self.search(stop) {
            Found::Nothing => Settled::Proved(self.scratch.segments.proofs[0]),
            Found::Refusal(interval, pair, reason) => Settled::Refused(interval, pair, reason),
            Found::Stopped => Settled::Stopped,
        }
    }

    /// The same without the contact of a refusal, which may cost more than finding the place.
    pub(super) fn attempt(
        &mut self,
        [from, to]: [&[f64]; 2],
        stop: &mut dyn FnMut() -> bool,
    ) -> Attempt {
        match self.settle_segment(from, to, stop) {
            Settled::Proved(proof) => Attempt::Proved(proof),
            Settled::Refused(interval, pair, reason) => Attempt::Refused {
                t: interval.middle,
                pair,
                reason,
            },
            Settled::Stopped => Attempt::Stopped,
        }
    }

    /// Whether [`Self::segment`] would prove each of several segments, all looked at together:
    /// eight intervals of whatever segments at once, and wide ones before narrow ones. Proofs are
    /// remembered for [`Self::segment`]. Cheaper than asking that for a verdict, because a
    /// refusal's exact contact often costs more than finding the refusal.
    pub fn segments<'q>(
        &mut self,
        segments: impl Iterator<Item = [&'q [f64]; 2]>,
        stop: &mut dyn FnMut() -> bool,
    ) -> SegmentsVerdict {
        if self.lay_out(segments, stop).is_none() {
            return SegmentsVerdict::Stopped;
        }
        match self.search(stop) {
            Found::Nothing => SegmentsVerdict::Proved,
            Found::Refusal(interval, pair, reason) => SegmentsVerdict::Refused(SegmentRefusal {
                segment: self.scratch.segments.numbers[interval.segment],
                t: interval.middle,
                pair,
                reason,
            }),
            Found::Stopped => SegmentsVerdict::Stopped,
        }
    }

    /// Takes the segments to be looked at in hand, but for those that are known; `None` where
    /// stopped.
    pub(super) fn lay_out<'q>(
        &mut self,
        segments: impl Iterator<Item = [&'q [f64]; 2]>,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<()> {
        self.begin();
        for (number, [from, to]) in segments.enumerate() {
            if number % ASKED_EVERY == ASKED_EVERY - 1 && stop() {
                return None;
            }
            self.lay_out_segment(number, from, to);
        }
        Some(())
    }

    fn lay_out_segment(&mut self, number: usize, from: &[f64], to: &[f64]) {
        let known = self.known(from, to);
        let segments = &mut self.scratch.segments;
        segments
            .in_order
            .push(known.unwrap_or(SegmentProof::EMPTY));
        if known.is_none() {
            segments.numbers.push(number);
            self.add(from, to);
        }
    }

    /// The proofs of the segments that were laid out, in their order; they are proved.
    pub(super) fn proofs_in_order(&mut self) -> Vec<SegmentProof> {
        let Segments {
            in_order,
            numbers,
            proofs,
            ..
        } = &mut self.scratch.segments;
        for (number, proof) in numbers.iter().zip(proofs) {
            in_order[*number] = *proof;
        }
        in_order.clone()
    }

    /// The same of one segment; `None` where stopped.
    pub fn proves(
        &mut self,
        from: &[f64],
        to: &[f64],
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<bool> {
        match self.segments([[from, to]].into_iter(), stop) {
            SegmentsVerdict::Proved => Some(true),
            SegmentsVerdict::Refused(_) => Some(false),
            SegmentsVerdict::Stopped => None,
        }
    }

    pub(super) fn known(&self, from: &[f64], to: &[f64]) -> Option<SegmentProof> {
        self.layers
            .reuse
            .then(|| self.scratch.ledger.get(from, to))
            .flatten()
    }

    /// Looks at all that is queued, wide intervals first; remembers the segments if all are proved.
    fn search(&mut self, stop: &mut dyn FnMut() -> bool) -> Found {
        while !self.scratch.queue.is_empty() {
            let (batch, count) = self.next_batch();
            let batch = &batch[..count];
            let Some(examined) = self.examine(batch, Until::FirstRefusal, stop) else {
                return Found::Stopped;
            };
            if let Some((lane, pair, reason)) = examined.refused {
                // They are not proved: see `remember_proved`.
                let back = batch.iter().rev();
                back.for_each(|interval| self.scratch.queue.push_front(*interval));
                return Found::Refusal(batch[lane], pair, reason);
            }
            self.queue_parts(batch, &examined);
        }
        self.remember_proved();
        Found::Nothing
    }

    /// Queues the parts of the intervals of a batch that are left undecided.
    pub(super) fn queue_parts(&mut self, batch: &[Interval], examined: &Examined) {
        // Behind all that is as wide: a refusal is found in the widest interval that shows it.
        for (interval, undecided) in batch.iter().zip(&examined.undecided) {
            self.scratch
                .queue
                .extend(interval.split(undecided));
        }
    }

    /// Remembers the segments at hand of which nothing is left in the queue.
    pub(super) fn remember_proved(&mut self) {
        if !self.layers.reuse {
            return;
        }
        let nq = self.space.nq();
        let Scratch {
            segments,
            queue,
            ledger,
            ..
        } = &mut *self.scratch;
        let open = open_segments(queue, segments.proofs.len());
        let ends = segments.ends.chunks((2 * nq).max(1));
        for (number, (ends, proof)) in ends.zip(&segments.proofs).enumerate() {
            if !open.get(number).is_some_and(|is_open| *is_open) {
                ledger.insert(&ends[..nq], &ends[nq..], *proof);
            }
        }
    }

    /// Up to eight intervals from the queue, either all new or all parts of others.
    pub(super) fn next_batch(&mut self) -> ([Interval; LANES], usize) {
        let queue = &mut self.scratch.queue;
        let mut batch = [Interval::default(); LANES];
        let mut count = 0;
        // The filter goes either over all pairs or over lists.
        while count < LANES
            && let Some(next) = queue.front()
            && (count == 0 || next.pairs.is_all() == batch[0].pairs.is_all())
        {
            batch[count] = *next;
            count += 1;
            queue.pop_front();
        }
        (batch, count)
    }

    /// Forgets the segments at hand.
    pub(super) fn begin(&mut self) {
        self.scratch.segments.clear();
        self.scratch.lists.clear();
        self.scratch.queue.clear();
        self.scratch.floors.begin();
    }

    /// Does something with other floors in the place of the validator's, which `fill` writes; what is
    /// done is given those that come back.
    pub(super) fn with_floors<T>(
        &mut self,
        fill: impl FnOnce(&mut Floors, &Floors),
        act: impl FnOnce(&mut Self, &Floors) -> T,
    ) -> T {
        let floors = self.scratch.widen(fill);
        let done = act(self, &floors);
        self.scratch.wide = std::mem::replace(&mut self.scratch.floors, floors);
        done
    }

    /// The same with one floor for all pairs (m). The segments at hand are forgotten after it: what is
    /// known of them is known at that floor.
    pub(super) fn with_floor<T>(
        &mut self,
        floor: f64,
        act: impl FnOnce(&mut Self, &Floors) -> T,
    ) -> T {
        let pairs = self.model.pairs().len();
        self.with_floors(
            |wide, _| wide.reset(pairs, floor),
            |validator, floors| {
                let done = act(validator, floors);
                validator.begin();
                done
            },
        )
    }

    /// Adds a segment to those at hand, and its first intervals to the queue; returns the size of
    /// its motion (rad).
    pub(super) fn add(&mut self, from: &[f64], to: &[f64]) -> f64 {
        let segments = &mut self.scratch.segments;
        segments.velocity.resize(self.space.nv(), 0.0);
        self.space
            .difference(to, from, &mut segments.velocity);
        segments.ends.extend_from_slice(from);
        segments.ends.extend_from_slice(to);
        let filter = self.model.filter();
        segments
            .lanes
            .push(&filter.skeleton, from, &segments.velocity, self.held);
        segments.is_unconfined |= !is_confined(&filter.confines, from, to);
        let motion = filter
            .skeleton
            .motion(&segments.velocity, filter.reach);
        let segment = segments.proofs.len();
        segments.proofs.push(SegmentProof::EMPTY);
        self.scratch
            .queue
            .extend(first_intervals(segment, motion));
        motion
    }

    pub(super) fn hit(&mut self, interval: &Interval, pair: usize, reason: HitReason) -> Hit {
        self.place(interval);
        let pair_of_bodies = &self.model.pairs()[pair];
        let contact = self
            .scratch
            .motion
            .contact(self.model, pair_of_bodies);
        // What decided may have seen another part of the bodies; the closest points have the last
        // word.
        let touches = contact.distance <= TOUCHING_M;
        Hit {
            reason: if touches {
                HitReason::Collision
            } else {
                reason
            },
            t: interval.middle,
            pair,
            contact,
            proved_until: interval.middle - interval.half,
        }
    }
}
