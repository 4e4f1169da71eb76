//! How a trajectory begins, so that a path can be gone along from rest: at rest, or from a velocity.

use super::blend::{Corner, Corners};
use super::controller::Manner;
use super::error::{NoStart, TimingError};
use super::keeper::Keeper;
use super::ramp::{Motors, Phasing};
use super::trajectory::{NS, State, TimedState, Trajectory};
use crate::validation::timed::{self, TimedVerdict};

/// Waypoints that are tried as the first to rest at.
const WAYPOINTS: usize = 4;

/// The beginning of a trajectory, and the path that is left.
#[derive(Clone, Debug)]
pub struct Begun {
    /// The last of them rests at the first of the corners.
    states: Vec<TimedState>,
    /// What is gone along from there.
    pub corners: Corners,
}

/// What comes of a beginning: a whole trajectory that stops at every waypoint.
pub struct Stopping {
    /// How it begins.
    pub begun: Begun,
    /// All of it.
    pub trajectory: Trajectory,
}

impl Begun {
    /// At rest where a path begins.
    pub fn at_rest(corners: Corners) -> Self {
        let first = State::resting(&corners.rows()[0].positions);
        Self {
            states: vec![TimedState::at(0, first)],
            corners,
        }
    }

    /// The whole trajectory, when its corners are gone along like this.
    pub fn then(&self, way: &Trajectory, manner: &Manner) -> Trajectory {
        let last = self.states.len() - 1;
        let joint = &self.states[last];
        let mut states = self.states[..last].to_vec();
        let way = way.states().iter();
        states.extend(way.map(|known| known.later(joint.time_ns)));
        states[last].is_fixed = joint.is_fixed;
        // The end is one anyway.
        let end = states.len() - 1;
        states[end].is_fixed = false;
        Trajectory::new(states).rested(manner.through_ns, manner.ends_ns)
    }

    /// The whole trajectory with a stop at each waypoint.
    ///
    /// # Errors
    /// No ramp between two of them.
    pub fn stopping(self, motors: &Motors, manner: &Manner) -> Result<Stopping, TimingError> {
        let way = stops(&self.corners, motors)?;
        Ok(Stopping {
            trajectory: self.then(&way, manner),
            begun: self,
        })
    }
}

/// From rest to rest between all waypoints, straight.
fn stops(corners: &Corners, motors: &Motors) -> Result<Trajectory, TimingError> {
    let rows = corners.rows();
    let mut states = vec![TimedState::at(0, State::resting(&rows[0].positions))];
    for (waypoint, ends) in rows.windows(2).enumerate() {
        let from = &states[states.len() - 1];
        let to = State::resting(&ends[1].positions);
        let ramps = motors.ramps([&from.state, &to], Phasing::Common, from.time_ns, i64::MAX);
        let ramps = ramps.ok_or(TimingError::Ramp { waypoint })?;
        states.extend(ramps.into_iter().skip(1));
        let last = states.len() - 1;
        states[last].is_fixed = ends[1].is_fixed;
    }
    Ok(Trajectory::new(states))
}

/// The fastest way that is proved to begin with a velocity and to stop at each waypoint after that; `None`
/// where stopped.
///
/// # Errors
/// None is: what was tried, and what it hits.
pub fn moving(
    keeper: &mut Keeper,
    corners: &Corners,
    start: State,
    stop: &mut dyn FnMut() -> bool,
) -> Option<Result<Stopping, TimingError>> {
    let leads = Leads::new(keeper, corners, start);
    let manner = keeper.manner();
    let motors = keeper.motors();
    let mut ways: Vec<Stopping> = leads
        .all()
        .into_iter()
        .filter_map(|begun| begun.stopping(&motors, &manner).ok())
        .collect();
    ways.sort_by_key(|way| way.trajectory.duration_ns());
    let tried = ways.len();
    for way in ways {
        if keeper.keeps(&way.trajectory, way.trajectory.whole(), stop)? {
            return Some(Ok(way));
        }
    }
    let no_start = leads.refused(keeper, tried, stop)?;
    Some(Err(TimingError::NoStart(Box::new(no_start))))
}

/// Ways to begin with a velocity.
struct Leads<'l> {
    motors: Motors<'l>,
    /// The first state, and the same moving on for as long as the controller needs.
    first: Vec<TimedState>,
    rows: Vec<Corner>,
}

impl<'l> Leads<'l> {
    fn new(keeper: &Keeper<'l, '_>, corners: &Corners, start: State) -> Self {
        let ends_ns = keeper.manner().ends_ns;
        let later = start.drifted(ends_ns as f64 / NS);
        let mut first = vec![TimedState::at(0, start)];
        if ends_ns > 0 {
            first.push(TimedState::at(ends_ns, later));
        }
        Self {
            motors: keeper.motors(),
            first,
            rows: corners.rows().to_vec(),
        }
    }

    /// The state that ramps begin with.
    fn state(&self) -> &TimedState {
        &self.first[self.first.len() - 1]
    }

    /// Straight to one of the next waypoints, or to rest wherever that is, and from there on or back.
    fn all(&self) -> Vec<Begun> {
        let mut all = Vec::new();
        for phasing in [Phasing::Common, Phasing::Own] {
            for row in self.waypoints() {
                all.extend(self.to(row, phasing));
            }
            if self.rows.len() > 1 {
                all.push(self.braking(phasing, &self.rows[1..]));
            }
            all.push(self.braking(phasing, &self.rows));
        }
        all
    }

