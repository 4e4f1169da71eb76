//! From a place to the nearest one beside it.

use super::super::examiner::Examiner;
use super::super::requirement::Requirement;
use super::super::undecided::Interval;
use super::Near;

/// Steps of the search for the place where a distance stops falling.
const STEPS: u32 = 24;

impl Examiner<'_> {
    /// A requirement at ratio `t` of an interval's segment, exactly, and the rate at which it grows
    /// there (per unit t).
    pub(super) fn near(
        &mut self,
        requirement: Requirement,
        interval: &Interval,
        t: f64,
    ) -> (Near, f64) {
        let place = Interval {
            middle: t,
            ..*interval
        };
        let (measure, rate) = self.measure_with_rate(requirement, &place);
        let near = Near {
            segment: interval.segment,
            t,
            requirement,
            measure,
        };
        (near, rate)
    }

    /// From an interval's middle to where the distance stops falling, within these ratios: it falls
    /// towards one of them, and until it grows again the step doubles; then the place is between
    /// the last two. A distance that cannot fall by more than `settled` (m) is the least.
    pub(super) fn follow(
        &mut self,
        requirement: Requirement,
        interval: &Interval,
        range: [f64; 2],
        settled: f64,
    ) -> Near {
        let (mut best, rate) = self.near(requirement, interval, interval.middle);
        let mut descent = Descent::new(interval, rate);
        for number in 0..STEPS {
            let t = descent.next(number, range);
            if t == descent.falling.0 {
                break;
            }
            let (next, rate) = self.near(requirement, interval, t);
            if next.measure.amount < best.measure.amount {
                best = next;
            }
            if descent.is_settled_at(t, rate, settled) {
                break;
            }
        }
        best
    }
}

/// The place between one where the distance still falls and one where it grows again, each with its
/// rate, where the rate would be zero if it changed evenly.
fn evenly_between(falling: (f64, f64), growing: (f64, f64)) -> f64 {
    let ratio = inner_ratio(falling.1.abs() / (falling.1.abs() + growing.1.abs()));
    falling.0 + ratio * (growing.0 - falling.0)
}

/// Never at an end: that would tell nothing new.
fn inner_ratio(ratio: f64) -> f64 {
    if ratio.is_finite() {
        ratio.clamp(0.01, 0.99)
    } else {
        0.5
    }
}

/// A search along a segment for the place where a distance stops falling.
struct Descent {
    /// Along which it falls: 1 or −1.
    direction: f64,
    /// The last place where it still falls, and the rate there.
    falling: (f64, f64),
    /// The nearest beyond where it grows again, once it is known.
    growing: Option<(f64, f64)>,
    step: f64,
}

impl Descent {
    /// From the middle of an interval, where the distance has this rate.
    fn new(interval: &Interval, rate: f64) -> Self {
        Self {
            direction: -rate.signum(),
            falling: (interval.middle, rate),
            growing: None,
            step: interval.half,
        }
    }

    /// Where to look next.
    fn next(&self, number: u32, [low, high]: [f64; 2]) -> f64 {
        match self.growing {
            None => (self.falling.0 + self.direction * self.step).clamp(low, high),
            // Where two pieces take turns the rate jumps, and even changes tell little: every other
            // time, halve.
            Some(growing) if number.is_multiple_of(2) => (self.falling.0 + growing.0) / 2.0,
            Some(growing) => evenly_between(self.falling, growing),
        }
    }

    /// Takes in a rate; whether the distance cannot fall by more than `settled` (m) any more.
    fn is_settled_at(&mut self, t: f64, rate: f64, settled: f64) -> bool {
        match rate * self.direction < 0.0 {
            true => self.falling = (t, rate),
            false => self.growing = Some((t, rate)),
        }
        self.step *= 2.0;
        self.falling.1.abs() * self.width() < settled
    }

    /// Between the two places that it lies between.
    fn width(&self) -> f64 {
        let falling = self.falling.0;
        self.growing
            .map_or(f64::INFINITY, |(t, _)| (t - falling).abs())
    }
}
