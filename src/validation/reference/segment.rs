//! One segment: halved until every requirement is proved to keep what is claimed of it.

use std::borrow::Cow;

use super::course::{Course, Interval};
use super::cover::{Cover, Near, Until, near};
use super::travel::Travel;
use super::{Effort, Objection, ROUNDING_M, Required, Shortfall, slack};
use crate::collision::{BodyPair, CollisionModel};
use crate::robot::Kinematics;
use crate::solid::transform::Transform;
use crate::validation::Requirement;

/// Halvings after which an interval is a rounding wide.
const DEEPEST: u32 = 48;

/// A segment of a model's path.
pub struct Segment<'a> {
    /// Its number, from 0.
    index: usize,
    model: &'a CollisionModel,
    covers: &'a [Cover],
    course: Course<'a>,
    held: &'a [f64],
    kinematics: Kinematics,
    /// Where the bodies stand.
    placed: Vec<Transform>,
}

/// A requirement and what is to be shown of it on the segment.
#[derive(Clone, Copy, Debug)]
struct Task {
    requirement: Requirement,
    /// V: what is kept changes no faster (per unit t). Of a clearance, no point of one body is faster
    /// seen from the other.
    speed: f64,
    /// What it is claimed to keep.
    claimed: f64,
    /// How much less may be proved.
    slack: f64,
}

impl<'a> Segment<'a> {
    /// A segment of this course.
    pub fn new(
        model: &'a CollisionModel,
        covers: &'a [Cover],
        held: &'a [f64],
        index: usize,
        course: Course<'a>,
    ) -> Self {
        Self {
            index,
            model,
            covers,
            course,
            held,
            kinematics: Kinematics::default(),
            placed: Vec::new(),
        }
    }

    /// Shows that every requirement keeps the larger of its floor and `claim`, less its slack.
    pub fn verify(
        &mut self,
        required: &[Required],
        claim: f64,
        effort: &mut Effort,
        stop: &mut dyn FnMut() -> bool,
    ) -> Result<(), Objection> {
        let tasks = self.tasks(required, claim);
        self.look_at_ends(&tasks, effort)?;
        self.bisect(Interval::WHOLE, &tasks, effort, stop)
    }

    fn tasks(&self, required: &[Required], claim: f64) -> Vec<Task> {
        let travel = self.travel(Interval::WHOLE);
        let task = |&Required { requirement, floor }: &Required| Task {
            requirement,
            speed: self.speed(&travel, requirement),
            claimed: claim.max(floor),
            slack: slack(floor),
        };
        required.iter().map(task).collect()
    }

    /// How the robot moves on an interval, at most.
    fn travel(&self, interval: Interval) -> Travel<'a> {
        let robot = self.model.robot();
        let (travel, _) = self.course.travel(robot, self.held, interval);
        travel
    }

    /// The tasks with their speeds on an interval: on a straight segment they are what they are on all of
    /// it.
    fn on<'t>(&self, interval: Interval, tasks: &'t [Task]) -> Cow<'t, [Task]> {
        if !self.course.is_curved() {
            return Cow::Borrowed(tasks);
        }
        let travel = self.travel(interval);
        let here = tasks.iter().map(|task| Task {
            speed: self.speed(&travel, task.requirement),
            ..*task
        });
        Cow::Owned(here.collect())
    }

    fn bodies_of(&self, requirement: Requirement) -> &'a BodyPair {
        let pair = requirement.pair();
        &self.model.pairs()[pair]
    }

    /// V of a clearance: each body's, seen from the link that carries both.
    fn speed(&self, travel: &Travel, requirement: Requirement) -> f64 {
        let bodies = self.bodies_of(requirement);
        let speed = |body: usize| {
            let link = self.model.bodies()[body].link;
            travel.speed(link, bodies.ancestor, self.covers[body].reach)
        };
        speed(bodies.a) + speed(bodies.b)
    }

    /// Puts all bodies where they are at ratio `t`.
    fn place(&mut self, t: f64) {
        let configuration = self.course.at(t);
        self.kinematics
            .update(self.model.robot(), &configuration, self.held);
        let bodies = self.model.bodies().iter();
        self.placed.clear();
        self.placed
            .extend(bodies.map(|body| body.placed(&self.kinematics)));
    }

    /// Least is often kept at a waypoint, where no interval has its middle.
    fn look_at_ends(&mut self, tasks: &[Task], effort: &mut Effort) -> Result<(), Objection> {
        for t in [0.0, 1.0] {
            self.place(t);
            self.look(t, tasks, effort)?;
        }
        Ok(())
    }

    /// Looks at all requirements where the bodies stand.
    fn look(&self, t: f64, tasks: &[Task], effort: &mut Effort) -> Result<(), Objection> {
        for task in tasks {
            self.measure(task, t, task.claimed, Until::Closest, effort)?;
        }
        Ok(())
    }

    /// Proves the requirements on an interval, if need be on its halves.
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
        let left = self.not_kept(interval, tasks, effort)?;
        if left.is_empty() {
            return Ok(());
        }
        for half in interval.halves() {
            let tasks = self.on(half, &left);
            self.bisect(half, &tasks, effort, stop)?;
        }
        Ok(())
    }

    /// The requirements that the middle of an interval does not prove on all of it.
    fn not_kept(
        &self,
        interval: Interval,
        tasks: &[Task],
        effort: &mut Effort,
    ) -> Result<Vec<Task>, Objection> {
        let mut left = Vec::new();
        for task in tasks {
            if !self.is_kept(task, interval, effort)? {
                left.push(*task);
            }
        }
        Ok(left)
    }

    /// Whether what is kept in the middle shows that the claim is kept on the whole interval.
    fn is_kept(
        &self,
        task: &Task,
        interval: Interval,
        effort: &mut Effort,
    ) -> Result<bool, Objection> {
        let travelled = task.speed * interval.half;
        let enough = task.claimed - task.slack + travelled;
        // In a wide interval that is to be halved anyway the closest of all is not worth its search.
        let until = match travelled > task.slack {
            true => Until::AnyCloser,
            false => Until::Closest,
        };
        let t = interval.middle;
        let near = self.measure(task, t, enough.max(task.claimed), until, effort)?;
        let is_kept = near.gap >= enough;
        if !is_kept && interval.depth == DEEPEST {
            let place = self.place_of(task, t, near.distance);
            return Err(Objection::NotProved(place));
        }
        Ok(is_kept)
    }

    /// What of a requirement is kept where the bodies stand, as far as it is less than `within`; an
    /// error where it is less than claimed.
    fn measure(
        &self,
        task: &Task,
        t: f64,
        within: f64,
        until: Until,
        effort: &mut Effort,
    ) -> Result<Near, Objection> {
        effort.distances += 1;
        let pair = self.bodies_of(task.requirement);
        let relative = self.placed[pair.b].inverse_of(&self.placed[pair.a]);
        let [a, b] = [pair.a, pair.b].map(|body| &self.covers[body]);
        let near = near(a, b, &relative, within, until);
        match near.distance < task.claimed - ROUNDING_M {
            true => Err(Objection::Less(self.place_of(task, t, near.distance))),
            false => Ok(near),
        }
    }

    fn place_of(&self, task: &Task, t: f64, amount: f64) -> Shortfall {
        Shortfall {
            segment: self.index,
            t,
            requirement: task.requirement.named(self.model, &[]),
            amount,
            claimed: task.claimed,
        }
    }
}
