//! Linear rows `J p = b` on the step of a path, each touching at most two neighbouring waypoints.

use super::cost::Cost;
use super::factor::dot;
use crate::collision::{BodyPair, CollisionModel};
use crate::constraint::{Held, Stand};
use crate::math::{Pose, Vec3};
use crate::robot::{ConfigurationSpace, Kinematics};
use crate::validation::{Hit, Requirement};
use std::ops::Range;

/// One row: `jᵀ ((1 − s) p_k + s p_{k+1}) = b`, at ratio s of segment k. Fixed waypoints drop out,
/// their p is 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row<'a> {
    /// Segment k.
    pub segment: usize,
    /// Ratio s on it, in [0, 1].
    pub ratio: f64,
    /// j, nv numbers.
    pub jacobian: &'a [f64],
    /// b.
    pub right_hand_side: f64,
}

impl Row<'_> {
    /// The two waypoints that the row touches, with their spreads 1 − s and s.
    pub fn spread(&self) -> [(usize, f64); 2] {
        [
            (self.segment, 1.0 - self.ratio),
            (self.segment + 1, self.ratio),
        ]
    }

    /// `J p` for the step p of a whole path.
    pub fn of_step(&self, step: &[f64]) -> f64 {
        let part = |(waypoint, spread)| self.of_waypoint(waypoint, spread, step);
        self.spread().into_iter().map(part).sum()
    }

    fn of_waypoint(&self, waypoint: usize, spread: f64, step: &[f64]) -> f64 {
        // A row at a waypoint itself may be the last one's, which has no successor.
        if spread == 0.0 {
            return 0.0;
        }
        spread * dot(self.jacobian, &step[self.coordinates(waypoint)])
    }

    /// Where a waypoint's numbers lie among those of a whole path.
    fn coordinates(&self, waypoint: usize) -> Range<usize> {
        let nv = self.jacobian.len();
        waypoint * nv..(waypoint + 1) * nv
    }

    /// `J_a H⁻¹ J_bᵀ`: T⁻¹ interpolated between the nodes of the two rows, times `j_a W⁻² j_bᵀ`.
    pub fn coupling(&self, other: &Row<'_>, cost: &Cost<'_>) -> f64 {
        let compliance = self.compliance(other, cost);
        // Rows on different strings do not feel each other.
        if compliance == 0.0 {
            return 0.0;
        }
        compliance * self.weighted_product(other, cost.inverse_weights())
    }

    #[inline]
    fn compliance(&self, other: &Row<'_>, cost: &Cost<'_>) -> f64 {
        let mut compliance = 0.0;
        for (i, of_a) in self.touched() {
            for (j, of_b) in other.touched() {
                compliance += of_a * of_b * cost.compliance(i, j);
            }
        }
        compliance
    }

    /// The waypoints that the row is about, with their spreads.
    #[inline]
    fn touched(&self) -> impl Iterator<Item = (usize, f64)> {
        self.spread()
            .into_iter()
            .filter(|(_, spread)| *spread != 0.0)
    }

    /// `j_a W⁻² j_bᵀ`.
    #[inline]
    fn weighted_product(&self, other: &Row<'_>, inverse_weights: &[f64]) -> f64 {
        let pairs = self
            .jacobian
            .iter()
            .zip(other.jacobian)
            .zip(inverse_weights);
        pairs
            .map(|((a, b), inverse)| a * inverse * b)
            .sum::<f64>()
    }

    /// Adds `Jᵀ multiplier` to a force on every waypoint.
    pub fn add_force(&self, multiplier: f64, force: &mut [f64]) {
        for (waypoint, spread) in self.touched() {
            let at = force[self.coordinates(waypoint)].iter_mut();
            at.zip(self.jacobian)
                .for_each(|(f, j)| *f += spread * multiplier * j);
        }
    }
}

/// Rows, the jacobians end to end.
#[derive(Clone, Debug, Default)]
pub struct Rows {
    nv: usize,
    places: Vec<(usize, f64)>,
    right_hand_sides: Vec<f64>,
    jacobians: Vec<f64>,
}

