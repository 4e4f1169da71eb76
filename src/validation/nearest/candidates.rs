//! Intervals on which less of a requirement may be kept than is looked for.

use std::cmp::Ordering;

use super::super::demand::Demand;
use super::super::examiner::{ASKED_EVERY, Examiner};
use super::super::requirement::Requirement;
use super::super::undecided::{Interval, List, Undecided};
use super::super::way::Way;
use super::{FINEST_M, Near, Search};

/// A requirement of which little is kept in the middle of an interval.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub(super) requirement: Requirement,
    pub(super) interval: Interval,
}

impl Candidate {
    /// Requirement by requirement, each along the path.
    pub(super) fn along_the_path(&self, other: &Self) -> Ordering {
        let place = |it: &Self| (it.requirement, it.interval.segment);
        place(self).cmp(&place(other)).then(
            self.interval
                .middle
                .total_cmp(&other.interval.middle),
        )
    }
}

impl Examiner<'_> {
    /// Looks at the whole path as a proof does, but goes on where too little is kept: these are the candidates. `None` where stopped or too dear.
    pub(super) fn candidates(
        &mut self,
        search: &Search,
        demand: &mut Demand,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Vec<Candidate>> {
        self.add_all(search.ways, demand, stop)?;
        let mut found = Vec::new();
        while !self.scratch.queue.is_empty() {
            if stop() || self.work() > search.most_work {
                return None;
            }
            let (batch, count) = self.next_batch();
            self.filter(demand, &batch[..count]);
            for (lane, interval) in batch[..count].iter().enumerate() {
                let undecided =
                    self.candidates_of_lane(demand, lane, interval, &mut found, stop)?;
                self.scratch
                    .queue
                    .extend(interval.split(&undecided));
            }
        }
        Some(found)
    }

    /// Takes all segments in hand; `None` where stopped.
    fn add_all(
        &mut self,
        ways: &[Way],
        demand: &mut Demand,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<()> {
        self.begin(demand);
        for (segment, way) in ways.iter().enumerate() {
            if segment % ASKED_EVERY == 0 && stop() {
                return None;
            }
            self.add(*way);
        }
        Some(())
    }

    /// Settles what the filter leaves of one interval.
    fn candidates_of_lane(
        &mut self,
        demand: &mut Demand,
        lane: usize,
        interval: &Interval,
        found: &mut Vec<Candidate>,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Undecided> {
        let first = self.scratch.lists.len();
        let mut excess = 0.0_f32;
        for entry in 0..self.scratch.filter.unproved.len() {
            if !self.scratch.filter.unproved[entry].is_in(lane) {
                continue;
            }
            match self.settle(demand, interval, entry, lane, stop)? {
                Some(_) => found.push(Candidate {
                    requirement: self.required(entry),
                    interval: *interval,
                }),
                None => excess = excess.max(self.list(entry, lane)),
            }
        }
        let pairs = List::Of(first, self.scratch.lists.len());
        Some(Undecided::new(pairs, excess))
    }

    /// What is nearest of the candidates' middles, followed to where it is nearest: what is farther
    /// away than this need not be looked for.
    pub(super) fn rough_smallest(
        &mut self,
        candidates: &[Candidate],
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Option<Near>> {
        let nearest = self.nearest_in_the_middle(candidates, stop)?;
        Some(nearest.map(|candidate| {
            let Candidate {
                requirement,
                interval,
            } = candidate;
            self.follow(requirement, &interval, [0.0, 1.0], FINEST_M)
        }))
    }

    /// The candidate of which least is kept in the middle; of equals, the first.
    fn nearest_in_the_middle(
        &mut self,
        candidates: &[Candidate],
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Option<Candidate>> {
        let mut nearest: Option<(f64, Candidate)> = None;
        for candidate in candidates {
            if stop() {
                return None;
            }
            let distance = self.measure_roughly(candidate.requirement, &candidate.interval);
            if nearest.is_none_or(|(least, _)| distance < least) {
                nearest = Some((distance, *candidate));
            }
        }
        Some(nearest.map(|(_, candidate)| candidate))
    }
}
