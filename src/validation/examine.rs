//! One look at up to eight intervals: the filter, then the exact bodies where it saw them too near.

use super::HitReason;
use super::filter::{Batch, Pairs, Proving};
use super::interval::{IntervalVerdict, Looks, PairInterval};
use super::undecided::{Interval, List, Undecided};
use super::validator::{FINEST, LOWERED_FLOOR_INTERVALS, Scratch, Validator};
use crate::collision::filter::REMOTE_M;
use crate::lanes::{EightWide, LANES};
use crate::robot::lane_kinematics::LaneInterval;

/// What the filter sees closer than this (m) is decided exactly whatever its floor: some times what
/// the filter rounds in a room of some metres.
const EXACT_BELOW_M: f64 = 2e-5;

/// When an interval has been looked at enough.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Until {
    /// One refusal settles the segment.
    FirstRefusal,
    /// The left half needs all that is undecided.
    EveryPair,
}

#[derive(Default)]
pub(super) struct Examined {
    /// Lane, pair and reason.
    pub(super) refused: Option<(usize, usize, HitReason)>,
    /// What is left of each lane.
    pub(super) undecided: [Undecided; LANES],
}

/// Adds a pair and a lane that looks at it; `slot` is where the pair stands, if it does.
fn merge(merged: &mut Vec<(u32, u8)>, slot: &mut u32, pair: u32, lane: u8) {
    match merged.get_mut(*slot as usize) {
        // A slot may be an earlier batch's: it counts where the pair agrees.
        Some((known, lanes)) if *known == pair => *lanes |= lane,
        _ => {
            *slot = merged.len() as u32;
            merged.push((pair, lane));
        }
    }
}

impl Interval {
    /// The same for the filter.
    fn of_lane(&self) -> LaneInterval {
        LaneInterval {
            segment: self.segment,
            middle: self.middle,
            half: self.half,
        }
    }
}

impl<'m> Validator<'m> {
    /// The bound of a pair on the interval of this half width about where its bodies stand.
    pub(super) fn bound(&self, pair: usize, half: f64, floor: f64) -> PairInterval<'m> {
        let pair = &self.model.pairs()[pair];
        let mut bound = self
            .scratch
            .motion
            .pair_interval(self.model, pair, half, floor);
        if !self.layers.along_normal {
            // Then the plain bound is always the smaller.
            bound.bend = f64::INFINITY;
        }
        bound
    }

    /// The same at the pair's floor.
    fn bound_at_floor(&self, pair: usize, half: f64) -> PairInterval<'m> {
        let floor = self.floors()[pair];
        let too_close = match self.seeks_contact {
            // Bodies in each other are no refusal before they are as deep as the floor says.
            true => f64::NEG_INFINITY,
            false => self.margin * floor,
        };
        PairInterval {
            too_close,
            ..self.bound(pair, half, floor)
        }
    }
}

