//! From one state to another by constant accelerations: one column, and all columns together.
//!
//! A ramp has three phases: an acceleration, then constant velocity, then another acceleration. Phases last
//! whole ticks, so that states are passed at whole nanoseconds and never nearer to each other than
//! the arithmetic of a controller can tell. Where the phases are known the ramp is: with T the time, τ₁
//! and τ₂ the first and the last phase, the velocity between them is
//! (Δx − ½ v₀ τ₁ − ½ v₁ τ₂) / (T − ½ τ₁ − ½ τ₂).

use super::limits::{ColumnLimits, Limits};
use super::trajectory::{NS, State, TimedState};

/// What rounding may exceed a limit by, as a part of it.
const ROUNDING: f64 = 1e-9;
/// Durations that are tried where the shortest is not feasible: what a column can do in a time it may
/// not be able to do in a little more.
const TRIES: u32 = 12;
/// Steps of the search for the acceleration that is least.
const STEPS: u32 = 32;
/// Changes of a column's phases that are tried.
const NUDGES: [Phases; 5] = [[0, 0], [1, -1], [-1, 1], [-1, -1], [1, 1]];

/// Both ends of one column's ramp.
#[derive(Clone, Copy, Debug)]
pub struct Ends {
    /// How far it goes (m or rad).
    pub way: f64,
    /// Velocity where it begins, and where it ends.
    pub velocities: [f64; 2],
}

/// The first and the last phase, in ticks.
type Phases = [i64; 2];

impl Ends {
    fn of(from: &State, to: &State, column: usize) -> Self {
        Self {
            way: to.positions[column] - from.positions[column],
            velocities: [from.velocities[column], to.velocities[column]],
        }
    }

    /// Whether it neither goes nor moves.
    pub fn are_still(&self) -> bool {
        self.way == 0.0 && self.velocities == [0.0; 2]
    }

    /// The least time it takes within limits (s): to the velocity that is reached between, and from it.
    pub fn least_s(&self, limits: &ColumnLimits) -> f64 {
        let [v0, v1] = self.velocities;
        let acceleration = &limits.acceleration;
        let mean = 0.5 * (v0 + v1);
        let direct = mean * (v1 - v0) / acceleration.towards(v1 - v0);
        // Farther than at the same acceleration all the way: first faster, then slower, else first
        // slower.
        let sign = if self.way >= direct { 1.0 } else { -1.0 };
        let [first, last] = [sign, -sign].map(|sign| acceleration.towards(sign));
        // As far as it had come from rest to the first velocity, and would come to rest from the last.
        let before = 0.5 * v0 * v0 / first;
        let after = 0.5 * v1 * v1 / last;
        let square = (self.way + before - after) / (0.5 / first - 0.5 / last);
        let velocity = sign * square.max(0.0).sqrt();
        let limit = limits.velocity.towards(sign);
        if limits.velocity.part(velocity) <= 1.0 {
            return (velocity - v0) / first + (v1 - velocity) / last;
        }
        let ramps = (limit - v0) / first + (v1 - limit) / last;
        let rising = 0.5 * (limit + v0) * (limit - v0) / first;
        let falling = 0.5 * (limit + v1) * (v1 - limit) / last;
        ramps + (self.way - (rising + falling)) / limit
    }
}

/// A ramp of one column that is looked for.
#[derive(Clone, Copy, Debug)]
struct Column<'l> {
    ends: Ends,
    limits: &'l ColumnLimits,
    tick_s: f64,
}

/// A ramp of one column.
#[derive(Clone, Copy, Debug)]
struct Ramp {
    phases: Phases,
    /// The velocity between them.
    velocity: f64,
}

