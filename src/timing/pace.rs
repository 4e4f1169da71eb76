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
struct Passed<'c> {
    place: Place,
    /// The stretch that follows it.
    stretch: &'c Stretch,
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
    let places = fastest(course.stretches, limits);
    let passed = course.passed(&places);
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

impl<'c> Course<'c> {
    /// When each place is passed.
    fn passed(&self, places: &[Place]) -> Vec<Passed<'c>> {
        let mut passed = vec![self.passing(places[0])];
        for ends in places.windows(2) {
            let width = ends[0].end(&ends[1], self.stretches) - ends[0].length;
            let change = 0.5 * (ends[1].square - ends[0].square) / width;
            let speeds = ends[0].square.sqrt() + ends[1].square.sqrt();
            let last = passed.len() - 1;
            passed[last].changes[1] = change;
            let taken_s = if speeds > 0.0 {
                2.0 * width / speeds
            } else {
                0.0
            };
            passed.push(Passed {
                time_s: passed[last].time_s + taken_s,
                changes: [change, 0.0],
                ..self.passing(ends[1])
            });
        }
        passed
    }

    fn passing(&self, place: Place) -> Passed<'c> {
        Passed {
            place,
            stretch: &self.stretches[place.stretch],
            time_s: 0.0,
            changes: [0.0; 2],
        }
    }

    /// The states so many times slower; where nothing changes along a line there need not be any.
    fn states(&self, passed: &[Passed], slower: f64) -> Vec<TimedState> {
        let [first, last] = self.ends.map(State::resting);
        let end_s = passed[passed.len() - 1].time_s;
        let end_ns = self.grains(end_s * slower).ceil() as i64 * self.grain_ns;
        let mut states = vec![TimedState::at(0, first)];
        for at in &passed[1..passed.len() - 1] {
            let time_ns = self.grains(at.time_s * slower).round() as i64 * self.grain_ns;
            let before_ns = states[states.len() - 1].time_ns;
            let room_ns = (time_ns - before_ns).min(end_ns - time_ns);
            if at.changes_anything() && (room_ns >= NEAR_NS || at.place.square == 0.0) {
                states.push(at.state(time_ns, slower));
            }
        }
        states.push(TimedState::at(end_ns, last));
        states
    }

    fn grains(&self, time_s: f64) -> f64 {
        time_s * NS / self.grain_ns as f64
    }
}

impl Passed<'_> {
    /// Whether the way is another after it than before it.
    fn changes_anything(&self) -> bool {
        let [before, after] = self.changes;
        let is_within_line = self.place.length > 0.0 && self.stretch.is_line();
        !is_within_line || (before - after).abs() > SAME * (1.0 + before.abs())
    }

    /// The state at a time that is nearly that of the place: times are whole nanoseconds.
    fn state(&self, time_ns: i64, slower: f64) -> TimedState {
        let speed = self.place.square.sqrt();
        if speed == 0.0 {
            return self.rest(time_ns);
        }
        let after = time_ns as f64 / NS / slower - self.time_s;
        let change = self.changes[usize::from(after >= 0.0)];
        let length = self.place.length + (speed + 0.5 * change * after) * after;
        let speed = (speed + change * after) / slower;
        let slopes = self.stretch.slope_at(length).into_iter();
        let state = State {
            positions: self.stretch.at(length),
            velocities: slopes.map(|slope| slope * speed).collect(),
        };
        TimedState::at(time_ns, state)
    }

    fn rest(&self, time_ns: i64) -> TimedState {
        let length = self.place.length;
        let state = State::resting(&self.stretch.at(length));
        TimedState::at(time_ns, state).fixed(self.stretch.is_after_fixed && length == 0.0)
    }
}
