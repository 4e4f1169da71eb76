//! Segments proved in the order of a path, up to the first that is not.

use std::ops::Range;

use super::SegmentProof;
use super::demand::Demand;
use super::examine::Until;
use super::examiner::Examiner;
use super::path_proof::ends;
use super::undecided::Interval;
use super::validator::Validator;
use crate::path::Path;

impl Validator<'_> {
    /// Proves these segments of a path together, and appends the proofs of those before the first
    /// that is refused; the number of that one, or the end of the range. `None` where stopped.
    pub(super) fn prove_in_order(
        &mut self,
        path: &Path,
        range: Range<usize>,
        proofs: &mut Vec<SegmentProof>,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<usize> {
        let range = self.up_to_violation(path, range, stop)?;
        self.lay_out(range.clone().map(|number| ends(path, number)), stop)?;
        let (examiner, mut demand) = self.at_floors();
        let refused = examiner.first_refused(&mut demand, stop)?;
        let numbers = &examiner.scratch.segments.numbers;
        let count = refused.map_or(range.len(), |segment| numbers[segment]);
        proofs.extend_from_slice(&examiner.proofs_in_order()[..count]);
        self.remember_proved();
        Some(range.start + count)
    }
}

impl Examiner<'_> {
    /// Looks at the segments at hand; the first that is refused, if any is. What follows it stays
    /// in the queue.
    pub(super) fn first_refused(
        &mut self,
        demand: &mut Demand,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Option<usize>> {
        let mut refused: Option<usize> = None;
        let mut left = Vec::new();
        while !self.scratch.queue.is_empty() {
            let (batch, count) = self.next_batch();
            let batch = &batch[..count];
            let examined = self.examine(demand, batch, Until::Everything, stop)?;
            self.queue_parts(batch, &examined);
            if let Some((lane, ..)) = examined.refused {
                let segment = batch[lane].segment;
                refused = Some(segment);
                left.push(batch[lane]);
                self.put_off(segment, &mut left);
            }
        }
        self.scratch.queue.extend(left);
        Some(refused)
    }

    /// Takes what does not lie before a refused segment out of the queue: it cannot be the first.
    fn put_off(&mut self, refused: usize, left: &mut Vec<Interval>) {
        self.scratch.queue.retain(|interval| {
            let is_before = interval.segment < refused;
            left.extend(Some(*interval).filter(|_| !is_before));
            is_before
        });
    }
}
