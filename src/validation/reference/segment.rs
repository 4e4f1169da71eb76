//! One segment: halved until every pair is proved to keep what is claimed of it.

use super::cover::{Cover, Near, Until, near};
use super::travel::Travel;
use super::{Closeness, Effort, Objection, ROUNDING_M, slack};
use crate::collision::CollisionModel;
use crate::robot::{ConfigurationSpace, Kinematics};
use crate::solid::transform::Transform;

/// Halvings after which an interval is a rounding wide.
const DEEPEST: u32 = 48;

/// A segment of a model's path.
pub struct Segment<'a> {
    /// Its number, from 0.
    index: usize,
    model: &'a CollisionModel,
    covers: &'a [Cover],
    space: &'a ConfigurationSpace,
    held: &'a [f64],
    from: &'a [f64],
    velocity: Vec<f64>,
    kinematics: Kinematics,
    configuration: Vec<f64>,
    /// Where the bodies stand.
    placed: Vec<Transform>,
}

/// A pair and what is to be shown of it on the segment.
#[derive(Clone, Copy, Debug)]
struct Task {
    /// By index.
    pair: usize,
    /// V: no point of one body is faster seen from the other (m per unit t).
    speed: f64,
    /// Distance that it is claimed to keep (m).
    claimed: f64,
    /// How much less may be proved (m).
    slack: f64,
}

/// An interval of the segment.
#[derive(Clone, Copy, Debug)]
struct Interval {
    middle: f64,
    half: f64,
    depth: u32,
}

impl<'a> Segment<'a> {
    /// The straight segment between two configurations.
    pub fn new(
        model: &'a CollisionModel,
        covers: &'a [Cover],
        space: &'a ConfigurationSpace,
        held: &'a [f64],
        index: usize,
        [from, to]: [&'a [f64]; 2],
    ) -> Self {
        let mut velocity = vec![0.0; space.nv()];
        space.difference(to, from, &mut velocity);
        let kinematics = Kinematics::default();
        let configuration = from.to_vec();
        Self {
            index,
            model,
            covers,
            space,
            held,
            from,
            velocity,
            kinematics,
            configuration,
            placed: Vec::new(),
        }
    }

    /// Shows that every pair keeps the larger of its floor and `claim` (m), less its slack.
    pub fn verify(
        &mut self,
        floors: &[f64],
        claim: f64,
        effort: &mut Effort,
        stop: &mut dyn FnMut() -> bool,
    ) -> Result<(), Objection> {
        let tasks = self.tasks(floors, claim);
        self.look_at_ends(&tasks, effort)?;
        self.bisect(
            Interval {
                middle: 0.5,
                half: 0.5,
                depth: 0,
            },
            &tasks,
            effort,
            stop,
        )
    }

    fn tasks(&mut self, floors: &[f64], claim: f64) -> Vec<Task> {
        let ends = [0.0, 1.0].map(|t| {
            self.place(t);
            self.kinematics.clone()
        });
        let travel = Travel::new(self.model.robot(), &self.velocity, [&ends[0], &ends[1]]);
        let speed = |body: usize, ancestor: Option<usize>| {
            travel.speed(
                self.model.bodies()[body].link,
                ancestor,
                self.covers[body].reach,
            )
        };
        let task = |(pair, &floor): (usize, &f64)| {
            let bodies = &self.model.pairs()[pair];
            let speed = speed(bodies.a, bodies.ancestor) + speed(bodies.b, bodies.ancestor);
            Task {
                pair,
                speed,
                claimed: claim.max(floor),
                slack: slack(floor),
            }
        };
        floors.iter().enumerate().map(task).collect()
    }

    /// Puts all bodies where they are at ratio `t`.
    fn place(&mut self, t: f64) {
        self.space
            .integrate(self.from, &self.velocity, t, &mut self.configuration);
        self.kinematics
            .update(self.model.robot(), &self.configuration, self.held);
        self.placed.clear();
        self.placed.extend(
            self.model
                .bodies()
                .iter()
                .map(|body| body.placed(&self.kinematics)),
        );
    }

    /// Pairs are often closest at a waypoint, where no interval has its middle.
    fn look_at_ends(&mut self, tasks: &[Task], effort: &mut Effort) -> Result<(), Objection> {
        for t in [0.0, 1.0] {
            self.place(t);
            for task in tasks {
                self.measure(task, t, task.claimed, Until::Closest, effort)?;
            }
        }
        Ok(())
    }

    /// Proves the pairs on an interval, if need be on its halves.
    fn bisect(
        &mut self,
        interval: Interval,
        tasks: &[Task],
        effort: &mut Effort,
        stop: &mut dyn FnMut() -> bool,
    ) -> Result<(), Objection> {
        if stop() {
            return Err(Objection::Stopped);
        }
        effort.intervals += 1;
        self.place(interval.middle);
        let mut left = Vec::new();
        for task in tasks {
            if !self.is_kept(task, interval, effort)? {
                left.push(*task);
            }
        }
        if left.is_empty() {
            return Ok(());
        }
        let half = interval.half / 2.0;
        let depth = interval.depth + 1;
        for middle in [interval.middle - half, interval.middle + half] {
            self.bisect(
                Interval {
                    middle,
                    half,
                    depth,
                },
                &left,
                effort,
                stop,
            )?;
        }
        Ok(())
    }

    /// Whether the distance in the middle shows that the pair keeps its claim on the whole
    /// interval.
    fn is_kept(
        &self,
        task: &Task,
        interval: Interval,
        effort: &mut Effort,
    ) -> Result<bool, Objection> {
        let travelled = task.speed * interval.half;
        let enough = task.claimed - task.slack + travelled;
        // In a wide interval that is to be halved anyway the closest of all is not worth its
        // search.
        let until = if travelled > task.slack {
            Until::AnyCloser
        } else {
            Until::Closest
        };
        let near = self.measure(
            task,
            interval.middle,
            enough.max(task.claimed),
            until,
            effort,
        )?;
        let is_kept = near.gap >= enough;
        if !is_kept && interval.depth == DEEPEST {
            return Err(Objection::NotProved(self.place_of(
                task,
                interval.middle,
                near.distance,
            )));
        }
        Ok(is_kept)
    }

    /// Distance of a pair where the bodies stand, as far as it is less than `within`; an error
    /// where it is less than claimed.
    fn measure(
        &self,
        task: &Task,
        t: f64,
        within: f64,
        until: Until,
        effort: &mut Effort,
    ) -> Result<Near, Objection> {
        effort.distances += 1;
        let pair = &self.model.pairs()[task.pair];
        let relative = self.placed[pair.b].inverse_of(&self.placed[pair.a]);
        let near = near(
            &self.covers[pair.a],
            &self.covers[pair.b],
            &relative,
            within,
            until,
        );
        if near.distance < task.claimed - ROUNDING_M {
            return Err(Objection::Closer(self.place_of(task, t, near.distance)));
        }
        Ok(near)
    }

    fn place_of(&self, task: &Task, t: f64, distance_m: f64) -> Closeness {
        let bodies = self.model.pair_names(task.pair);
        Closeness {
            segment: self.index,
            t,
            bodies,
            distance_m,
            claimed_m: task.claimed,
        }
    }
}
