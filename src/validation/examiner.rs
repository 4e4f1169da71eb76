//! What looks at segments: their intervals, where bodies stand on them, and the memory for both. It
//! has no floors of its own: each look is given its [`Demand`](super::demand::Demand).

use std::collections::VecDeque;
use std::ops::RangeInclusive;

use super::demand::Demand;
use super::filter::FilterScratch;
use super::polynomial::Polynomial;
use super::segment_motion::SegmentMotion;
use super::undecided::{Interval, Segments};
use super::way::{Expansion, Way};
use super::{Layers, SegmentProof};
use crate::collision::CollisionModel;
use crate::lanes::{InstructionSet, LANES};
use crate::robot::{ConfigurationSpace, Kinematics};

/// Joint-space motion of the first intervals (rad; translations are divided by the robot's reach).
const START_WIDTH: f64 = 0.35;

/// Segments that are laid out between two questions whether to stop.
pub(super) const ASKED_EVERY: usize = 256;

/// Reusable memory of an examiner.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    pub(super) motion: SegmentMotion,
    pub(super) kinematics: Kinematics,
    pub(super) filter: FilterScratch,
    pub(super) segments: Segments,
    /// Of the intervals of curves, lane by lane; the first also of those that are looked at exactly.
    pub(super) expansions: [Expansion; LANES],
    /// Lists of undecided pairs, each a range of this.
    pub(super) lists: Vec<u32>,
    /// The pairs of a batch, each with the lanes that look at it, and where each pair stands in it.
    pub(super) merged: Vec<(u32, u8)>,
    pub(super) slots: Vec<u32>,
    pub(super) queue: VecDeque<Interval>,
}

impl Scratch {
    /// For so many pairs.
    pub(super) fn make_room(&mut self, pairs: usize) {
        // A slot counts only where the merged list agrees: what an earlier request left does no
        // harm.
        self.slots.resize(pairs, 0);
    }
}

/// Looks at segments of one robot in one scene.
pub(super) struct Examiner<'a> {
    pub(super) model: &'a CollisionModel,
    pub(super) space: &'a ConfigurationSpace,
    pub(super) held: &'a [f64],
    pub(super) scratch: &'a mut Scratch,
    pub(super) layers: Layers,
    pub(super) instructions: InstructionSet,
    /// Tests of two bodies that were exact.
    pub(super) exact: u64,
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

/// The same of a curve.
fn is_curve_confined(confines: &[(usize, RangeInclusive<f64>)], columns: &[Polynomial]) -> bool {
    confines.iter().all(|(q, range)| {
        columns[*q]
            .extremes(0.0, 1.0)
            .iter()
            .all(|(value, _)| range.contains(value))
    })
}

fn is_within(confines: &[(usize, RangeInclusive<f64>)], configuration: &[f64]) -> bool {
    confines
        .iter()
        .all(|(q, range)| range.contains(&configuration[*q]))
}

impl<'a> Examiner<'a> {
    /// `held` are the values of the robot's held variables.
    pub(super) fn new(
        model: &'a CollisionModel,
        space: &'a ConfigurationSpace,
        held: &'a [f64],
        scratch: &'a mut Scratch,
    ) -> Self {
        scratch
            .filter
            .reset(model.filter(), space, held);
        Self {
            model,
            space,
            held,
            scratch,
            layers: Layers::default(),
            instructions: InstructionSet::default(),
            exact: 0,
        }
    }
}

impl Examiner<'_> {
    /// Forgets the segments at hand.
    pub(super) fn forget(&mut self) {
        self.scratch.segments.clear();
        self.scratch.lists.clear();
        self.scratch.queue.clear();
    }

    /// The same, and what was spent on them.
    pub(super) fn begin(&mut self, demand: &mut Demand) {
        self.forget();
        demand.floors.begin();
    }

    /// Adds a segment to those at hand, and its first intervals to the queue; returns the size of
    /// its motion (rad).
    pub(super) fn add(&mut self, way: Way) -> f64 {
        let motion = match way {
            Way::Straight(ends) => self.add_straight(ends),
            Way::Curved(columns) => self.add_curve(columns),
        };
        let segments = &mut self.scratch.segments;
        let segment = segments.proofs.len();
        segments.proofs.push(SegmentProof::EMPTY);
        self.scratch
            .queue
            .extend(first_intervals(segment, motion));
        motion
    }

    fn add_straight(&mut self, [from, to]: [&[f64]; 2]) -> f64 {
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
        filter
            .skeleton
            .motion(&segments.velocity, filter.reach)
    }

    fn add_curve(&mut self, columns: &[Polynomial]) -> f64 {
        let Scratch {
            segments,
            expansions: [whole, ..],
            ..
        } = &mut *self.scratch;
        whole.update(self.space, columns, 0.5, 0.5);
        segments.curves.extend_from_slice(columns);
        let filter = self.model.filter();
        // No value is farther from the middle than the greatest speed takes it.
        segments
            .lanes
            .push(&filter.skeleton, &whole.middle, &whole.speed, self.held);
        segments.is_unconfined |= !is_curve_confined(&filter.confines, columns);
        segments.velocity.clear();
        segments.velocity.extend(whole.size());
        filter
            .skeleton
            .motion(&segments.velocity, filter.reach)
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

    /// Stands all bodies where they are in the middle of an interval.
    pub(super) fn place(&mut self, interval: &Interval) {
        let known = self.scratch.segments.exact;
        // Pair after pair is looked at in the same middle.
        if known.is_none_or(|known| !known.is_same_part(interval)) {
            match self.scratch.segments.are_curves() {
                true => self.place_on_curve(interval),
                false => {
                    let is_begun = known.is_some_and(|known| known.segment == interval.segment);
                    self.place_on_line(interval, is_begun);
                }
            }
            self.scratch.segments.exact = Some(*interval);
        }
    }

    fn place_on_line(&mut self, interval: &Interval, is_begun: bool) {
        let Scratch {
            motion, segments, ..
        } = &mut *self.scratch;
        let (from, to) = segments.ends(interval.segment, self.space.nq());
        if !is_begun {
            motion.begin(self.model, self.space, from, to, self.held);
        }
        motion.place(self.model, self.space, from, interval.middle, self.held);
    }

    fn place_on_curve(&mut self, interval: &Interval) {
        let Scratch {
            motion,
            segments,
            expansions: [expansion, ..],
            ..
        } = &mut *self.scratch;
        let columns = segments.curve(interval.segment, self.space.nq());
        expansion.update(self.space, columns, interval.middle, interval.half);
        motion.follow(self.model, expansion, self.held);
    }

    /// Stands all bodies where they are at a ratio of any segment.
    pub(super) fn stand(&mut self, from: &[f64], to: &[f64], t: f64) {
        // The motion is no longer that of the segments at hand.
        self.scratch.segments.exact = None;
        let motion = &mut self.scratch.motion;
        motion.begin(self.model, self.space, from, to, self.held);
        motion.place(self.model, self.space, from, t, self.held);
    }
}
