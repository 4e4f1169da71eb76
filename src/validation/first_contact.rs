//! Where a segment first collides, whatever is merely too close on it: a collision anywhere is
//! worse than anything that cannot be proved.
//!
//! The search is the proof of [`continuous`](super::continuous) with another question: not whether
//! every pair keeps its floor, but whether any gets deeper into each other than [`UNSEEN_DEPTH_M`].
//! Only contact in the middle of an interval refuses, and an interval that no pair gets as deep on
//! is done. What lies to the left of a contact is looked at first, so that the earliest is found
//! without a look at what follows it.

use super::demand::Demand;
use super::examine::{Examined, Until};
use super::examiner::Examiner;
use super::path_proof::LEAST_FLOOR_M;
use super::requirement::Requirement;
use super::undecided::Interval;
use super::validator::{FINEST, Validator};
use super::way::Way;

/// Bodies that get no deeper into each other than this (m) may pass as too close.
pub const UNSEEN_DEPTH_M: f64 = LEAST_FLOOR_M;

/// Intervals after which none narrower than [`FINEST`] is looked at on this segment.
const MOST_INTERVALS: usize = 100_000;
/// No interval is narrower: the values of a configuration have few more digits.
const NARROWEST: f64 = 1.0 / (1_u64 << 44) as f64;

/// Bodies that touch or overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Touch {
    /// Ratio on the segment, in [0, 1].
    pub(super) t: f64,
    /// The clearance that is not kept.
    pub(super) requirement: Requirement,
}

/// What a search for contact found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum FirstContact {
    /// No pair gets deeper into each other than [`UNSEEN_DEPTH_M`].
    Nothing,
    /// This is so before `t` less [`FINEST`].
    At(Touch),
    /// `stop` said so; with what was found until then, which need not be the first.
    Stopped(Option<Touch>),
}

/// How far a search has come.
struct Earliest {
    touch: Option<Touch>,
    /// Intervals looked at.
    looks: usize,
}

impl Earliest {
    /// Whether an interval needs a look.
    fn wants(&self, part: &Interval) -> bool {
        // A contact is told to within `FINEST`: one that is as near before it is the same.
        let before = self
            .touch
            .map_or(f64::INFINITY, |touch| touch.t - FINEST);
        part.half >= self.narrowest() && part.middle - part.half < before
    }

    /// No interval is looked at that has less than this half width.
    fn narrowest(&self) -> f64 {
        match self.looks < MOST_INTERVALS {
            true => NARROWEST,
            false => FINEST / 2.0,
        }
    }
}

impl Validator<'_> {
    /// The first contact on a segment, to within [`FINEST`]. Floors and what is proved stay as they
    /// are.
    pub(super) fn first_contact(
        &mut self,
        way: Way,
        stop: &mut dyn FnMut() -> bool,
    ) -> FirstContact {
        let (examiner, mut demand) = self.seeking_contact(-UNSEEN_DEPTH_M);
        let found = examiner.earliest_contact(&mut demand, way, stop);
        // What is known of the segment is known at that floor.
        examiner.forget();
        found
    }
}

impl Examiner<'_> {
    fn earliest_contact(
        &mut self,
        demand: &mut Demand,
        way: Way,
        stop: &mut dyn FnMut() -> bool,
    ) -> FirstContact {
        self.begin(demand);
        self.add(way);
        let mut search = Earliest {
            touch: None,
            looks: 0,
        };
        // The queue is in order along the segment, and so are the lanes.
        while !self.scratch.queue.is_empty() {
            let (batch, count) = self.next_batch();
            let Some(examined) = self.examine(demand, &batch[..count], Until::Everything, stop)
            else {
                return FirstContact::Stopped(search.touch);
            };
            search.looks += count;
            self.narrow(&batch[..count], &examined, &mut search);
        }
        search
            .touch
            .map_or(FirstContact::Nothing, FirstContact::At)
    }

    /// Puts what is left of a batch first; where it touches, nothing that follows counts any more.
    fn narrow(&mut self, batch: &[Interval], examined: &Examined, search: &mut Earliest) {
        let mut left = batch;
        if let Some((lane, requirement, _)) = examined.refused {
            let interval = &batch[lane];
            search.touch = Some(Touch {
                t: interval.middle,
                requirement,
            });
            left = &batch[..lane];
            self.scratch.queue.clear();
            let before = interval.first_half(examined.undecided[lane].pairs);
            self.queue_first(std::iter::once(before), search);
        }
        // From the last to the first, each before all others: the queue stays in order.
        for (interval, undecided) in left.iter().zip(&examined.undecided).rev() {
            self.queue_first(interval.split(undecided), search);
        }
    }

    /// Puts intervals that follow each other before all others, but for those that need no look.
    fn queue_first(&mut self, parts: impl DoubleEndedIterator<Item = Interval>, search: &Earliest) {
        parts
            .rev()
            .filter(|part| search.wants(part))
            .for_each(|part| self.scratch.queue.push_front(part));
    }
}
