//! A trajectory as it is planned: states with times in whole nanoseconds, and cubics between them.
//!
//! States lie wherever an acceleration changes, so that these cubics are what was planned.

use crate::robot::RobotModel;
use crate::validation::polynomial::{Knot, Polynomial};
use crate::validation::timed::{Curve, CurveError, Point};

/// Nanoseconds of a second.
pub const NS: f64 = 1e9;

/// A part of a trajectory, by the times of its ends (ns).
pub type Window = [i64; 2];

/// Where all columns are, and how fast they move.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// m or rad.
    pub positions: Vec<f64>,
    /// Per second.
    pub velocities: Vec<f64>,
}

/// A state and when it is passed.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedState {
    /// From the trajectory's start (ns).
    pub time_ns: i64,
    /// The state.
    pub state: State,
    /// Whether its positions are those of a fixed waypoint.
    pub is_fixed: bool,
}

/// States in the order of time; the first at 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    states: Vec<TimedState>,
}

/// The columns of a place, so much of a direction farther.
pub fn moved(from: &[f64], direction: &[f64], by: f64) -> Vec<f64> {
    let columns = from.iter().zip(direction);
    columns
        .map(|(from, direction)| from + direction * by)
        .collect()
}

impl State {
    /// At rest.
    pub fn resting(positions: &[f64]) -> Self {
        Self {
            positions: positions.to_vec(),
            velocities: vec![0.0; positions.len()],
        }
    }

    /// Whether no column moves.
    pub fn rests(&self) -> bool {
        self.velocities
            .iter()
            .all(|velocity| *velocity == 0.0)
    }

    /// So much later, if the velocities stay as they are (s).
    #[must_use]
    pub fn drifted(&self, seconds: f64) -> Self {
        Self {
            positions: moved(&self.positions, &self.velocities, seconds),
            velocities: self.velocities.clone(),
        }
    }

    fn knot(&self, column: usize) -> Knot {
        Knot {
            position: self.positions[column],
            velocity: self.velocities[column],
            acceleration: 0.0,
        }
    }
}

impl TimedState {
    /// Passed at this time (ns).
    pub fn at(time_ns: i64, state: State) -> Self {
        Self {
            time_ns,
            state,
            is_fixed: false,
        }
    }

    /// The same at a fixed waypoint, or not.
    #[must_use]
    pub fn fixed(self, is_fixed: bool) -> Self {
        Self { is_fixed, ..self }
    }

    /// The same so much later (ns).
    #[must_use]
    pub fn later(&self, by_ns: i64) -> Self {
        Self {
            time_ns: self.time_ns + by_ns,
            ..self.clone()
        }
    }

    fn point(&self) -> Point {
        Point {
            time_s: self.time_ns as f64 / NS,
            positions: self.state.positions.clone(),
            velocities: self.state.velocities.clone(),
            accelerations: Vec::new(),
        }
    }
}

/// The curve of cubics between states.
///
/// # Errors
/// Times that do not grow, a quaternion that moves.
pub fn curve(robot: &RobotModel, states: &[TimedState]) -> Result<Curve, CurveError> {
    let points: Vec<Point> = states.iter().map(TimedState::point).collect();
    Curve::new(robot, &points)
}

impl Trajectory {
    /// Of states in the order of time; one that stands still may be alone.
    pub fn new(states: Vec<TimedState>) -> Self {
        Self { states }
    }

    /// Its states.
    pub fn states(&self) -> &[TimedState] {
        &self.states
    }

    /// The last state.
    pub fn last(&self) -> &TimedState {
        &self.states[self.states.len() - 1]
    }

    /// From the first state to the last (ns).
    pub fn duration_ns(&self) -> i64 {
        self.last().time_ns - self.states[0].time_ns
    }

    /// All of it.
    pub fn whole(&self) -> Window {
        [self.states[0].time_ns, self.last().time_ns]
    }

    /// When fixed waypoints are passed (ns).
    pub fn fixed(&self) -> Vec<i64> {
        let fixed = self
            .states
            .iter()
            .filter(|known| known.is_fixed);
        fixed.map(|known| known.time_ns).collect()
    }

    fn is_fixed_at(&self, time_ns: i64) -> bool {
        let mut states = self.states.iter();
        states.any(|known| known.time_ns == time_ns && known.is_fixed)
    }

