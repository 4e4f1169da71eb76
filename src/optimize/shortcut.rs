//! Shortcuts, the baselines of the paper: straight lines between two random places of the path.
//!
//! [`random`] straightens all coordinates at once (Geraerts and Overmars, *Creating high-quality paths for
//! motion planning*, 2007: "shortcut"), [`partial`] one joint at a time, the others moving as before
//! ("partial shortcut"). A candidate counts only when every segment that changed is proved and the path
//! is strictly shorter. It never reaches across a fixed waypoint.

use super::candidate::Search;
use super::outcome::Termination;
use super::task::{Improvement, Task};
use crate::path::Path;
use crate::validation::{SegmentsVerdict, Validator};

/// A candidate that gains less than this part of the length counts as a failure, though it is taken.
const WORTHWHILE: f64 = 3e-4;

/// So many failures in a row for each waypoint end the search.
const PATIENCE_PER_WAYPOINT: u64 = 20;

/// So many for each component that moves on its own.
const PATIENCE_PER_COMPONENT: u64 = 10;

/// So many at least.
const LEAST_PATIENCE: u64 = 200;

/// How often a place of a partial shortcut is moved to the nearest waypoint, where it adds none.
const SNAPPED: f64 = 0.5;

/// Random shortcuts over all coordinates that may move.
///
/// Leaves the best path in `path` and returns the candidates tried and why they ended.
pub fn random(
    task: &Task,
    path: &mut Path,
    validator: &mut Validator,
    stop: &mut dyn FnMut() -> bool,
    publish: &mut dyn FnMut(Improvement),
) -> (u64, Termination) {
    let mut search = Search::new(task, path);
    let everything = 0..search.moving.len();
    search.run(validator, stop, publish, &mut |search| {
        let places = search.draw_places(0.0)?;
        search.build(places, everything.clone());
        Some(())
    })
}

/// Partial shortcuts: one factor of the configuration space (a joint's angle, a rotation) at a time.
///
/// Each is first tried over every whole stretch between fixed waypoints, then between random places.
/// Leaves the best path in `path` and returns the candidates tried and why they ended.
pub fn partial(
    task: &Task,
    path: &mut Path,
    validator: &mut Validator,
    stop: &mut dyn FnMut() -> bool,
    publish: &mut dyn FnMut(Improvement),
) -> (u64, Termination) {
    let mut search = Search::new(task, path);
    let mut whole: Vec<(usize, usize)> =
        (0..search.moving.len()).flat_map(|c| (0..search.stretches()).map(move |s| (c, s))).collect();
    search.run(validator, stop, publish, &mut |search| {
        let (component, places) = match whole.pop() {
            Some((component, stretch)) => (component, search.whole_stretch(stretch)),
            None if search.moving.is_empty() => return None,
            None => (search.random.usize(..search.moving.len()), search.draw_places(SNAPPED)?),
        };
        search.build(places, component..component + 1);
        Some(())
    })
}

impl Search<'_, '_> {
    /// Tries what `propose` builds until nothing is gained any more. `None` proposes nothing, which is a failure.
    fn run(
        &mut self,
        validator: &mut Validator,
        stop: &mut dyn FnMut() -> bool,
        publish: &mut dyn FnMut(Improvement),
        propose: &mut dyn FnMut(&mut Self) -> Option<()>,
    ) -> (u64, Termination) {
        let (mut tried, mut failures) = (0, 0);
        if self.path.len() < 3 {
            return (tried, Termination::Converged);
        }
        while failures < self.patience() {
            if stop() {
                return (tried, Termination::Stopped);
            }
            if validator.work() >= self.task.work_budget {
                return (tried, Termination::WorkBudget);
            }
            tried += 1;
            failures += 1;
            let Some(gain) = propose(self).and_then(|()| self.gain()) else { continue };
            match self.proves(validator, stop) {
                SegmentsVerdict::Refused(_) => continue,
                SegmentsVerdict::Stopped => return (tried, Termination::Stopped),
                SegmentsVerdict::Proved => self.accept(),
            }
            if gain >= WORTHWHILE * self.length() {
                failures = 0;
            }
            self.drop_needless(validator, stop);
            publish(Improvement { path: self.path, length: self.length(), iterations: tried });
        }
        (tried, Termination::Converged)
    }

    fn patience(&self) -> u64 {
        let waypoints = PATIENCE_PER_WAYPOINT * self.path.len() as u64;
        LEAST_PATIENCE.max(waypoints).max(PATIENCE_PER_COMPONENT * self.moving.len() as u64)
    }
}