impl Validator<'_> {
    /// Decides what can be decided on intervals that look at the same pairs; the pairs left over
    /// become a list for each interval. `None` where stopped.
    pub(super) fn examine(
        &mut self,
        batch: &[Interval],
        until: Until,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Examined> {
        if stop() {
            return None;
        }
        self.filter(batch);
        self.note_kept(batch);
        let mut examined = Examined::default();
        // Nearest first: if anything is refused, it is most likely there.
        if until == Until::FirstRefusal {
            examined.refused = self.refuse_nearest(batch, stop)?;
            if examined.refused.is_some() {
                return Some(examined);
            }
        }
        for (lane, interval) in batch.iter().enumerate() {
            self.settle_pairs(interval, lane, until, &mut examined, stop)?;
            if examined.refused.is_some() && until == Until::FirstRefusal {
                break;
            }
        }
        Some(examined)
    }

    /// Counts the intervals of a batch, with what the pairs that the filter proved keep on each.
    fn note_kept(&mut self, batch: &[Interval]) {
        let Scratch {
            segments, filter, ..
        } = &mut *self.scratch;
        for (interval, kept) in batch.iter().zip(filter.kept) {
            segments.proofs[interval.segment].intervals += 1;
            segments.keep(interval.segment, f64::from(kept));
        }
    }

    /// Settles the pair that the filter saw nearest; lane, pair and reason where it is refused.
    fn refuse_nearest(
        &mut self,
        batch: &[Interval],
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Option<(usize, usize, HitReason)>> {
        let Some((entry, lane)) = self.most_likely_refused() else {
            return Some(None);
        };
        let pair = self.pair(entry);
        let reason = self.settle(&batch[lane], entry, lane, stop)?;
        Some(reason.map(|reason| (lane, pair, reason)))
    }

    /// The pair of an entry that the filter leaves.
    fn pair(&self, entry: usize) -> usize {
        self.scratch.filter.unproved[entry].pair as usize
    }

    /// Settles what the filter leaves of one lane, up to the first refusal if no more is asked for.
    fn settle_pairs(
        &mut self,
        interval: &Interval,
        lane: usize,
        until: Until,
        examined: &mut Examined,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<()> {
        let first = self.scratch.lists.len();
        let mut excess = 0.0_f32;
        for entry in 0..self.scratch.filter.unproved.len() {
            if !self.scratch.filter.unproved[entry].is_in(lane) {
                continue;
            }
            let reason = self.settle(interval, entry, lane, stop)?;
            excess = excess.max(self.list(entry, lane));
            if let Some(reason) = reason {
                let pair = self.pair(entry);
                examined.refused = examined.refused.or(Some((lane, pair, reason)));
                if until == Until::FirstRefusal {
                    return Some(());
                }
            }
        }
        let pairs = List::Of(first, self.scratch.lists.len());
        examined.undecided[lane] = Undecided::new(pairs, excess);
        Some(())
    }

    /// Puts a pair on the list that grows, if it is undecided in a lane; by how much its displacement
    /// exceeds what it has, else 0.
    pub(super) fn list(&mut self, entry: usize, lane: usize) -> f32 {
        let unproved = &self.scratch.filter.unproved[entry];
        if !unproved.is_in(lane) {
            return 0.0;
        }
        self.scratch.lists.push(unproved.pair);
        unproved.excess[lane]
    }

    /// Runs the filter on up to eight intervals.
    pub(super) fn filter(&mut self, batch: &[Interval]) {
        let lanes = ((1_u16 << batch.len()) - 1) as u8;
        self.merge_lists(batch);
        if !self.layers.filter {
            return self.leave_all(batch[0].pairs, lanes);
        }
        // Lanes beyond the batch repeat its last interval: no number in them is infinite or none.
        let interval = |lane: usize| batch[lane.min(batch.len() - 1)].of_lane();
        self.run(
            Proving,
            std::array::from_fn(interval),
            lanes,
            batch[0].pairs.is_all(),
        );
    }

    /// `merged` ← the pairs on the lists of a batch, each once, with the lanes that look at it.
    fn merge_lists(&mut self, batch: &[Interval]) {
        let Scratch {
            lists,
            merged,
            slots,
            ..
        } = &mut *self.scratch;
        merged.clear();
        for (lane, interval) in batch.iter().enumerate() {
            let List::Of(first, last) = interval.pairs else {
                break;
            };
            for &pair in &lists[first..last] {
                merge(merged, &mut slots[pair as usize], pair, 1 << lane);
            }
        }
    }

    /// Leaves everything to the exact bodies.
    fn leave_all(&mut self, pairs: List, lanes: u8) {
        let Scratch { filter, merged, .. } = &mut *self.scratch;
        match pairs {
            List::All => {
                filter.leave((0..self.model.pairs().len() as u32).map(|pair| (pair, lanes)))
            }
            List::Of(..) => filter.leave(merged.iter().copied()),
        }
    }

    #[inline]
    pub(super) fn run<'s, W: EightWide<Output = ()>>(
        &'s mut self,
        what: impl FnOnce(Batch<'s>) -> W,
        intervals: [LaneInterval; LANES],
        lanes: u8,
        all_pairs: bool,
    ) {
        let with_remote = self.may_reach_remote();
        let Scratch {
            filter: scratch,
            segments,
            merged,
            floors,
            ..
        } = &mut *self.scratch;
        let batch = Batch {
            filter: self.model.filter(),
            space: self.space,
            segments: &segments.lanes,
            intervals,
            lanes,
            pairs: match all_pairs {
                true => Pairs::All { with_remote },
                false => Pairs::Of(merged),
            },
            highest_floor: floors.highest(),
            floors: floors.all(),
            scratch,
        };
        self.instructions.run(what(batch));
    }

    /// Whether obstacles count that no configuration within the limits comes near.
    fn may_reach_remote(&self) -> bool {
        let highest = self.scratch.floors.highest();
        self.scratch.segments.is_unconfined || self.margin * highest >= REMOTE_M
    }

    /// The undecided pair and lane that the filter saw nearest.
    fn most_likely_refused(&self) -> Option<(usize, usize)> {
        let gaps = self.undecided_gaps();
        let nearest = gaps.fold((None, f32::INFINITY), |nearest, (place, gap)| {
            if gap < nearest.1 {
                (Some(place), gap)
            } else {
                nearest
            }
        });
        nearest.0
    }

    /// Entry and lane of all that is undecided, and the gap that the filter saw.
    fn undecided_gaps(&self) -> impl Iterator<Item = ((usize, usize), f32)> {
        let entries = self.scratch.filter.unproved.iter().enumerate();
        entries.flat_map(|(entry, unproved)| {
            let lanes = (0..LANES).filter(|lane| unproved.is_in(*lane));
            lanes.map(move |lane| ((entry, lane), unproved.gap[lane]))
        })
    }

    /// Settles one undecided pair on one interval, exactly if the filter saw it too near to be
    /// split unseen; a pair that is proved leaves the lane. `None` where stopped, `Some(reason)`
    /// where refused.
    pub(super) fn settle(
        &mut self,
        interval: &Interval,
        entry: usize,
        lane: usize,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Option<HitReason>> {
        let unproved = self.scratch.filter.unproved[entry];
        let pair = unproved.pair as usize;
        let is_near = f64::from(unproved.gap[lane]) < self.exactly_below(pair);
        let verdict = if is_near || interval.half < FINEST {
            self.place(interval);
            self.decide(pair, interval.half, stop)
        } else {
            IntervalVerdict::Split
        };
        Some(match verdict {
            IntervalVerdict::Stopped => return None,
            IntervalVerdict::Proved(kept) => {
                self.scratch.filter.unproved[entry].lanes &= !(1 << lane);
                self.scratch
                    .segments
                    .keep(interval.segment, kept);
                None
            }
            IntervalVerdict::Collision => Some(HitReason::Collision),
            IntervalVerdict::TooClose => Some(HitReason::TooClose),
            IntervalVerdict::Split => self
                .spend(pair)
                .then_some(HitReason::Uncertified),
        })
    }

    /// Distance below which a pair is not split unseen (m).
    fn exactly_below(&self, pair: usize) -> f64 {
        // Where the filter's rounding exceeds half a floor, splitting would go on without an end.
        (self.margin * self.floors()[pair]).max(EXACT_BELOW_M)
    }

    /// Stands all bodies where they are in the middle of an interval.
    pub(super) fn place(&mut self, interval: &Interval) {
        let Interval {
            segment, middle, ..
        } = *interval;
        let Scratch {
            motion, segments, ..
        } = &mut *self.scratch;
        let (from, to) = segments.ends(segment, self.space.nq());
        if segments
            .exact
            .is_none_or(|(begun, _)| begun != segment)
        {
            motion.begin(self.model, self.space, from, to, self.held);
        } else if segments.exact == Some((segment, Some(middle))) {
            // Pair after pair is looked at in the same middle.
            return;
        }
        motion.place(self.model, self.space, from, middle, self.held);
        segments.exact = Some((segment, Some(middle)));
    }

    /// Counts an interval against a pair with a lowered floor; true once it has had its share.
    fn spend(&mut self, pair: usize) -> bool {
        self.scratch.floors.spend(pair) > LOWERED_FLOOR_INTERVALS
    }

    /// Decides a pair on the interval of this half width about where its bodies stand.
    pub(super) fn decide(
        &mut self,
        pair: usize,
        half: f64,
        stop: &mut dyn FnMut() -> bool,
    ) -> IntervalVerdict {
        let interval = self.bound_at_floor(pair, half);
        let mut looks = Looks::new(stop);
        let mut verdict = self.decide_along(pair, &interval, &mut looks);
        if self.seeks_contact && verdict == IntervalVerdict::Split {
            // What made it too wide is one part of the bodies; others may touch in the middle.
            verdict = interval.touches_in_the_middle(&mut looks);
        }
        self.exact += looks.count;
        verdict
    }

    /// Decides an interval, first along the direction in which the pair was last seen apart.
    pub(super) fn decide_along(
        &mut self,
        pair: usize,
        interval: &PairInterval,
        looks: &mut Looks,
    ) -> IntervalVerdict {
        let mut direction = self.scratch.directions.get(&pair).copied();
        let verdict = interval.decide(&mut direction, looks);
        if let Some(direction) = direction {
            self.scratch.directions.insert(pair, direction);
        }
        verdict
    }
}
