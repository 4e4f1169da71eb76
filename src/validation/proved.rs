//! What is proved, as a value.
//!
//! Only a validator makes one, and it holds on to the rows that it speaks of, so that nobody
//! changes them meanwhile: whoever accepts nothing but this need not ask what was proved.

use super::validator::Validator;
use super::{SegmentProof, SegmentRefusal, SegmentsVerdict};

/// Rows laid end to end, every straight segment between which keeps the floors of the validator
/// that made this.
///
/// ```compile_fail
/// let nobody_asked = taut::validation::Proved { rows: &[0.0, 1.0], proofs: Vec::new() };
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Proved<'p> {
    rows: &'p [f64],
    proofs: Vec<SegmentProof>,
}

impl<'p> Proved<'p> {
    pub(super) fn new(rows: &'p [f64], proofs: Vec<SegmentProof>) -> Self {
        Self { rows, proofs }
    }

    /// The rows.
    pub fn rows(&self) -> &'p [f64] {
        self.rows
    }

    /// The proof of each segment, in order; one row alone is a segment that does not move.
    pub fn proofs(&self) -> &[SegmentProof] {
        &self.proofs
    }

    /// The same, by itself.
    pub fn into_proofs(self) -> Vec<SegmentProof> {
        self.proofs
    }
}

/// What is known of rows laid end to end.
#[derive(Clone, Debug, PartialEq)]
pub enum RowsVerdict<'p> {
    /// Every segment is proved.
    Proved(Proved<'p>),
    /// One is refused; not always the first that would be.
    Refused(SegmentRefusal),
    /// `stop` said so before there was a verdict.
    Stopped,
}

impl Validator<'_> {
    /// Proves the segments between rows laid end to end, all looked at together; see
    /// [`Self::segments`].
    pub fn prove<'p>(
        &mut self,
        rows: &'p [f64],
        stop: &mut dyn FnMut() -> bool,
    ) -> RowsVerdict<'p> {
        match self.segments(self.segments_of(rows), stop) {
            SegmentsVerdict::Proved => {
                RowsVerdict::Proved(Proved::new(rows, self.examiner.proofs_in_order()))
            }
            SegmentsVerdict::Refused(refusal) => RowsVerdict::Refused(refusal),
            SegmentsVerdict::Stopped => RowsVerdict::Stopped,
        }
    }

    /// Both ends of each segment of rows laid end to end.
    fn segments_of<'p>(
        &self,
        rows: &'p [f64],
    ) -> impl Iterator<Item = [&'p [f64]; 2]> + Clone + use<'p> {
        let nq = self.examiner.space.nq();
        let ends = move |segment: usize| {
            let next = ((segment + 1) * nq).min(rows.len() - nq);
            [&rows[segment * nq..][..nq], &rows[next..][..nq]]
        };
        // A robot without variables stands still: one segment that does not move.
        let waypoints = rows.len().checked_div(nq).unwrap_or(1);
        (0..(waypoints - 1).max(1)).map(ends)
    }
}
