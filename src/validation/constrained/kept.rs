//! What a proved path leaves of its constraints: what is claimed, and what is found.

use super::Constrained;
use super::least::Least;
use crate::path::Path;
use crate::validation::examiner::ASKED_EVERY;
use crate::validation::nearest::{Near, Nearest};
use crate::validation::path_proof::{ends, segments};
use crate::validation::requirement::Requirement;
use crate::validation::validator::Validator;

/// A constraint of whose tolerance less than this part is left holds the path; optimizers aim at half
/// of it.
pub const HOLDING_PART: f64 = 0.03;

/// What a path leaves of the tolerances of its constraints, as they are asked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Kept {
    /// For each segment, what is proved to be left of each constraint everywhere on it; nothing where
    /// there are no constraints.
    pub left: Vec<Vec<f64>>,
    /// Of each constraint the place where least was found to be left: by looks, which prove nothing of
    /// the places between them.
    pub tightest: Vec<Near>,
    /// Where constraints hold the path: for each, and each segment on which less than [`HOLDING_PART`]
    /// of its tolerance was found to be left, the place of the least; in order along the path. One at a
    /// waypoint counts once.
    pub holds: Vec<Near>,
}

impl Kept {
    /// What is nearest along a path, with what of the constraints holds it.
    #[must_use]
    pub fn among(&self, mut nearest: Nearest) -> Nearest {
        nearest.holds.extend_from_slice(&self.holds);
        nearest.holds.sort_by(Near::along_the_path);
        nearest
    }
}

/// The least of a constraint that was found on a segment.
#[derive(Clone, Copy, Debug)]
struct Found {
    segment: usize,
    least: Least,
}

impl Found {
    /// Whether it is at the same waypoint as one of the segment before.
    fn continues(&self, before: &Self) -> bool {
        self.segment == before.segment + 1 && self.least.t == 0.0 && before.least.t == 1.0
    }
}

/// What was found of one constraint along a path.
#[derive(Clone, Debug, Default)]
struct Along {
    tightest: Option<Found>,
    holds: Vec<Found>,
}

impl Along {
    fn take(&mut self, found: Found, is_hold: bool) {
        let tightest = self.tightest.as_ref();
        if tightest.is_none_or(|tightest| found.least.left < tightest.least.left) {
            self.tightest = Some(found);
        }
        let is_known = self
            .holds
            .last()
            .is_some_and(|last| found.continues(last));
        if is_hold && !is_known {
            self.holds.push(found);
        }
    }
}

impl Constrained<'_> {
    /// Whether so little is left of a constraint that it holds the path.
    fn holds_at(&self, index: usize, left: f64) -> bool {
        let tolerance = self.constraints[index].held.tolerance();
        left + self.raises[index] < HOLDING_PART * tolerance
    }

    /// Looks at a segment; what is claimed of it.
    fn look_along(&mut self, ends: [&[f64]; 2], segment: usize, along: &mut [Along]) -> Vec<f64> {
        let mut seen = self.seen_along(ends);
        for (index, along) in along.iter_mut().enumerate() {
            let is_hold = self.holds_at(index, seen[index].left);
            if is_hold {
                seen[index] = self.narrowed_down(index, ends, seen[index]);
            }
            let least = seen[index];
            along.take(Found { segment, least }, is_hold);
        }
        self.claims(ends, &seen)
    }

    fn near(&mut self, index: usize, path: &Path, found: Found) -> Near {
        let [from, to] = ends(path, found.segment);
        let t = found.least.t;
        let configuration = self.standing.space.between(from, to, t);
        Near {
            segment: found.segment,
            t,
            requirement: Requirement::Constraint(index),
            measure: self.measure(index, &configuration),
        }
    }

    /// The least of a constraint along a path, narrowed down.
    fn tightest(&mut self, index: usize, path: &Path, found: Found) -> Near {
        let least = self.narrowed_down(index, ends(path, found.segment), found.least);
        self.near(index, path, Found { least, ..found })
    }
}

impl Validator<'_> {
    /// What a proved path leaves of its constraints. Where `stop` says so, of the rest of the path no
    /// more is claimed than is proved of all of it, and nothing is looked for there.
    pub fn kept(&mut self, path: &Path, stop: &mut dyn FnMut() -> bool) -> Kept {
        let constrained = &mut self.constrained;
        if constrained.is_empty() {
            return Kept::default();
        }
        let mut kept = Kept::default();
        let mut along = vec![Along::default(); constrained.constraints.len()];
        let mut is_over = false;
        for segment in 0..segments(path) {
            is_over = is_over || (segment % ASKED_EVERY == ASKED_EVERY - 1 && stop());
            kept.left.push(match is_over {
                true => constrained.least_claims(),
                false => constrained.look_along(ends(path, segment), segment, &mut along),
            });
        }
        for (index, along) in along.into_iter().enumerate() {
            let tightest = along.tightest.into_iter();
            kept.tightest
                .extend(tightest.map(|found| constrained.tightest(index, path, found)));
            for hold in along.holds {
                kept.holds
                    .push(constrained.near(index, path, hold));
            }
        }
        kept.holds.sort_by(Near::along_the_path);
        kept
    }
}
