//! One look at up to eight intervals: the filter, then the exact bodies where it saw them too near.

use super::HitReason;
use super::demand::{Demand, Directions, Refuses};
use super::examiner::{Examiner, Scratch};
use super::filter::{Batch, Pairs, Proving, ProvingCurves};
use super::interval::{IntervalVerdict, Looks, PairInterval};
use super::requirement::Requirement;
use super::undecided::{Interval, List, Undecided};
use super::validator::{FINEST, LOWERED_FLOOR_INTERVALS};
use crate::collision::filter::REMOTE_M;
use crate::lanes::{EightWide, LANES};
use crate::robot::lane_kinematics::{LaneCurve, LaneInterval};

/// What the filter sees closer than this (m) is decided exactly whatever its floor: some times what
/// the filter rounds in a room of some metres.
const EXACT_BELOW_M: f64 = 2e-5;

/// When an interval has been looked at enough.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Until {
    /// One refusal settles the segment.
    FirstRefusal,
    /// The left half needs all that is undecided.
    Everything,
}

#[derive(Default)]
pub(super) struct Examined {
    /// Lane, requirement and reason.
    pub(super) refused: Option<(usize, Requirement, HitReason)>,
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

impl<'m> Examiner<'m> {
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
}

impl Examiner<'_> {
    /// Decides what can be decided on intervals that look at the same pairs; the pairs left over
    /// become a list for each interval. `None` where stopped.
    pub(super) fn examine(
        &mut self,
        demand: &mut Demand,
        batch: &[Interval],
        until: Until,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Examined> {
        if stop() {
            return None;
        }
        self.filter(demand, batch);
        self.note_kept(batch);
        let mut examined = Examined::default();
        // Nearest first: if anything is refused, it is most likely there.
        if until == Until::FirstRefusal {
            examined.refused = self.refuse_nearest(demand, batch, stop)?;
            if examined.refused.is_some() {
                return Some(examined);
            }
        }
        for (lane, interval) in batch.iter().enumerate() {
            self.settle_lane(demand, interval, lane, until, &mut examined, stop)?;
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

    /// Settles what the filter saw nearest; lane, requirement and reason where it is refused.
    fn refuse_nearest(
        &mut self,
        demand: &mut Demand,
        batch: &[Interval],
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Option<(usize, Requirement, HitReason)>> {
        let Some((entry, lane)) = self.most_likely_refused() else {
            return Some(None);
        };
        let reason = self.settle(demand, &batch[lane], entry, lane, stop)?;
        Some(reason.map(|reason| (lane, self.required(entry), reason)))
    }

    /// What an entry that the filter leaves is about.
    pub(super) fn required(&self, entry: usize) -> Requirement {
        Requirement::Clearance(self.scratch.filter.unproved[entry].pair as usize)
    }

    /// Settles what the filter leaves of one lane, up to the first refusal if no more is asked for.
    fn settle_lane(
        &mut self,
        demand: &mut Demand,
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
            let reason = self.settle(demand, interval, entry, lane, stop)?;
            excess = excess.max(self.list(entry, lane));
            if let Some(reason) = reason {
                let requirement = self.required(entry);
                examined.refused = examined
                    .refused
                    .or(Some((lane, requirement, reason)));
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
    pub(super) fn filter(&mut self, demand: &Demand, batch: &[Interval]) {
        let lanes = ((1_u16 << batch.len()) - 1) as u8;
        self.merge_lists(batch);
        if !self.layers.filter {
            return self.leave_all(batch[0].pairs, lanes);
        }
        // Lanes beyond the batch repeat its last interval: no number in them is infinite or none.
        let interval = |lane: usize| batch[lane.min(batch.len() - 1)].of_lane();
        let intervals = std::array::from_fn(interval);
        let all_pairs = batch[0].pairs.is_all();
        match self.scratch.segments.are_curves() {
            true => {
                self.fill_with_curves(batch);
                self.run(demand, ProvingCurves, intervals, lanes, all_pairs);
            }
            false => self.run(demand, Proving, intervals, lanes, all_pairs),
        }
    }

    /// Fills the lanes with intervals of curves.
    pub(super) fn fill_with_curves(&mut self, batch: &[Interval]) {
        let Scratch {
            segments,
            expansions,
            filter,
            ..
        } = &mut *self.scratch;
        for (interval, expansion) in batch.iter().zip(expansions.iter_mut()) {
            let columns = segments.curve(interval.segment, self.space.nq());
            expansion.update(self.space, columns, interval.middle, interval.half);
        }
        let lanes: [LaneCurve; LANES] =
            std::array::from_fn(|lane| expansions[lane.min(batch.len() - 1)].of_lane());
        filter.input.fill_with_curves(&lanes);
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
        demand: &'s Demand,
        what: impl FnOnce(Batch<'s>) -> W,
        intervals: [LaneInterval; LANES],
        lanes: u8,
        all_pairs: bool,
    ) {
        let with_remote = self.may_reach_remote(demand);
        let Scratch {
            filter: scratch,
            segments,
            merged,
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
            highest_floor: demand.floors.highest(),
            floors: demand.floors.clearances(),
            scratch,
        };
        self.instructions.run(what(batch));
    }

    /// Whether obstacles count that no configuration within the limits comes near.
    fn may_reach_remote(&self, demand: &Demand) -> bool {
        self.scratch.segments.is_unconfined || demand.farthest() >= REMOTE_M
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

    /// Settles one entry on one interval, exactly if the filter saw it too near to be split unseen;
    /// what is proved leaves the lane. `None` where stopped, `Some(reason)` where refused.
    pub(super) fn settle(
        &mut self,
        demand: &mut Demand,
        interval: &Interval,
        entry: usize,
        lane: usize,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Option<HitReason>> {
        let unproved = self.scratch.filter.unproved[entry];
        let requirement = self.required(entry);
        let is_near = f64::from(unproved.gap[lane]) < exactly_below(demand, requirement);
        let verdict = if is_near || interval.half < FINEST {
            self.place(interval);
            self.decide(demand, requirement, interval.half, stop)
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
            IntervalVerdict::Split => spend(demand, requirement).then_some(HitReason::Uncertified),
        })
    }

    /// Decides a requirement on the interval of this half width about where the bodies stand.
    pub(super) fn decide(
        &mut self,
        demand: &mut Demand,
        requirement: Requirement,
        half: f64,
        stop: &mut dyn FnMut() -> bool,
    ) -> IntervalVerdict {
        let pair = requirement.pair();
        let floor = demand.floors.of(requirement);
        let interval = PairInterval {
            too_close: demand.refused_below(requirement),
            ..self.bound(pair, half, floor)
        };
        let mut looks = Looks::new(stop);
        let mut verdict = decide_along(demand.directions, pair, &interval, &mut looks);
        if demand.refuses == Refuses::Contact && verdict == IntervalVerdict::Split {
            // What made it too wide is one part of the bodies; others may touch in the middle.
            verdict = interval.touches_in_the_middle(&mut looks);
        }
        self.exact += looks.count;
        verdict
    }

    /// Whether a requirement is proved to keep this amount on the whole interval. `None` where
    /// stopped.
    pub(super) fn keeps(
        &mut self,
        directions: &mut Directions,
        requirement: Requirement,
        interval: &Interval,
        amount: f64,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<bool> {
        let pair = requirement.pair();
        self.place(interval);
        let bound = PairInterval {
            too_close: amount,
            ..self.bound(pair, interval.half, amount)
        };
        let mut looks = Looks::new(stop);
        let verdict = decide_along(directions, pair, &bound, &mut looks);
        self.exact += looks.count;
        match verdict {
            IntervalVerdict::Stopped => None,
            verdict => Some(matches!(verdict, IntervalVerdict::Proved(_))),
        }
    }
}

/// What the filter sees less of than this is not split unseen.
fn exactly_below(demand: &Demand, requirement: Requirement) -> f64 {
    // Where the filter's rounding exceeds half a floor, splitting would go on without an end.
    demand
        .worth_trying(requirement)
        .max(EXACT_BELOW_M)
}

/// Counts an interval against a requirement with a lowered floor; true once it has had its share.
fn spend(demand: &mut Demand, requirement: Requirement) -> bool {
    demand.floors.spend(requirement) > LOWERED_FLOOR_INTERVALS
}

/// Decides an interval, first along the direction in which the pair was last seen apart.
fn decide_along(
    directions: &mut Directions,
    pair: usize,
    interval: &PairInterval,
    looks: &mut Looks,
) -> IntervalVerdict {
    let mut direction = directions.get(&pair).copied();
    let verdict = interval.decide(&mut direction, looks);
    if let Some(direction) = direction {
        directions.insert(pair, direction);
    }
    verdict
}
