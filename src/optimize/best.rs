//! The best path so far: it takes nothing but what is [`Proved`], and sees for itself that it is
//! strictly shorter.

use std::ops::Range;

use super::cost;
use super::task::{SHORTER, Task};
use crate::path::Path;
use crate::validation::{Proved, RowsVerdict, SegmentProof, Validator};

/// By how much a path may seem longer without a needless waypoint, as a part of its length: what
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
    /// Length of each segment.
    steps: Vec<f64>,
    /// Length of the path up to each waypoint: their sums, one after the other.
    arcs: Vec<f64>,
    /// Of each segment; `None` where the input is not proved and nothing has taken its place.
    proofs: Vec<Option<SegmentProof>>,
    /// Length of the input.
    input_length: f64,
    velocity: Vec<f64>,
}

fn known_proofs(proved: &Proved<'_>) -> impl Iterator<Item = Option<SegmentProof>> {
    proved.proofs().iter().copied().map(Some)
}

impl<'r> Best<'r> {
    /// Begins with an input that is proved.
    pub fn proved(task: &'r Task<'r>, input: &Path, proved: Proved<'_>) -> Self {
        assert_eq!(input.as_flat(), proved.rows(), "proved is something else");
        let proofs = proved
            .into_proofs()
            .into_iter()
            .map(Some)
            .collect();
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
            steps: Vec::new(),
            arcs: vec![0.0],
            proofs,
            input_length: 0.0,
            velocity: vec![0.0; task.space.nv()],
        };
        best.measure(0..0, input.as_flat());
        best.input_length = best.length();
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

    /// Length of the input.
    pub fn input_length(&self) -> f64 {
        self.input_length
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
        let length = self
            .task
            .length(path.rows(), &mut self.velocity);
        let is_shorter = self.is_longer_than(length);
        if is_shorter {
            self.become_path(path, fixed);
        }
        is_shorter
    }

    fn become_path(&mut self, path: &Proved<'_>, fixed: &[bool]) {
        self.path
            .splice(0..self.path.len(), path.rows());
        self.fixed.clear();
        self.fixed.extend_from_slice(fixed);
        self.proofs.clear();
        self.proofs.extend(known_proofs(path));
        self.measure(0..self.steps.len(), path.rows());
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
        if !self.is_as_said(range, rows.rows(), change) {
            return false;
        }
        if let Some(tail) = tail {
            // First, while the numbers of the waypoints of `range` are as they were.
            self.splice(range.end - 1..self.path.len(), tail);
        }
        self.splice(range.clone(), rows);
        true
    }

    /// Whether rows in the place of the waypoints `range` change the path as it is said.
    fn is_as_said(&mut self, range: &Range<usize>, rows: &[f64], change: Change) -> bool {
        let gain = self.gain(range, rows);
        match change {
            Change::Shortens => gain > SHORTER * self.length(),
            Change::Simplifies => {
                let is_fewer = rows.len() < range.len() * self.path.nq();
                is_fewer && gain >= -ROUNDING * self.length()
            }
        }
    }

    /// How much shorter the path would be with these rows in the place of the waypoints `range`.
    pub fn gain(&mut self, range: &Range<usize>, rows: &[f64]) -> f64 {
        self.length_of(range) - self.task.length(rows, &mut self.velocity)
    }

