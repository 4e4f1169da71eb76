//! Contact half-spaces: what keeps two bodies apart near a configuration, to first order.
//!
//! At a configuration the closest points of a pair are a on A and b on B, n the unit vector from b to a, d their
//! distance. The bodies come closer at the rate `j = nᵀ (J_A(a) − J_B(b))`, so that a displacement p of that
//! configuration leaves them `d + j p` apart. Unlike the paper's row this needs no contact, and its normal is true.

use super::rows::add_point_rows;
use crate::collision::{CollisionModel, query};
use crate::robot::{ConfigurationSpace, Kinematics};

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
        Self { model, held, kinematics: Kinematics::default(), jacobian: vec![0.0; space.nv()] }
    }

    /// d and j of a pair at `q`; `None` where the bodies touch or overlap.
    pub fn at(&mut self, pair: usize, q: &[f64]) -> Option<(f64, &[f64])> {
        let (bodies, pair) = (self.model.bodies(), self.model.pairs()[pair]);
        self.kinematics.update(self.model.robot(), q, self.held);
        let (a, b) = (&bodies[pair.a], &bodies[pair.b]);
        let contact = query::nearly_closest(a, &a.placed(&self.kinematics), b, &b.placed(&self.kinematics));
        if contact.distance <= SHORTEST_DISTANCE_M {
            return None;
        }
        self.jacobian.fill(0.0);
        let points = [contact.point_a, contact.point_b];
        add_point_rows(self.model, &self.kinematics, &pair, points, contact.normal, &mut self.jacobian);
        Some((contact.distance, &self.jacobian))
    }
}
