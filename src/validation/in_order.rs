//! Segments proved in the order of a path, up to the first that is not.

use std::ops::Range;

use super::SegmentProof;
use super::continuous::{Scratch, Validator};
use super::examine::Until;
use super::path_proof::ends;
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
        self.begin();
        for number in range.clone() {
            let [from, to] = ends(path, number);
            if self.known(from, to).is_none() {
                self.add(from, to);
                self.scratch.segments.numbers.push(number);
            }
        }
        let refused = self.first_refused(stop)?;
        let Scratch { segments, .. } = &*self.scratch;
        let end = refused.map_or(range.end, |segment| segments.numbers[segment]);
        let mut added = segments.numbers.iter().zip(&segments.proofs).peekable();
        for number in range.start..end {
            let [from, to] = ends(path, number);
            let proof = added
                .next_if(|(of, _)| **of == number)
                .map(|(_, proof)| *proof);
            proofs.push(
                proof
                    .or_else(|| self.known(from, to))
                    .expect("a segment is looked at or known"),
            );
        }
        self.remember_proved();
        Some(end)
    }

    /// Looks at the segments at hand; the first that is refused, if any is. What follows it stays
    /// in the queue.
    pub(super) fn first_refused(
        &mut self,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Option<usize>> {
        let mut refused: Option<usize> = None;
        let mut left = Vec::new();
        while !self.scratch.queue.is_empty() {
            let (batch, count) = self.next_batch();
            let examined = self.examine(&batch[..count], Until::EveryPair, stop)?;
            if let Some((lane, ..)) = examined.refused {
                refused = Some(batch[lane].segment);
                left.push(batch[lane]);
            }
            for (interval, undecided) in batch.iter().zip(&examined.undecided) {
                self.scratch.queue.extend(interval.split(undecided));
            }
            if examined.refused.is_some() {
                let first = refused.unwrap_or(usize::MAX);
                self.scratch.queue.retain(|interval| {
                    let is_before = interval.segment < first;
                    left.extend(Some(*interval).filter(|_| !is_before));
                    is_before
                });
            }
        }
        self.scratch.queue.extend(left);
        Some(refused)
    }
}