impl Column<'_> {
    fn seconds(&self, ticks: i64) -> f64 {
        ticks as f64 * self.tick_s
    }

    /// The velocity between phases of a ramp of so many ticks.
    fn velocity_between(&self, [first, last]: Phases, ticks: i64) -> f64 {
        let [v0, v1] = self.ends.velocities;
        let first = self.seconds(first);
        let last = self.seconds(last);
        let ends = 0.5 * (v0 * first + v1 * last);
        let between = self.seconds(ticks) - 0.5 * (first + last);
        (self.ends.way - ends) / between
    }

    /// The ramp with these phases, if it is within limits.
    fn with_phases(&self, phases: Phases, ticks: i64) -> Option<Ramp> {
        let velocity = self.velocity_between(phases, ticks);
        let [v0, v1] = self.ends.velocities;
        let [first, last] = phases.map(|ticks| self.seconds(ticks));
        let acceleration = &self.limits.acceleration;
        let parts = [
            self.limits.velocity.part(velocity),
            acceleration.part((velocity - v0) / first),
            acceleration.part((v1 - velocity) / last),
        ];
        let is_within = parts.iter().all(|part| *part <= 1.0 + ROUNDING);
        is_within.then_some(Ramp { phases, velocity })
    }

    /// The gentlest ramp of so many ticks that is found, if one is within limits.
    fn gentlest(&self, ticks: i64) -> Option<Ramp> {
        let [first, last] = self.phases(ticks)?;
        let nudged = NUDGES.map(|[earlier, later]| [first + earlier, last + later]);
        let is_whole = |phases: &Phases| {
            let [first, last] = *phases;
            first >= 1 && last >= 1 && first + last <= ticks
        };
        nudged
            .into_iter()
            .filter(is_whole)
            .find_map(|phases| self.with_phases(phases, ticks))
    }

    /// Two phases that fill the time, or where the velocity between them is beyond its limit three.
    fn phases(&self, ticks: i64) -> Option<Phases> {
        let phases = self.without_coasting(ticks);
        let velocity = self.velocity_between(phases, ticks);
        let limit = &self.limits.velocity;
        match limit.part(velocity) <= 1.0 {
            true => Some(phases),
            false => self.coasting(ticks, limit.towards(velocity)),
        }
    }

    /// Two phases that fill the time and whose larger part of an acceleration limit is least.
    ///
    /// With Δv = v₁ − v₀ and C = 2 (Δx − v₀ T) − Δv T the accelerations are (Δv + C / τ₁) / T and
    /// (Δv − C / τ₂) / T. Each part falls and rises once with τ₁, and so does the larger of both.
    fn without_coasting(&self, ticks: i64) -> Phases {
        let [v0, v1] = self.ends.velocities;
        let time = self.seconds(ticks);
        let change = v1 - v0;
        let excess = 2.0 * (self.ends.way - v0 * time) - change * time;
        let limit = &self.limits.acceleration;
        let part = |first: f64| {
            let accelerations = [change + excess / first, change - excess / (time - first)];
            let parts = accelerations.map(|sum| limit.part(sum / time));
            parts[0].max(parts[1])
        };
        let first = (least(part, [0.0, time]) / self.tick_s).round();
        let first = (first as i64).clamp(1, ticks - 1);
        [first, ticks - first]
    }

    /// Phases about a constant velocity, with the same part of their limits as accelerations.
    fn coasting(&self, ticks: i64, velocity: f64) -> Option<Phases> {
        let [v0, v1] = self.ends.velocities;
        let [first, last] = [velocity - v0, v1 - velocity];
        let limit = |change: f64| self.limits.acceleration.towards(change);
        let gained = 0.5 * first * first / limit(first);
        let lost = 0.5 * last * last / limit(last);
        let missing = velocity * self.seconds(ticks) - self.ends.way;
        let part = (gained - lost) / missing;
        let phase = |change: f64| change / (part * limit(change)) / self.tick_s;
        let phases = [first, last].map(phase);
        let are_some = phases
            .iter()
            .all(|phase| phase.is_finite() && *phase >= 0.0);
        are_some.then(|| phases.map(|phase| (phase.floor() as i64).max(1)))
    }

    /// How far a ramp has come after some of all its ticks, and how fast it is then.
    fn after(&self, ramp: &Ramp, ticks: i64, all: i64) -> [f64; 2] {
        let [v0, v1] = self.ends.velocities;
        let [first, last] = ramp.phases;
        let middle = ramp.velocity;
        if ticks <= first {
            let velocity = v0 + (middle - v0) * ticks as f64 / first as f64;
            return [0.5 * (v0 + velocity) * self.seconds(ticks), velocity];
        }
        if ticks <= all - last {
            let way = 0.5 * (v0 + middle) * self.seconds(first);
            return [way + middle * self.seconds(ticks - first), middle];
        }
        let left = all - ticks;
        let velocity = v1 + (middle - v1) * left as f64 / last as f64;
        let way = 0.5 * (v1 + velocity) * self.seconds(left);
        [self.ends.way - way, velocity]
    }
}

/// Where a function that falls and rises once is least between two places, neither of which counts.
fn least(of: impl Fn(f64) -> f64, [mut from, mut to]: [f64; 2]) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_895;
    let mut places = [to - GOLDEN * (to - from), from + GOLDEN * (to - from)];
    let mut values = places.map(&of);
    for _ in 0..STEPS {
        if values[0] <= values[1] {
            to = places[1];
            places = [to - GOLDEN * (to - from), places[0]];
            values = [of(places[0]), values[0]];
        } else {
            from = places[0];
            places = [places[1], from + GOLDEN * (to - from)];
            values = [values[1], of(places[1])];
        }
    }
    0.5 * (from + to)
}

