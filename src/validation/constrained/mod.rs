//! What constraints keep on a segment: the theorem of [`crate::constraint`], with the acceleration that
//! [`motion`](super::motion) bounds.
//!
//! An interval is proved where the theorem says so of every constraint that is open there. Where one
//! is violated in the middle, the segment is refused; else the interval is halved, and its halves look
//! only at what is open.

mod claim;
mod ends;
pub mod kept;
mod least;
mod search;
#[cfg(test)]
mod tests;
mod validator;

use ends::Ends;
pub(super) use search::{Search, Violation};

use super::motion::{Course, MotionBounds};
use super::polynomial::Polynomial;
use super::requirement::Measure;
use super::way::{Expansion, Way};
use crate::collision::CollisionModel;
use crate::constraint::{Constraint, Held, Stand, Vector, Watched};
use crate::robot::{ConfigurationSpace, Kinematics};

/// What rounding may take from a depth (m, or rad): some thousand times the last bit of a few metres.
const ROUNDING: f64 = 1e-12;

/// No tolerance is raised by more than this many of itself.
const MOST_RAISE: f64 = 1.0;
/// Least raise of a tolerance, in tolerances: what is only just kept is proved in no time.
const LEAST_RAISE: f64 = 1e-3;

/// Depth that a vector keeps in one of its regions on the interval of this half width about where
/// the robot stands, at the velocity that it has there; `bounds` are of its chain on the segment, or on
/// an interval of a curve that has this one in it.
pub(super) fn kept(held: &Held, stand: &Stand, bounds: &MotionBounds, half: f64) -> f64 {
    let at = held.watched.at(stand);
    let way = held.watched.rate(stand) * half;
    let bend = 0.5 * half * half * bounds.acceleration(0);
    held.kept([at - way, at + way], bend + rounding(&held.watched, stand))
}

/// What rounding may take from a depth.
fn rounding(watched: &Watched, stand: &Stand) -> f64 {
    match watched.vector() {
        // It is what its column says: what is only just kept is kept.
        Vector::Joint(_) => -ROUNDING,
        Vector::Direction(_) => ROUNDING,
        // Last bits are those of where it is in the world.
        Vector::Point(_) => ROUNDING * (1.0 + watched.seen(stand.kinematics).length()),
    }
}

/// Bounds how what is watched moves.
fn bound(bounds: &mut MotionBounds, watched: &Watched, course: &Course, held: &[f64]) {
    match watched.vector() {
        Vector::Joint(joint) => {
            bounds.accelerate(joint.factor.abs() * course.acceleration_of(joint.coordinate));
        }
        Vector::Point(_) | Vector::Direction(_) => bounds.update(watched.chain(), course, held),
    }
}

/// A robot on a segment.
#[derive(Debug)]
struct Standing<'a> {
    model: &'a CollisionModel,
    space: &'a ConfigurationSpace,
    held: &'a [f64],
    kinematics: Kinematics,
    configuration: Vec<f64>,
    velocity: Vec<f64>,
    /// On a curve.
    expansion: Expansion,
}

impl Standing<'_> {
    /// Sets out from one configuration to another.
    fn set_out(&mut self, [from, to]: [&[f64]; 2]) {
        self.configuration.resize(self.space.nq(), 0.0);
        self.velocity.resize(self.space.nv(), 0.0);
        self.space
            .difference(to, from, &mut self.velocity);
    }

    /// Stands at a ratio of the segment that begins at `from`.
    fn stand(&mut self, from: &[f64], t: f64) {
        self.space
            .integrate(from, &self.velocity, t, &mut self.configuration);
        self.place();
    }

    /// Stands in the middle of an interval of a curve.
    fn follow(&mut self, columns: &[Polynomial], middle: f64, half: f64) {
        self.expansion
            .update(self.space, columns, middle, half);
        self.configuration
            .clone_from(&self.expansion.middle);
        self.velocity
            .clone_from(&self.expansion.velocity);
        self.place();
    }

    fn place(&mut self) {
        let robot = self.model.robot();
        self.kinematics
            .update(robot, &self.configuration, self.held);
        self.kinematics
            .update_velocities(robot, &self.velocity);
    }

    fn seen(&self) -> Stand<'_> {
        Stand {
            kinematics: &self.kinematics,
            configuration: &self.configuration,
            velocity: &self.velocity,
        }
    }
}

/// The constraints of a request, with the tolerances that its input forced up.
#[derive(Debug)]
pub(super) struct Constrained<'a> {
    constraints: &'a [Constraint],
    /// What is proved of each: its tolerance may be raised.
    allowed: Vec<Held>,
    /// By how much each is.
    raises: Vec<f64>,
    standing: Standing<'a>,
    bounds: Vec<MotionBounds>,
    ends: Ends,
    /// Intervals that were looked at.
    pub(super) looks: u64,
}

impl<'a> Constrained<'a> {
    /// Of no constraint.
    pub(super) fn none(
        model: &'a CollisionModel,
        space: &'a ConfigurationSpace,
        held: &'a [f64],
    ) -> Self {
        Self {
            constraints: &[],
            allowed: Vec::new(),
            raises: Vec::new(),
            standing: Standing {
                model,
                space,
                held,
                kinematics: Kinematics::default(),
                configuration: Vec::new(),
                velocity: Vec::new(),
                expansion: Expansion::default(),
            },
            bounds: Vec::new(),
            ends: Ends::default(),
            looks: 0,
        }
    }

    /// Of these, with the tolerances asked for.
    pub(super) fn of(self, constraints: &'a [Constraint]) -> Self {
        let held = constraints.iter();
        Self {
            constraints,
            allowed: held
                .map(|constraint| constraint.held.clone())
                .collect(),
            raises: vec![0.0; constraints.len()],
            ..self
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.constraints.is_empty()
    }

    pub(super) fn constraints(&self) -> &'a [Constraint] {
        self.constraints
    }

    /// What is proved of each constraint.
    pub(super) fn allowed(&self) -> &[Held] {
        &self.allowed
    }

    /// Raises the tolerance of one to this much above what is asked.
    pub(super) fn raise(&mut self, index: usize, by: f64) {
        self.raises[index] = by;
        self.allowed[index] = self.constraints[index].held.widened(by);
    }

    /// The next raise of a tolerance, after `present`, at which what is left of it this much may be
    /// proved; `None` beyond the most.
    pub(super) fn next_raise(&self, index: usize, present: f64, left: f64) -> Option<f64> {
        let held = &self.constraints[index].held;
        let tolerance = held.tolerance();
        let wanted = (LEAST_RAISE * tolerance).max(-1.05 * left);
        let raise = wanted.max(2.0 * present);
        let may =
            raise.is_finite() && raise <= MOST_RAISE * tolerance && held.widened(raise).is_convex();
        may.then_some(raise)
    }

    /// How a constraint stands at a configuration: what is left of the tolerance that is asked.
    pub(super) fn measure(&mut self, index: usize, configuration: &[f64]) -> Measure {
        self.standing
            .set_out([configuration, configuration]);
        self.standing.stand(configuration, 0.0);
        let held = &self.constraints[index].held;
        let stand = self.standing.seen();
        let at = held.watched.at(&stand);
        let (_, outward) = held.beside(held.side(at), at);
        let point = held.watched.seen(stand.kinematics);
        Measure {
            amount: held.left(at),
            points: [point, point],
            normal: -held.watched.in_world(stand.kinematics, outward),
        }
    }
}
