//! A part of a trajectory that is to be replaced, with the fixed waypoint that it has to pass.

use fastrand::Rng;

use super::controller::Manner;
use super::limits::{ColumnLimits, Limits};
use super::ramp::{Motors, Phasing};
use super::trajectory::{NS, State, TimedState, Trajectory, Window};

/// Parts of the mean velocity about a waypoint that are tried there.
const PARTS: [f64; 6] = [1.0, 1.3, 1.7, 2.2, 0.6, 0.0];

/// The states at the ends of a part, and a fixed waypoint between them.
pub struct Through {
    /// The part.
    pub window: Window,
    ends: [State; 2],
    fixed: Option<Passing>,
}

/// A fixed waypoint, and the time for which it is passed at constant velocity.
struct Passing {
    time_ns: i64,
    half_ns: i64,
    positions: Vec<f64>,
    parts: &'static [f64],
}

impl Through {
    /// Of a window; where there is more than one fixed waypoint in it, it is made smaller until one is left.
    pub fn new(trajectory: &Trajectory, window: Window, manner: &Manner, rng: &mut Rng) -> Self {
        let half_ns = manner.through_ns / 2;
        let fixed = trajectory.fixed();
        let mut inside = fixed.clone();
        inside.retain(|time| window[0] < time + half_ns && time - half_ns < window[1]);
        if inside.is_empty() {
            return Self::of(trajectory, window, None);
        }
        let time_ns = inside[rng.usize(0..inside.len())];
        let passing = Passing {
            time_ns,
            half_ns,
            positions: trajectory.at(time_ns).positions,
            parts: match manner.passes_moving {
                true => &PARTS,
                false => &[0.0],
            },
        };
        let window = passing.window(window, &fixed);
        Self::of(trajectory, window, Some(passing))
    }

    fn of(trajectory: &Trajectory, window: Window, fixed: Option<Passing>) -> Self {
        Self {
            window,
            ends: window.map(|time| trajectory.at(time)),
            fixed,
        }
    }

    /// The fastest ramps that are found from one end to the other, if they take less than this (ns).
    pub fn ramps(
        &self,
        motors: &Motors,
        phasing: Phasing,
        most_ns: i64,
    ) -> Option<Vec<TimedState>> {
        let Some(passing) = &self.fixed else {
            let [from, to] = &self.ends;
            return motors.ramps([from, to], phasing, self.window[0], most_ns);
        };
        let ways = passing.parts.iter().filter_map(|part| {
            let velocities = self.velocities(passing, motors.limits, *part);
            self.passing(passing, velocities, motors, phasing)
        });
        let fastest = ways.min_by_key(|states| end_ns(states))?;
        (end_ns(&fastest) - self.window[0] < most_ns).then_some(fastest)
    }

    /// Velocities to pass a waypoint with.
    fn velocities(&self, passing: &Passing, limits: &Limits, part: f64) -> Vec<f64> {
        let [from, to] = &self.ends;
        let [start_ns, end_ns] = self.window;
        let before_s = seconds(passing.time_ns - start_ns);
        let after_s = seconds(end_ns - passing.time_ns);
        let columns = limits.columns().iter().enumerate();
        let velocity = |(column, limits): (usize, &ColumnLimits)| {
            let here = passing.positions[column];
            let before = (here - from.positions[column]) / before_s;
            let after = (to.positions[column] - here) / after_s;
            let range = &limits.velocity;
            (part * mean(before, after)).clamp(range.least, range.most)
        };
        columns.map(velocity).collect()
    }

    /// Ramps to a waypoint and from it.
    fn passing(
        &self,
        passing: &Passing,
        velocities: Vec<f64>,
        motors: &Motors,
        phasing: Phasing,
    ) -> Option<Vec<TimedState>> {
        let here = State {
            positions: passing.positions.clone(),
            velocities,
        };
        let half_s = passing.half_ns as f64 / NS;
        let before = here.drifted(-half_s);
        let after = here.drifted(half_s);
        let [from, to] = &self.ends;
        let mut states = ramps(motors, [from, &before], phasing, self.window[0])?;
        let time_ns = end_ns(&states) + passing.half_ns;
        let leaving = ramps(motors, [&after, to], phasing, time_ns + passing.half_ns)?;
        let passed = TimedState::at(time_ns, here).fixed(true);
        if passing.half_ns > 0 {
            states.push(passed);
            states.extend(leaving);
            return Some(states);
        }
        // All three are the same state.
        states.pop();
        states.push(passed);
        states.extend(leaving.into_iter().skip(1));
        Some(states)
    }
}

impl Passing {
    /// As much of a window as lies between the waypoints beside this one, and all of its passing.
    fn window(&self, [from_ns, to_ns]: Window, fixed: &[i64]) -> Window {
        let here = fixed.partition_point(|time| *time < self.time_ns);
        let before = here.checked_sub(1).map(|before| fixed[before]);
        let after = fixed.get(here + 1);
        let least_ns = before.map_or(i64::MIN, |time| time + self.half_ns);
        let most_ns = after.map_or(i64::MAX, |time| time - self.half_ns);
        [
            from_ns
                .min(self.time_ns - self.half_ns)
                .max(least_ns),
            to_ns
                .max(self.time_ns + self.half_ns)
                .min(most_ns),
        ]
    }
}

/// When the last of states is passed (ns).
fn end_ns(states: &[TimedState]) -> i64 {
    states[states.len() - 1].time_ns
}

/// A time that may be divided by (s).
fn seconds(time_ns: i64) -> f64 {
    time_ns.max(1) as f64 / NS
}

/// The harmonic mean of two velocities, 0 where a column turns back.
fn mean(before: f64, after: f64) -> f64 {
    match before * after > 0.0 {
        true => 2.0 * before * after / (before + after),
        false => 0.0,
    }
}

/// Ramps from a state to another, or that state alone where they are the same.
fn ramps(
    motors: &Motors,
    [from, to]: [&State; 2],
    phasing: Phasing,
    start_ns: i64,
) -> Option<Vec<TimedState>> {
    match from == to {
        true => Some(vec![TimedState::at(start_ns, from.clone())]),
        false => motors.ramps([from, to], phasing, start_ns, i64::MAX),
    }
}
