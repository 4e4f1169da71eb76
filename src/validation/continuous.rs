//! The certified check of segments: intervals, eight at a time, and lists of undecided pairs that
//! shrink on the way down.
//!
//! A segment is cut into intervals; eight of them, of whatever segments, are looked at together by
//! the [filter](super::filter). What it does not prove is undecided. Where it saw an undecided pair
//! at least 1.5 floors apart in the middle, the interval is split; where not, the exact bodies
//! decide: a lower bound of the distance over the whole interval reaches the pair's floor → the
//! pair is done; the bodies touch in the middle → collision; they are closer than 1.5 floors → too
//! close; otherwise it is split. Parts of a split interval look only at the pairs that are
//! undecided there. These are at least 1.5 floors apart in the middle, so they end when their
//! displacement bound falls to half a floor: everything clearer than 1.5 floors is proved,
//! everything proved is at least one floor clear.

use std::collections::VecDeque;

use super::constrained::Search;
use super::demand::Demand;
use super::examine::{Examined, Until};
use super::examiner::{ASKED_EVERY, Examiner};
use super::polynomial::Polynomial;
use super::requirement::Requirement;
use super::undecided::{Interval, Segments};
use super::validator::Validator;
use super::way::Way;
use super::{Hit, HitReason, SegmentProof, SegmentRefusal, SegmentVerdict, SegmentsVerdict};

/// What a search for a refusal found first.
enum Found {
    Nothing,
    Refusal(Interval, Requirement, HitReason),
    Stopped,
}

/// What came of one segment.
pub(super) enum Attempt {
    Proved(SegmentProof),
    Refused {
        t: f64,
        requirement: Requirement,
        reason: HitReason,
    },
    Stopped,
}

/// The same, with the interval that is refused.
enum Settled {
    Proved(SegmentProof),
    Refused(Interval, Requirement, HitReason),
    Stopped,
}

/// Which segments have an interval in the queue; none at all where it is empty.
fn open_segments(queue: &VecDeque<Interval>, count: usize) -> Vec<bool> {
    let mut open = Vec::new();
    for interval in queue {
        open.resize(count, false);
        open[interval.segment] = true;
    }
    open
}

