//! One look at up to eight intervals: the filter, then the exact bodies where it saw them too near.

use super::HitReason;
use super::continuous::{FINEST, LOWERED_FLOOR_INTERVALS, Scratch, Validator};
use super::filter::{Batch, Pairs, Proving};
use super::interval::{IntervalVerdict, Looks};
use super::undecided::{Interval, List, Undecided};
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
        for (lane, interval) in batch.iter().enumerate() {
            let proof = &mut self.scratch.segments.proofs[interval.segment];
            proof.intervals += 1;
            proof.clearance_m = proof
                .clearance_m
                .min(f64::from(self.scratch.filter.kept[lane]));
        }
        let mut examined = Examined::default();
        // Nearest first: if anything is refused, it is most likely there.
        if until == Until::FirstRefusal
            && let Some((entry, lane)) = self.most_likely_refused()
            && let Some(reason) = self.settle(&batch[lane], entry, lane, stop)?
        {
            examined.refused = Some((
                lane,
                self.scratch.filter.unproved[entry].pair as usize,
                reason,
            ));
            return Some(examined);
        }
        for (lane, interval) in batch.iter().enumerate() {
            let first = self.scratch.lists.len();
            let mut excess = 0.0_f32;
            for entry in 0..self.scratch.filter.unproved.len() {
                if self.scratch.filter.unproved[entry].lanes >> lane & 1 == 0 {
                    continue;
                }
                let reason = self.settle(interval, entry, lane, stop)?;
                let unproved = &self.scratch.filter.unproved[entry];
                if unproved.lanes >> lane & 1 == 1 {
                    self.scratch.lists.push(unproved.pair);
                    excess = excess.max(unproved.excess[lane]);
                }
                if let Some(reason) = reason {
                    examined.refused =
                        examined
                            .refused
                            .or(Some((lane, unproved.pair as usize, reason)));
                    if until == Until::FirstRefusal {
                        return Some(examined);
                    }
                }
            }
            // Also of what is no number, two parts.
            let parts = excess.ceil().max(2.0).min(LANES as f32) as usize;
            examined.undecided[lane] = Undecided {
                pairs: List::Of(first, self.scratch.lists.len()),
                parts,
            };
        }
        Some(examined)
    }

    /// Runs the filter on up to eight intervals.
    pub(super) fn filter(&mut self, batch: &[Interval]) {
        let lanes = ((1_u16 << batch.len()) - 1) as u8;
        let Scratch {
            filter,
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
            return match batch[0].pairs {
                List::All => {
                    filter.leave((0..self.model.pairs().len() as u32).map(|pair| (pair, lanes)))
                }
                List::Of(..) => filter.leave(merged.iter().copied()),
            };
        }
        let interval = |lane: usize| {
            let Interval {
                segment,
                middle,
                half,
                ..
            } = batch[lane.min(batch.len() - 1)];
            LaneInterval {
                segment,
                middle,
                half,
            }
        };
        self.run(
            Proving,
            std::array::from_fn(interval),
            lanes,
            batch[0].pairs.is_all(),
        );
    }

    /// Runs the filter's kernel, proving or sampling.
    #[inline]
    pub(super) fn run<'s, W: EightWide<Output = ()>>(
        &'s mut self,
        what: impl FnOnce(Batch<'s>) -> W,
        intervals: [LaneInterval; LANES],
        lanes: u8,
        all_pairs: bool,
    ) {
        let margin = self.margin;
        let Scratch {
            filter: scratch,
            segments,
            merged,
            floors,
            ..
        } = &mut *self.scratch;
        let pairs = match all_pairs {
            true => Pairs::All {
                with_remote: segments.is_unconfined || margin * floors.highest() >= REMOTE_M,
            },
            false => Pairs::Of(merged),
        };
        let filter = self.model.filter();
        let segments = &segments.lanes;
        let highest_floor = floors.highest();
        let floors = floors.all();
        let batch = Batch {
            filter,
            space: self.space,
            segments,
            intervals,
            lanes,
            pairs,
            floors,
            highest_floor,
            scratch,
        };
        self.instructions.run(what(batch));
    }

    /// The undecided pair and lane that the filter saw nearest.
    fn most_likely_refused(&self) -> Option<(usize, usize)> {
        let mut nearest = None;
        let mut least = f32::INFINITY;
        for (entry, unproved) in self.scratch.filter.unproved.iter().enumerate() {
            for lane in (0..LANES).filter(|lane| unproved.lanes >> lane & 1 == 1) {
                if unproved.gap[lane] < least {
                    nearest = Some((entry, lane));
                    least = unproved.gap[lane];
                }
            }
        }
        nearest
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
        let mut verdict = IntervalVerdict::Split;
        // Where its rounding exceeds half a floor, splitting would go on without an end.
        let exactly_below = (self.margin * self.floors()[pair]).max(EXACT_BELOW_M);
        if f64::from(unproved.gap[lane]) < exactly_below || interval.half < FINEST {
            self.place(interval);
            verdict = self.decide(pair, interval.half, stop);
        }
        Some(match verdict {
            IntervalVerdict::Stopped => return None,
            IntervalVerdict::Proved(kept) => {
                self.scratch.filter.unproved[entry].lanes &= !(1 << lane);
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
    pub(super) fn place(&mut self, interval: &Interval) {
        let Scratch {
            motion, segments, ..
        } = &mut *self.scratch;
        let nq = self.space.nq();
        let (from, to) = segments.ends[2 * nq * interval.segment..][..2 * nq].split_at(nq);
        if segments
            .exact
            .is_none_or(|(segment, _)| segment != interval.segment)
        {
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
        self.scratch.floors.spend(pair) > LOWERED_FLOOR_INTERVALS
    }

    pub(super) fn decide(
        &mut self,
        pair: usize,
        half: f64,
        stop: &mut dyn FnMut() -> bool,
    ) -> IntervalVerdict {
        let model = self.model;
        let motion = &self.scratch.motion;
        let floor = self.floors()[pair];
        let mut interval = motion.pair_interval(model, &model.pairs()[pair], half, floor);
        interval.too_close = if self.seeks_contact {
            f64::NEG_INFINITY
        } else {
            self.margin * floor
        };
        if !self.layers.along_normal {
            interval.bend = f64::INFINITY;
        }
        let mut looks = Looks::new(stop);
        let mut direction = self.scratch.directions.get(&pair).copied();
        let mut verdict = interval.decide(&mut direction, &mut looks);
        if self.seeks_contact && verdict == IntervalVerdict::Split {
            // What made it too wide is one part of the bodies; others may touch in the middle.
            verdict = interval.touches_in_the_middle(&mut looks);
        }
        self.exact += looks.count;
        if let Some(direction) = direction {
            self.scratch.directions.insert(pair, direction);
        }
        verdict
    }
}
