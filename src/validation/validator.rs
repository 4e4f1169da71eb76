//! Whom a proof is asked of: the model of one request, its floors, and the memory that its parts
//! share.

use std::collections::{HashMap, VecDeque};

use super::filter::FilterScratch;
use super::floors::Floors;
use super::ledger::Ledger;
use super::segment_motion::SegmentMotion;
use super::undecided::{Interval, Segments};
use super::{Layers, Queries};
use crate::collision::CollisionModel;
use crate::lanes::InstructionSet;
use crate::math::Vec3;
use crate::robot::{ConfigurationSpace, Kinematics};

/// Width to which [`Validator::first_hit`] narrows a refusal down.
pub const FINEST: f64 = 1.0 / 2048.0;

/// Intervals that one pair at a lowered floor may take on one segment before it counts as not
/// provable.
pub const LOWERED_FLOOR_INTERVALS: u32 = 100_000;

/// A proof is tried only of bodies that are this many floors apart in the middle of an interval.
const MARGIN: f64 = 1.5;

/// Segments that are laid out between two questions whether to stop.
pub(super) const ASKED_EVERY: usize = 256;

/// Reusable memory of a validator; nothing in it outlives a request but its capacity.
#[derive(Debug, Default)]
pub struct Scratch {
    pub(super) motion: SegmentMotion,
    pub(super) kinematics: Kinematics,
    pub(super) filter: FilterScratch,
    pub(super) segments: Segments,
    /// Lists of undecided pairs, each a range of this.
    pub(super) lists: Vec<u32>,
    /// The pairs of a batch, each with the lanes that look at it, and where each pair stands in it.
    pub(super) merged: Vec<(u32, u8)>,
    pub(super) slots: Vec<u32>,
    pub(super) queue: VecDeque<Interval>,
    pub(super) floors: Floors,
    /// Distances that a search for the nearest bodies looks for, while it lasts in the place of the
    /// floors.
    pub(super) wide: Floors,
    /// What this request's validator has proved.
    pub(super) ledger: Ledger,
    /// Where pairs of many pieces lay apart when they were last looked at.
    pub(super) directions: HashMap<usize, Vec3>,
}

impl Scratch {
    /// Puts what `fill` writes in the place of the floors; which they were.
    pub(super) fn widen(&mut self, fill: impl FnOnce(&mut Floors, &Floors)) -> Floors {
        let mut wide = std::mem::take(&mut self.wide);
        fill(&mut wide, &self.floors);
        std::mem::replace(&mut self.floors, wide)
    }
    /// Forgets the last request.
    fn start(&mut self, model: &CollisionModel, clearance: f64) {
        let pairs = model.pairs().len();
        self.floors.reset(pairs, clearance);
        // A slot counts only where the merged list agrees: what an earlier request left does no
        // harm.
        self.slots.resize(pairs, 0);
        self.ledger.clear();
        self.directions.clear();
    }
}

/// Proves segments for one request: one robot and scene, one set of floors.
pub struct Validator<'a> {
    pub(super) model: &'a CollisionModel,
    pub(super) space: &'a ConfigurationSpace,
    pub(super) held: &'a [f64],
    pub(super) scratch: &'a mut Scratch,
    pub(super) layers: Layers,
    pub(super) instructions: InstructionSet,
    /// Bodies closer than this many of their floors are too close to be proved.
    pub(super) margin: f64,
    /// Only contact refuses, however close bodies are; see [`first_contact`](super::first_contact).
    pub(super) seeks_contact: bool,
    pub(super) exact: u64,
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
        scratch
            .filter
            .reset(model.filter(), space, held);
        Self {
            model,
            space,
            held,
            scratch,
            layers: Layers::default(),
            instructions: InstructionSet::default(),
            margin: MARGIN,
            seeks_contact: false,
            exact: 0,
        }
    }

    /// The same with some layers switched off.
    #[must_use]
    pub fn with_layers(mut self, layers: Layers) -> Self {
        self.layers = layers;
        if layers.portable_lanes {
            self.instructions = InstructionSet::Portable;
        }
        self
    }

    /// Whether what is proved is remembered.
    pub fn remembers(&self) -> bool {
        self.layers.reuse
    }
    /// Floor of each pair (m).
    pub fn floors(&self) -> &[f64] {
        self.scratch.floors.all()
    }
    /// Pairs whose floor is below the clearance asked for, with their floors (m).
    pub fn lowered(&self) -> impl Iterator<Item = (usize, f64)> {
        self.scratch.floors.lowered()
    }
    /// Sets the floor of one pair (m).
    pub fn set_floor(&mut self, pair: usize, floor: f64) {
        if floor > self.floors()[pair] {
            // What was proved at the lower floor says nothing of the higher one.
            self.scratch.ledger.clear();
        }
        self.scratch.floors.set(pair, floor);
    }
    /// Tests of two bodies or parts of them since the validator was made: what work is counted in.
    pub fn work(&self) -> u64 {
        let Queries { far, near, exact } = self.queries();
        far + near + exact
    }
    /// The same by layer.
    pub fn queries(&self) -> Queries {
        let FilterScratch { far, near, .. } = self.scratch.filter;
        Queries {
            far,
            near,
            exact: self.exact,
        }
    }
    /// The model that is checked.
    pub fn model(&self) -> &'a CollisionModel {
        self.model
    }
}