/// What is demanded is an argument; nothing is remembered.
impl Examiner<'_> {
    /// Proves the straight segment between two configurations, or refuses it as soon as anything is
    /// found.
    pub(super) fn segment(
        &mut self,
        demand: &mut Demand,
        way: Way,
        stop: &mut dyn FnMut() -> bool,
    ) -> SegmentVerdict {
        match self.settle_segment(demand, way, stop) {
            Settled::Proved(proof) => SegmentVerdict::Proved(proof),
            Settled::Refused(interval, requirement, reason) => SegmentVerdict::Refused(Hit {
                // Wide intervals come first: nothing is known of what lies before.
                proved_until: 0.0,
                ..self.hit(&interval, requirement, reason)
            }),
            Settled::Stopped => SegmentVerdict::Stopped,
        }
    }

    /// Proves a segment, or finds what refuses it.
    fn settle_segment(
        &mut self,
        demand: &mut Demand,
        way: Way,
        stop: &mut dyn FnMut() -> bool,
    ) -> Settled {
        self.begin(demand);
        self.add(way);
        match self.search(demand, stop) {
            Found::Nothing => Settled::Proved(self.scratch.segments.proofs[0]),
            Found::Refusal(interval, requirement, reason) => {
                Settled::Refused(interval, requirement, reason)
            }
            Found::Stopped => Settled::Stopped,
        }
    }

    /// Takes the segments to be looked at in hand, but for those of which a proof is `known`; `None`
    /// where stopped.
    pub(super) fn lay_out<'q>(
        &mut self,
        demand: &mut Demand,
        segments: impl Iterator<Item = [&'q [f64]; 2]>,
        known: impl Fn(&[f64], &[f64]) -> Option<SegmentProof>,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<()> {
        self.begin(demand);
        for (number, [from, to]) in segments.enumerate() {
            if number % ASKED_EVERY == ASKED_EVERY - 1 && stop() {
                return None;
            }
            self.lay_out_segment(number, [from, to].into(), known(from, to));
        }
        Some(())
    }

    fn lay_out_segment(&mut self, number: usize, way: Way, known: Option<SegmentProof>) {
        let segments = &mut self.scratch.segments;
        segments
            .in_order
            .push(known.unwrap_or(SegmentProof::EMPTY));
        if known.is_none() {
            segments.numbers.push(number);
            self.add(way);
        }
    }

    /// Looks at the segments that were laid out.
    pub(super) fn settle_laid_out(
        &mut self,
        demand: &mut Demand,
        stop: &mut dyn FnMut() -> bool,
    ) -> SegmentsVerdict {
        match self.search(demand, stop) {
            Found::Nothing => SegmentsVerdict::Proved,
            Found::Refusal(interval, requirement, reason) => {
                SegmentsVerdict::Refused(SegmentRefusal {
                    segment: self.scratch.segments.numbers[interval.segment],
                    t: interval.middle,
                    requirement,
                    reason,
                })
            }
            Found::Stopped => SegmentsVerdict::Stopped,
        }
    }

    /// The proofs of the segments that were laid out, in their order; they are proved.
    pub(super) fn proofs_in_order(&mut self) -> Vec<SegmentProof> {
        let Segments {
            in_order,
            numbers,
            proofs,
            ..
        } = &mut self.scratch.segments;
        for (number, proof) in numbers.iter().zip(proofs) {
            in_order[*number] = *proof;
        }
        in_order.clone()
    }

    /// Looks at all that is queued, wide intervals first.
    fn search(&mut self, demand: &mut Demand, stop: &mut dyn FnMut() -> bool) -> Found {
        while !self.scratch.queue.is_empty() {
            let (batch, count) = self.next_batch();
            let batch = &batch[..count];
            let Some(examined) = self.examine(demand, batch, Until::FirstRefusal, stop) else {
                return Found::Stopped;
            };
            if let Some((lane, requirement, reason)) = examined.refused {
                // They are not proved: see `remember_proved`.
                let back = batch.iter().rev();
                back.for_each(|interval| self.scratch.queue.push_front(*interval));
                return Found::Refusal(batch[lane], requirement, reason);
            }
            self.queue_parts(batch, &examined);
        }
        Found::Nothing
    }

    /// Queues the parts of the intervals of a batch that are left undecided.
    pub(super) fn queue_parts(&mut self, batch: &[Interval], examined: &Examined) {
        // Behind all that is as wide: a refusal is found in the widest interval that shows it.
        for (interval, undecided) in batch.iter().zip(&examined.undecided) {
            self.scratch
                .queue
                .extend(interval.split(undecided));
        }
    }

    pub(super) fn hit(
        &mut self,
        interval: &Interval,
        requirement: Requirement,
        reason: HitReason,
    ) -> Hit {
        self.place(interval);
        let measure = self.measure(requirement);
        Hit {
            // What decided may have seen another part of the bodies; the closest points have the last
            // word.
            reason: if measure.touches() {
                HitReason::Collision
            } else {
                reason
            },
            t: interval.middle,
            requirement,
            measure,
            proved_until: interval.middle - interval.half,
        }
    }
}

