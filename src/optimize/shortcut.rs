//! Shortcuts, the baselines of the paper: straight lines between two random places of the path.
//!
//! [`random`] straightens all coordinates at once (Geraerts and Overmars, *Creating high-quality
//! paths for motion planning*, 2007: "shortcut"), [`partial`] one joint at a time, the others
//! moving as before ("partial shortcut"). A candidate counts only when every segment that changed
//! is proved and the path is strictly shorter. It never reaches across a fixed waypoint.

use super::best::Change;
use super::candidate::{Place, Search};
use super::outcome::{Stage, Termination};
use super::progress::{Progress, Tried};

/// A candidate that gains less than this part of the length counts as a failure, though it is
/// taken.
const WORTHWHILE: f64 = 3e-4;

/// How often a place of a partial shortcut is moved to the nearest waypoint, where it adds none.
const SNAPPED: f64 = 0.5;

/// How long shortcuts go on without gaining.
#[derive(Clone, Copy)]
struct Patience {
    /// So many failures in a row at least.
    least: u64,
    /// So many for each waypoint.
    per_waypoint: u64,
    /// So many for each component that moves on its own.
    per_component: u64,
}

impl Patience {
    /// Failures in a row after which it ends.
    fn failures(&self, waypoints: u64, components: u64) -> u64 {
        self.least
            .max(self.per_waypoint * waypoints)
            .max(self.per_component * components)
    }
}

/// When nothing else is tried.
const PATIENT: Patience = Patience {
    least: 200,
    per_waypoint: 20,
    per_component: 10,
};

/// When another stage may do better.
const BRIEF: Patience = Patience {
    least: 40,
    per_waypoint: 5,
    per_component: 4,
};

/// Random shortcuts over all coordinates that may move; returns why they ended.
pub fn random(progress: &mut Progress) -> Termination {
    random_with(progress, PATIENT)
}

/// The same, but they give up early.
pub fn random_briefly(progress: &mut Progress) -> Termination {
    random_with(progress, BRIEF)
}

fn random_with(progress: &mut Progress, patience: Patience) -> Termination {
    progress.enter(Stage::Shortcut);
    let mut search = Search::new(progress);
    let everything = 0..search.moving.len();
    search.run(patience, &mut |search| {
        let places = search.draw_places(0.0)?;
        search.build(places, everything.clone());
        Some(())
    })
}

/// Partial shortcuts: one factor of the configuration space (a joint's angle, a rotation) at a
/// time; returns why they ended.
///
/// Each is first tried over every whole stretch between fixed waypoints, then between random
/// places.
pub fn partial(progress: &mut Progress) -> Termination {
    partial_with(progress, PATIENT)
}

/// The same, but they give up early.
pub fn partial_briefly(progress: &mut Progress) -> Termination {
    partial_with(progress, BRIEF)
}

fn partial_with(progress: &mut Progress, patience: Patience) -> Termination {
    progress.enter(Stage::PartialShortcut);
    let mut search = Search::new(progress);
    let mut whole: Vec<(usize, usize)> = (0..search.moving.len())
        .flat_map(|c| (0..search.stretches()).map(move |s| (c, s)))
        .collect();
    search.run(patience, &mut |search| {
        let (component, places) = match whole.pop() {
            Some((component, stretch)) => (component, search.whole_stretch(stretch)),
            None => search.draw_component()?,
        };
        search.build(places, component..component + 1);
        Some(())
    })
}

/// Leaves out runs of waypoints, long ones first, where the straight line is free; says why the run
/// must end, if it must.
pub fn leave_out_waypoints(progress: &mut Progress) -> Option<Termination> {
    progress.enter(Stage::Shortcut);
    let mut search = Search::new(progress);
    let mut stride = (search.progress.best.path().len() - 1) * 2 / 3;
    while stride >= 2 && search.moves_everything() {
        if let Some(termination) = search.stride_over(stride) {
            return Some(termination);
        }
        stride = (stride - 1).min(stride * 2 / 3);
    }
    None
}

/// Leaves out waypoints that the path can do without, one by one: also those that only lie on a
/// straight line.
pub fn leave_out_needless(progress: &mut Progress) -> Option<Termination> {
    progress.enter(Stage::Shortcut);
    let before = progress.best.length();
    let mut search = Search::new(progress);
    search.drop_needless_of_all();
    if progress.is_shorter_than(before) {
        progress.publish();
    }
    progress.must_end()
}

impl Search<'_, '_, '_> {
    /// Tries what `propose` builds until nothing is gained any more. `None` proposes nothing, which
    /// is a failure.
    fn run(
        &mut self,
        patience: Patience,
        propose: &mut dyn FnMut(&mut Self) -> Option<()>,
    ) -> Termination {
        let mut failures = 0;
        if self.progress.best.path().len() < 3 {
            return Termination::Converged;
        }
        while failures < self.failures(patience) {
            if let Some(termination) = self.progress.must_end() {
                return termination;
            }
            self.progress.iterations += 1;
            match self.try_proposal(propose) {
                None => return Termination::Stopped,
                Some(true) => failures = 0,
                Some(false) => failures += 1,
            }
        }
        Termination::Converged
    }

    /// Tries one proposal; whether it gained something worthwhile, `None` where stopped.
    fn try_proposal(&mut self, propose: &mut dyn FnMut(&mut Self) -> Option<()>) -> Option<bool> {
        let Some(gain) = propose(self).and_then(|()| self.gain()) else {
            return Some(false);
        };
        match self.try_candidate(Change::Shortens) {
            Tried::Refused(_) | Tried::NotShorter => return Some(false),
            Tried::Stopped => return None,
            Tried::Taken => {}
        }
        let is_worthwhile = gain >= WORTHWHILE * self.length();
        self.drop_needless();
        self.progress.publish();
        Some(is_worthwhile)
    }

    /// A random component, and two random places.
    fn draw_component(&mut self) -> Option<(usize, (Place, Place))> {
        let count = self.moving.len();
        let component = (count > 0).then(|| self.progress.random.usize(..count))?;
        Some((component, self.draw_places(SNAPPED)?))
    }

    /// Leaves out runs of one waypoint less than `stride`, from the start to the goal; says why the run
    /// must end, if it must.
    fn stride_over(&mut self, stride: usize) -> Option<Termination> {
        let mut from = 0;
        while from + stride < self.progress.best.path().len() {
            if let Some(termination) = self.progress.must_end() {
                return Some(termination);
            }
            self.progress.iterations += 1;
            if self.leave_out(from + 1..from + stride) {
                self.progress.publish();
            }
            from += stride;
        }
        None
    }

    fn failures(&self, patience: Patience) -> u64 {
        let waypoints = self.progress.best.path().len() as u64;
        patience.failures(waypoints, self.moving.len() as u64)
    }
}
