//! How fast a path may be gone along: the fastest velocities along it within the limits, by a pass from its
//! end and one from its beginning.
//!
//! With s the length along a path, x = ṡ² and u = s̈, a column's velocity is q′ ṡ and its acceleration
//! q′ u + q″ x. Between two places that are Δ apart u is constant, and x grows by 2 Δ u. q″ is constant on a
//! stretch, q′ goes straight: where both ends of an interval keep the limits of acceleration, all of it
//! does. Backward, the pass finds the fastest at which each place may be passed so that the rest is
//! possible; forward, it goes as fast as that allows (Pham and Pham, TOPP-RA, 2018).

use super::blend::Stretch;
use super::limits::Limits;

/// Intervals of a path, about.
const INTERVALS: f64 = 120.0;
/// A line has as many at least.
const LEAST_OF_LINE: usize = 6;
/// A parabola has as many.
const LEAST_OF_PARABOLA: usize = 4;

/// A place along a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The stretch that follows it; of the last place the one before.
    pub stretch: usize,
    /// How far on it (s).
    pub length: f64,
    /// The square of the velocity along the path.
    pub square: f64,
}

impl Place {
    /// How far on its stretch what follows it ends: at the next place, or with the stretch (s).
    pub fn end(&self, next: &Self, stretches: &[Stretch]) -> f64 {
        match next.stretch == self.stretch {
            true => next.length,
            false => stretches[self.stretch].length,
        }
    }
}

/// α + β x: a bound of u.
#[derive(Clone, Copy, Debug)]
struct Line {
    alpha: f64,
    beta: f64,
}

impl Line {
    fn at(&self, x: f64) -> f64 {
        self.alpha + self.beta * x
    }
}

/// Bounds of u between two places, by x at the first.
#[derive(Debug, Default)]
struct Bounds {
    lower: Vec<Line>,
    upper: Vec<Line>,
}

impl Bounds {
    fn clear(&mut self) {
        self.lower.clear();
        self.upper.clear();
    }

    /// The highest of the lower ones.
    fn least(&self, x: f64) -> Line {
        let highest = |a: &Line, b: &Line| if b.at(x) > a.at(x) { *b } else { *a };
        let lines = self.lower.iter();
        lines.fold(
            Line {
                alpha: f64::NEG_INFINITY,
                beta: 0.0,
            },
            |known, line| highest(&known, line),
        )
    }

    /// The lowest of the upper ones.
    fn most(&self, x: f64) -> Line {
        let lowest = |a: &Line, b: &Line| if b.at(x) < a.at(x) { *b } else { *a };
        let lines = self.upper.iter();
        lines.fold(
            Line {
                alpha: f64::INFINITY,
                beta: 0.0,
            },
            |known, line| lowest(&known, line),
        )
    }

    /// The largest x up to this at which some u is between them: what is between is the wider the smaller
    /// x is, and never empty at 0.
    fn largest(&self, mut x: f64) -> f64 {
        loop {
            let least = self.least(x);
            let most = self.most(x);
            if least.at(x) <= most.at(x) {
                return x;
            }
            // Where these two cross; nearer than that there is nothing.
            let crossing = (most.alpha - least.alpha) / (least.beta - most.beta);
            if crossing.is_nan() || crossing >= x {
                return x.min(crossing.max(0.0));
            }
            x = crossing.max(0.0);
            if x == 0.0 {
                return x;
            }
        }
    }
}

/// The fastest way along stretches that begin and end at rest, place by place.
///
/// Where a stretch does not begin as the one before ends, the way comes to rest between them.
pub fn fastest(stretches: &[Stretch], limits: &Limits) -> Vec<Place> {
    let mut places = places(stretches, limits);
    let mut bounds = Bounds::default();
    for first in (0..places.len() - 1).rev() {
        let interval = Interval::new(stretches, &places, first);
        interval.bound(limits, &mut bounds);
        let step = 2.0 * interval.width;
        // The place after it may be no faster than it is known to be.
        bounds.upper.push(Line {
            alpha: places[first + 1].square / step,
            beta: -1.0 / step,
        });
        bounds.lower.push(Line {
            alpha: 0.0,
            beta: -1.0 / step,
        });
        places[first].square = bounds.largest(places[first].square);
    }
    places[0].square = 0.0;
    for first in 0..places.len() - 1 {
        let interval = Interval::new(stretches, &places, first);
        interval.bound(limits, &mut bounds);
        let square = places[first].square;
        let after = square + 2.0 * interval.width * bounds.most(square).at(square);
        let next = &mut places[first + 1];
        next.square = next.square.min(after).max(0.0);
    }
    places
}

