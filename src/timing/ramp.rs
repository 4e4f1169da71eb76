//! From one state to another by constant accelerations: one column, and all columns together.
//!
//! A ramp has three phases: an acceleration, then constant velocity, then another acceleration. Phases last
//! whole [`TICK_NS`], so that states are passed at whole nanoseconds and never nearer to each other than
//! the arithmetic of a controller can tell. Where the phases are known the ramp is: with T the time, τ₁
//! and τ₂ the first and the last phase, the velocity between them is
//! (Δx − ½ v₀ τ₁ − ½ v₁ τ₂) / (T − ½ τ₁ − ½ τ₂).

use super::limits::{ColumnLimits, Limits};
use super::trajectory::{NS, State, TimedState};

/// Phases last a whole number of these (ns).
pub const TICK_NS: i64 = 100_000;
const TICK_S: f64 = TICK_NS as f64 / NS;
/// What rounding may exceed a limit by, as a part of it.
const ROUNDING: f64 = 1e-9;
/// Durations that are tried where the shortest is not feasible: what a column can do in a time it may
/// not be able to do in a little more.
const TRIES: u32 = 12;
/// Steps of the search for the acceleration that is least.
const STEPS: u32 = 32;

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

/// A ramp of one column.
#[derive(Clone, Copy, Debug)]
struct Ramp {
    phases: Phases,
    /// The velocity between them.
    velocity: f64,
}

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
        let square =
            (self.way + 0.5 * v0 * v0 / first - 0.5 * v1 * v1 / last) / (0.5 / first - 0.5 / last);
        let velocity = sign * square.max(0.0).sqrt();
        let limit = limits.velocity.towards(sign);
        if limits.velocity.part(velocity) <= 1.0 {
            return (velocity - v0) / first + (v1 - velocity) / last;
        }
        let ramps = (limit - v0) / first + (v1 - limit) / last;
        let way =
            0.5 * (limit + v0) * (limit - v0) / first + 0.5 * (limit + v1) * (v1 - limit) / last;
        ramps + (self.way - way) / limit
    }

    /// The velocity between phases of a ramp of so many ticks.
    fn velocity_between(&self, [first, last]: Phases, ticks: i64) -> f64 {
        let [v0, v1] = self.velocities;
        let [first, last, all] = [first, last, ticks].map(|ticks| ticks as f64 * TICK_S);
        (self.way - 0.5 * (v0 * first + v1 * last)) / (all - 0.5 * (first + last))
    }

    /// The ramp with these phases, if it is within limits.
    fn with_phases(&self, phases: Phases, ticks: i64, limits: &ColumnLimits) -> Option<Ramp> {
        let ramp = Ramp {
            phases,
            velocity: self.velocity_between(phases, ticks),
        };
        let [v0, v1] = self.velocities;
        let [first, last] = phases.map(|ticks| ticks as f64 * TICK_S);
        let parts = [
            limits.velocity.part(ramp.velocity),
            limits
                .acceleration
                .part((ramp.velocity - v0) / first),
            limits
                .acceleration
                .part((v1 - ramp.velocity) / last),
        ];
        let is_within = parts.iter().all(|part| *part <= 1.0 + ROUNDING);
        is_within.then_some(ramp)
    }

    /// The gentlest ramp of so many ticks that is found, if one is within limits.
    fn gentlest(&self, ticks: i64, limits: &ColumnLimits) -> Option<Ramp> {
        let phases = self.phases(ticks, limits)?;
        let others = [[0, 0], [1, -1], [-1, 1], [-1, -1], [1, 1]];
        others.iter().find_map(|[first, last]| {
            let phases = [phases[0] + first, phases[1] + last];
            let is_whole = phases.iter().all(|phase| *phase >= 1) && phases[0] + phases[1] <= ticks;
            is_whole
                .then(|| self.with_phases(phases, ticks, limits))
                .flatten()
        })
    }

    /// Two phases that fill the time, or where the velocity between them is beyond its limit three.
    fn phases(&self, ticks: i64, limits: &ColumnLimits) -> Option<Phases> {
        let phases = self.without_coasting(ticks, limits);
        let velocity = self.velocity_between(phases, ticks);
        match limits.velocity.part(velocity) <= 1.0 {
            true => Some(phases),
            false => self.coasting(ticks, limits, limits.velocity.towards(velocity)),
        }
    }

    /// Two phases that fill the time and whose larger part of an acceleration limit is least.
    ///
    /// With Δv = v₁ − v₀ and C = 2 (Δx − v₀ T) − Δv T the accelerations are (Δv + C / τ₁) / T and
    /// (Δv − C / τ₂) / T. Each part falls and rises once with τ₁, and so does the larger of both.
    fn without_coasting(&self, ticks: i64, limits: &ColumnLimits) -> Phases {
        let [v0, v1] = self.velocities;
        let time = ticks as f64 * TICK_S;
        let change = v1 - v0;
        let excess = 2.0 * (self.way - v0 * time) - change * time;
        let part = |first: f64| {
            let accelerations = [change + excess / first, change - excess / (time - first)];
            let parts = accelerations.map(|sum| limits.acceleration.part(sum / time));
            parts[0].max(parts[1])
        };
        let first = least(part, [0.0, time]);
        let first = ((first / TICK_S).round() as i64).clamp(1, ticks - 1);
        [first, ticks - first]
    }

    /// Phases about a constant velocity, with the same part of their limits as accelerations.
    fn coasting(&self, ticks: i64, limits: &ColumnLimits, velocity: f64) -> Option<Phases> {
        let [v0, v1] = self.velocities;
        let time = ticks as f64 * TICK_S;
        let [first, last] = [velocity - v0, v1 - velocity];
        let limit = |change: f64| limits.acceleration.towards(change);
        let gained = 0.5 * first * first / limit(first) - 0.5 * last * last / limit(last);
        let part = gained / (velocity * time - self.way);
        let phases = [first, last].map(|change| change / (part * limit(change)) / TICK_S);
        let are_some = phases
            .iter()
            .all(|phase| phase.is_finite() && *phase >= 0.0);
        are_some.then(|| phases.map(|phase| (phase.floor() as i64).max(1)))
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

impl Ramp {
    /// How far it has come after so many ticks, and how fast it is then.
    fn after(&self, ends: &Ends, ticks: i64, all: i64) -> [f64; 2] {
        let [v0, v1] = ends.velocities;
        let [first, last] = self.phases;
        let seconds = |ticks: i64| ticks as f64 * TICK_S;
        let way_of_first = 0.5 * (v0 + self.velocity) * seconds(first);
        if ticks <= first {
            let velocity = v0 + (self.velocity - v0) * ticks as f64 / first as f64;
            [0.5 * (v0 + velocity) * seconds(ticks), velocity]
        } else if ticks <= all - last {
            [
                way_of_first + self.velocity * seconds(ticks - first),
                self.velocity,
            ]
        } else {
            let left = all - ticks;
            let velocity = v1 + (self.velocity - v1) * left as f64 / last as f64;
            [ends.way - 0.5 * (v1 + velocity) * seconds(left), velocity]
        }
    }
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

/// The states of the fastest ramps that are found from one state to another within limits, the first at
/// `start_ns`; `None` where they take as long as `most_ns`.
pub fn between(
    [from, to]: [&State; 2],
    limits: &Limits,
    phasing: Phasing,
    start_ns: i64,
    most_ns: i64,
) -> Option<Vec<TimedState>> {
    let ends: Vec<Ends> = (0..from.positions.len())
        .map(|column| Ends::of(from, to, column))
        .collect();
    let (slowest, least_s) = slowest(&ends, limits)?;
    let mut ticks = ((least_s / TICK_S).ceil() as i64).max(2);
    for attempt in 0..TRIES {
        if ticks * TICK_NS >= most_ns {
            return None;
        }
        if let Some(ramps) = in_ticks(&ends, limits, phasing, slowest, ticks) {
            return Some(states([from, to], &ends, &ramps, ticks, start_ns));
        }
        ticks += 1 + (ticks >> 8) * i64::from(attempt);
    }
    None
}

/// The column that needs most time, and that time (s); `None` where one can never do it.
fn slowest(ends: &[Ends], limits: &Limits) -> Option<(usize, f64)> {
    let mut slowest = (0, 0.0);
    for (column, (ends, limits)) in ends.iter().zip(limits.columns()).enumerate() {
        if ends.are_still() {
            continue;
        }
        let least_s = ends.least_s(limits);
        if !least_s.is_finite() {
            return None;
        }
        if least_s > slowest.1 {
            slowest = (column, least_s);
        }
    }
    Some(slowest)
}

/// A ramp of each column in so many ticks.
fn in_ticks(
    ends: &[Ends],
    limits: &Limits,
    phasing: Phasing,
    slowest: usize,
    ticks: i64,
) -> Option<Vec<Ramp>> {
    let limits = limits.columns();
    let lead = ends[slowest].gentlest(ticks, &limits[slowest])?;
    let ramp = |column: usize| {
        let common = ends[column].with_phases(lead.phases, ticks, &limits[column]);
        let is_still = ends[column].are_still();
        match common {
            Some(ramp) if phasing == Phasing::Common || is_still || column == slowest => Some(ramp),
            common => ends[column]
                .gentlest(ticks, &limits[column])
                .or(common),
        }
    };
    (0..ends.len()).map(ramp).collect()
}

/// The states wherever an acceleration changes.
fn states(
    [from, to]: [&State; 2],
    ends: &[Ends],
    ramps: &[Ramp],
    ticks: i64,
    start_ns: i64,
) -> Vec<TimedState> {
    let mut changes: Vec<i64> = ramps
        .iter()
        .flat_map(|ramp| [ramp.phases[0], ticks - ramp.phases[1]])
        .collect();
    changes.sort_unstable();
    changes.dedup();
    let time = |ticks: i64| start_ns + ticks * TICK_NS;
    let mut states = vec![TimedState::at(time(0), from.clone())];
    states.extend(changes.into_iter().map(|tick| {
        let [ways, velocities] = [0, 1].map(|what| {
            let all = ramps.iter().zip(ends);
            all.map(|(ramp, ends)| ramp.after(ends, tick, ticks)[what])
                .collect::<Vec<f64>>()
        });
        let positions = from.positions.iter().zip(ways);
        let state = State {
            positions: positions
                .map(|(from, way)| from + way)
                .collect(),
            velocities,
        };
        TimedState::at(time(tick), state)
    }));
    states.push(TimedState::at(time(ticks), to.clone()));
    states
}
