//! How long and how often to measure, and medians over windows.

use std::time::Duration;

use crate::cli::load_test::error::LoadError;
use crate::cli::load_test::fleet::Fleet;
use crate::cli::load_test::orders::Window;
use crate::cli::load_test::tally::Tally;
pub(super) use crate::daemon::{HANG_SEED, PANIC_SEED};

/// Lets both seeds do what they do.
pub(super) const FAULTS: &str = "fault_injection = true";

/// Which form to run, and from which seed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trial {
    /// The long form.
    pub long: bool,
    /// The seed.
    pub seed: u64,
}

impl Trial {
    /// What the form asks for.
    pub(super) fn pick<T>(&self, short: T, long: T) -> T {
        if self.long { long } else { short }
    }

    /// Windows of each kind, at least 20 in the long form.
    pub(super) fn windows(&self) -> usize {
        self.pick(3, 24)
    }

    /// A window with fixed work for each request and this trial's seed.
    pub(super) fn window(&self, number: usize) -> Window {
        Window {
            seed: self.seed.wrapping_add(number as u64),
            budget: BUDGET,
            ..Window::closed()
        }
    }
}

/// Work of a request that takes some milliseconds.
pub(super) const BUDGET: u64 = 6_000;

/// Lets a fleet send for so long; all clients' tallies as one.
pub(super) fn run(fleet: &mut Fleet, window: Window, length: Duration) -> Result<Tally, LoadError> {
    Ok(Tally::of(&fleet.run(window, length)?))
}

/// The middle value; 0 of none.
pub(super) fn median(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => 0.0,
        count if count % 2 == 1 => values[middle],
        _ => (values[middle - 1] + values[middle]) / 2.0,
    }
}

/// `a ÷ b`; as much as there can be where b is 0 and a is not.
pub(super) fn ratio(a: f64, b: f64) -> f64 {
    match (a, b) {
        (0.0, 0.0) => 1.0,
        (_, 0.0) => f64::MAX,
        _ => a / b,
    }
}
