//! Whom a proof is asked of: what is required in one request, and what is proved of it.

use super::constrained::Constrained;
use super::demand::{Demand, Directions, MARGIN, Refuses};
use super::examiner::{self, Examiner};
use super::filter::FilterScratch;
use super::floors::Floors;
use super::ledger::Ledger;
use super::requirement::Requirement;
use super::{Layers, Queries};
use crate::collision::CollisionModel;
use crate::lanes::InstructionSet;
use crate::robot::ConfigurationSpace;

/// Width to which [`Validator::first_hit`] narrows a refusal down.
pub const FINEST: f64 = 1.0 / 2048.0;

/// Intervals that one requirement at a lowered floor may take on one segment before it counts as
/// not provable.
pub const LOWERED_FLOOR_INTERVALS: u32 = 100_000;

/// The margin of close proofs.
pub(super) const CLOSE_MARGIN: f64 = 1.1;

/// Reusable memory of a validator; nothing in it outlives a request but its capacity.
#[derive(Debug, Default)]
pub struct Scratch {
    examiner: examiner::Scratch,
    floors: Floors,
    /// Memory for floors that are not the request's.
    other_floors: Floors,
    ledger: Ledger,
    directions: Directions,
}

impl Scratch {
    /// Forgets the last request.
    fn start(&mut self, model: &CollisionModel, clearance: f64) {
        let pairs = model.pairs().len();
        self.floors.reset(pairs, clearance);
        self.examiner.make_room(pairs);
        self.ledger.clear();
        self.directions.clear();
    }
}

/// Proves segments for one request: one robot and scene, one set of floors.
pub struct Validator<'a> {
    pub(super) examiner: Examiner<'a>,
    pub(super) floors: &'a mut Floors,
    pub(super) other_floors: &'a mut Floors,
    /// What is proved at the floors.
    pub(super) ledger: &'a mut Ledger,
    pub(super) directions: &'a mut Directions,
    pub(super) constrained: Constrained<'a>,
    /// How many of its floors must be kept in the middle of an interval.
    pub(super) margin: f64,
}

impl<'a> Validator<'a> {
    /// A validator whose floors are all `clearance` (m); `held` are the values of the robot's held
    /// variables.
    pub fn new(
        model: &'a CollisionModel,
        space: &'a ConfigurationSpace,
        held: &'a [f64],
        clearance: f64,
        scratch: &'a mut Scratch,
    ) -> Self {
        scratch.start(model, clearance);
        Self {
            examiner: Examiner::new(model, space, held, &mut scratch.examiner),
            floors: &mut scratch.floors,
            other_floors: &mut scratch.other_floors,
            ledger: &mut scratch.ledger,
            directions: &mut scratch.directions,
            constrained: Constrained::none(model, space, held),
            margin: MARGIN,
        }
    }

    /// The same with some layers switched off.
    #[must_use]
    pub fn with_layers(mut self, layers: Layers) -> Self {
        self.examiner.layers = layers;
        if layers.portable_lanes {
            self.examiner.instructions = InstructionSet::Portable;
        }
        self
    }

    /// The same, but what is only a tenth clearer than its floor is proved too, in narrower intervals; and
    /// a floor that must be lowered is lowered to nine tenths of what is kept. For what goes along a path
    /// that comes as close as it may.
    #[must_use]
    pub fn closely(mut self) -> Self {
        self.margin = CLOSE_MARGIN;
        self
    }

    /// Whether what is proved is remembered.
    pub fn remembers(&self) -> bool {
        self.examiner.layers.reuse
    }
    /// What each requirement must keep.
    pub fn floors(&self) -> &Floors {
        self.floors
    }
    /// Sets the floor of one requirement.
    pub fn set_floor(&mut self, requirement: Requirement, floor: f64) {
        if floor > self.floors.of(requirement) {
            // What was proved at the lower floor says nothing of the higher one.
            self.ledger.clear();
        }
        self.floors.set(requirement, floor);
        if let Requirement::Constraint(index) = requirement {
            self.constrained.raise(index, -floor);
        }
    }
    /// Tests of two bodies or parts of them, and intervals looked at for constraints, since the validator
    /// was made: what work is counted in.
    pub fn work(&self) -> u64 {
        self.examiner.work() + self.constrained.looks
    }
    /// The tests by layer.
    pub fn queries(&self) -> Queries {
        self.examiner.queries()
    }
    /// The model that is checked.
    pub fn model(&self) -> &'a CollisionModel {
        self.examiner.model
    }
    /// Values of the robot's held variables.
    pub fn held(&self) -> &'a [f64] {
        self.examiner.held
    }

    /// What looks at intervals, and the demand of a proof at the validator's floors.
    pub(super) fn at_floors(&mut self) -> (&mut Examiner<'a>, Demand<'_>) {
        let demand = Demand {
            margin: self.margin,
            ..Demand::proof(self.floors, self.directions)
        };
        (&mut self.examiner, demand)
    }

    /// The same at floors that are these much higher (m).
    pub(super) fn at_raised_floors(&mut self, raise: f64) -> (&mut Examiner<'a>, Demand<'_>) {
        self.other_floors.raise(self.floors, raise);
        let demand = Demand::proof(self.other_floors, self.directions);
        (&mut self.examiner, demand)
    }

    /// The same where nothing is refused but contact, at this floor of every clearance (m).
    pub(super) fn seeking_contact(&mut self, floor: f64) -> (&mut Examiner<'a>, Demand<'_>) {
        let pairs = self.examiner.model.pairs().len();
        self.other_floors.reset(pairs, floor);
        let demand = Demand {
            refuses: Refuses::Contact,
            ..Demand::proof(self.other_floors, self.directions)
        };
        (&mut self.examiner, demand)
    }
}

impl Examiner<'_> {
    pub(super) fn work(&self) -> u64 {
        let Queries { far, near, exact } = self.queries();
        far + near + exact
    }

    fn queries(&self) -> Queries {
        let FilterScratch { far, near, .. } = self.scratch.filter;
        Queries {
            far,
            near,
            exact: self.exact,
        }
    }
}
