//! A part of a trajectory that is to be replaced, with the fixed waypoint that it has to pass.

use fastrand::Rng;

use super::controller::Manner;
use super::limits::Limits;
use super::ramp::{Motors, Phasing};
use super::trajectory::{NS, State, TimedState, Trajectory, Window};

/// Parts of the velocity that a waypoint is passed with today's mean speed which are tried.
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
        let is_in = |time: &&i64| window[0] < **time + half_ns && **time - half_ns < window[1];
        let inside: Vec<i64> = fixed.iter().filter(is_in).copied().collect();
        let chosen = (!inside.is_empty()).then(|| inside[rng.usize(0..inside.len())]);
        let window = chosen.map_or(window, |time| {
            let before = fixed.iter().rev().find(|other| **other < time);
            let after = fixed.iter().find(|other| **other > time);
            [
                window[0]
                    .min(time - half_ns)
                    .max(before.map_or(i64::MIN, |other| other + half_ns)),
                window[1]
                    .max(time + half_ns)
                    .min(after.map_or(i64::MAX, |other| other - half_ns)),
            ]
        });
        Self {
            window,
            ends: window.map(|time| trajectory.at(time)),
            fixed: chosen.map(|time_ns| Passing {
                time_ns,
                half_ns,
                positions: trajectory.at(time_ns).positions,
                parts: if manner.passes_moving { &PARTS } else { &[0.0] },
            }),
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
        let fastest = ways.min_by_key(|states| states[states.len() - 1].time_ns)?;
        let duration_ns = fastest[fastest.len() - 1].time_ns - self.window[0];
        (duration_ns < most_ns).then_some(fastest)
    }

    /// Velocities to pass a waypoint with: of each column this part of the mean on both sides, 0 where it
    /// turns back.
    fn velocities(&self, passing: &Passing, limits: &Limits, part: f64) -> Vec<f64> {
        let [from, to] = &self.ends;
        let times = [
            passing.time_ns - self.window[0],
            self.window[1] - passing.time_ns,
        ];
        let seconds = times.map(|time| (time as f64 / NS).max(1e-9));
        let columns = limits.columns().iter().enumerate();
        columns
            .map(|(column, limits)| {
                let here = passing.positions[column];
                let before = (here - from.positions[column]) / seconds[0];
                let after = (to.positions[column] - here) / seconds[1];
                if before * after <= 0.0 {
                    return 0.0;
                }
                let mean = part * 2.0 * before * after / (before + after);
                mean.clamp(limits.velocity.least, limits.velocity.most)
            })
            .collect()
    }

    /// Ramps to a waypoint and from it.
    fn passing(
        &self,
        passing: &Passing,
        velocities: Vec<f64>,
        motors: &Motors,
        phasing: Phasing,
    ) -> Option<Vec<TimedState>> {
        let [from, to] = &self.ends;
        let here = State {
            positions: passing.positions.clone(),
            velocities,
        };
        let half_s = passing.half_ns as f64 / NS;
        let [before, after] = [-half_s, half_s].map(|seconds| here.drifted(seconds));
        let mut states = arriving(motors, [from, &before], phasing, self.window[0])?;
        let time_ns = states.last()?.time_ns + passing.half_ns;
        if passing.half_ns == 0 {
            states.pop();
        }
        states.push(TimedState {
            is_fixed: true,
            ..TimedState::at(time_ns, here)
        });
        let leaving = arriving(motors, [&after, to], phasing, time_ns + passing.half_ns)?;
        states.extend(
            leaving
                .into_iter()
                .skip(usize::from(passing.half_ns == 0)),
        );
        Some(states)
    }
}

/// Ramps from a state to another, or that state alone where they are the same.
fn arriving(
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
