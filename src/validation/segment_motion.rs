//! The bodies of a model as they move along one segment: bounds for all of it, places and velocities at one
//! of its instants.

use super::interval::PairInterval;
use super::motion::{MotionBounds, Twist};
use crate::collision::piece::Transform;
use crate::collision::query;
use crate::collision::{BodyPair, CollisionModel, Contact};
use crate::robot::{ConfigurationSpace, Kinematics};

/// Reusable memory for the motion of all bodies.
#[derive(Debug, Default)]
pub struct SegmentMotion {
    kinematics: Kinematics,
    configuration: Vec<f64>,
    velocity: Vec<f64>,
    bounds: Vec<MotionBounds>,
    placed: Vec<Transform>,
    /// World twists of the links, per unit t.
    twists: Vec<Twist>,
}

impl SegmentMotion {
    /// Sets the segment and bounds the motion of every body on all of it.
    pub fn begin(
        &mut self,
        model: &CollisionModel,
        space: &ConfigurationSpace,
        from: &[f64],
        to: &[f64],
        held: &[f64],
    ) {
        self.configuration.resize(space.nq(), 0.0);
        self.velocity.resize(space.nv(), 0.0);
        self.bounds.resize_with(model.bodies().len(), MotionBounds::default);
        space.difference(to, from, &mut self.velocity);
        for (bounds, body) in self.bounds.iter_mut().zip(model.bodies()) {
            bounds.update(body, from, &self.velocity, held);
        }
    }

    /// Places all bodies, with their velocities, at ratio `t` of the segment that starts at `from`.
    pub fn place(&mut self, model: &CollisionModel, space: &ConfigurationSpace, from: &[f64], t: f64, held: &[f64]) {
        let robot = model.robot();
        space.integrate(from, &self.velocity, t, &mut self.configuration);
        self.kinematics.update(robot, &self.configuration, held);
        self.kinematics.update_velocities(robot, &self.velocity);
        let kinematics = &self.kinematics;
        self.placed.clear();
        self.placed.extend(model.bodies().iter().map(|body| body.placed(kinematics)));
        self.twists.clear();
        self.twists.extend(kinematics.poses().iter().enumerate().map(|(link, pose)| {
            Twist::through(kinematics.angular()[link], kinematics.linear()[link], pose.translation)
        }));
    }

    /// The pair on the interval of this half width about the configuration that was placed last.
    pub fn pair_interval<'a>(
        &self,
        model: &'a CollisionModel,
        pair: &BodyPair,
        half: f64,
        floor: f64,
    ) -> PairInterval<'a> {
        let &BodyPair { a, b, ancestor, .. } = pair;
        let (body_a, body_b) = (&model.bodies()[a], &model.bodies()[b]);
        let carrier = ancestor.map_or(Twist::default(), |link| self.twists[link]);
        let twist = |link: Option<usize>| match link {
            Some(link) => self.twists[link].relative_to(&carrier).scaled(half),
            None => Twist::default(),
        };
        let (placed_a, placed_b) = (&self.placed[a], &self.placed[b]);
        let (bend, travel) = self.bend_and_travel(pair, half);
        PairInterval {
            a: body_a,
            b: body_b,
            relative: placed_b.inverse_of(placed_a),
            twist_a: twist(body_a.link).seen_from(placed_b),
            twist_b: twist(body_b.link).seen_from(placed_b),
            bend,
            travel,
            floor,
        }
    }

    /// ½h²(A_A + A_B) and h(V_A + V_B) of a pair.
    fn bend_and_travel(&self, pair: &BodyPair, half: f64) -> (f64, f64) {
        let (a, b, [above_a, above_b]) = (&self.bounds[pair.a], &self.bounds[pair.b], pair.motions_above);
        let bend = 0.5 * half * half * (a.acceleration(above_a) + b.acceleration(above_b));
        (bend, half * (a.speed(above_a) + b.speed(above_b)))
    }

    /// Closest points of a pair where the bodies were placed last, exact, in the world.
    pub fn contact(&self, model: &CollisionModel, pair: &BodyPair) -> Contact {
        let (placed, bodies) = (&self.placed, model.bodies());
        query::closest(&bodies[pair.a], &placed[pair.a], &bodies[pair.b], &placed[pair.b])
    }
}
