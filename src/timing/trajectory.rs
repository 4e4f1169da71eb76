//! A trajectory as it is written: points with times in whole nanoseconds, positions and velocities.
//!
//! A controller goes from point to point by cubics. Points lie wherever an acceleration changes, so that
//! these cubics are what was planned, and what is proved are these cubics.

use crate::robot::RobotModel;
use crate::validation::polynomial::{Knot, Polynomial};
use crate::validation::timed::{Curve, CurveError, Point};

/// Nanoseconds of a second.
pub const NS: f64 = 1e9;

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
}

/// States in the order of time; the first at 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    states: Vec<TimedState>,
}

impl State {
    /// At rest.
    pub fn resting(positions: &[f64]) -> Self {
        Self {
            positions: positions.to_vec(),
            velocities: vec![0.0; positions.len()],
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
        Self { time_ns, state }
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

/// The curve that a controller makes of states.
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

    /// Its points, as a controller gets them.
    pub fn points(&self) -> Vec<Point> {
        self.states
            .iter()
            .map(TimedState::point)
            .collect()
    }

    /// From the first state to the last (ns).
    pub fn duration_ns(&self) -> i64 {
        let ends = self.states.first().zip(self.states.last());
        ends.map_or(0, |(first, last)| last.time_ns - first.time_ns)
    }

    /// The same in seconds.
    pub fn duration_s(&self) -> f64 {
        self.duration_ns() as f64 / NS
    }

    /// The state at a time (ns) between both ends.
    pub fn at(&self, time_ns: i64) -> State {
        let next = self
            .states
            .partition_point(|known| known.time_ns <= time_ns);
        let last = next.clamp(1, self.states.len() - 1);
        let [from, to] = [&self.states[last - 1], &self.states[last]];
        if time_ns == to.time_ns {
            return to.state.clone();
        }
        between(from, to, time_ns)
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
    pub fn spliced(&self, [from_ns, to_ns]: [i64; 2], states: Vec<TimedState>) -> Self {
        let end_ns = states.last().map_or(to_ns, |last| last.time_ns);
        let mut all: Vec<TimedState> = self
            .states
            .iter()
            .filter(|known| known.time_ns < from_ns)
            .cloned()
            .collect();
        all.extend(states);
        let after = self
            .states
            .iter()
            .filter(|known| known.time_ns > to_ns);
        all.extend(after.map(|known| TimedState {
            time_ns: known.time_ns - to_ns + end_ns,
            state: known.state.clone(),
        }));
        Self::new(all)
    }
}

/// The state between two others.
fn between(from: &TimedState, to: &TimedState, time_ns: i64) -> State {
    let duration = (to.time_ns - from.time_ns) as f64 / NS;
    let after = (time_ns - from.time_ns) as f64 / NS;
    let columns = 0..from.state.positions.len();
    let [positions, velocities] = [0, 1].map(|order| {
        columns
            .clone()
            .map(|column| {
                let way =
                    Polynomial::cubic(from.state.knot(column), to.state.knot(column), duration);
                match order {
                    0 => way.at(after),
                    _ => way.derivative().at(after),
                }
            })
            .collect()
    });
    State {
        positions,
        velocities,
    }
}
