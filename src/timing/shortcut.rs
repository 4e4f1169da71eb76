//! Shortcuts in time: a part of a trajectory is replaced by faster ramps between the states at both its
//! ends (Hauser and Ng-Thow-Hing, 2010), where these are proved. Where a fixed waypoint lies between them
//! the ramps meet there, at the velocity that is fastest of a few.

use fastrand::Rng;

use super::controller::Manner;
use super::keeper::Keeper;
use super::ramp::Phasing;
use super::through::Through;
use super::trajectory::{TimedState, Trajectory, Window};

/// Nanoseconds that most others are a multiple of.
const SPAN_NS: i64 = 100_000;
/// A shortcut is worth its proof if it gains this (ns).
const LEAST_GAIN_NS: i64 = 2 * SPAN_NS;
/// States nearer to each other than this count as one (ns).
const NEAR_NS: i64 = 5 * SPAN_NS;
/// No shorter part is looked at (ns).
const SHORTEST_NS: i64 = 20 * SPAN_NS;
/// Tries that gain little, one after the other, after which there is nothing left.
const PATIENCE: u32 = 150;
/// What they must gain together to be more than little, as a part of the duration.
const LITTLE: f64 = 2e-3;
/// Tries at the most.
const MOST_TRIES: u32 = 2_000;

/// How long the search goes on.
#[derive(Clone, Copy, Debug)]
pub struct Until {
    /// The least duration there can be (ns).
    pub bound_ns: i64,
    /// The count of work at which to give up.
    pub most_work: u64,
}

struct Search<'s, 'k, 'm> {
    keeper: &'s mut Keeper<'k, 'm>,
    manner: Manner,
    trajectory: Trajectory,
    rng: Rng,
}

/// Makes a trajectory faster as long as that pays, and what comes of it; also where `stop` says so.
pub fn shortcut(
    keeper: &mut Keeper,
    trajectory: Trajectory,
    seed: u64,
    until: &Until,
    stop: &mut dyn FnMut() -> bool,
) -> Trajectory {
    let mut search = Search {
        manner: keeper.manner(),
        keeper,
        trajectory,
        rng: Rng::with_seed(seed),
    };
    // Whether anything is done is seen in the trajectory; a stop leaves what there is.
    let _finished = search.run(until, stop);
    search.trajectory
}

impl Search<'_, '_, '_> {
    /// `None` where stopped.
    fn run(&mut self, until: &Until, stop: &mut dyn FnMut() -> bool) -> Option<()> {
        let mut last_ns = self.trajectory.duration_ns();
        let mut idle = 0;
        for number in 0..MOST_TRIES {
            let now_ns = self.trajectory.duration_ns();
            let is_spent = idle >= PATIENCE || self.keeper.work() > until.most_work;
            if now_ns - until.bound_ns <= LEAST_GAIN_NS || is_spent {
                break;
            }
            if (last_ns - now_ns) as f64 > LITTLE * last_ns as f64 {
                last_ns = now_ns;
                idle = 0;
            }
            let window = match number {
                0 => self.inside([0, now_ns]),
                _ => self.window(now_ns),
            };
            idle += u32::from(!self.attempt(window, stop)?);
        }
        Some(())
    }

    /// A part at random: of any size anywhere, or small about a state, where accelerations change.
    fn window(&mut self, end_ns: i64) -> Window {
        let ends = match self.rng.bool() {
            true => [self.rng.i64(0..=end_ns), self.rng.i64(0..=end_ns)],
            false => self.about_a_state(end_ns),
        };
        let snapped = ends.map(|time| {
            let time = time.clamp(0, end_ns);
            let whole = time - time % self.manner.grain_ns;
            self.trajectory.snapped(whole, NEAR_NS)
        });
        self.inside([snapped[0].min(snapped[1]), snapped[0].max(snapped[1])])
    }

    fn about_a_state(&mut self, end_ns: i64) -> Window {
        let states = self.trajectory.states();
        let about = states[self.rng.usize(0..states.len())].time_ns;
        let size = end_ns as f64 * (-5.0 * self.rng.f64()).exp();
        let share = self.rng.f64();
        let from = about - (size * share) as i64;
        [from, from + size as i64]
    }

    /// A window as far as it is not of the parts that both ends must go on for.
    fn inside(&self, window: Window) -> Window {
        let [start_ns, end_ns] = self.trajectory.whole();
        let ends_ns = self.manner.ends_ns;
        window.map(|time| {
            time.max(start_ns + ends_ns)
                .min(end_ns - ends_ns)
        })
    }

    /// Whether a part is replaced by a faster one; `None` where stopped.
    fn attempt(&mut self, window: Window, stop: &mut dyn FnMut() -> bool) -> Option<bool> {
        if stop() {
            return None;
        }
        let through = Through::new(&self.trajectory, window, &self.manner, &mut self.rng);
        let [from_ns, to_ns] = through.window;
        if to_ns - from_ns < SHORTEST_NS {
            return Some(false);
        }
        for phasing in self.phasings() {
            let most_ns = to_ns - from_ns - LEAST_GAIN_NS;
            let motors = self.keeper.motors();
            if let Some(states) = through.ramps(&motors, phasing, most_ns)
                && self.takes(through.window, states, stop)?
            {
                return Some(true);
            }
        }
        Some(false)
    }

    /// Whether other states are proved in the place of a part, which they then take.
    fn takes(
        &mut self,
        window: Window,
        states: Vec<TimedState>,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<bool> {
        let end_ns = states
            .last()
            .map_or(window[1], |last| last.time_ns);
        let faster = self.trajectory.spliced(window, states);
        let rest = [end_ns, faster.last().time_ns];
        let shifts = self.manner.shifts && rest[0] < rest[1];
        let is_kept = self
            .keeper
            .keeps(&faster, [window[0], end_ns], stop)?
            && (!shifts || self.keeper.keeps(&faster, rest, stop)?);
        if is_kept {
            self.trajectory = faster;
        }
        Some(is_kept)
    }

    /// Both ways to share phases, one of them first.
    fn phasings(&mut self) -> [Phasing; 2] {
        match self.rng.bool() {
            true => [Phasing::Common, Phasing::Own],
            false => [Phasing::Own, Phasing::Common],
        }
    }
}
