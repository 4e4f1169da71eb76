//! From a place to the nearest one beside it.

use super::super::continuous::Validator;
use super::super::undecided::Interval;
use super::Near;

/// Steps of the search for the place where a distance stops falling.
const STEPS: u32 = 24;
impl Validator<'_> {
    /// A pair at ratio `t` of an interval's segment, exactly, and the rate at which its distance
    /// grows there (m per unit t).
    pub(super) fn near(&mut self, pair: usize, interval: &Interval, t: f64) -> (Near, f64) {
        self.place(&Interval {
            middle: t,
            ..*interval
        });
        self.exact += 1;
        let (contact, rate) = self
            .scratch
            .motion
            .apart(self.model, &self.model.pairs()[pair]);
        (
            Near {
                segment: interval.segment,
                t,
                pair,
                contact,
            },
            rate,
        )
    }

    /// About the distance of a pair in the middle of an interval, never below it (m).
    pub(super) fn nearly_apart(&mut self, pair: usize, interval: &Interval) -> f64 {
        self.place(interval);
        self.exact += 1;
        self.scratch
            .motion
            .nearly_apart(self.model, &self.model.pairs()[pair])
    }

    /// From an interval's middle to where the distance stops falling, within these ratios: it falls
    /// towards one of them, and until it grows again the step doubles; then the place is between
    /// the last two. A distance that cannot fall by more than `settled` (m) is the least.
    pub(super) fn follow(
        &mut self,
        pair: usize,
        interval: &Interval,
        [low, high]: [f64; 2],
        settled: f64,
    ) -> Near {
        let (mut best, rate) = self.near(pair, interval, interval.middle);
        let direction = -rate.signum();
        let mut falling = (interval.middle, rate);
        let mut growing = None::<(f64, f64)>;
        let mut step = interval.half;
        for number in 0..STEPS {
            let t = match growing {
                None => (falling.0 + direction * step).clamp(low, high),
                // Where two pieces take turns the rate jumps, and even changes tell little: every
                // other time, halve.
                Some(growing) if number % 2 == 0 => (falling.0 + growing.0) / 2.0,
                Some(growing) => evenly_between(falling, growing),
            };
            if t == falling.0 {
                break;
            }
            let (next, rate) = self.near(pair, interval, t);
            if next.contact.distance < best.contact.distance {
                best = next;
            }
            match rate * direction < 0.0 {
                true => falling = (t, rate),
                false => growing = Some((t, rate)),
            }
            step *= 2.0;
            let width = growing.map_or(f64::INFINITY, |(t, _)| (t - falling.0).abs());
            if falling.1.abs() * width < settled {
                break;
            }
        }
        best
    }
}

/// The place between one where the distance still falls and one where it grows again, each with its
/// rate, where the rate would be zero if it changed evenly.
fn evenly_between(falling: (f64, f64), growing: (f64, f64)) -> f64 {
    let ratio = falling.1.abs() / (falling.1.abs() + growing.1.abs());
    let ratio = if ratio.is_finite() {
        ratio.clamp(0.01, 0.99)
    } else {
        0.5
    };
    falling.0 + ratio * (growing.0 - falling.0)
}