/// At the validator's floors, and what is proved is remembered.
impl Validator<'_> {
    /// Proves the straight segment between two configurations, or refuses it as soon as anything is
    /// found.
    ///
    /// Intervals are looked at from wide to narrow, so that a refusal is much cheaper than a proof.
    /// `stop` is asked at every eight intervals, and within them where the search is long.
    pub fn segment(
        &mut self,
        from: &[f64],
        to: &[f64],
        stop: &mut dyn FnMut() -> bool,
    ) -> SegmentVerdict {
        if let Some(proof) = self.known(from, to) {
            return SegmentVerdict::Proved(proof);
        }
        if let Some(hit) = self.violation_hit([from, to], Search::Any) {
            return SegmentVerdict::Refused(hit);
        }
        let (examiner, mut demand) = self.at_floors();
        let verdict = examiner.segment(&mut demand, [from, to].into(), stop);
        if let SegmentVerdict::Proved(_) = verdict {
            self.remember_proved();
        }
        verdict
    }

    /// The same without the measure of a refusal, which may cost more than finding the place.
    pub(super) fn attempt(&mut self, way: Way, stop: &mut dyn FnMut() -> bool) -> Attempt {
        if let Way::Straight([from, to]) = way
            && let Some(proof) = self.known(from, to)
        {
            return Attempt::Proved(proof);
        }
        if let Some(violation) = self.violation(way, Search::Any) {
            return Attempt::Refused {
                t: violation.t,
                requirement: violation.requirement(),
                reason: violation.reason,
            };
        }
        let (examiner, mut demand) = self.at_floors();
        match examiner.settle_segment(&mut demand, way, stop) {
            Settled::Proved(proof) => {
                self.remember_proved();
                Attempt::Proved(proof)
            }
            Settled::Refused(interval, requirement, reason) => Attempt::Refused {
                t: interval.middle,
                requirement,
                reason,
            },
            Settled::Stopped => Attempt::Stopped,
        }
    }

    /// Whether [`Self::segment`] would prove each of several segments, all looked at together:
    /// eight intervals of whatever segments at once, and wide ones before narrow ones. Proofs are
    /// remembered for [`Self::segment`]. Cheaper than asking that for a verdict, because a
    /// refusal's exact measure often costs more than finding the refusal. Constraints come first: they
    /// are the cheapest to refuse by.
    pub fn segments<'q>(
        &mut self,
        segments: impl Iterator<Item = [&'q [f64]; 2]> + Clone,
        stop: &mut dyn FnMut() -> bool,
    ) -> SegmentsVerdict {
        // Where constraints refuse, nothing is laid out: what is still at hand is of another path, perhaps of
        // another request, and must not be remembered as proved of this one.
        self.examiner.forget();
        match self.refused_by_constraints(segments.clone(), stop) {
            None => return SegmentsVerdict::Stopped,
            Some(Some(refusal)) => return SegmentsVerdict::Refused(refusal),
            Some(None) => {}
        }
        if self.lay_out(segments, stop).is_none() {
            return SegmentsVerdict::Stopped;
        }
        let (examiner, mut demand) = self.at_floors();
        let verdict = examiner.settle_laid_out(&mut demand, stop);
        if verdict == SegmentsVerdict::Proved {
            self.remember_proved();
        }
        verdict
    }

    /// Whether each of several curves, the columns of each for t in [0, 1], is proved, all looked at
    /// together; nothing is remembered.
    pub(super) fn curves<'q>(
        &mut self,
        curves: impl Iterator<Item = &'q [Polynomial]> + Clone,
        stop: &mut dyn FnMut() -> bool,
    ) -> SegmentsVerdict {
        let ways = curves.map(Way::Curved).enumerate();
        let mut violations = ways.clone().filter_map(|(number, way)| {
            let violation = self.violation(way, Search::Any)?;
            Some(violation.refusal(number))
        });
        if let Some(refusal) = violations.next() {
            return SegmentsVerdict::Refused(refusal);
        }
        let (examiner, mut demand) = self.at_floors();
        examiner.begin(&mut demand);
        ways.for_each(|(number, way)| examiner.lay_out_segment(number, way, None));
        examiner.settle_laid_out(&mut demand, stop)
    }

    /// Takes the segments to be looked at in hand, but for those that are known; `None` where
    /// stopped.
    pub(super) fn lay_out<'q>(
        &mut self,
        segments: impl Iterator<Item = [&'q [f64]; 2]>,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<()> {
        let ledger = self.remembers().then_some(&*self.ledger);
        let known = |from: &[f64], to: &[f64]| ledger?.get(from, to);
        let mut demand = Demand::proof(self.floors, self.directions);
        self.examiner
            .lay_out(&mut demand, segments, known, stop)
    }

    /// Whether one segment is proved; `None` where stopped.
    pub fn proves(
        &mut self,
        from: &[f64],
        to: &[f64],
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<bool> {
        match self.segments([[from, to]].into_iter(), stop) {
            SegmentsVerdict::Proved => Some(true),
            SegmentsVerdict::Refused(_) => Some(false),
            SegmentsVerdict::Stopped => None,
        }
    }

    pub(super) fn known(&self, from: &[f64], to: &[f64]) -> Option<SegmentProof> {
        self.remembers()
            .then(|| self.ledger.get(from, to))
            .flatten()
    }

    /// Remembers the segments at hand of which nothing is left in the queue.
    pub(super) fn remember_proved(&mut self) {
        if !self.remembers() {
            return;
        }
        let nq = self.examiner.space.nq();
        let segments = &self.examiner.scratch.segments;
        let open = open_segments(&self.examiner.scratch.queue, segments.proofs.len());
        let ends = segments.ends.chunks((2 * nq).max(1));
        for (number, (ends, proof)) in ends.zip(&segments.proofs).enumerate() {
            if !open.get(number).is_some_and(|is_open| *is_open) {
                self.ledger
                    .insert(&ends[..nq], &ends[nq..], *proof);
            }
        }
    }
}