    /// The next waypoints, up to one that must be passed.
    fn waypoints(&self) -> impl Iterator<Item = usize> {
        let after = self.rows.iter().skip(1);
        let free = after.take_while(|row| !row.is_fixed).count();
        let last = (free + 1).min(WAYPOINTS);
        1..self.rows.len().min(last + 1)
    }

    /// To rest at a waypoint.
    fn to(&self, row: usize, phasing: Phasing) -> Option<Begun> {
        let state = self.state();
        let rest = State::resting(&self.rows[row].positions);
        let ends = [&state.state, &rest];
        let ramps = self
            .motors
            .ramps(ends, phasing, state.time_ns, i64::MAX)?;
        Some(self.begun(ramps, self.rows[row..].to_vec()))
    }

    /// To rest wherever that is, and on along these.
    fn braking(&self, phasing: Phasing, after: &[Corner]) -> Begun {
        let states = self.braked(phasing);
        let rest = Corner {
            positions: states[states.len() - 1].state.positions.clone(),
            is_fixed: false,
        };
        let mut rows = vec![rest];
        rows.extend_from_slice(after);
        rows.dedup_by(|next, known| next.positions == known.positions);
        self.begun(states, rows)
    }

    fn begun(&self, ramps: Vec<TimedState>, mut rows: Vec<Corner>) -> Begun {
        // The first has been passed already.
        let start = &self.rows[0].positions;
        let again = rows
            .iter_mut()
            .filter(|row| row.positions == *start);
        again.for_each(|row| row.is_fixed = false);
        let mut states = self.led(ramps);
        let last = states.len() - 1;
        states[last].is_fixed = rows[0].is_fixed;
        Begun {
            states,
            corners: Corners::new(rows, self.motors.limits),
        }
    }

    /// All states from the start on, the last of the first ones being the first of these.
    fn led(&self, states: Vec<TimedState>) -> Vec<TimedState> {
        let mut led = self.first.clone();
        led.pop();
        led.extend(states);
        led
    }

    /// All columns to rest at a constant deceleration: together, or each as soon as it can.
    fn braked(&self, phasing: Phasing) -> Vec<TimedState> {
        let brake = Brake::new(&self.state().state, phasing, &self.motors);
        let start_ns = self.state().time_ns;
        let mut changes = brake.ticks.clone();
        changes.push(0);
        changes.sort_unstable();
        changes.dedup();
        let at = |tick: i64| {
            let time_ns = start_ns + tick * self.motors.tick_ns;
            TimedState::at(time_ns, brake.after(tick))
        };
        changes.into_iter().map(at).collect()
    }

    /// What the simplest way hits: straight on to rest, and back.
    fn refused(
        &self,
        keeper: &mut Keeper,
        tried: usize,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<NoStart> {
        let states = self.braked(Phasing::Common);
        let rest = &states[states.len() - 1];
        let robot = keeper.robot();
        let mut refused = NoStart::new(robot, [&self.first[0], rest], tried);
        let lead = Trajectory::new(self.led(states));
        let Ok(written) = keeper.written(&lead, lead.whole()) else {
            return Some(refused);
        };
        refused.leaves_limits(robot, &written.curve);
        match timed::prove(keeper.validator(), &written.curve, true, stop) {
            TimedVerdict::Refused(hit) => refused.hit = Some(hit),
            TimedVerdict::Proved(_) => {}
            TimedVerdict::Stopped => return None,
        }
        Some(refused)
    }
}

/// How columns come to rest, each at a constant deceleration.
struct Brake<'b> {
    state: &'b State,
    /// How long each takes.
    ticks: Vec<i64>,
    tick_s: f64,
}

impl<'b> Brake<'b> {
    fn new(state: &'b State, phasing: Phasing, motors: &Motors) -> Self {
        let tick_s = motors.tick_ns as f64 / NS;
        let columns = state
            .velocities
            .iter()
            .zip(motors.limits.columns());
        let needed = columns.map(|(velocity, limits)| match *velocity == 0.0 {
            true => 0.0,
            false => -velocity / limits.acceleration.towards(-velocity) / tick_s,
        });
        let mut ticks: Vec<i64> = needed
            .map(|ticks| ticks.ceil() as i64)
            .collect();
        let most = ticks.iter().copied().fold(0, i64::max);
        if phasing == Phasing::Common {
            ticks.fill(most);
        }
        Self {
            state,
            ticks,
            tick_s,
        }
    }

    /// The state so many ticks later.
    fn after(&self, tick: i64) -> State {
        let columns = 0..self.ticks.len();
        let (positions, velocities) = columns
            .map(|column| self.column(column, tick))
            .unzip();
        State {
            positions,
            velocities,
        }
    }

    fn column(&self, column: usize, tick: i64) -> (f64, f64) {
        let all = self.ticks[column];
        let gone = tick.min(all);
        let left = (all - gone) as f64 / all.max(1) as f64;
        let velocity = self.state.velocities[column];
        let way = 0.5 * velocity * (1.0 + left) * gone as f64 * self.tick_s;
        (self.state.positions[column] + way, velocity * left)
    }
}
