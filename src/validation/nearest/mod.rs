//! Where a proved path comes nearest to breaking anything, and what holds it.
//!
//! A proof only says what is kept; a person wants to know where and between what. So the path is
//! looked at once more: the filter and the bound of a proof leave few places that may be nearer
//! than what is looked for (`candidates`), and of these each stretch is searched for its least
//! distance (`stretch`). Distances are exact and their places are where they are least, up to
//! [`RESOLUTION`]. First only what holds the path is looked for, and farther only where nothing
//! does. Constraints are looked at elsewhere (`Kept`): what of them holds the path is added.

mod candidates;
mod follow;
mod stretch;
#[cfg(test)]
mod tests;

use std::cmp::Ordering;

use super::demand::{Demand, Directions};
use super::examiner::Examiner;
use super::floors::Floors;
use super::path_proof::{ends, segments};
use super::requirement::{Measure, Requirement};
use super::validator::Validator;
use super::way::Way;
use crate::path::Path;
use candidates::Candidate;
use stretch::Sought;

/// Bodies nearer than this many of their floors hold the path: optimizers aim at two.
pub const CONTACT_FLOORS: f64 = 3.0;
/// How far the nearest bodies are looked for where nothing holds the path, in floors, ...
const SEARCHED_FLOORS: f64 = 10.0;
/// ... and at the most (m).
const SEARCHED_M: f64 = 0.02;
/// A place has the least distance of its stretch but for this part of the pair's floor.
pub const RESOLUTION: f64 = 0.25;
/// Nobody asks for less than this (m), however low the floor.
const FINEST_M: f64 = 1e-6;

/// A place at which least of a requirement is kept on a stretch of a path: of a clearance, where the
/// two bodies are closest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Near {
    /// Segment of the path, from 0.
    pub segment: usize,
    /// Ratio on the segment, in [0, 1].
    pub t: f64,
    /// What is kept.
    pub requirement: Requirement,
    /// How much, exact.
    pub measure: Measure,
}

/// What is nearest along a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Nearest {
    /// How far was looked (m): where nothing is named, nothing is nearer than this.
    pub searched_m: f64,
    /// The least distance of all.
    pub smallest: Option<Near>,
    /// What holds the path: for each clearance and each stretch of a segment on which less than
    /// [`CONTACT_FLOORS`] of its floors is kept, the place where it is least; in order along the
    /// path. Stretches with little motion between them may count as one, and those on both sides of
    /// a waypoint do, unless more is kept there than beside it. Of constraints as `Kept` has them.
    pub holds: Vec<Near>,
}

impl Near {
    pub(super) fn along_the_path(&self, other: &Self) -> Ordering {
        self.segment
            .cmp(&other.segment)
            .then(self.t.total_cmp(&other.t))
            .then(self.requirement.cmp(&other.requirement))
    }
}

impl Nearest {
    /// What is looked for of a requirement with this floor: what holds the path, or is nearer than
    /// all that was found.
    fn sought(&self, requirement: Requirement, floor: f64, most_work: u64) -> Sought {
        let smallest = self.smallest.as_ref();
        let least = smallest.map_or(self.searched_m, |near| near.measure.amount);
        Sought {
            requirement,
            within: (CONTACT_FLOORS * floor).max(least),
            resolution: (RESOLUTION * floor).max(FINEST_M),
            most_work,
        }
    }

    /// Takes in a place; it holds the path where less than this is kept.
    fn take_in(&mut self, near: Near, within: f64) {
        let distance = near.measure.amount;
        if distance < self.searched_m && self.is_least(distance) {
            self.smallest = Some(near);
        }
        self.holds
            .extend(Some(near).filter(|_| distance < within));
    }

    /// Whether nothing nearer or as near is known.
    fn is_least(&self, distance: f64) -> bool {
        let smallest = self.smallest.as_ref();
        smallest.is_none_or(|least| distance < least.measure.amount)
    }
}

/// How far is looked along the segments of a path, and how much that may cost.
struct Search<'w, 'p> {
    ways: &'w [Way<'p>],
    searched_m: f64,
    /// The validator's count of work at which to give up.
    most_work: u64,
}

impl Validator<'_> {
    /// Looks for what is nearest along a path that is proved.
    ///
    /// Floors, what is proved and where pairs were seen apart stay as they were, so that the search
    /// changes no later verdict. `None` where `stop` said so, or where the search cost more than it
    /// may: then nothing is known.
    pub fn nearest(&mut self, path: &Path, stop: &mut dyn FnMut() -> bool) -> Option<Nearest> {
        let segments = 0..segments(path);
        let ways: Vec<Way> = segments
            .map(|segment| ends(path, segment).into())
            .collect();
        self.nearest_along(&ways, stop)
    }

    /// The same along segments of any kind.
    pub(super) fn nearest_along(
        &mut self,
        ways: &[Way],
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Nearest> {
        let clearance = self.floors.common();
        let near = CONTACT_FLOORS * clearance;
        let far = (SEARCHED_FLOORS * clearance).min(SEARCHED_M);
        let most_work = self.work() + most_work(ways.len());
        let mut directions = Directions::default();
        let mut within = |searched_m| {
            let search = Search {
                ways,
                searched_m,
                most_work,
            };
            self.search_within(&search, &mut directions, stop)
        };
        let found = within(near)?;
        match found.smallest {
            None if far > near => within(far),
            _ => Some(found),
        }
    }

    /// Looks as far as is searched, with that in the place of the floors.
    fn search_within(
        &mut self,
        search: &Search,
        directions: &mut Directions,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Nearest> {
        let pairs = self.model().pairs().len();
        self.other_floors
            .reset(pairs, search.searched_m);
        let mut demand = Demand::proof(self.other_floors, directions);
        self.examiner
            .search_nearest(search, &mut demand, self.floors, stop)
    }
}

impl Examiner<'_> {
    fn search_nearest(
        &mut self,
        search: &Search,
        demand: &mut Demand,
        floors: &Floors,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Nearest> {
        let Search {
            searched_m,
            most_work,
            ..
        } = *search;
        let mut candidates = self.candidates(search, demand, stop)?;
        candidates.sort_by(Candidate::along_the_path);
        let rough = self.rough_smallest(&candidates, stop)?;
        let mut found = Nearest {
            searched_m,
            smallest: rough.filter(|near| near.measure.amount < searched_m),
            holds: Vec::new(),
        };
        for of_one in candidates.chunk_by(|a, b| a.requirement == b.requirement) {
            let requirement = of_one[0].requirement;
            let floor = floors.of(requirement);
            let sought = found.sought(requirement, floor, most_work);
            for near in self.stretches(&sought, demand.directions, of_one, stop)? {
                found.take_in(near, CONTACT_FLOORS * floor);
            }
        }
        found.holds.sort_by(Near::along_the_path);
        Some(found)
    }
}

/// Work that a search may cost: many times what it takes even along a path that is held everywhere.
fn most_work(segments: usize) -> u64 {
    500_000 + 100_000 * (segments + 1) as u64
}
