//! Where a proved path comes nearest to anything, and which bodies hold it.
//!
//! A proof only says what is kept; a person wants to know where and between what. So the path is
//! looked at once more: the filter and the bound of a proof leave few places that may be nearer
//! than what is looked for (`candidates`), and of these each stretch is searched for its least
//! distance (`stretch`). Distances are exact and their places are where they are least, up to
//! [`RESOLUTION`]. First only what holds the path is looked for, and farther only where nothing
//! does.

mod candidates;
mod follow;
mod stretch;
#[cfg(test)]
mod tests;

use std::cmp::Ordering;

use super::Contact;
use super::floors::Floors;
use super::validator::Validator;
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

/// A place at which two bodies are closest on a stretch of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Near {
    /// Segment of the path, from 0.
    pub segment: usize,
    /// Ratio on the segment, in [0, 1].
    pub t: f64,
    /// Index of the pair in the collision model.
    pub pair: usize,
    /// Closest points there, exact.
    pub contact: Contact,
}

/// What is nearest along a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Nearest {
    /// How far was looked (m): where nothing is named, nothing is nearer than this.
    pub searched_m: f64,
    /// The least distance of all.
    pub smallest: Option<Near>,
    /// For each pair and each stretch of a segment on which it is nearer than [`CONTACT_FLOORS`] of
    /// its floors, the place where it is nearest; in order along the path. Stretches with little
    /// motion between them may count as one, and those on both sides of a waypoint do, unless the
    /// pair is farther apart there than beside it.
    pub contacts: Vec<Near>,
}

impl Near {
    fn along_the_path(&self, other: &Self) -> Ordering {
        self.segment
            .cmp(&other.segment)
            .then(self.t.total_cmp(&other.t))
            .then(self.pair.cmp(&other.pair))
    }
}

impl Nearest {
    /// What is looked for of a pair with this floor: what holds the path, or is nearer than all that
    /// was found.
    fn sought(&self, pair: usize, floor: f64, most_work: u64) -> Sought {
        let smallest = self.smallest.as_ref();
        let least = smallest.map_or(self.searched_m, |near| near.contact.distance);
        Sought {
            pair,
            within: (CONTACT_FLOORS * floor).max(least),
            resolution: (RESOLUTION * floor).max(FINEST_M),
            most_work,
        }
    }

    /// Takes in a place; it is a contact where the bodies are within this distance (m).
    fn take_in(&mut self, near: Near, within: f64) {
        let distance = near.contact.distance;
        if distance < self.searched_m && self.is_least(distance) {
            self.smallest = Some(near);
        }
        self.contacts
            .extend(Some(near).filter(|_| distance < within));
    }

    /// Whether nothing nearer or as near is known.
    fn is_least(&self, distance: f64) -> bool {
        let smallest = self.smallest.as_ref();
        smallest.is_none_or(|least| distance < least.contact.distance)
    }
}

impl Validator<'_> {
    /// Looks for what is nearest along a path that is proved.
    ///
    /// Floors, what is proved and where pairs were seen apart stay as they were, so that the search
    /// changes no later verdict. `None` where `stop` said so, or where the search cost more than it
    /// may: then nothing is known.
    pub fn nearest(&mut self, path: &Path, stop: &mut dyn FnMut() -> bool) -> Option<Nearest> {
        let clearance = self.scratch.floors.common();
        let near = CONTACT_FLOORS * clearance;
        let far = (SEARCHED_FLOORS * clearance).min(SEARCHED_M);
        let directions = std::mem::take(&mut self.scratch.directions);
        let most_work = self.work() + most_work(path);
        let mut found = self.search_within(path, near, most_work, stop);
        if far > near
            && found
                .as_ref()
                .is_some_and(|found| found.smallest.is_none())
        {
            found = self.search_within(path, far, most_work, stop);
        }
        self.scratch.directions = directions;
        found
    }

    /// Looks as far as `searched_m`, with that in the place of the floors.
    fn search_within(
        &mut self,
        path: &Path,
        searched_m: f64,
        most_work: u64,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Nearest> {
        self.with_floor(searched_m, |validator, floors| {
            validator.search_nearest(path, floors, searched_m, most_work, stop)
        })
    }

    fn search_nearest(
        &mut self,
        path: &Path,
        floors: &Floors,
        searched_m: f64,
        most_work: u64,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Nearest> {
        let mut candidates = self.candidates(path, most_work, stop)?;
        candidates.sort_by(Candidate::along_the_path);
        let rough = self.rough_smallest(&candidates, stop)?;
        let mut found = Nearest {
            searched_m,
            smallest: rough.filter(|near| near.contact.distance < searched_m),
            contacts: Vec::new(),
        };
        for of_pair in candidates.chunk_by(|a, b| a.pair == b.pair) {
            let pair = of_pair[0].pair;
            let floor = floors.all()[pair];
            let sought = found.sought(pair, floor, most_work);
            for near in self.stretches(&sought, of_pair, stop)? {
                found.take_in(near, CONTACT_FLOORS * floor);
            }
        }
        found.contacts.sort_by(Near::along_the_path);
        Some(found)
    }
}

/// Work that a search may cost: many times what it takes even along a path that is held everywhere.
fn most_work(path: &Path) -> u64 {
    500_000 + 100_000 * path.len() as u64
}