/// The places, each as fast as velocities alone allow.
fn places(stretches: &[Stretch], limits: &Limits) -> Vec<Place> {
    let total: f64 = stretches
        .iter()
        .map(|stretch| stretch.length)
        .sum();
    let mut places = Vec::new();
    for (number, stretch) in stretches.iter().enumerate() {
        let least = match stretch.is_line() {
            true => LEAST_OF_LINE,
            false => LEAST_OF_PARABOLA,
        };
        let count = ((INTERVALS * stretch.length / total).round() as usize).max(least);
        let place = |part: usize| {
            let length = stretch.length * part as f64 / count as f64;
            Place {
                stretch: number,
                length,
                square: most_square(stretch, length, limits),
            }
        };
        let mut own = (0..count).map(place);
        let mut first = own.next().expect("a stretch has intervals");
        let is_smooth = number > 0 && is_smooth(&stretches[number - 1], stretch);
        if !is_smooth || stretch.is_after_fixed {
            first.square = 0.0;
        }
        places.push(first);
        places.extend(own);
    }
    if let Some((number, last)) = stretches.iter().enumerate().next_back() {
        places.push(Place {
            stretch: number,
            length: last.length,
            square: 0.0,
        });
    }
    places
}

/// Whether one stretch ends as the next begins.
fn is_smooth(before: &Stretch, after: &Stretch) -> bool {
    let ends = before.slope_at(before.length);
    let pairs = ends.iter().zip(&after.slope);
    pairs
        .map(|(end, slope)| (end - slope).abs())
        .fold(0.0, f64::max)
        < 1e-9
}

/// The largest x that velocities allow.
fn most_square(stretch: &Stretch, length: f64, limits: &Limits) -> f64 {
    let slopes = stretch.slope_at(length);
    let columns = slopes.iter().zip(limits.columns());
    // The way along the path is fastest where the slope is 1 of the velocity limit.
    let largest = columns
        .map(|(slope, limits)| limits.velocity.part(*slope))
        .fold(0.0, f64::max);
    (1.0 / (largest * largest)).min(1e12)
}

/// What lies between two places that follow each other.
struct Interval {
    /// q′ at both ends.
    slopes: [Vec<f64>; 2],
    bend: Vec<f64>,
    width: f64,
}

impl Interval {
    fn new(stretches: &[Stretch], places: &[Place], first: usize) -> Self {
        let place = places[first];
        let stretch = &stretches[place.stretch];
        let end = place.end(&places[first + 1], stretches);
        Self {
            slopes: [place.length, end].map(|length| stretch.slope_at(length)),
            bend: stretch.bend.clone(),
            width: end - place.length,
        }
    }

    /// The bounds of u that keep every acceleration's limits at both ends.
    fn bound(&self, limits: &Limits, bounds: &mut Bounds) {
        bounds.clear();
        for (column, limits) in limits.columns().iter().enumerate() {
            let bend = self.bend[column];
            let range = &limits.acceleration;
            // At the end x is larger by 2 Δ u.
            let ends = [
                self.slopes[0][column],
                self.slopes[1][column] + 2.0 * self.width * bend,
            ];
            for slope in ends {
                bounds.add(slope, bend, [range.least, range.most]);
            }
        }
    }
}

impl Bounds {
    /// least ≤ slope u + bend x ≤ most.
    fn add(&mut self, slope: f64, bend: f64, [least, most]: [f64; 2]) {
        if slope.abs() < 1e-12 {
            return self.add_flat(bend, [least, most]);
        }
        let line = |limit: f64| Line {
            alpha: limit / slope,
            beta: -bend / slope,
        };
        let [lower, upper] = match slope > 0.0 {
            true => [least, most],
            false => [most, least],
        };
        self.lower.push(line(lower));
        self.upper.push(line(upper));
    }

    /// The same where u does not count: x ≤ limit / bend, as a bound that nothing keeps beyond.
    fn add_flat(&mut self, bend: f64, [least, most]: [f64; 2]) {
        const STEEP: f64 = 1e9;
        if bend == 0.0 {
            return;
        }
        let largest = if bend > 0.0 { most } else { least } / bend;
        self.upper.push(Line {
            alpha: STEEP * largest,
            beta: -STEEP,
        });
        self.lower.push(Line {
            alpha: -STEEP * largest,
            beta: STEEP,
        });
    }
}
