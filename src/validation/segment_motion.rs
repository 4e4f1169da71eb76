//! The bodies of a model as they move along one segment: bounds for all of it (of a curve, for one of its
//! intervals), places and velocities at one of its instants.

use super::interval::PairInterval;
use super::motion::{Course, MotionBounds, Twist};
use super::way::Expansion;
use crate::collision::{Body, BodyPair, CollisionModel};
use crate::math::{Pose, Vec3};
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
        space.difference(to, from, &mut self.velocity);
        let course = Course::Straight {
            from,
            velocity: &self.velocity,
        };
        bound_bodies(&mut self.bounds, model, &course, held);
    }

    /// Stands all bodies, with their velocities, in the middle of an interval of a curve, and bounds
    /// their motion on it.
    pub fn follow(&mut self, model: &CollisionModel, expansion: &Expansion, held: &[f64]) {
        self.configuration.clone_from(&expansion.middle);
        self.velocity.clone_from(&expansion.velocity);
        bound_bodies(&mut self.bounds, model, &Course::Curved(expansion), held);
        self.place_bodies(model, held);
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
        space.integrate(from, &self.velocity, t, &mut self.configuration);
        self.place_bodies(model, held);
    }

    fn place_bodies(&mut self, model: &CollisionModel, held: &[f64]) {
        let robot = model.robot();
        self.kinematics
            .update(robot, &self.configuration, held);
        self.kinematics
            .update_velocities(robot, &self.velocity);
        let bodies = model.carried_bodies().iter();
        self.placed.clear();
        self.placed
            .extend(bodies.map(|body| body.placed(&self.kinematics)));
        self.update_twists();
    }

    fn update_twists(&mut self) {
        let kinematics = &self.kinematics;
        let twist = |(link, pose): (usize, &Pose)| {
            let angular = kinematics.angular()[link];
            Twist::through(angular, kinematics.linear()[link], pose.translation)
        };
        self.twists.clear();
        self.twists
            .extend(kinematics.poses().iter().enumerate().map(twist));
    }

    /// The pair on the interval of this half width about the configuration that was placed last.
    pub fn pair_interval<'a>(
        &self,
        model: &'a CollisionModel,
        pair: &BodyPair,
        half: f64,
        floor: f64,
    ) -> PairInterval<'a> {
        let a = &model.bodies()[pair.a];
        let b = &model.bodies()[pair.b];
        let (bend, travel) = self.bend_and_travel(pair, half);
        let placed_b = self.placed(model, pair.b);
        PairInterval {
            a,
            b,
            relative: placed_b.inverse_of(self.placed(model, pair.a)),
            twist_a: self
                .half_twist(a, pair, half)
                .seen_from(placed_b),
            twist_b: self
                .half_twist(b, pair, half)
                .seen_from(placed_b),
            bend,
            travel,
            floor,
            // A proof needs half a floor for what the bodies move: nearer it would be split without end.
            too_close: 1.5 * floor,
        }
    }

    /// Half displacement of a body of a pair, relative to their common ancestor: what carries both
    /// parts nothing.
    fn half_twist(&self, body: &Body, pair: &BodyPair, half: f64) -> Twist {
        let carrier = self.twist(pair.ancestor);
        let own = body.link.map(|_| self.twist(body.link));
        own.map_or(Twist::default(), |own| {
            own.relative_to(&carrier).scaled(half)
        })
    }

    /// Of a link in the world, which stands still itself.
    fn twist(&self, link: Option<usize>) -> Twist {
        link.map_or(Twist::default(), |link| self.twists[link])
    }

    fn placed<'a>(&'a self, model: &'a CollisionModel, body: usize) -> &'a Transform {
        self.placed
            .get(body)
            .unwrap_or(&model.bodies()[body].place)
    }

    /// ½h²(A_A + A_B) and h(V_A + V_B) of a pair.
    fn bend_and_travel(&self, pair: &BodyPair, half: f64) -> (f64, f64) {
        let a = self.bounds_of(pair.a, pair.motions_above[0]);
        let b = self.bounds_of(pair.b, pair.motions_above[1]);
        (0.5 * half * half * (a.0 + b.0), half * (a.1 + b.1))
    }

    /// A and V of a body, none for what stands still.
    fn bounds_of(&self, body: usize, motions_above: usize) -> (f64, f64) {
        self.bounds
            .get(body)
            .map_or((0.0, 0.0), |bounds| {
                (
                    bounds.acceleration(motions_above),
                    bounds.speed(motions_above),
                )
            })
    }

    /// Speed at which the bodies of a pair approach each other at most on the segment (m per unit
    /// t).
    pub fn speed(&self, pair: &BodyPair) -> f64 {
        self.bend_and_travel(pair, 1.0).1
    }

    /// Closest points of a pair where the bodies were placed last, exact, in the world.
    pub fn contact(&self, model: &CollisionModel, pair: &BodyPair) -> Contact {
        let [(a, at_a), (b, at_b)] = self.sides(model, pair);
        query::closest(&a.solid, at_a, &b.solid, at_b)
    }

    /// The bodies of a pair, and where they were placed last.
    fn sides<'s>(
        &'s self,
        model: &'s CollisionModel,
        pair: &BodyPair,
    ) -> [(&'s Body, &'s Transform); 2] {
        [pair.a, pair.b].map(|body| (&model.bodies()[body], self.placed(model, body)))
    }

    /// The same, with the penetration depth of a pair that touches or overlaps.
    pub fn penetration(&self, model: &CollisionModel, pair: &BodyPair) -> Contact {
        let [(a, at_a), (b, at_b)] = self.sides(model, pair);
        penetration(&a.solid, at_a, &b.solid, at_b)
    }

    /// Whether a body of a pair has a part wholly inside a mesh of the other where the bodies were
    /// placed last.
    pub fn is_enclosed(&self, model: &CollisionModel, pair: &BodyPair) -> bool {
        let [(a, at_a), (b, at_b)] = self.sides(model, pair);
        query::enclosed(&a.solid, at_a, &b.solid, at_b).is_some()
    }

    /// Distance of a pair that is apart where the bodies were placed last, at most 1 +
    /// [`query::NEARLY`] times the true one (m).
    pub fn nearly_apart(&self, model: &CollisionModel, pair: &BodyPair) -> f64 {
        let [(a, at_a), (b, at_b)] = self.sides(model, pair);
        query::nearly_closest(&a.solid, at_a, &b.solid, at_b).distance
    }

    /// Closest points of a pair that is apart where the bodies were placed last, exact, in the
    /// world, and the rate at which the distance grows along the segment (m per unit t).
    pub fn apart(&self, model: &CollisionModel, pair: &BodyPair) -> (Contact, f64) {
        let [(a, at_a), (b, at_b)] = self.sides(model, pair);
        let contact = query::between_surfaces(&a.solid, at_a, &b.solid, at_b);
        let apart = self.velocity(a, contact.point_a) - self.velocity(b, contact.point_b);
        (contact, contact.normal.dot(apart))
    }

    /// Velocity of a point of a body, in the world.
    fn velocity(&self, body: &Body, point: Vec3) -> Vec3 {
        body.link
            .map_or(Vec3::ZERO, |link| self.twists[link].at(point))
    }
}

fn bound_bodies(
    all: &mut Vec<MotionBounds>,
    model: &CollisionModel,
    course: &Course,
    held: &[f64],
) {
    let carried = model.carried_bodies();
    all.resize_with(carried.len(), MotionBounds::default);
    for (bounds, body) in all.iter_mut().zip(carried) {
        bounds.update(&body.chain, course, held);
    }
}
