//! Intervals on which a pair may come nearer than what is looked for.

use std::cmp::Ordering;

use super::super::path_proof::{ends, segments};
use super::super::undecided::{Interval, List, Undecided};
use super::super::validator::{ASKED_EVERY, Validator};
use super::{FINEST_M, Near};

use crate::path::Path;

/// A pair that is near in the middle of an interval.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub(super) pair: usize,
    pub(super) interval: Interval,
}

impl Candidate {
    /// Pair by pair, each along the path.
    pub(super) fn along_the_path(&self, other: &Self) -> Ordering {
        let place = |it: &Self| (it.pair, it.interval.segment);
        place(self).cmp(&place(other)).then(
            self.interval
                .middle
                .total_cmp(&other.interval.middle),
        )
    }
}

impl Validator<'_> {
    /// Looks at the whole path as a proof at the present floors does, but goes on where a pair is
    /// too close: these are the candidates. `None` where stopped or too dear.
    pub(super) fn candidates(
        &mut self,
        path: &Path,
        most_work: u64,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Vec<Candidate>> {
        self.add_all(path, stop)?;
        let mut found = Vec::new();
        while !self.scratch.queue.is_empty() {
            if stop() || self.work() > most_work {
                return None;
            }
            let (batch, count) = self.next_batch();
            self.filter(&batch[..count]);
            for (lane, interval) in batch[..count].iter().enumerate() {
                let undecided = self.settle_lane(lane, interval, &mut found, stop)?;
                self.scratch
                    .queue
                    .extend(interval.split(&undecided));
            }
        }
        Some(found)
    }

    /// Takes all segments of a path in hand; `None` where stopped.
    fn add_all(&mut self, path: &Path, stop: &mut dyn FnMut() -> bool) -> Option<()> {
        self.begin();
        for segment in 0..segments(path) {
            if segment % ASKED_EVERY == 0 && stop() {
                return None;
            }
            let [from, to] = ends(path, segment);
            self.add(from, to);
        }
        Some(())
    }

    /// Settles what the filter leaves of one interval.
    fn settle_lane(
        &mut self,
        lane: usize,
        interval: &Interval,
        found: &mut Vec<Candidate>,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Undecided> {
        let first = self.scratch.lists.len();
        let mut excess = 0.0_f32;
        for entry in 0..self.scratch.filter.unproved.len() {
            let unproved = &self.scratch.filter.unproved[entry];
            if !unproved.is_in(lane) {
                continue;
            }
            let pair = unproved.pair as usize;
            match self.settle(interval, entry, lane, stop)? {
                Some(_) => found.push(Candidate {
                    pair,
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
        Some(
            nearest.map(|Candidate { pair, interval }| {
                self.follow(pair, &interval, [0.0, 1.0], FINEST_M)
            }),
        )
    }

    /// The candidate whose bodies are nearest in the middle; of equals, the first.
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
            let distance = self.nearly_apart(candidate.pair, &candidate.interval);
            if nearest.is_none_or(|(least, _)| distance < least) {
                nearest = Some((distance, *candidate));
            }
        }
        Some(nearest.map(|(_, candidate)| candidate))
    }
}
