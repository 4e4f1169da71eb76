//! Half-spaces: what keeps a requirement near a configuration, to first order.
//!
//! Of a clearance: at a configuration the closest points of a pair are a on A and b on B, n the unit vector from b
//! to a, d their distance. The bodies come closer at the rate `j = nᵀ (J_A(a) − J_B(b))`, so that a
//! displacement p of that configuration leaves them `d + j p` apart. Unlike the paper's row this
//! needs no contact, and its normal is true.

use super::rows::PartingRate;
use crate::collision::{BodyPair, CollisionModel};
use crate::constraint::{Held, Side, Stand};
use crate::math::Vec3;
use crate::robot::{ConfigurationSpace, Kinematics};
use crate::solid::cover::Ball;
use crate::solid::query;
use crate::validation::{Contact, HOLDING_PART, Requirement};

/// Part of its tolerance that is aimed at of a constraint: what keeps it is proved in few intervals.
const AIMED_PART: f64 = 0.5 * HOLDING_PART;

/// Places of a cloud that are closer to each other than this hold the path as one (m).
const NEIGHBOURHOOD_M: f64 = 0.05;

/// Bodies closer than this have no direction worth a row (m).
const SHORTEST_DISTANCE_M: f64 = 1e-7;

/// What of a requirement a half-space is about: of a constraint a side of its region, of a cloud that stands
/// still what is near a place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Part {
    /// Of a constraint.
    pub side: Side,
    /// Where, in the frame of the cloud (m).
    pub near: Option<Vec3>,
}

impl Part {
    /// Whether two are about the same.
    pub fn is_near(&self, other: &Self) -> bool {
        let places = self.near.zip(other.near);
        self.side == other.side && places.is_none_or(|(a, b)| a.distance(b) < NEIGHBOURHOOD_M)
    }
}

/// Makes half-spaces; holds the scratch.
#[derive(Debug)]
pub struct HalfSpace<'a> {
    model: &'a CollisionModel,
    held: &'a [f64],
    constraints: &'a [Held],
    kinematics: Kinematics,
    /// Where `kinematics` stands.
    stands_at: Vec<f64>,
    /// j, nv numbers, of the last half-space.
    jacobian: Vec<f64>,
}

impl<'a> HalfSpace<'a> {
    /// For one model and what is kept of constraints, with the robot's held variables at `held`.
    pub fn new(
        model: &'a CollisionModel,
        space: &ConfigurationSpace,
        held: &'a [f64],
        constraints: &'a [Held],
    ) -> Self {
        Self {
            model,
            held,
            constraints,
            kinematics: Kinematics::default(),
            stands_at: Vec::new(),
            jacobian: vec![0.0; space.nv()],
        }
    }

    /// The amount d that is kept at `q` of one side of a requirement, and j; `None` where nothing is. Of a
    /// constraint d is the distance to that side of its region.
    pub fn at(&mut self, requirement: Requirement, part: Part, q: &[f64]) -> Option<(f64, &[f64])> {
        match requirement {
            Requirement::Clearance(pair) => self.of_pair(pair, part.near, q),
            Requirement::Constraint(index) => self.of_constraint(index, part.side, q),
        }
    }

    /// The part that least is kept of.
    pub fn part(&mut self, requirement: Requirement, q: &[f64]) -> Part {
        match requirement {
            Requirement::Clearance(pair) => Part {
                near: self.nearest_of_cloud(pair, q),
                ..Part::default()
            },
            Requirement::Constraint(index) => {
                let held = &self.constraints[index];
                Part {
                    side: held.side(self.watch(held, q)),
                    near: None,
                }
            }
        }
    }

    /// Where a cloud that stands still is nearest.
    fn nearest_of_cloud(&mut self, pair: usize, q: &[f64]) -> Option<Vec3> {
        let pair = self.model.pairs()[pair];
        let cloud = &self.model.bodies()[pair.b];
        if cloud.link.is_some() || cloud.solid.tree.cells().is_none() {
            return None;
        }
        let contact = self.contact(&pair, None, q)?;
        Some(cloud.place.inverse_point(contact.point_b))
    }

    /// What a half-space aims at of a constraint.
    pub fn aim(&self, constraint: usize) -> f64 {
        let tolerance = self.constraints[constraint].tolerance();
        if tolerance.is_finite() {
            AIMED_PART * tolerance
        } else {
            0.0
        }
    }

    fn stand(&mut self, q: &[f64]) {
        self.stands_at.clear();
        self.stands_at.extend_from_slice(q);
        self.kinematics
            .update(self.model.robot(), q, self.held);
    }

    /// Where what is watched is.
    fn watch(&mut self, held: &Held, q: &[f64]) -> Vec3 {
        // A side is asked for before the half-space, and both are of the same place.
        if self.stands_at != q {
            self.stand(q);
        }
        held.watched.at(&Stand {
            kinematics: &self.kinematics,
            configuration: q,
            velocity: &[],
        })
    }

