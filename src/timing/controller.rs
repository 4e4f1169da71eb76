//! What is written for a controller, so that the curve it makes of the points is the one that is proved.
//!
//! A trajectory is planned with accelerations that jump. Cubics go along it as it is. Quintics go through
//! accelerations that do not jump: what is written for them is its average over [`BLEND_NS`], with a
//! point wherever the change of the acceleration changes, so that each quintic is a cubic. An average is
//! within all limits of velocity and acceleration that the trajectory is within, and passes no place
//! exactly but where velocities are constant for as long. What is written to go straight are samples, whose
//! differences are averages as well.

use std::fmt;
use std::str::FromStr;

use super::trajectory::{NS, State, TimedState, Trajectory, Window};
use crate::validation::timed::Point;

/// How long an acceleration takes to change in what is written for quintics (ns).
pub const BLEND_NS: i64 = 4_000_000;
/// States of what is written for quintics are at whole multiples of this (ns): nearer to each other, what a
/// controller computes of them is mostly rounding.
const QUINTIC_GRAIN_NS: i64 = 200_000;
/// Rates at which points may follow each other (Hz).
const RATES_HZ: std::ops::RangeInclusive<f64> = 1.0..=10_000.0;

/// How a controller goes from a point to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Controller {
    /// By cubics: points have positions and velocities.
    #[default]
    Cubic,
    /// By quintics: points have accelerations too, and these do not jump.
    Quintic,
    /// Straight, at a rate: points have positions only, and follow each other evenly. Velocities and
    /// accelerations are differences of positions at that rate.
    Linear {
        /// Points a second (Hz).
        rate_hz: f64,
    },
}

/// What a trajectory must be for a controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Manner {
    /// Times of its states are whole multiples of this (ns).
    pub grain_ns: i64,
    /// For how long it goes on at constant velocity from its first state, and to its last (ns).
    pub ends_ns: i64,
    /// For how long it does so where it passes a place exactly, half of it before (ns).
    pub through_ns: i64,
    /// Whether fixed waypoints may be passed without resting.
    pub passes_moving: bool,
    /// Whether points lie elsewhere on it if it has been faster before.
    pub shifts: bool,
}

impl Controller {
    /// Name in results and options.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Cubic => "cubic",
            Self::Quintic => "quintic",
            Self::Linear { .. } => "linear",
        }
    }

    /// The same, if its points may follow each other at its rate.
    ///
    /// # Errors
    /// They may not.
    pub fn usable(self) -> Result<Self, NoController> {
        match self {
            Self::Linear { rate_hz } if !RATES_HZ.contains(&rate_hz) => {
                Err(NoController(self.to_string()))
            }
            usable => Ok(usable),
        }
    }

    /// What a trajectory must be for it.
    pub fn manner(&self) -> Manner {
        let plain = Manner {
            grain_ns: 1,
            ends_ns: 0,
            through_ns: 0,
            passes_moving: true,
            shifts: false,
        };
        match self {
            Self::Cubic => plain,
            Self::Quintic => Manner {
                grain_ns: QUINTIC_GRAIN_NS,
                ends_ns: BLEND_NS / 2,
                through_ns: BLEND_NS,
                ..plain
            },
            // A sample lies on whatever rests as long as from one to the next; each half is whole.
            Self::Linear { rate_hz } => Manner {
                through_ns: (period_ns(*rate_hz) + 1) / 2 * 2,
                passes_moving: false,
                shifts: true,
                ..plain
            },
        }
    }

    /// What is written of a trajectory, as far as what lies between two times (ns) counts for it.
    pub fn points(&self, trajectory: &Trajectory, window: Window) -> Vec<TimedPoint> {
        match self {
            Self::Cubic => cubic(trajectory, window),
            Self::Quintic => quintic(trajectory, window),
            Self::Linear { rate_hz } => linear(trajectory, window, period_ns(*rate_hz)),
        }
    }
}

impl fmt::Display for Controller {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Linear { rate_hz } => write!(f, "linear@{rate_hz}"),
            other => f.write_str(other.name()),
        }
    }
}

/// A text that names no controller.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{0:?} is no controller; give cubic, quintic, or linear@250: straight between points, so many a second (1 to 10000)"
)]
pub struct NoController(String);

impl FromStr for Controller {
    type Err = NoController;

    fn from_str(text: &str) -> Result<Self, NoController> {
        let linear = || {
            let rate_hz = text.strip_prefix("linear@")?.parse().ok()?;
            Some(Self::Linear { rate_hz })
        };
        let named = match text {
            "cubic" => Some(Self::Cubic),
            "quintic" => Some(Self::Quintic),
            _ => linear(),
        };
        named
            .ok_or_else(|| NoController(text.to_owned()))?
            .usable()
    }
}

/// A point as it is written.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedPoint {
    /// From the trajectory's start (ns).
    pub time_ns: i64,
    /// m or rad.
    pub positions: Vec<f64>,
    /// Per second; empty where the controller is to go straight, but for the first point of what begins with
    /// a velocity.
    pub velocities: Vec<f64>,
    /// Per second squared; empty where the controller is not to go by quintics.
    pub accelerations: Vec<f64>,
}