    /// The state at a time (ns); before the first and after the last velocities stay as they are.
    pub fn at(&self, time_ns: i64) -> State {
        let next = self
            .states
            .partition_point(|known| known.time_ns <= time_ns);
        let Some(from) = next
            .checked_sub(1)
            .map(|last| &self.states[last])
        else {
            return drifted(&self.states[0], time_ns);
        };
        match self.states.get(next) {
            Some(to) => between(from, to, time_ns),
            None => drifted(from, time_ns),
        }
    }

    /// The time of the state nearest to a time (ns), where one is not farther than this.
    pub fn snapped(&self, time_ns: i64, within_ns: i64) -> i64 {
        let times = self.states.iter().map(|known| known.time_ns);
        let nearest = times.min_by_key(|known| (known - time_ns).abs());
        nearest
            .filter(|known| (known - time_ns).abs() <= within_ns)
            .unwrap_or(time_ns)
    }

    /// With other states in the place of those between two times (ns); the first and the last of them are
    /// those that were there, the last at another time.
    #[must_use]
    pub fn spliced(&self, [from_ns, to_ns]: Window, states: Vec<TimedState>) -> Self {
        let end_ns = states.last().map_or(to_ns, |last| last.time_ns);
        let own = self.states.iter();
        let mut all: Vec<TimedState> = own
            .clone()
            .filter(|known| known.time_ns < from_ns)
            .cloned()
            .collect();
        let first = all.len();
        all.extend(states);
        let last = all.len() - 1;
        for (number, time) in [(first, from_ns), (last, to_ns)] {
            all[number].is_fixed |= self.is_fixed_at(time);
        }
        let after = own.filter(|known| known.time_ns > to_ns);
        all.extend(after.map(|known| known.later(end_ns - to_ns)));
        Self::new(all)
    }

    /// The same, or if it has one state this and the same so much later (ns).
    #[must_use]
    pub fn lasting(mut self, least_ns: i64) -> Self {
        if let [only] = self.states.as_slice() {
            self.states = vec![only.clone(), only.later(least_ns)];
        }
        self
    }

    /// The same, but wherever it rests it does so for some time: between the ends, and at each of them (ns).
    #[must_use]
    pub fn rested(&self, between_ns: i64, ends_ns: i64) -> Self {
        let last = self.states.len() - 1;
        let mut later_ns = 0;
        let mut states = Vec::with_capacity(self.states.len());
        for (number, known) in self.states.iter().enumerate() {
            let is_end = number == 0 || number == last;
            let stay_ns = match (known.state.rests(), is_end) {
                (false, _) => 0,
                (true, true) => ends_ns,
                (true, false) => between_ns,
            };
            let known = known.later(later_ns);
            later_ns += stay_ns;
            states.extend(staying(known, stay_ns));
        }
        Self::new(states)
    }
}

/// A state that rests for some time; in the middle of that it is fixed.
fn staying(known: TimedState, stay_ns: i64) -> Vec<TimedState> {
    if stay_ns == 0 {
        return vec![known];
    }
    let middle = Some(known.later(stay_ns / 2)).filter(|middle| middle.is_fixed);
    let first = known.fixed(false);
    let last = first.later(stay_ns);
    [Some(first), middle, Some(last)]
        .into_iter()
        .flatten()
        .collect()
}

fn drifted(known: &TimedState, time_ns: i64) -> State {
    let seconds = (time_ns - known.time_ns) as f64 / NS;
    match seconds == 0.0 {
        true => known.state.clone(),
        false => known.state.drifted(seconds),
    }
}

/// The state between two others.
fn between(from: &TimedState, to: &TimedState, time_ns: i64) -> State {
    let duration = (to.time_ns - from.time_ns) as f64 / NS;
    let after = (time_ns - from.time_ns) as f64 / NS;
    if after == 0.0 {
        return from.state.clone();
    }
    let columns = 0..from.state.positions.len();
    let (positions, velocities) = columns
        .map(|column| {
            let ends = [from, to].map(|known| known.state.knot(column));
            let way = Polynomial::cubic(ends[0], ends[1], duration);
            (way.at(after), way.derivative().at(after))
        })
        .unzip();
    State {
        positions,
        velocities,
    }
}
