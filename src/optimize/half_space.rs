//! Half-spaces: what keeps a requirement near a configuration, to first order.
//!
//! Of a clearance: at a configuration the closest points of a pair are a on A and b on B, n the unit vector from b
//! to a, d their distance. The bodies come closer at the rate `j = nᵀ (J_A(a) − J_B(b))`, so that a
//! displacement p of that configuration leaves them `d + j p` apart. Unlike the paper's row this
//! needs no contact, and its normal is true.

use super::rows::PartingRate;
use crate::collision::{BodyPair, CollisionModel};
use crate::robot::{ConfigurationSpace, Kinematics};
use crate::solid::query;
use crate::validation::{Contact, Requirement};

/// Bodies closer than this have no direction worth a row (m).
const SHORTEST_DISTANCE_M: f64 = 1e-7;

/// Makes half-spaces; holds the scratch.
#[derive(Debug)]
pub struct HalfSpace<'a> {
    model: &'a CollisionModel,
    held: &'a [f64],
    kinematics: Kinematics,
    /// j, nv numbers, of the last half-space.
    jacobian: Vec<f64>,
}

impl<'a> HalfSpace<'a> {
    /// For one model, with the robot's held variables at `held`.
    pub fn new(model: &'a CollisionModel, space: &ConfigurationSpace, held: &'a [f64]) -> Self {
        Self {
            model,
            held,
            kinematics: Kinematics::default(),
            jacobian: vec![0.0; space.nv()],
        }
    }

    /// The amount d that is kept at `q`, and j; `None` where nothing is.
    pub fn at(&mut self, requirement: Requirement, q: &[f64]) -> Option<(f64, &[f64])> {
        let Requirement::Clearance(pair) = requirement;
        let pair = self.model.pairs()[pair];
        let contact = self.contact(&pair, q);
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

    fn contact(&mut self, pair: &BodyPair, q: &[f64]) -> Contact {
        self.kinematics
            .update(self.model.robot(), q, self.held);
        let a = &self.model.bodies()[pair.a];
        let b = &self.model.bodies()[pair.b];
        // Nearly the closest points will do: any pair of surface points with its own normal is a
        // half-space that holds to first order, and what it leads to is proved anyhow.
        query::nearly_closest(
            &a.solid,
            &a.placed(&self.kinematics),
            &b.solid,
            &b.placed(&self.kinematics),
        )
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
            let mut builder = HalfSpace::new(&model, robot.space(), &held);
            for pair in 0..model.pairs().len() {
                let true_distance = distance(&model, &held, pair, &q);
                let Some((found, row)) = builder.at(Requirement::Clearance(pair), &q) else {
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