    fn of_constraint(&mut self, index: usize, side: Side, q: &[f64]) -> Option<(f64, &[f64])> {
        let held = &self.constraints[index];
        let at = self.watch(held, q);
        let (depth, outward) = held.beside(side, at);
        if depth < 0.0 {
            return None;
        }
        self.jacobian.fill(0.0);
        let robot = self.model.robot();
        held.watched
            .add_row(robot, &self.kinematics, -outward, &mut self.jacobian);
        Some((depth, &self.jacobian))
    }

    fn of_pair(&mut self, pair: usize, near: Option<Vec3>, q: &[f64]) -> Option<(f64, &[f64])> {
        let pair = self.model.pairs()[pair];
        let contact = self.contact(&pair, near, q)?;
        if contact.distance <= SHORTEST_DISTANCE_M {
            return None;
        }
        let points = [contact.point_a, contact.point_b];
        let rate = PartingRate {
            pair,
            points,
            direction: contact.normal,
        };
        self.jacobian.fill(0.0);
        rate.add_row(self.model, &self.kinematics, &mut self.jacobian);
        Some((contact.distance, &self.jacobian))
    }

    fn contact(&mut self, pair: &BodyPair, near: Option<Vec3>, q: &[f64]) -> Option<Contact> {
        self.stand(q);
        let [a, b] = [pair.a, pair.b].map(|body| &self.model.bodies()[body]);
        let [at_a, at_b] = [a, b].map(|body| body.placed(&self.kinematics));
        // Nearly the closest points will do: any pair of surface points with its own normal is a
        // half-space that holds to first order, and what it leads to is proved anyhow.
        match near {
            None => Some(query::nearly_closest(&a.solid, &at_a, &b.solid, &at_b)),
            Some(center) => {
                let radius = NEIGHBOURHOOD_M;
                query::nearly_closest_in(&a.solid, &at_a, &b.solid, &at_b, Ball { center, radius })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::query::NEARLY;
    use crate::testing;
    use proptest::prelude::*;

    /// Rates on both sides of a kink, or that of another part of a mesh, differ by more (m per rad
    /// or m).
    const SMOOTH: f64 = 1e-4;

    /// Exact distance of the surfaces of a pair.
    fn distance(model: &CollisionModel, held: &[f64], pair: usize, q: &[f64]) -> f64 {
        let mut kinematics = Kinematics::default();
        kinematics.update(model.robot(), q, held);
        let pair = model.pairs()[pair];
        let a = &model.bodies()[pair.a];
        let b = &model.bodies()[pair.b];
        query::between_surfaces(
            &a.solid,
            &a.placed(&kinematics),
            &b.solid,
            &b.placed(&kinematics),
        )
        .distance
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(256))]

        #[test]
        fn a_half_space_is_the_true_distance_and_its_rate(seed: u64) {
            let mut rng = fastrand::Rng::with_seed(seed);
            let model = testing::model(&mut rng);
            let (robot, nv) = (model.robot(), model.robot().space().nv());
            let held: Vec<f64> = robot.held().iter().map(|h| h.default).collect();
            let q = testing::configuration(&mut rng, robot);
            let mut builder = HalfSpace::new(&model, robot.space(), &held, &[]);
            for pair in 0..model.pairs().len() {
                let true_distance = distance(&model, &held, pair, &q);
                let Some((found, row)) = builder.at(Requirement::Clearance(pair), Part::default(), &q) else {
                    prop_assert!(true_distance <= 2.0 * SHORTEST_DISTANCE_M, "no half-space {true_distance} m apart");
                    continue;
                };
                prop_assert!(found >= true_distance - 1e-9 && found <= (1.0 + NEARLY) * true_distance + 1e-9);
                // Nearly the closest points may be on another part of a mesh, which parts at its
                // own rate.
                if found > true_distance + 1e-9 || true_distance < 1e-3 {
                    continue;
                }
                for v in 0..nv {
                    let at = |step: f64| {
                        let (mut velocity, mut moved) = (vec![0.0; nv], q.clone());
                        velocity[v] = 1.0;
                        robot.space().integrate(&q, &velocity, step, &mut moved);
                        distance(&model, &held, pair, &moved)
                    };
                    let (left, right) = ((true_distance - at(-1e-6)) / 1e-6, (at(1e-6) - true_distance) / 1e-6);
                    if (left - right).abs() < SMOOTH {
                        let rate = 0.5 * (left + right);
                        prop_assert!((row[v] - rate).abs() < SMOOTH, "coordinate {v}: {} or {rate}", row[v]);
                    }
                }
            }
        }
    }
}