impl Rows {
    /// No rows, on velocities of `nv` coordinates.
    pub fn new(nv: usize) -> Self {
        Self {
            nv,
            ..Self::default()
        }
    }
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.places.len()
    }
    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }
    /// One row.
    pub fn get(&self, index: usize) -> Row<'_> {
        let (segment, ratio) = self.places[index];
        Row {
            segment,
            ratio,
            jacobian: self.jacobian(index),
            right_hand_side: self.right_hand_sides[index],
        }
    }
    fn jacobian(&self, index: usize) -> &[f64] {
        &self.jacobians[index * self.nv..(index + 1) * self.nv]
    }
    /// The rows in order.
    pub fn iter(&self) -> impl Iterator<Item = Row<'_>> {
        (0..self.len()).map(|index| self.get(index))
    }
    /// Adds a row.
    pub fn push(&mut self, row: Row<'_>) {
        self.places.push((row.segment, row.ratio));
        self.right_hand_sides.push(row.right_hand_side);
        self.jacobians.extend_from_slice(row.jacobian);
    }
    /// Changes the right-hand side of a row.
    pub fn set_right_hand_side(&mut self, index: usize, value: f64) {
        self.right_hand_sides[index] = value;
    }
    /// Keeps the first `count` rows.
    pub fn truncate(&mut self, count: usize) {
        self.places.truncate(count);
        self.right_hand_sides.truncate(count);
        self.jacobians.truncate(count * self.nv);
    }
}

/// Makes the paper's collision rows; holds the scratch.
#[derive(Debug)]
pub struct CollisionRow<'a> {
    model: &'a CollisionModel,
    held: &'a [f64],
    constraints: &'a [Held],
    kinematics: Kinematics,
    jacobian: Vec<f64>,
}

/// Points closer than this at the free configuration give no direction (m).
const SHORTEST_DIRECTION_M: f64 = 1e-12;

impl<'a> CollisionRow<'a> {
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
            jacobian: vec![0.0; space.nv()],
        }
    }

    /// `uᵀ (J_A(c_A) − J_B(c_B))` at `q_free`: moving along it separates or closes the two contact
    /// points.
    ///
    /// c_A and c_B are the points of bodies A and B that touch at `q_coll` (or are closest there,
    /// where the segment was refused without touching), carried by their bodies back to `q_free`; u
    /// is the unit vector between them there. `None` where they do not part. The right-hand side is
    /// 0: what touches at `q_coll` stays as far apart as at `q_free` (Campana et al. 2016,
    /// collision constraint). Of a constraint: towards the inside of the side of its region that is
    /// violated at `q_coll`.
    pub fn at(&mut self, hit: &Hit, q_coll: &[f64], q_free: &[f64]) -> Option<&[f64]> {
        match hit.requirement {
            Requirement::Clearance(pair) => self.of_pair(pair, hit, q_coll, q_free),
            Requirement::Constraint(index) => Some(self.of_constraint(index, q_coll, q_free)),
        }
    }

    fn of_constraint(&mut self, index: usize, q_coll: &[f64], q_free: &[f64]) -> &[f64] {
        let held = &self.constraints[index];
        self.stand(q_coll);
        let side = held.side(self.watch(held, q_coll));
        self.stand(q_free);
        let (_, outward) = held.beside(side, self.watch(held, q_free));
        self.jacobian.fill(0.0);
        let robot = self.model.robot();
        held.watched
            .add_row(robot, &self.kinematics, -outward, &mut self.jacobian);
        &self.jacobian
    }

    /// Where what is watched is.
    fn watch(&self, held: &Held, q: &[f64]) -> Vec3 {
        held.watched.at(&Stand {
            kinematics: &self.kinematics,
            configuration: q,
            velocity: &[],
        })
    }

    fn of_pair(
        &mut self,
        pair: usize,
        hit: &Hit,
        q_coll: &[f64],
        q_free: &[f64],
    ) -> Option<&[f64]> {
        let pair = self.model.pairs()[pair];
        let local = self.in_bodies(&pair, hit.measure.points, q_coll);
        let points = self.in_world(&pair, local, q_free);
        let rate = PartingRate {
            pair,
            points,
            direction: direction(points)?,
        };
        self.jacobian.fill(0.0);
        rate.add_row(self.model, &self.kinematics, &mut self.jacobian);
        Some(&self.jacobian)
    }

    /// World points of the bodies of a pair at `q`, each in its body's frame.
    fn in_bodies(&mut self, pair: &BodyPair, points: [Vec3; 2], q: &[f64]) -> [Vec3; 2] {
        self.stand(q);
        self.map_links(pair, points, |pose, point| {
            pose.inverse_transform_point(point)
        })
    }

    fn stand(&mut self, q: &[f64]) {
        self.kinematics
            .update(self.model.robot(), q, self.held);
    }

    /// The other way round.
    fn in_world(&mut self, pair: &BodyPair, points: [Vec3; 2], q: &[f64]) -> [Vec3; 2] {
        self.stand(q);
        self.map_links(pair, points, |pose, point| pose.transform_point(point))
    }

    /// What becomes of the points of the bodies that links carry; obstacles' points stay.
    fn map_links(
        &self,
        pair: &BodyPair,
        points: [Vec3; 2],
        map: impl Fn(&Pose, Vec3) -> Vec3,
    ) -> [Vec3; 2] {
        let poses = self.kinematics.poses();
        let link = |body: usize| self.model.bodies()[body].link;
        let moved = |body, point| link(body).map_or(point, |link| map(&poses[link], point));
        [moved(pair.a, points[0]), moved(pair.b, points[1])]
    }
}