/// How the columns share the phases of a ramp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phasing {
    /// Those of the slowest column, wherever that is within limits: between states at rest all columns
    /// then go straight.
    Common,
    /// Each column its own, as gentle as can be.
    Own,
}

/// What goes along ramps.
#[derive(Clone, Copy, Debug)]
pub struct Motors<'l> {
    /// What they allow.
    pub limits: &'l Limits,
    /// Phases last a whole number of these (ns).
    pub tick_ns: i64,
}

impl Motors<'_> {
    /// The states of the fastest ramps that are found from one state to another within limits, the first at
    /// `start_ns`; `None` where they take as long as `most_ns`.
    pub fn ramps(
        &self,
        states: [&State; 2],
        phasing: Phasing,
        start_ns: i64,
        most_ns: i64,
    ) -> Option<Vec<TimedState>> {
        let pair = Pair {
            columns: self.columns(states),
            states,
            phasing,
        };
        let (slowest, least_s) = pair.slowest()?;
        let tick_s = self.tick_ns as f64 / NS;
        let mut ticks = ((least_s / tick_s).ceil() as i64).max(2);
        for attempt in 0..TRIES {
            if ticks * self.tick_ns >= most_ns {
                return None;
            }
            if let Some(ramps) = pair.in_ticks(slowest, ticks) {
                let passed = pair.passed(&ramps, ticks).into_iter();
                let at = |(tick, state)| TimedState::at(start_ns + tick * self.tick_ns, state);
                return Some(passed.map(at).collect());
            }
            ticks += 1 + (ticks >> 8) * i64::from(attempt);
        }
        None
    }

    fn columns(&self, [from, to]: [&State; 2]) -> Vec<Column<'_>> {
        let columns = self.limits.columns().iter().enumerate();
        columns
            .map(|(column, limits)| Column {
                ends: Ends::of(from, to, column),
                limits,
                tick_s: self.tick_ns as f64 / NS,
            })
            .collect()
    }
}

/// Two states, and the ramps between them that are looked for.
struct Pair<'s, 'l> {
    states: [&'s State; 2],
    columns: Vec<Column<'l>>,
    phasing: Phasing,
}

impl Pair<'_, '_> {
    /// The column that needs most time, and that time (s); `None` where one can never do it.
    fn slowest(&self) -> Option<(usize, f64)> {
        let mut slowest = (0, 0.0);
        for (number, column) in self.columns.iter().enumerate() {
            if column.ends.are_still() {
                continue;
            }
            let least_s = column.ends.least_s(column.limits);
            if !least_s.is_finite() {
                return None;
            }
            if least_s > slowest.1 {
                slowest = (number, least_s);
            }
        }
        Some(slowest)
    }

    /// A ramp of each column in so many ticks.
    fn in_ticks(&self, slowest: usize, ticks: i64) -> Option<Vec<Ramp>> {
        let lead = self.columns[slowest].gentlest(ticks)?;
        let ramp = |(number, column): (usize, &Column)| {
            let common = column.with_phases(lead.phases, ticks);
            let is_shared = self.phasing == Phasing::Common || number == slowest;
            match common {
                Some(ramp) if is_shared || column.ends.are_still() => Some(ramp),
                common => column.gentlest(ticks).or(common),
            }
        };
        self.columns
            .iter()
            .enumerate()
            .map(ramp)
            .collect()
    }

    /// The states wherever an acceleration changes, by ticks.
    fn passed(&self, ramps: &[Ramp], all: i64) -> Vec<(i64, State)> {
        let phases = ramps.iter().map(|ramp| ramp.phases);
        let changes = phases.flat_map(|[first, last]| [first, all - last]);
        let mut changes: Vec<i64> = changes.collect();
        changes.sort_unstable();
        changes.dedup();
        let [first, last] = self.states.map(State::clone);
        let mut states = vec![(0, first)];
        for ticks in changes {
            states.push((ticks, self.after(ramps, ticks, all)));
        }
        states.push((all, last));
        states
    }

    fn after(&self, ramps: &[Ramp], ticks: i64, all: i64) -> State {
        let ramps = ramps.iter().zip(&self.columns);
        let (ways, velocities): (Vec<f64>, Vec<f64>) = ramps
            .map(|(ramp, column)| column.after(ramp, ticks, all).into())
            .unzip();
        let from = self.states[0].positions.iter();
        State {
            positions: from
                .zip(ways)
                .map(|(from, way)| from + way)
                .collect(),
            velocities,
        }
    }
}
