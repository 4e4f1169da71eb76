//! Requirements at single configurations, exactly: how much of each is kept, and what is inside of a
//! mesh.

use super::examiner::Examiner;
use super::interval::{IntervalVerdict, Looks};
use super::requirement::{Measure, Requirement};
use super::undecided::Interval;
use super::validator::Validator;
use crate::collision::{Body, BodyPair};
use crate::math::Vec3;
use crate::solid::Contact;
use crate::solid::query;
use crate::solid::transform::Transform;

/// Whether a body is inside a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Enclosed {
    /// None is.
    Nothing,
    /// The clearance that is not kept, with a point inside and the depth to the nearest surface.
    Broken(Requirement, Measure),
    /// `stop` said so before all pairs were asked.
    Stopped,
}

/// Where bodies stand.
impl<'m> Examiner<'m> {
    fn bodies_of(&self, requirement: Requirement) -> &'m BodyPair {
        let pair = requirement.pair();
        &self.model.pairs()[pair]
    }

    /// How much of a requirement is kept.
    pub(super) fn measure(&self, requirement: Requirement) -> Measure {
        let pair = self.bodies_of(requirement);
        self.scratch
            .motion
            .contact(self.model, pair)
            .into()
    }

    /// The same, and the rate at which it grows (per unit t), in the middle of an interval.
    pub(super) fn measure_with_rate(
        &mut self,
        requirement: Requirement,
        middle: &Interval,
    ) -> (Measure, f64) {
        self.place(middle);
        self.exact += 1;
        let pair = self.bodies_of(requirement);
        let (contact, rate) = self.scratch.motion.apart(self.model, pair);
        (contact.into(), rate)
    }

    /// About how much is kept in the middle of an interval, never less than is.
    pub(super) fn measure_roughly(&mut self, requirement: Requirement, interval: &Interval) -> f64 {
        self.place(interval);
        self.exact += 1;
        let pair = self.bodies_of(requirement);
        self.scratch
            .motion
            .nearly_apart(self.model, pair)
    }

    /// Whether bodies touch or overlap: cheaper than the measure.
    fn is_broken(&self, requirement: Requirement) -> bool {
        let motion = &self.scratch.motion;
        let pair = self.bodies_of(requirement);
        let interval = motion.pair_interval(self.model, pair, 0.0, 0.0);
        let surfaces = interval.touches_in_the_middle(&mut Looks::new(&mut || false));
        surfaces == IntervalVerdict::Collision || motion.is_enclosed(self.model, pair)
    }

    fn stand_at(&mut self, configuration: &[f64]) {
        let kinematics = &mut self.scratch.kinematics;
        kinematics.update(self.model.robot(), configuration, self.held);
    }

    /// The bodies of a pair, and where the kinematics place them.
    fn sides(&self, pair: &BodyPair) -> [(&'m Body, Transform); 2] {
        [pair.a, pair.b].map(|body| {
            let body = &self.model.bodies()[body];
            (body, body.placed(&self.scratch.kinematics))
        })
    }

    /// A point of one body inside of the other, where the kinematics stand.
    fn enclosed(&self, pair: usize) -> Option<Contact> {
        let [(a, at_a), (b, at_b)] = self.sides(&self.model.pairs()[pair]);
        query::enclosed(&a.solid, &at_a, &b.solid, &at_b)
    }
}

impl Validator<'_> {
    /// How much of a requirement is kept at one configuration, exactly.
    pub fn measure_at(&mut self, requirement: Requirement, configuration: &[f64]) -> Measure {
        if let Requirement::Constraint(index) = requirement {
            return self.constrained.measure(index, configuration);
        }
        let examiner = &mut self.examiner;
        examiner.stand_at(configuration);
        let [(a, at_a), (b, at_b)] = examiner.sides(examiner.bodies_of(requirement));
        query::closest(&a.solid, &at_a, &b.solid, &at_b).into()
    }

    /// Whether a requirement is not kept at all at one configuration, because bodies touch or
    /// overlap: cheaper than the measure.
    pub fn is_broken_at(&mut self, requirement: Requirement, configuration: &[f64]) -> bool {
        if let Requirement::Constraint(index) = requirement {
            return self
                .constrained
                .measure(index, configuration)
                .amount
                < 0.0;
        }
        self.examiner
            .stand(configuration, configuration, 0.0);
        self.examiner.is_broken(requirement)
    }

    /// How much of a requirement is kept at a ratio of a segment, exactly.
    pub fn measure(
        &mut self,
        requirement: Requirement,
        [from, to]: [&[f64]; 2],
        t: f64,
    ) -> Measure {
        if let Requirement::Constraint(index) = requirement {
            let configuration = self.examiner.space.between(from, to, t);
            return self.constrained.measure(index, &configuration);
        }
        self.examiner.stand(from, to, t);
        self.examiner.measure(requirement)
    }

    /// The same, with the penetration depth where bodies touch or overlap: for
    /// people, and dearer.
    pub fn measure_depth(
        &mut self,
        requirement: Requirement,
        [from, to]: [&[f64]; 2],
        t: f64,
    ) -> Measure {
        self.examiner.stand(from, to, t);
        let pair = self.examiner.bodies_of(requirement);
        let motion = &self.examiner.scratch.motion;
        motion
            .penetration(self.examiner.model, pair)
            .into()
    }

    /// The cell that a requirement's bodies touch or nearly touch at a ratio of a segment, in words: what it is, of which
    /// cloud, where its middle is in the world; `None` where neither is a cloud. `points` are the
    /// closest or contact points in the world.
    pub fn cell_at(
        &mut self,
        requirement: Requirement,
        [from, to]: [&[f64]; 2],
        t: f64,
        points: [Vec3; 2],
    ) -> Option<String> {
        let Requirement::Clearance(pair) = requirement else {
            return None;
        };
        let configuration = self.examiner.space.between(from, to, t);
        self.examiner.stand_at(&configuration);
        let sides = self
            .examiner
            .sides(&self.examiner.model.pairs()[pair]);
        sides
            .into_iter()
            .zip(points)
            .find_map(|((body, at), point)| {
                let cells = body.solid.tree.cells()?;
                let place = cells.nearest(at.inverse_point(point));
                let [x, y, z] = at
                    .point(cells.cloud().cell(place).center)
                    .to_array();
                let what = cells.cloud().words(place);
                Some(format!(
                    "{what} of {} at ({x:.4}, {y:.4}, {z:.4})",
                    body.name
                ))
            })
    }

    /// The first pair of which one body has a part wholly inside a mesh of the other: no surfaces
    /// meet there, and a proof that goes on from such a configuration would be of no worth. Asked
    /// once per request, of the configuration that everything proved is connected to. `stop` is
    /// asked at every pair.
    pub fn enclosed_at(
        &mut self,
        configuration: &[f64],
        stop: &mut dyn FnMut() -> bool,
    ) -> Enclosed {
        let examiner = &mut self.examiner;
        examiner.stand_at(configuration);
        for &pair in examiner.model.hollow_pairs() {
            if stop() {
                return Enclosed::Stopped;
            }
            if let Some(contact) = examiner.enclosed(pair) {
                return Enclosed::Broken(Requirement::Clearance(pair), contact.into());
            }
        }
        Enclosed::Nothing
    }
}
