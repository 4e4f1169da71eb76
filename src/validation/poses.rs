//! Single configurations, exactly: closest points of a pair, and what is inside of a mesh.

use super::Contact;
use super::Validator;

use super::interval::{IntervalVerdict, Looks};
use crate::collision::Body;
use crate::solid::query;
use crate::solid::transform::Transform;

/// Whether a body is inside a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Enclosed {
    /// None is.
    Nothing,
    /// This pair, with a point inside and the depth to the nearest surface.
    Pair(usize, Contact),
    /// `stop` said so before all pairs were asked.
    Stopped,
}

impl Validator<'_> {
    /// Closest points of a pair at one configuration, exact, in the world.
    pub fn contact(&mut self, pair: usize, configuration: &[f64]) -> Contact {
        self.stand_at(configuration);
        let [(a, at_a), (b, at_b)] = self.sides(pair);
        query::closest(&a.solid, &at_a, &b.solid, &at_b)
    }

    fn stand_at(&mut self, configuration: &[f64]) {
        let kinematics = &mut self.scratch.kinematics;
        kinematics.update(self.model.robot(), configuration, self.held);
    }

    /// The bodies of a pair, and where the kinematics place them.
    fn sides(&self, pair: usize) -> [(&Body, Transform); 2] {
        let pair = &self.model.pairs()[pair];
        [pair.a, pair.b].map(|body| {
            let body = &self.model.bodies()[body];
            (body, body.placed(&self.scratch.kinematics))
        })
    }

    /// Stands all bodies where they are at a ratio of a segment.
    pub(super) fn stand(&mut self, from: &[f64], to: &[f64], t: f64) {
        // The motion is no longer that of the segments at hand.
        self.scratch.segments.exact = None;
        let motion = &mut self.scratch.motion;
        motion.begin(self.model, self.space, from, to, self.held);
        motion.place(self.model, self.space, from, t, self.held);
    }

    /// Whether a pair touches or overlaps at one configuration: cheaper than the contact.
    pub fn touches(&mut self, pair: usize, configuration: &[f64]) -> bool {
        self.stand(configuration, configuration, 0.0);
        let motion = &self.scratch.motion;
        let pair = &self.model.pairs()[pair];
        let interval = motion.pair_interval(self.model, pair, 0.0, 0.0);
        let surfaces = interval.touches_in_the_middle(&mut Looks::new(&mut || false));
        surfaces == IntervalVerdict::Collision || motion.is_enclosed(self.model, pair)
    }

    /// The same at a ratio of a segment.
    pub fn contact_between(&mut self, pair: usize, from: &[f64], to: &[f64], t: f64) -> Contact {
        self.contact_and_speed(pair, from, to, t).0
    }

    /// The same, with the speed that the distance changes at most at on the whole segment (m per
    /// unit t).
    pub fn contact_and_speed(
        &mut self,
        pair: usize,
        from: &[f64],
        to: &[f64],
        t: f64,
    ) -> (Contact, f64) {
        self.stand(from, to, t);
        let motion = &self.scratch.motion;
        let pair = &self.model.pairs()[pair];
        (motion.contact(self.model, pair), motion.speed(pair))
    }

    /// Closest points of a pair at a ratio of a segment, with the penetration depth where it
    /// touches or overlaps: for people, and dearer than [`Self::contact`].
    pub fn penetration(&mut self, pair: usize, from: &[f64], to: &[f64], t: f64) -> Contact {
        self.stand(from, to, t);
        let pair = &self.model.pairs()[pair];
        self.scratch
            .motion
            .penetration(self.model, pair)
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
        self.stand_at(configuration);
        for &pair in self.model.hollow_pairs() {
            if stop() {
                return Enclosed::Stopped;
            }
            if let Some(contact) = self.enclosed(pair) {
                return Enclosed::Pair(pair, contact);
            }
        }
        Enclosed::Nothing
    }

    /// A point of one body inside of the other, where the kinematics stand.
    fn enclosed(&self, pair: usize) -> Option<Contact> {
        let [(a, at_a), (b, at_b)] = self.sides(pair);
        query::enclosed(&a.solid, &at_a, &b.solid, &at_b)
    }
}
