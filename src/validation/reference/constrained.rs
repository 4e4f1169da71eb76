//! What a certificate claims of constraints, by the plainest means: a vector that is d deep in a convex
//! region and no faster than V stays in it for d / V.

use super::course::{Course, Interval};
use super::{Effort, Objection, Shortfall, check_count, check_range};
use crate::collision::CollisionModel;
use crate::constraint::{self, Constraint, Held, Stand, Vector, Watched};
use crate::robot::Kinematics;
use crate::validation::{Certificate, NamedRequirement, RequirementKind};

/// How far below its claim a constraint may be proved, in tolerances.
const SLACK: f64 = 1e-3;
/// What rounding may take from a number that is left (rad or m).
const ROUNDING: f64 = 1e-9;
/// Halvings after which an interval is too thin to say anything.
const DEEPEST: u32 = 40;

/// The constraints of a certificate, and what is claimed of them.
pub(super) struct Constrained<'a> {
    model: &'a CollisionModel,
    held: &'a [f64],
    constraints: Vec<Constraint>,
    left: &'a [Vec<f64>],
    kinematics: Kinematics,
}

/// What is to be shown of one constraint on a segment.
struct Task<'c> {
    constraint: &'c Constraint,
    claimed: f64,
    /// The regions less what is claimed to be left, but for the slack.
    narrowed: Held,
}

/// A segment.
struct Way<'s> {
    index: usize,
    course: Course<'s>,
}

impl<'a> Constrained<'a> {
    pub(super) fn new(
        model: &'a CollisionModel,
        held: &'a [f64],
        certificate: &'a Certificate,
    ) -> Result<Self, Objection> {
        let mut read = Self {
            model,
            held,
            constraints: Vec::new(),
            left: &[],
            kinematics: Kinematics::default(),
        };
        if let Some(claims) = &certificate.constraints {
            read.constraints =
                constraint::constraints(&claims.asked, model.robot(), model.scene())?;
            read.left = &claims.left;
            let segments = certificate.segments.len();
            check_count("claims of constraints", read.left.len(), segments)?;
        }
        read.check_names(certificate)?;
        read.check_claims(certificate)?;
        Ok(read)
    }

    /// Every tolerance that is raised is that of a constraint.
    fn check_names(&self, certificate: &Certificate) -> Result<(), Objection> {
        let names: Vec<NamedRequirement> = self
            .constraints
            .iter()
            .map(NamedRequirement::constraint)
            .collect();
        let raised = certificate
            .lowered
            .iter()
            .filter(|lowered| lowered.requirement.kind != RequirementKind::Clearance);
        for lowered in raised {
            if !names.contains(&lowered.requirement) {
                return Err(Objection::NotRequired(lowered.requirement.clone()));
            }
        }
        Ok(())
    }

    /// No claim is below what the tolerance is raised to.
    fn check_claims(&self, certificate: &Certificate) -> Result<(), Objection> {
        for (segment, left) in self.left.iter().enumerate() {
            let count = self.constraints.len();
            check_count("constraints in a claim", left.len(), count)?;
            for (constraint, &left) in self.constraints.iter().zip(left) {
                let floor = floor(certificate, constraint);
                let what = format!("what segment {} leaves of {}", segment + 1, constraint.name);
                check_range(what, left, floor..=f64::MAX)?;
            }
        }
        Ok(())
    }

    /// Shows that a segment leaves what is claimed of every constraint.
    pub(super) fn verify(
        &mut self,
        index: usize,
        course: Course,
        effort: &mut Effort,
        stop: &mut dyn FnMut() -> bool,
    ) -> Result<(), Objection> {
        if self.constraints.is_empty() {
            return Ok(());
        }
        let way = Way { index, course };
        let constraints = std::mem::take(&mut self.constraints);
        let verified = constraints
            .iter()
            .zip(&self.left[index])
            .try_for_each(|(constraint, &claimed)| {
                let task = task(constraint, claimed);
                let speed = self.speed(&way, &constraint.held.watched, Interval::WHOLE);
                self.bisect(&way, &task, speed, Interval::WHOLE, effort, stop)
            });
        self.constraints = constraints;
        verified
    }

    /// V: how fast what is watched is at most on an interval, per unit t.
    fn speed(&self, way: &Way, watched: &Watched, interval: Interval) -> f64 {
        let [link, sees] = [watched.link(), watched.seen_from()];
        let speeds = way.course.speeds(interval);
        if let Vector::Joint(joint) = watched.vector() {
            return (joint.factor * speeds[joint.coordinate]).abs();
        }
        let (travel, place) = way
            .course
            .travel(self.model.robot(), self.held, interval);
        match watched.vector() {
            Vector::Point(point) => {
                let own = travel.speed(link, None, point.length());
                let origin = travel.speed(sees, None, 0.0);
                let arm = |at: &Kinematics| {
                    let eye = sees.map_or(watched.seen(at), |link| at.poses()[link].translation);
                    watched.seen(at).distance(eye)
                };
                // From there to anywhere it gets no farther than both move.
                let reach = arm(&place) + own + origin;
                own + travel.speed(sees, None, reach)
            }
            Vector::Direction(_) | Vector::Joint(_) => travel.turning(link) + travel.turning(sees),
        }
    }

    fn stand(&mut self, way: &Way, t: f64) -> Vec<f64> {
        let configuration = way.course.at(t);
        self.kinematics
            .update(self.model.robot(), &configuration, self.held);
        configuration
    }

    /// Proves a constraint on an interval on which what is watched is no faster than this, if need be
    /// on its halves.
    fn bisect(
        &mut self,
        way: &Way,
        task: &Task,
        speed: f64,
        interval: Interval,
        effort: &mut Effort,
        stop: &mut dyn FnMut() -> bool,
    ) -> Result<(), Objection> {
        if stop() {
            return Err(Objection::Stopped);
        }
        effort.intervals += 1;
        let configuration = self.stand(way, interval.middle);
        let held = &task.constraint.held;
        let at = held.watched.at(&Stand {
            kinematics: &self.kinematics,
            configuration: &configuration,
            velocity: &[],
        });
        let left = held.left(at);
        let shortfall = || Shortfall {
            segment: way.index,
            t: interval.middle,
            requirement: NamedRequirement::constraint(task.constraint),
            amount: left,
            claimed: task.claimed,
        };
        if left < task.claimed - ROUNDING {
            return Err(Objection::Less(shortfall()));
        }
        if task.narrowed.depth(at) >= speed * interval.half {
            return Ok(());
        }
        if interval.depth == DEEPEST {
            return Err(Objection::NotProved(shortfall()));
        }
        for half in interval.halves() {
            let speed = match way.course.is_curved() {
                true => self.speed(way, &held.watched, half),
                false => speed,
            };
            self.bisect(way, task, speed, half, effort, stop)?;
        }
        Ok(())
    }
}

fn task(constraint: &Constraint, claimed: f64) -> Task<'_> {
    let held = &constraint.held;
    let slack = SLACK * held.tolerance().min(1.0);
    Task {
        constraint,
        claimed,
        narrowed: held.widened(slack - claimed),
    }
}

/// The least that may be left of a constraint: nothing, or what its tolerance is raised by.
fn floor(certificate: &Certificate, constraint: &Constraint) -> f64 {
    let named = NamedRequirement::constraint(constraint);
    let own = certificate
        .lowered
        .iter()
        .filter(|lowered| lowered.requirement == named);
    own.map(|lowered| lowered.floor)
        .fold(0.0, f64::min)
}
