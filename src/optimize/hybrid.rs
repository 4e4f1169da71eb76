//! The default: waypoints are left out, then contact half-spaces and shortcuts take turns.
//!
//! Contact half-spaces pull the path taut around what holds it and end in the nearest local
//! minimum; shortcuts, of all joints or of one, leap out of it, and know nothing of the slopes.
//! Which goes next is decided by what each last gained for the work that it took, counted, never
//! timed. Each goes on until it gains nothing more, and then rests until another has changed the
//! path; when all rest, the run ends.

use super::outcome::Termination;
use super::progress::Progress;
use super::{contact, shortcut};

/// A stage that shortens the path by less than this part has not changed it.
const WORTHWHILE: f64 = 1e-3;

/// A part of the run.
type Stage = fn(&mut Progress) -> Termination;

/// In the order in which they go first.
const STAGES: [Stage; 3] = [
    contact::optimize,
    shortcut::partial_briefly,
    shortcut::random_briefly,
];

/// What is known of a stage.
#[derive(Clone, Copy)]
struct Prospect {
    /// Part of the length that it last gained for each unit of work; unknown is best.
    rate: f64,
    rests: bool,
}

impl Prospect {
    const UNKNOWN: Self = Self {
        rate: f64::INFINITY,
        rests: false,
    };
}

/// Pulls the path taut; returns why that ended.
pub fn optimize(progress: &mut Progress) -> Termination {
    if let Some(termination) = shortcut::leave_out_waypoints(progress) {
        return termination;
    }
    let mut prospects = [Prospect::UNKNOWN; STAGES.len()];
    while let Some(next) = most_promising(&prospects) {
        let length = progress.best.length();
        let work = progress.validator.work();
        if let Some(termination) = run(STAGES[next], progress) {
            return termination;
        }
        let gain = 1.0 - progress.best.length() / length;
        let rate = gain / (progress.validator.work() - work).max(1) as f64;
        if gain >= WORTHWHILE {
            prospects
                .iter_mut()
                .for_each(|prospect| prospect.rests = false);
        }
        // It has just ended because it can gain nothing more by itself.
        prospects[next] = Prospect { rate, rests: true };
    }
    Termination::Converged
}

/// Runs a stage until it gains nothing more; why the run must end, if it must.
fn run(stage: Stage, progress: &mut Progress) -> Option<Termination> {
    match stage(progress) {
        Termination::Converged | Termination::IterationLimit => {
            shortcut::leave_out_needless(progress)
        }
        termination => Some(termination),
    }
}

/// The stage that does not rest and gained most for its work; of equals, the first.
fn most_promising(prospects: &[Prospect]) -> Option<usize> {
    let awake = (0..prospects.len()).filter(|&stage| !prospects[stage].rests);
    let rate = |stage: usize| prospects[stage].rate;
    awake.reduce(|best, stage| {
        if rate(stage) > rate(best) {
            stage
        } else {
            best
        }
    })
}
