//! The bodies of a model as they move along one segment: bounds for all of it, places and
//! velocities at one of its instants.

use super::interval::PairInterval;
use super::motion::{MotionBounds, Twist};
use crate::collision::{BodyPair, CollisionModel};
use crate::math::Vec3;
use crate::robot::{ConfigurationSpace, Kinematics};
use crate::solid::Contact;
use crate::solid::penetration::penetration;
use crate::solid::query;
use crate::solid::transform::Transform;

/// Reusable memory for the motion of all bodies.
#[derive(Debug, Default)]
pub struct SegmentMotion {
    kinematics: Kinematics,
    configuration: Vec<f64>,
    velocity: Vec<f64>,
    /// Of the bodies that links carry: obstacles, which may be thousands, stand where they are.
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
        let carried = model.carried_bodies();
        self.bounds
            .resize_with(carried.len(), MotionBounds::default);
        space.difference(to, from, &mut self.velocity);
        for (bounds, body) in self.bounds.iter_mut().zip(carried) {
            bounds.update(body, from, &self.velocity, held);
        }
    }

    /// Places all bodies, with their velocities, at ratio `t` of the segment that starts at `from`.
    pub fn place(
        &mut self,
        model: &CollisionModel,
        space: &ConfigurationSpace,
        from: &[f64],
        t: f64,
        held: &[f64],
    ) {
        let robot = model.robot();
        space.integrate(from, &self.velocity, t, &mut self.configuration);
        self.kinematics.update(robot, &self.configuration, held);
        self.kinematics.update_velocities(robot, &self.velocity);
        let kinematics = &self.kinematics;
        self.placed.clear();
        self.placed.extend(
            model
                .carried_bodies()
                .iter()
                .map(|body| body.placed(kinematics)),
        );
        self.twists.clear();
        self.twists
            .extend(kinematics.poses().iter().enumerate().map(|(link, pose)| {
                Twist::through(
                    kinematics.angular()[link],
                    kinematics.linear()[link],
                    pose.translation,
                )
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
        let body_a = &model.bodies()[a];
        let body_b = &model.bodies()[b];
        let carrier = ancestor.map_or(Twist::default(), |link| self.twists[link]);
        let twist = |link: Option<usize>| match link {
            Some(link) => self.twists[link].relative_to(&carrier).scaled(half),
            None => Twist::default(),
        };
        let placed_a = self.placed(model, a);
        let placed_b = self.placed(model, b);
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
            too_close: 1.5 * floor,
        }
    }

    fn placed<'a>(&'a self, model: &'a CollisionModel, body: usize) -> &'a Transform {
        self.placed.get(body).unwrap_or(&model.bodies()[body].place)
    }

    /// ½h²(A_A + A_B) and h(V_A + V_B) of a pair.
    fn bend_and_travel(&self, pair: &BodyPair, half: f64) -> (f64, f64) {
        let of = |body: usize, above: usize| {
            self.bounds.get(body).map_or((0.0, 0.0), |bounds| {
                (bounds.acceleration(above), bounds.speed(above))
            })
        };
        let a = of(pair.a, pair.motions_above[0]);
        let b = of(pair.b, pair.motions_above[1]);
        (0.5 * half * half * (a.0 + b.0), half * (a.1 + b.1))
    }

    /// Speed at which the bodies of a pair approach each other at most on the segment (m per unit
    /// t).
    pub fn speed(&self, pair: &BodyPair) -> f64 {
        self.bend_and_travel(pair, 1.0).1
    }

    /// Closest points of a pair where the bodies were placed last, exact, in the world.
    pub fn contact(&self, model: &CollisionModel, pair: &BodyPair) -> Contact {
        let [a, b] = [pair.a, pair.b];
        let bodies = model.bodies();
        query::closest(
            &bodies[a].solid,
            self.placed(model, a),
            &bodies[b].solid,
            self.placed(model, b),
        )
    }

    /// The same, with the penetration depth of a pair that touches or overlaps.
    pub fn penetration(&self, model: &CollisionModel, pair: &BodyPair) -> Contact {
        let [a, b] = [pair.a, pair.b];
        let bodies = model.bodies();
        penetration(
            &bodies[a].solid,
            self.placed(model, a),
            &bodies[b].solid,
            self.placed(model, b),
        )
    }

    /// Whether a body of a pair has a part wholly inside a mesh of the other where the bodies were
    /// placed last.
    pub fn is_enclosed(&self, model: &CollisionModel, pair: &BodyPair) -> bool {
        let [(body_a, at_a), (body_b, at_b)] =
            [pair.a, pair.b].map(|body| (&model.bodies()[body].solid, self.placed(model, body)));
        query::enclosed(body_a, at_a, body_b, at_b).is_some()
    }

    /// Distance of a pair that is apart where the bodies were placed last, at most 1 +
    /// [`query::NEARLY`] times the true one (m).
    pub fn nearly_apart(&self, model: &CollisionModel, pair: &BodyPair) -> f64 {
        let [a, b] = [pair.a, pair.b];
        let bodies = model.bodies();
        query::nearly_closest(
            &bodies[a].solid,
            self.placed(model, a),
            &bodies[b].solid,
            self.placed(model, b),
        )
        .distance
    }

    /// Closest points of a pair that is apart where the bodies were placed last, exact, in the
    /// world, and the rate at which the distance grows along the segment (m per unit t).
    pub fn apart(&self, model: &CollisionModel, pair: &BodyPair) -> (Contact, f64) {
        let bodies = model.bodies();
        let [(body_a, at_a), (body_b, at_b)] =
            [pair.a, pair.b].map(|body| (&bodies[body], self.placed(model, body)));
        let contact = query::between_surfaces(&body_a.solid, at_a, &body_b.solid, at_b);
        let velocity = |link: Option<usize>, point| {
            link.map_or(Vec3::ZERO, |link| self.twists[link].at(point))
        };
        let apart = velocity(body_a.link, contact.point_a) - velocity(body_b.link, contact.point_b);
        (contact, contact.normal.dot(apart))
    }
}
