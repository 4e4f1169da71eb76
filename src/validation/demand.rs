//! What is demanded where intervals are looked at: an argument of every look.

use std::collections::HashMap;

use super::floors::Floors;
use super::requirement::Requirement;
use crate::math::Vec3;

/// A proof is tried only of what keeps this many of its floors in the middle of an interval.
pub(super) const MARGIN: f64 = 1.5;

/// Where pairs of many pieces lay apart when they were last looked at.
pub(super) type Directions = HashMap<usize, Vec3>;

/// What refuses a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refuses {
    /// Whatever keeps less than the margin asks for.
    TooLittle,
    /// Only contact, however close bodies are; see [`first_contact`](super::first_contact).
    Contact,
}

/// What every requirement must keep, with what margin, and what is known of how to show it.
pub(super) struct Demand<'d> {
    pub(super) floors: &'d mut Floors,
    /// What keeps less than this many of its floors is not tried to be proved.
    pub(super) margin: f64,
    pub(super) refuses: Refuses,
    pub(super) directions: &'d mut Directions,
}

impl<'d> Demand<'d> {
    /// That of a proof.
    pub(super) fn proof(floors: &'d mut Floors, directions: &'d mut Directions) -> Self {
        Self {
            floors,
            margin: MARGIN,
            refuses: Refuses::TooLittle,
            directions,
        }
    }

    /// What a requirement must keep in the middle of an interval to be tried.
    pub(super) fn worth_trying(&self, requirement: Requirement) -> f64 {
        self.margin * self.floors.of(requirement)
    }

    /// What refuses a requirement that keeps less in the middle of an interval.
    pub(super) fn refused_below(&self, requirement: Requirement) -> f64 {
        match self.refuses {
            Refuses::TooLittle => self.worth_trying(requirement),
            // Bodies in each other are no refusal before they are as deep as the floor says.
            Refuses::Contact => f64::NEG_INFINITY,
        }
    }

    /// How far anything is looked for (m).
    pub(super) fn farthest(&self) -> f64 {
        self.margin * self.floors.highest()
    }
}
