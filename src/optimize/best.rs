//! The best path so far: it takes nothing but what is [`Proved`], and sees for itself that it is
//! strictly shorter.

use std::ops::Range;

use super::task::{SHORTER, Task};
use crate::path::Path;
use crate::validation::{Proved, RowsVerdict, SegmentProof, Validator};

/// By how much a path without needless waypoints may seem longer, as a part of its length: what
/// rounding adds.
const ROUNDING: f64 = 1e-12;

/// What a change does to the path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// It becomes strictly shorter.
    Shortens,
    /// It has fewer waypoints and is not longer.
    Simplifies,
}

/// A path, the waypoints of it that stay, and the proofs of its segments.
#[derive(Clone)]
pub struct Best<'r> {
    task: &'r Task<'r>,
    path: Path,
    /// Waypoints that must stay as they are, the first and the last among them.
    fixed: Vec<bool>,
    /// Length of the path up to each waypoint.
    arcs: Vec<f64>,
    /// Of each segment; `None` where the input is not proved and nothing has taken its place.
    proofs: Vec<Option<SegmentProof>>,
    velocity: Vec<f64>,
}

impl<'r> Best<'r> {
    /// Begins with an input that is proved.
    pub fn proved(task: &'r Task<'r>, input: &Path, proved: Proved<'_>) -> Self {
        assert_eq!(input.as_flat(), proved.rows(), "proved is something else");
        let proofs = proved.into_proofs().into_iter().map(Some).collect();
        Self::new(task, input, proofs)
    }

    /// Begins with an input that is not proved: until all of it is replaced by what is, or turns
    /// out to be provable after all, the path counts for nothing.
    pub fn unproved(task: &'r Task<'r>, input: &Path) -> Self {
        Self::new(task, input, vec![None; (input.len() - 1).max(1)])
    }

    fn new(task: &'r Task<'r>, input: &Path, proofs: Vec<Option<SegmentProof>>) -> Self {
        let mut best = Self {
            task,
            path: input.clone(),
            fixed: task.fixed.to_vec(),
            arcs: Vec::with_capacity(input.len()),
            proofs,
            velocity: vec![0.0; task.space.nv()],
        };
        best.measure();
        best
    }

    /// The path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What is asked.
    pub fn task(&self) -> &'r Task<'r> {
        self.task
    }

    /// Which waypoints must stay as they are, the first and the last among them.
    pub fn fixed(&self) -> &[bool] {
        &self.fixed
    }

    /// Length of the path up to each waypoint.
    pub fn arcs(&self) -> &[f64] {
        &self.arcs
    }

    /// Length of the path.
    pub fn length(&self) -> f64 {
        self.arcs[self.arcs.len() - 1]
    }

    /// Whether a length is strictly shorter than the path's.
    pub fn is_longer_than(&self, length: f64) -> bool {
        length < self.length() * (1.0 - SHORTER)
    }

    /// Whether every segment is proved.
    pub fn is_proved(&self) -> bool {
        self.proofs.iter().all(Option::is_some)
    }

    /// Path and proofs, by themselves; no proofs unless all of it is proved.
    pub fn into_parts(self) -> (Path, Option<Vec<SegmentProof>>) {
        let proofs = self.proofs.into_iter().collect();
        (self.path, proofs)
    }

    /// Takes another path, of as many waypoints as `fixed` has entries, if it is strictly shorter;
    /// says whether it did.
    pub fn take(&mut self, path: &Proved<'_>, fixed: &[bool]) -> bool {
        let length = self.task.length(path.rows(), &mut self.velocity);
        if !self.is_longer_than(length) {
            return false;
        }
        self.path.splice(0..self.path.len(), path.rows());
        self.fixed.clear();
        self.fixed.extend_from_slice(fixed);
        self.proofs.clear();
        self.proofs.extend(path.proofs().iter().copied().map(Some));
        self.measure();
        true
    }

    /// Puts `rows` in the place of the waypoints `range`, whose ends they repeat; and `tail`, from
    /// the last of them on, in the place of what follows, where that moves by whole turns. Says
    /// whether it did: the change must be what it is said to be.
    pub fn replace(
        &mut self,
        range: &Range<usize>,
        rows: &Proved<'_>,
        tail: Option<&Proved<'_>>,
        change: Change,
    ) -> bool {
        let gain = self.gain(range, rows.rows());
        let least = match change {
            Change::Shortens => SHORTER,
            Change::Simplifies => -ROUNDING,
        };
        if gain <= least * self.length() {
            return false;
        }
        if let Some(tail) = tail {
            self.splice(range.end - 1..self.path.len(), tail);
        }
        self.splice(range.clone(), rows);
        self.measure();
        true
    }

    /// How much shorter the path would be with these rows in the place of the waypoints `range`.
    pub fn gain(&mut self, range: &Range<usize>, rows: &[f64]) -> f64 {
        let before = self.arcs[range.end - 1] - self.arcs[range.start];
        before - self.task.length(rows, &mut self.velocity)
    }

    /// Asks for a proof of those segments that have none; says whether all are proved then.
    pub fn prove_rest(
        &mut self,
        validator: &mut Validator<'_>,
        stop: &mut dyn FnMut() -> bool,
    ) -> bool {
        if !self.is_proved()
            && let RowsVerdict::Proved(proved) = validator.prove(self.path.as_flat(), stop)
        {
            self.proofs = proved.into_proofs().into_iter().map(Some).collect();
        }
        self.is_proved()
    }

    /// Between waypoints that stay there are as many new ones as the rows say; the ends keep
    /// whether they are fixed.
    fn splice(&mut self, range: Range<usize>, rows: &Proved<'_>) {
        let count = rows.rows().len() / self.path.nq();
        if count != range.len() {
            self.fixed.splice(
                range.start + 1..range.end - 1,
                std::iter::repeat_n(false, count - 2),
            );
        }
        self.proofs.splice(
            range.start..range.end - 1,
            rows.proofs().iter().copied().map(Some),
        );
        self.path.splice(range, rows.rows());
    }

    fn measure(&mut self) {
        let mut arc = 0.0;
        self.arcs.clear();
        self.arcs.push(arc);
        for [from, to] in self.path.segments() {
            arc += self
                .task
                .metric
                .distance(self.task.space, from, to, &mut self.velocity);
            self.arcs.push(arc);
        }
    }
}