/// The unit vector from the second point to the first.
fn direction(points: [Vec3; 2]) -> Option<Vec3> {
    let parted = points[0] - points[1];
    (parted.length() > SHORTEST_DIRECTION_M).then(|| parted.normalize())
}

/// How fast two points of a pair's bodies part along a direction.
pub struct PartingRate {
    /// The bodies.
    pub pair: BodyPair,
    /// A point of each, in the world.
    pub points: [Vec3; 2],
    /// A unit vector.
    pub direction: Vec3,
}

impl PartingRate {
    /// Adds `directionᵀ (J_A(c_A) − J_B(c_B))` to a row of nv numbers.
    pub fn add_row(&self, model: &CollisionModel, kinematics: &Kinematics, row: &mut [f64]) {
        let [a, b] = self.points;
        for (body, point, sign) in [(self.pair.a, a, 1.0), (self.pair.b, b, -1.0)] {
            if let Some(link) = model.bodies()[body].link {
                kinematics.add_point_row(model.robot(), link, point, self.direction, sign, row);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;
    use crate::validation::{HitReason, Measure};
    use proptest::prelude::*;

    /// World positions of the two contact points, each carried by its body from `q_coll` to `q`.
    fn carried(
        model: &CollisionModel,
        held: &[f64],
        hit: &Hit,
        q_coll: &[f64],
        q: &[f64],
    ) -> [Vec3; 2] {
        let pair = hit.requirement.pair();
        let pair = model.pairs()[pair];
        let mut there = Kinematics::default();
        let mut here = Kinematics::default();
        there.update(model.robot(), q_coll, held);
        here.update(model.robot(), q, held);
        let carry = |body: usize, point: Vec3| match model.bodies()[body].link {
            Some(link) => here.poses()[link] * there.poses()[link].inverse_transform_point(point),
            None => point,
        };
        [
            carry(pair.a, hit.measure.points[0]),
            carry(pair.b, hit.measure.points[1]),
        ]
    }

    proptest! {
        #[test]
        fn the_row_is_the_rate_at_which_the_contact_points_part(seed: u64) {
            let mut rng = fastrand::Rng::with_seed(seed);
            let model = testing::model(&mut rng);
            prop_assume!(!model.pairs().is_empty());
            let robot = model.robot();
            let held: Vec<f64> = robot.held().iter().map(|h| h.default).collect();
            let q_coll = testing::configuration(&mut rng, robot);
            let q_free = testing::neighbour(&mut rng, robot, &q_coll);
            let point = testing::vector(&mut rng, 0.5);
            let measure = Measure { amount: 0.0, points: [point; 2], normal: Vec3::X };
            let requirement = Requirement::Clearance(rng.usize(..model.pairs().len()));
            let hit = Hit { reason: HitReason::Collision, t: 0.5, requirement, measure, proved_until: 0.0 };
            let gap = |q: &[f64]| {
                let [a, b] = carried(&model, &held, &hit, &q_coll, q);
                (a - b).length()
            };
            prop_assume!(gap(&q_free) > 1e-3);
            let mut builder = CollisionRow::new(&model, robot.space(), &held, &[]);
            let row = builder.at(&hit, &q_coll, &q_free).expect("the points part").to_vec();
            for v in 0..row.len() {
                let at = |step: f64| {
                    let (mut velocity, mut q) = (vec![0.0; row.len()], q_free.clone());
                    velocity[v] = 1.0;
                    robot.space().integrate(&q_free, &velocity, step, &mut q);
                    gap(&q)
                };
                let rate = (at(1e-6) - at(-1e-6)) / 2e-6;
                prop_assert!((row[v] - rate).abs() < 1e-5, "coordinate {v}: {} or {rate}", row[v]);
            }
        }
    }

    #[test]
    fn points_that_do_not_part_give_no_row() {
        let mut rng = fastrand::Rng::with_seed(3);
        let model = testing::model(&mut rng);
        let robot = model.robot();
        let held: Vec<f64> = robot.held().iter().map(|h| h.default).collect();
        let q = testing::configuration(&mut rng, robot);
        let measure = Measure {
            amount: 0.0,
            points: [Vec3::ONE; 2],
            normal: Vec3::X,
        };
        let hit = Hit {
            reason: HitReason::Collision,
            t: 0.5,
            requirement: Requirement::Clearance(0),
            measure,
            proved_until: 0.0,
        };
        assert!(
            CollisionRow::new(&model, robot.space(), &held, &[])
                .at(&hit, &q, &q)
                .is_none()
        );
    }
}
