//! Segments, their intervals, and the pairs that are undecided on each.

use super::SegmentProof;
use super::polynomial::Polynomial;
use crate::lanes::LANES;
use crate::robot::lane_kinematics::LaneSegments;

/// `[middle − half, middle + half]` of a segment, and the pairs that are undecided there.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Interval {
    pub(super) segment: usize,
    pub(super) middle: f64,
    pub(super) half: f64,
    pub(super) pairs: List,
}

/// Pairs that are undecided on an interval.
#[derive(Clone, Copy, Debug, Default)]
pub(super) enum List {
    /// All of the model.
    #[default]
    All,
    /// A range of the lists.
    Of(usize, usize),
}

/// Pairs that an interval leaves undecided, and the number of parts that should settle them.
#[derive(Clone, Copy, Default)]
pub(super) struct Undecided {
    pub(super) pairs: List,
    pub(super) parts: usize,
}

impl Undecided {
    /// On an interval that is `excess` times too wide for these pairs.
    ///
    /// The displacement is nearly proportional to the width, so that as many parts should settle
    /// them; also of what is no number, two.
    pub(super) fn new(pairs: List, excess: f32) -> Self {
        let parts = excess.ceil().max(2.0).min(LANES as f32) as usize;
        Self { pairs, parts }
    }
}

impl List {
    pub(super) fn is_all(&self) -> bool {
        matches!(self, Self::All)
    }

    pub(super) fn is_empty(&self) -> bool {
        matches!(self, Self::Of(first, last) if first == last)
    }
}

impl Interval {
    /// Whether both are the same part of the same segment.
    pub(super) fn is_same_part(&self, other: &Self) -> bool {
        let place = |it: &Self| (it.segment, it.middle, it.half);
        place(self) == place(other)
    }

    /// The first half, which looks at these pairs.
    pub(super) fn first_half(&self, pairs: List) -> Self {
        let half = self.half / 2.0;
        Self {
            middle: self.middle - half,
            half,
            pairs,
            ..*self
        }
    }
    /// Equal parts from left to right, which look at what is undecided; none where nothing is.
    pub(super) fn split(
        &self,
        undecided: &Undecided,
    ) -> impl DoubleEndedIterator<Item = Self> + use<> {
        let Undecided { pairs, parts } = *undecided;
        let parts = if pairs.is_empty() { 0 } else { parts };
        let whole = Self { pairs, ..*self };
        let half = self.half / parts.max(1) as f64;
        (0..parts).map(move |part| whole.part_of(part, half))
    }

    /// The part of this half width and number, from the left.
    fn part_of(&self, part: usize, half: f64) -> Self {
        let start = self.middle - self.half;
        Self {
            middle: start + half * (2 * part + 1) as f64,
            half,
            ..*self
        }
    }

    /// The part of a whole segment of this half width and number, which looks at all pairs.
    pub(super) fn part(segment: usize, part: usize, half: f64) -> Self {
        Self {
            segment,
            middle: half * (2 * part + 1) as f64,
            half,
            pairs: List::All,
        }
    }
}

impl Segments {
    /// Forgets all.
    pub(super) fn clear(&mut self) {
        self.ends.clear();
        self.curves.clear();
        self.lanes.clear();
        self.proofs.clear();
        self.numbers.clear();
        self.in_order.clear();
        self.is_unconfined = false;
        self.exact = None;
    }

    /// Both ends of a segment, of configurations of so many numbers.
    pub(super) fn ends(&self, segment: usize, nq: usize) -> (&[f64], &[f64]) {
        self.ends[2 * nq * segment..][..2 * nq].split_at(nq)
    }

    /// Whether those at hand are curves.
    pub(super) fn are_curves(&self) -> bool {
        !self.curves.is_empty()
    }

    /// The columns of a curve.
    pub(super) fn curve(&self, segment: usize, nq: usize) -> &[Polynomial] {
        &self.curves[segment * nq..][..nq]
    }

    /// What is kept on a segment, at most this (m).
    pub(super) fn keep(&mut self, segment: usize, clearance_m: f64) {
        let proof = &mut self.proofs[segment];
        proof.clearance_m = proof.clearance_m.min(clearance_m);
    }
}

/// The segments that are being proved.
#[derive(Debug, Default)]
pub(super) struct Segments {
    /// Both ends of each straight one, one after the other.
    pub(super) ends: Vec<f64>,
    /// The columns of each curve, one after the other: all that are at hand are straight, or none.
    pub(super) curves: Vec<Polynomial>,
    pub(super) velocity: Vec<f64>,
    pub(super) lanes: LaneSegments,
    pub(super) proofs: Vec<SegmentProof>,
    /// What the caller calls each.
    pub(super) numbers: Vec<usize>,
    /// The proofs of all that the caller asks for, known ones among them.
    pub(super) in_order: Vec<SegmentProof>,
    /// Some end is outside of the limits that remote obstacles count on.
    pub(super) is_unconfined: bool,
    /// The interval for which the exact motion was prepared: in its middle the bodies stand.
    pub(super) exact: Option<Interval>,
}
