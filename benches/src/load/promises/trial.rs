//! How long and how often to measure, and medians over windows.

use std::time::Duration;

use crate::error::Error;
use crate::load::fleet::Fleet;
use crate::load::orders::Window;
use crate::load::tally::Tally;
use crate::statistics;

/// The seed that makes a worker panic where the configuration allows it.
pub(super) const PANIC_SEED: u64 = 0xfa17_fa17_fa17_fa17;
/// The seed that stays at its first improvement until told to stop, where the configuration allows it.
pub(super) const HANG_SEED: u64 = 0x4a46_4a46_4a46_4a46;

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
pub(super) fn run(fleet: &mut Fleet, window: Window, length: Duration) -> Result<Tally, Error> {
    Ok(Tally::of(&fleet.run(window, length)?))
}

/// A figure of a disturbed window over that of a calm one; the two take turns in being first.
pub(super) fn disturbed_over_calm(
    number: usize,
    mut figure: impl FnMut(bool) -> Result<f64, Error>,
) -> Result<f64, Error> {
    let mut of = [0.0; 2];
    for turn in [number % 2, 1 - number % 2] {
        of[turn] = figure(turn == 1)?;
    }
    Ok(ratio(of[1], of[0]))
}

/// The middle value; 0 of none.
pub(super) fn median(values: &[f64]) -> f64 {
    statistics::median(values.iter().copied()).unwrap_or(0.0)
}

/// `a ÷ b`; as much as there can be where b is 0 and a is not.
pub(super) fn ratio(a: f64, b: f64) -> f64 {
    match (a, b) {
        (0.0, 0.0) => 1.0,
        (_, 0.0) => f64::MAX,
        _ => a / b,
    }
}
