//! Shortcuts, the baselines of the paper: straight lines between two random places of the path.
//!
//! [`random`] straightens all coordinates at once (Geraerts and Overmars, *Creating high-quality paths for
//! motion planning*, 2007: "shortcut"), [`partial`] one joint at a time, the others moving as before
//! ("partial shortcut"). A candidate counts only when every segment that changed is proved and the path
//! is strictly shorter. It never reaches across a fixed waypoint.

use super::candidate::Search;
use super::outcome::{Stage, Termination};
use super::progress::Progress;
use crate::validation::SegmentsVerdict;

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

/// Random shortcuts over all coordinates that may move; returns why they ended.
pub fn random(progress: &mut Progress) -> Termination {
    progress.enter(Stage::Shortcut);
    let mut search = Search::new(progress);
    let everything = 0..search.moving.len();
    search.run(&mut |search| {
        let places = search.draw_places(0.0)?;
        search.build(places, everything.clone());
        Some(())
    })
}

/// Partial shortcuts: one factor of the configuration space (a joint's angle, a rotation) at a time; returns why
/// they ended.
///
/// Each is first tried over every whole stretch between fixed waypoints, then between random places.
pub fn partial(progress: &mut Progress) -> Termination {
    progress.enter(Stage::PartialShortcut);
    let mut search = Search::new(progress);
    let mut whole: Vec<(usize, usize)> =
        (0..search.moving.len()).flat_map(|c| (0..search.stretches()).map(move |s| (c, s))).collect();
    search.run(&mut |search| {
        let (component, places) = match whole.pop() {
            Some((component, stretch)) => (component, search.whole_stretch(stretch)),
            None if search.moving.is_empty() => return None,
            None => (search.progress.random.usize(..search.moving.len()), search.draw_places(SNAPPED)?),
        };
        search.build(places, component..component + 1);
        Some(())
    })
}

impl Search<'_, '_, '_> {
    /// Tries what `propose` builds until nothing is gained any more. `None` proposes nothing, which is a failure.
    fn run(&mut self, propose: &mut dyn FnMut(&mut Self) -> Option<()>) -> Termination {
        let mut failures = 0;
        if self.progress.path.len() < 3 {
            return Termination::Converged;
        }
        while failures < self.patience() {
            if let Some(termination) = self.progress.must_end() {
                return termination;
            }
            self.progress.iterations += 1;
            failures += 1;
            let Some(gain) = propose(self).and_then(|()| self.gain()) else { continue };
            match self.proves() {
                SegmentsVerdict::Refused(_) => continue,
                SegmentsVerdict::Stopped => return Termination::Stopped,
                SegmentsVerdict::Proved => self.accept(),
            }
            if gain >= WORTHWHILE * self.length() {
                failures = 0;
            }
            self.drop_needless();
            self.progress.publish();
        }
        Termination::Converged
    }

    fn patience(&self) -> u64 {
        let waypoints = PATIENCE_PER_WAYPOINT * self.progress.path.len() as u64;
        LEAST_PATIENCE.max(waypoints).max(PATIENCE_PER_COMPONENT * self.moving.len() as u64)
    }
}

/// Leaves out runs of waypoints: half of the path at once, then a quarter, and so on down to single ones.
pub fn skip(progress: &mut Progress) -> Option<Termination> {
    progress.enter(Stage::Shortcut);
    let mut search = Search::new(progress);
    if search.moving.len() < search.progress.task.space.components().len() {
        return None; // A straight line would move what may not move otherwise than before.
    }
    let mut stride = (search.progress.path.len() - 1) * 2 / 3;
    while stride >= 2 {
        let mut from = 0;
        while from + stride < search.progress.path.len() {
            if let Some(termination) = search.progress.must_end() {
                return Some(termination);
            }
            search.progress.iterations += 1;
            if search.leave_out(from + 1..from + stride) {
                search.progress.publish();
            }
            from += stride;
        }
        stride = (stride - 1).min(stride * 2 / 3);
    }
    None
}
