//! Where a segment is first refused: everything before that is proved.

use super::constrained::Search;
use super::examine::{Examined, Until};
use super::examiner::Examiner;
use super::requirement::Requirement;
use super::undecided::Interval;
use super::validator::{FINEST, Validator};
use super::{Hit, HitReason, SegmentVerdict};

impl Validator<'_> {
    /// The same verdict as [`Self::segment`], but a refusal is the first along the segment, found
    /// to [`FINEST`]: everything before its `proved_until` is proved.
    pub fn first_hit(
        &mut self,
        from: &[f64],
        to: &[f64],
        stop: &mut dyn FnMut() -> bool,
    ) -> SegmentVerdict {
        let violation = self.violation_hit([from, to], Search::First);
        match (self.first_of_pairs(from, to, stop), violation) {
            (SegmentVerdict::Refused(hit), Some(violation)) => {
                SegmentVerdict::Refused(earlier(hit, violation))
            }
            (SegmentVerdict::Proved(_), Some(violation)) => SegmentVerdict::Refused(violation),
            (verdict, _) => verdict,
        }
    }

    fn first_of_pairs(
        &mut self,
        from: &[f64],
        to: &[f64],
        stop: &mut dyn FnMut() -> bool,
    ) -> SegmentVerdict {
        let (examiner, mut demand) = self.at_floors();
        examiner.begin(&mut demand);
        examiner.add([from, to].into());
        // A stack on which what is farthest left is next; a hit makes all that waits to its right
        // idle.
        examiner
            .scratch
            .queue
            .make_contiguous()
            .reverse();
        let mut earliest = None;
        while let Some(interval) = examiner.scratch.queue.pop_back() {
            let Some(examined) =
                examiner.examine(&mut demand, &[interval], Until::Everything, stop)
            else {
                return SegmentVerdict::Stopped;
            };
            earliest = examiner
                .go_left(interval, &examined)
                .or(earliest);
        }
        let Some((interval, requirement, reason)) = earliest else {
            return SegmentVerdict::Proved(examiner.scratch.segments.proofs[0]);
        };
        // The measure is exact and dear: only of the hit that counts.
        SegmentVerdict::Refused(examiner.hit(&interval, requirement, reason))
    }
}

/// The one that is first; what is proved of both is proved.
fn earlier(a: Hit, b: Hit) -> Hit {
    let first = if b.t < a.t { b } else { a };
    Hit {
        proved_until: a.proved_until.min(b.proved_until),
        ..first
    }
}

impl Examiner<'_> {
    /// Puts what is left of an interval on the stack: of one that is refused, what lies before.
    fn go_left(
        &mut self,
        interval: Interval,
        examined: &Examined,
    ) -> Option<(Interval, Requirement, HitReason)> {
        let undecided = &examined.undecided[0];
        let Some((_, requirement, reason)) = examined.refused else {
            self.scratch
                .queue
                .extend(interval.split(undecided).rev());
            return None;
        };
        self.scratch.queue.clear();
        let left = Some(interval.first_half(undecided.pairs));
        self.scratch
            .queue
            .extend(left.filter(|left| left.half > FINEST));
        Some((interval, requirement, reason))
    }
}