    /// Length of the path between the first and the last of these waypoints.
    fn length_of(&self, range: &Range<usize>) -> f64 {
        self.arcs[range.end - 1] - self.arcs[range.start]
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
            self.proofs = proved
                .into_proofs()
                .into_iter()
                .map(Some)
                .collect();
        }
        self.is_proved()
    }

    /// Between waypoints that stay there are as many new ones as the rows say; the ends keep
    /// whether they are fixed.
    fn splice(&mut self, range: Range<usize>, rows: &Proved<'_>) {
        let segments = range.start..range.end - 1;
        let count = rows.rows().len() / self.path.nq();
        if count != range.len() {
            let between = std::iter::repeat_n(false, count - 2);
            self.fixed
                .splice(range.start + 1..range.end - 1, between);
        }
        self.proofs
            .splice(segments.clone(), known_proofs(rows));
        self.measure(segments, rows.rows());
        self.path.splice(range, rows.rows());
    }

    /// Puts the lengths of the segments between these rows in the place of those of `segments`.
    fn measure(&mut self, segments: Range<usize>, rows: &[f64]) {
        let first = segments.start;
        let lengths = cost::steps(self.task.space, self.task.metric, rows, &mut self.velocity);
        self.steps.splice(segments, lengths);
        self.add_up_arcs(first);
    }

    /// The length up to each waypoint after `first`, one segment after the other: the sum is the same,
    /// bit for bit, whichever part of the path changed last.
    fn add_up_arcs(&mut self, first: usize) {
        self.arcs.truncate(first + 1);
        let mut arc = self.arcs[first];
        for step in &self.steps[first..] {
            arc += step;
            self.arcs.push(arc);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::collision::CollisionModel;
    use crate::optimize::testing;
    use crate::path::Metric;
    use crate::scene::Scene;
    use crate::validation::Scratch;

    const CORNER: [[f64; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]];

    /// A disc on an empty plane, and a path of it.
    fn on_a_plane(rows: &[[f64; 2]], examine: impl FnOnce(&Task<'_>, &mut Validator<'_>, &Path)) {
        let scene = Scene::new("plane", Vec::new(), Vec::new(), Vec::new()).expect("nothing");
        let model = CollisionModel::new(Arc::new(testing::disc(0.1)), Arc::new(scene));
        let model = model.expect("a model");
        let space = model.robot().space();
        let metric = Metric::new(space, vec![1.0; 2]).expect("two weights");
        let input = path(rows);
        let mut fixed = vec![false; rows.len()];
        fixed[0] = true;
        fixed[rows.len() - 1] = true;
        let task = Task {
            model: &model,
            space,
            metric: &metric,
            held: &[],
            constraints: Vec::new(),
            fixed: &fixed,
            fixed_rows: &[rows[0], rows[rows.len() - 1]].concat(),
            moving: &[true; 2],
            keep_goal: false,
            seed: 0,
            work_budget: u64::MAX,
        };
        let mut scratch = Scratch::default();
        let mut validator = Validator::new(&model, space, &[], 1e-3, &mut scratch);
        examine(&task, &mut validator, &input);
    }

    fn path(rows: &[[f64; 2]]) -> Path {
        Path::from_rows(2, rows.concat()).expect("whole rows")
    }

    fn proved<'p>(validator: &mut Validator<'_>, rows: &'p Path) -> Proved<'p> {
        match validator.prove(rows.as_flat(), &mut || false) {
            RowsVerdict::Proved(proved) => proved,
            verdict => panic!("{verdict:?}"),
        }
    }

    #[test]
    fn only_what_is_strictly_shorter_is_taken() {
        on_a_plane(&CORNER, |task, validator, corner| {
            let mut best = Best::proved(task, corner, proved(validator, corner));
            let longer = path(&[[0.0, 0.0], [1.0, -0.1], [1.0, 1.0]]);
            let shorter = path(&[[0.0, 0.0], [0.9, 0.1], [1.0, 1.0]]);
            assert!(!best.take(&proved(validator, corner), task.fixed));
            assert!(!best.take(&proved(validator, &longer), task.fixed));
            assert_eq!((best.path(), best.length()), (corner, 2.0));
            assert!(best.take(&proved(validator, &shorter), task.fixed));
            assert_eq!(best.path(), &shorter);
            assert_eq!(best.into_parts().1.map(|proofs| proofs.len()), Some(2));
        });
    }

    #[test]
    fn a_part_becomes_shorter_or_simpler() {
        on_a_plane(&CORNER, |task, validator, corner| {
            let mut best = Best::proved(task, corner, proved(validator, corner));
            let bent = path(&[[0.0, 0.0], [1.0, 0.0], [1.0, 0.5], [1.0, 1.0]]);
            let bent = proved(validator, &bent);
            for change in [Change::Shortens, Change::Simplifies] {
                assert!(!best.replace(&(0..3), &bent, None, change), "{change:?}");
            }
            let cut = path(&[[0.5, 0.0], [1.0, 0.5]]);
            let around = path(&[[0.0, 0.0], [0.5, 0.0], [1.0, 0.5], [1.0, 1.0]]);
            assert!(best.replace(&(0..3), &proved(validator, &around), None, Change::Shortens));
            assert_eq!(best.fixed(), [true, false, false, true]);
            let same = proved(validator, &cut);
            assert!(!best.replace(&(1..3), &same, None, Change::Shortens));
            let straight = path(&[[0.0, 0.0], [1.0, 0.5]]);
            let straight = proved(validator, &straight);
            assert!(best.replace(&(0..3), &straight, None, Change::Simplifies));
            assert_eq!(best.fixed(), [true, false, true]);
            assert!((best.length() - 1.25_f64.sqrt() - 0.5).abs() < 1e-15);
        });
    }

    #[test]
    fn an_input_without_proof_counts_once_all_of_it_is_proved() {
        let rows = [[0.0, 0.0], [0.5, 0.5], [1.0, 0.0], [1.0, 1.0]];
        on_a_plane(&rows, |task, validator, input| {
            let mut best = Best::unproved(task, input);
            let first = path(&[[0.0, 0.0], [1.0, 0.0]]);
            let first = proved(validator, &first);
            assert!(best.replace(&(0..3), &first, None, Change::Shortens));
            assert!(!best.is_proved());
            assert!(!best.clone().prove_rest(validator, &mut || true));
            assert_eq!(best.clone().into_parts().1, None);
            assert!(best.prove_rest(validator, &mut || false));
            assert!(best.into_parts().1.is_some());
        });
    }
}
