//! Stretches of a path, gone along as fast as limits allow, as states with times.

use super::along::{Place, fastest};
use super::blend::Stretch;
use super::limits::Limits;
use super::trajectory::{NS, State, TimedState, curve};
use crate::robot::RobotModel;

/// States are no nearer to each other than this, but where it rests (ns).
const NEAR_NS: i64 = 100_000;
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

/// A way along stretches, from rest to rest.
#[derive(Clone, Copy, Debug)]
pub struct Course<'c> {
    /// What it goes along.
    pub stretches: &'c [Stretch],
    /// Where it begins and ends.
    pub ends: [&'c [f64]; 2],
    /// Times of its states are whole multiples of this (ns).
    pub grain_ns: i64,
}

/// The states of a way that keeps the limits as it is executed: `None` where it does so at no pace that is
/// tried.
pub fn paced(robot: &RobotModel, course: &Course, limits: &Limits) -> Option<Vec<TimedState>> {
    let passed = passed(course.stretches, &fastest(course.stretches, limits));
    let mut slower = 1.0;
    for _ in 0..TRIES {
        let states = course.states(&passed, slower);
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

impl Course<'_> {
    /// The states so many times slower; where nothing changes along a line there need not be any.
    fn states(&self, passed: &[Passed], slower: f64) -> Vec<TimedState> {
        let grains = |time_s: f64| time_s * slower * NS / self.grain_ns as f64;
        let [first, last] = self.ends.map(State::resting);
        let mut states = vec![TimedState::at(0, first)];
        let end_s = passed.last().map_or(0.0, |end| end.time_s);
        let end_ns = grains(end_s).ceil() as i64 * self.grain_ns;
        for at in &passed[1..passed.len() - 1] {
            let time_ns = grains(at.time_s).round() as i64 * self.grain_ns;
            let before_ns = states[states.len() - 1].time_ns;
            let is_apart = time_ns - before_ns >= NEAR_NS && end_ns - time_ns >= NEAR_NS;
            if at.changes_anything(self.stretches) && (is_apart || at.place.square == 0.0) {
                states.push(at.passed_at(self.stretches, time_ns, slower));
            }
        }
        states.push(TimedState::at(end_ns, last));
        states
    }
}

impl Passed {
    /// Whether the way is another after it than before it.
    fn changes_anything(&self, stretches: &[Stretch]) -> bool {
        let [before, after] = self.changes;
        let is_within_line = self.place.length > 0.0 && stretches[self.place.stretch].is_line();
        !is_within_line || (before - after).abs() > SAME * (1.0 + before.abs())
    }

    fn passed_at(&self, stretches: &[Stretch], time_ns: i64, slower: f64) -> TimedState {
        let is_fixed = stretches[self.place.stretch].is_after_fixed;
        TimedState {
            is_fixed: is_fixed && self.place.length == 0.0,
            ..TimedState::at(time_ns, self.state(stretches, time_ns, slower))
        }
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
