//! A look at the waypoints of a path, which says early that the path collides: the filter at all of
//! them, eight at a time, then the exact bodies of each pair where the filter saw it nearest. What
//! it finds is a collision, if not the first; what it does not find, the proof does.

use super::demand::Demand;
use super::examiner::Examiner;
use super::filter::Unproved;
use super::interval::IntervalVerdict;
use super::requirement::Requirement;
use super::undecided::Interval;
use super::validator::Validator;
use crate::lanes::LANES;
use crate::path::Path;

/// A waypoint, and the clearance of a pair that touches or overlaps there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Colliding {
    pub(super) waypoint: usize,
    pub(super) requirement: Requirement,
}

/// What the filter did not prove to be apart.
#[derive(Clone, Copy, Debug)]
struct Suspect {
    at: Colliding,
    gap: f32,
}

/// Takes in where the filter sees a pair at these waypoints.
fn note_nearest(known: &mut Option<Suspect>, unproved: &Unproved, numbers: &[usize; LANES]) {
    let requirement = Requirement::Clearance(unproved.pair as usize);
    for lane in (0..LANES).filter(|lane| unproved.is_in(*lane)) {
        let gap = unproved.gap[lane];
        if known.is_none_or(|known| gap < known.gap) {
            let waypoint = numbers[lane];
            let at = Colliding {
                waypoint,
                requirement,
            };
            *known = Some(Suspect { at, gap });
        }
    }
}

impl Validator<'_> {
    /// Whether any two bodies' surfaces meet at one configuration.
    pub fn collides(&mut self, configuration: &[f64]) -> bool {
        let path = Path::from_rows(configuration.len(), configuration.to_vec());
        path.is_some_and(|path| self.collides_at_start(&path))
    }

    fn collides_at_start(&mut self, path: &Path) -> bool {
        let start = std::iter::once(0);
        let found = self.colliding_waypoint(path, start, &mut || false);
        found.flatten().is_some()
    }

    /// The first of the collisions that a look at these waypoints finds. `stop` is asked at every
    /// eight, and at every exact look; `None` where it said so before any was found.
    pub(super) fn colliding_waypoint(
        &mut self,
        path: &Path,
        waypoints: impl Iterator<Item = usize>,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Option<Colliding>> {
        let (examiner, mut demand) = self.seeking_contact(0.0);
        let found = examiner.look_at_waypoints(&mut demand, path, waypoints, stop);
        // What is known of them is known at that floor.
        examiner.forget();
        found
    }
}

impl Examiner<'_> {
    fn look_at_waypoints(
        &mut self,
        demand: &mut Demand,
        path: &Path,
        waypoints: impl Iterator<Item = usize>,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Option<Colliding>> {
        let mut suspects = self.suspects(demand, path, waypoints, stop)?;
        suspects.sort_by(|a, b| {
            a.gap
                .total_cmp(&b.gap)
                .then(a.at.requirement.cmp(&b.at.requirement))
        });
        let mut first: Option<Colliding> = None;
        for Suspect { at, .. } in suspects {
            if first.is_some_and(|first| first.waypoint <= at.waypoint) {
                continue;
            }
            match self.look_exactly(demand, path, at, stop) {
                IntervalVerdict::Stopped => return first.map(Some),
                IntervalVerdict::Collision => first = Some(at),
                IntervalVerdict::Proved(_) | IntervalVerdict::TooClose | IntervalVerdict::Split => {
                }
            }
        }
        Some(first)
    }

    fn look_exactly(
        &mut self,
        demand: &mut Demand,
        path: &Path,
        at: Colliding,
        stop: &mut dyn FnMut() -> bool,
    ) -> IntervalVerdict {
        if stop() {
            return IntervalVerdict::Stopped;
        }
        let waypoint = path.waypoint(at.waypoint);
        self.begin(demand);
        self.add([waypoint, waypoint].into());
        self.place(&Interval::default());
        self.decide(demand, at.requirement, 0.0, stop)
    }

    /// For each pair that the filter does not prove to be apart everywhere, the waypoint where it
    /// sees it nearest. `None` where stopped.
    fn suspects(
        &mut self,
        demand: &mut Demand,
        path: &Path,
        waypoints: impl Iterator<Item = usize>,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Vec<Suspect>> {
        let mut nearest: Vec<Option<Suspect>> = vec![None; self.model.pairs().len()];
        let mut waypoints = waypoints.peekable();
        while waypoints.peek().is_some() {
            if stop() {
                return None;
            }
            let numbers = self.filter_waypoints(demand, path, &mut waypoints);
            for unproved in &self.scratch.filter.unproved {
                note_nearest(&mut nearest[unproved.pair as usize], unproved, &numbers);
            }
        }
        Some(nearest.into_iter().flatten().collect())
    }

    /// Runs the filter at the next eight waypoints; which they are.
    fn filter_waypoints(
        &mut self,
        demand: &mut Demand,
        path: &Path,
        waypoints: &mut impl Iterator<Item = usize>,
    ) -> [usize; LANES] {
        let mut numbers = [0; LANES];
        let mut batch = [Interval::default(); LANES];
        let mut count = 0;
        self.begin(demand);
        for number in waypoints.take(LANES) {
            self.add([path.waypoint(number), path.waypoint(number)].into());
            numbers[count] = number;
            batch[count].segment = count;
            count += 1;
        }
        self.filter(demand, &batch[..count]);
        numbers
    }
}