impl TimedPoint {
    /// A state, without accelerations.
    pub fn of_state(known: &TimedState) -> Self {
        Self {
            time_ns: known.time_ns,
            positions: known.state.positions.clone(),
            velocities: known.state.velocities.clone(),
            accelerations: Vec::new(),
        }
    }

    /// The same with its time in seconds.
    pub fn point(&self) -> Point {
        Point {
            time_s: self.time_ns as f64 / NS,
            positions: self.positions.clone(),
            velocities: self.velocities.clone(),
            accelerations: self.accelerations.clone(),
        }
    }
}

fn cubic(trajectory: &Trajectory, [from_ns, to_ns]: Window) -> Vec<TimedPoint> {
    let states = trajectory.states().iter();
    states
        .filter(|known| (from_ns..=to_ns).contains(&known.time_ns))
        .map(TimedPoint::of_state)
        .collect()
}

/// From one sample to the next (ns).
fn period_ns(rate_hz: f64) -> i64 {
    (NS / rate_hz).round() as i64
}

fn linear(trajectory: &Trajectory, [from_ns, to_ns]: Window, period_ns: i64) -> Vec<TimedPoint> {
    let end_ns = trajectory.last().time_ns;
    let start = &trajectory.states()[0].state;
    let samples = from_ns / period_ns..=(to_ns + period_ns - 1) / period_ns;
    samples
        .map(|sample| TimedPoint {
            time_ns: sample * period_ns,
            positions: trajectory
                .at((sample * period_ns).min(end_ns))
                .positions,
            // What it begins with is in no difference; one point with velocities changes no way.
            velocities: match sample == 0 && !start.rests() {
                true => start.velocities.clone(),
                false => Vec::new(),
            },
            accelerations: Vec::new(),
        })
        .collect()
}

fn quintic(trajectory: &Trajectory, [from_ns, to_ns]: Window) -> Vec<TimedPoint> {
    const HALF_NS: i64 = BLEND_NS / 2;
    let [start_ns, end_ns] = trajectory.whole();
    let states = trajectory.states().iter();
    let changes = states.flat_map(|known| [-HALF_NS, HALF_NS].map(|by| known.time_ns + by));
    let mut times: Vec<i64> = changes
        .filter(|time| (start_ns..=end_ns).contains(time))
        .chain([start_ns, end_ns])
        .chain(trajectory.fixed())
        .collect();
    times.sort_unstable();
    times.dedup();
    let first = times.partition_point(|time| *time <= from_ns - HALF_NS);
    let last = times.partition_point(|time| *time < to_ns + HALF_NS);
    let touched = &times[first.saturating_sub(1)..=last.min(times.len() - 1)];
    let points = touched.iter();
    points
        .map(|time| averaged(trajectory, *time))
        .collect()
}

/// The average of a trajectory about a time (ns), and its rates there.
fn averaged(trajectory: &Trajectory, time_ns: i64) -> TimedPoint {
    let window = [-BLEND_NS / 2, BLEND_NS / 2].map(|by| time_ns + by);
    let [before, after] = window.map(|time| trajectory.at(time));
    let here = trajectory.at(time_ns);
    let rate = |from: &[f64], to: &[f64]| -> Vec<f64> {
        let columns = from.iter().zip(to);
        let change = columns.map(|(from, to)| to - from);
        change
            .map(|change| change / (BLEND_NS as f64 / NS))
            .collect()
    };
    let mut point = TimedPoint {
        time_ns,
        positions: mean(trajectory, window),
        velocities: rate(&before.positions, &after.positions),
        accelerations: rate(&before.velocities, &after.velocities),
    };
    // Where a velocity is constant the average is the place itself, to the last bit.
    for column in 0..here.positions.len() {
        let velocities = [&before, &here, &after].map(|state| state.velocities[column]);
        if velocities[0] == velocities[1] && velocities[1] == velocities[2] {
            point.positions[column] = here.positions[column];
            point.velocities[column] = velocities[1];
        }
    }
    point
}

/// The mean of the positions between two times (ns), by Simpson's rule, which is exact for cubics.
fn mean(trajectory: &Trajectory, [from_ns, to_ns]: Window) -> Vec<f64> {
    let states = trajectory.states().iter();
    let inner = states
        .map(|known| known.time_ns)
        .filter(|time| from_ns < *time && *time < to_ns);
    let mut times = vec![from_ns];
    times.extend(inner);
    times.push(to_ns);
    let mut sum = vec![0.0; trajectory.states()[0].state.positions.len()];
    for ends in times.windows(2) {
        let share = (ends[1] - ends[0]) as f64 / (6.0 * (to_ns - from_ns) as f64);
        let looks = [
            (ends[0], 1.0),
            ((ends[0] + ends[1]) / 2, 4.0),
            (ends[1], 1.0),
        ];
        for (time, weight) in looks {
            add(&mut sum, &trajectory.at(time), weight * share);
        }
    }
    sum
}

fn add(sum: &mut [f64], state: &State, share: f64) {
    let columns = sum.iter_mut().zip(&state.positions);
    columns.for_each(|(sum, position)| *sum += share * position);
}
