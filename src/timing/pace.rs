//! Stretches of a path, gone along as fast as limits allow, as states with times.

use super::along::{Place, fastest};
use super::blend::Stretch;
use super::limits::Limits;
use super::ramp::TICK_NS;
use super::trajectory::{NS, State, TimedState, curve};
use crate::robot::RobotModel;

/// Changes of the acceleration along a line that are none.
const SAME: f64 = 1e-9;
/// A trajectory that is beyond its limits is made slower so many times, each by as much as it is beyond.
const TRIES: u32 = 8;
/// How far beyond a limit counts as within, as a part of it.
pub const BEYOND: f64 = 1e-7;

/// A place with its time.
#[derive(Clone, Copy, Debug)]
struct Passed {
    place: Place,
    /// When, if nothing is made slower (s).
    time_s: f64,
    /// The acceleration along the path before it, and after.
    changes: [f64; 2],
}

/// The states of a way along stretches, from rest to rest, that keeps the limits as it is executed: `None`
/// where it does so at no pace that is tried.
pub fn paced(
    robot: &RobotModel,
    stretches: &[Stretch],
    ends: [&[f64]; 2],
    limits: &Limits,
) -> Option<Vec<TimedState>> {
    let passed = passed(stretches, &fastest(stretches, limits));
    let mut slower = 1.0;
    for _ in 0..TRIES {
        let states = states(stretches, &passed, ends, slower);
        let usage = limits.usage(&curve(robot, &states).ok()?);
        if usage.stretch() <= 1.0 + 0.5 * BEYOND {
            return Some(states);
        }
        slower *= usage.stretch() * (1.0 + 0.1 * BEYOND);
    }
    None
}

/// When each place is passed.
fn passed(stretches: &[Stretch], places: &[Place]) -> Vec<Passed> {
    let mut time_s = 0.0;
    let mut before = 0.0;
    let mut passed = Vec::with_capacity(places.len());
    for (number, place) in places.iter().enumerate() {
        let next = places.get(number + 1);
        let (width, change) = next.map_or((0.0, 0.0), |next| {
            let end = match next.stretch == place.stretch {
                true => next.length,
                false => stretches[place.stretch].length,
            };
            let width = end - place.length;
            (width, 0.5 * (next.square - place.square) / width)
        });
        passed.push(Passed {
            place: *place,
            time_s,
            changes: [before, change],
        });
        let speeds = place.square.sqrt() + next.map_or(0.0, |next| next.square.sqrt());
        if speeds > 0.0 {
            time_s += 2.0 * width / speeds;
        }
        before = change;
    }
    passed
}

/// The states so many times slower; where nothing changes along a line there need not be any.
fn states(
    stretches: &[Stretch],
    passed: &[Passed],
    [first, last]: [&[f64]; 2],
    slower: f64,
) -> Vec<TimedState> {
    let mut states = vec![TimedState::at(0, State::resting(first))];
    let end_ns = passed.last().map_or(0.0, |end| end.time_s) * slower * NS;
    let end_ns = end_ns.ceil() as i64;
    for at in &passed[1..passed.len() - 1] {
        let time_ns = (at.time_s * slower * NS).round() as i64;
        let is_apart =
            time_ns - states[states.len() - 1].time_ns >= TICK_NS && end_ns - time_ns >= TICK_NS;
        if at.changes_anything(stretches) && (is_apart || at.place.square == 0.0) {
            states.push(TimedState::at(
                time_ns,
                at.state(stretches, time_ns, slower),
            ));
        }
    }
    states.push(TimedState::at(end_ns, State::resting(last)));
    states
}

impl Passed {
    /// Whether the way is another after it than before it.
    fn changes_anything(&self, stretches: &[Stretch]) -> bool {
        let [before, after] = self.changes;
        let is_within_line = self.place.length > 0.0 && stretches[self.place.stretch].is_line();
        !is_within_line || (before - after).abs() > SAME * (1.0 + before.abs())
    }

    /// The state at a time that is nearly that of the place: times are whole nanoseconds.
    fn state(&self, stretches: &[Stretch], time_ns: i64, slower: f64) -> State {
        let stretch = &stretches[self.place.stretch];
        let after = time_ns as f64 / NS / slower - self.time_s;
        let speed = self.place.square.sqrt();
        if speed == 0.0 {
            return State::resting(&stretch.at(self.place.length));
        }
        let change = self.changes[usize::from(after >= 0.0)];
        let length = self.place.length + (speed + 0.5 * change * after) * after;
        let speed = (speed + change * after) / slower;
        let slopes = stretch.slope_at(length).into_iter();
        State {
            positions: stretch.at(length),
            velocities: slopes.map(|slope| slope * speed).collect(),
        }
    }
}
