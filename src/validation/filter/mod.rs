//! The filter: the theorem of [`motion`](super::motion) for balls, on eight intervals at once in
//! f32.
//!
//! A ball moves like its centre, so only the velocity of the centre along the normal and the bend
//! of its path count. Everything that is rounded is paid for: places and boxes with larger radii,
//! velocities with a share of the plain bound V h, large values with a rounding of their own. What
//! passes is proved; what does not pass is only undecided.

mod cells;
mod narrow;
mod placed;
#[cfg(test)]
mod tests;

use super::interval::ROUNDING_M;
use crate::collision::Filter;
use crate::collision::filter::{ObjectNode, Partner, REMOTE_M};
use crate::lanes::{Eight, EightWide, LANES, Lanes, Mask, Packed, Vectors};
use crate::robot::ConfigurationSpace;
use crate::robot::lane_kinematics::{LaneInput, LaneInterval, LaneSegments, Placed};
use cells::CellScratch;
use placed::{PlacedBall, PlacedBody};

/// A pair that is not proved in some lanes.
#[derive(Clone, Copy, Debug)]
pub struct Unproved {
    /// The pair, by index.
    pub pair: u32,
    /// The lanes.
    pub lanes: u8,
    /// At most the distance in the middle of each of those lanes (m).
    pub gap: [f32; LANES],
    /// How many times too wide each of those intervals is, as far as the filter can tell.
    pub excess: [f32; LANES],
}

impl Unproved {
    /// Whether the pair is undecided in a lane.
    #[inline]
    pub fn is_in(&self, lane: usize) -> bool {
        self.lanes >> lane & 1 == 1
    }
}

/// Pairs that a batch looks at.
#[derive(Clone, Copy, Debug)]
pub enum Pairs<'a> {
    /// All; with the obstacles that are always far or without.
    All {
        /// Whether obstacles that are always far count.
        with_remote: bool,
    },
    /// These, each in some lanes.
    Of(&'a [(u32, u8)]),
}

/// Eight intervals to be looked at together.
pub struct Batch<'a> {
    /// The filter's model.
    pub filter: &'a Filter,
    /// Space of the configurations.
    pub space: &'a ConfigurationSpace,
    /// Segments that the intervals belong to.
    pub segments: &'a LaneSegments,
    /// The intervals.
    pub intervals: [LaneInterval; LANES],
    /// Lanes that count.
    pub lanes: u8,
    /// Pairs to look at.
    pub pairs: Pairs<'a>,
    /// Distance to be proved, for each pair (m).
    pub floors: &'a [f64],
    /// The highest of them (m).
    pub highest_floor: f64,
    /// Memory.
    pub scratch: &'a mut FilterScratch,
}

/// Memory of the filter, and what came of the last batch.
#[derive(Debug, Default)]
pub struct FilterScratch {
    /// Values of the held variables, and room for the lanes' configurations.
    pub input: LaneInput,
    /// Pairs that are not proved.
    pub unproved: Vec<Unproved>,
    /// Distance that all that was proved in a lane keeps (m).
    pub kept: [f32; LANES],
    /// Tests of the broad phase: a ball around a body against a node over obstacles or another such
    /// ball.
    pub far: u64,
    /// Tests of two parts of bodies.
    pub near: u64,
    placed: Placed,
    bodies: Vec<PlacedBody>,
    balls: Vec<PlacedBall>,
    open: Vec<(u32, u8)>,
    pairs: Vec<(u32, u8)>,
    /// Bends of each body relative to the joints that carry it, from the body up.
    bends: Vec<Packed>,
    cells: CellScratch,
    batch: u64,
}

const ZERO: Packed = Packed(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);

impl FilterScratch {
    /// Memory for the bodies of a model. What an earlier request left there is of an earlier batch
    /// and never read.
    pub fn reset(&mut self, filter: &Filter, space: &ConfigurationSpace, held: &[f64]) {
        self.input.reset(space, held);
        self.bodies.clear();
        let mut first = 0;
        let mut first_bend = 0;
        for body in &*filter.bodies {
            self.bodies
                .push(PlacedBody::unknown(first, first_bend));
            first += 1 + body.clusters.len() + body.balls.len();
            first_bend += body.hops.len();
        }
        self.balls.resize(first, PlacedBall::UNKNOWN);
        self.bends.resize(first_bend, ZERO);
        self.far = 0;
        self.near = 0;
    }

    /// Where the frames of the last batch are.
    #[cfg(test)]
    pub(crate) fn frames(&self) -> &[crate::robot::lane_kinematics::LaneFrame] {
        &self.placed.frames
    }

    /// What comes of a filter that is switched off: everything is undecided, at no known distance.
    pub fn leave(&mut self, pairs: impl Iterator<Item = (u32, u8)>) {
        let gap = [f32::NEG_INFINITY; LANES];
        let excess = [f32::INFINITY; LANES];
        self.unproved.clear();
        self.kept = [f32::INFINITY; LANES];
        self.unproved
            .extend(pairs.map(|(pair, lanes)| Unproved {
                pair,
                lanes,
                gap,
                excess,
            }));
    }
}

/// Proves that bodies keep apart while they move.
pub struct Proving<'a>(pub Batch<'a>);
/// The same on intervals of curves, with which the memory's input is filled already.
pub struct ProvingCurves<'a>(pub Batch<'a>);
/// Looks only at the middles: bodies apart there pass. For comparison; it proves nothing of the
/// interval.
pub struct Sampling<'a>(pub Batch<'a>);

impl EightWide for Proving<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Eight>(self, simd: S) {
        Look::<S, true, false>::new(simd, self.0).all();
    }
}

impl EightWide for ProvingCurves<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Eight>(self, simd: S) {
        Look::<S, true, true>::new(simd, self.0).all();
    }
}

impl EightWide for Sampling<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Eight>(self, simd: S) {
        Look::<S, false, false>::new(simd, self.0).all();
    }
}

struct Look<'a, S: Eight, const MOVING: bool, const CURVED: bool> {
    simd: S,
    batch: Batch<'a>,
    kept: Lanes<S>,
    drift: Lanes<S>,
}

impl<'a, S: Eight, const MOVING: bool, const CURVED: bool> Look<'a, S, MOVING, CURVED> {
    #[inline(always)]
    fn new(simd: S, batch: Batch<'a>) -> Self {
        let mut drift = [0.0_f32; LANES];
        for (drift, interval) in drift.iter_mut().zip(&batch.intervals) {
            *drift = batch.segments.rounding(interval.segment);
        }
        let drift = Lanes::new(simd, pulp::cast(drift));
        Self {
            simd,
            batch,
            kept: Lanes::splat(simd, f32::INFINITY),
            drift,
        }
    }

    #[inline(always)]
    fn all(mut self) {
        self.place_frames();
        let mut near = std::mem::take(&mut self.batch.scratch.pairs);
        near.clear();
        match self.batch.pairs {
            Pairs::Of(pairs) => near.extend_from_slice(pairs),
            Pairs::All { with_remote } => self.near(with_remote, &mut near),
        }
        self.test(&near);
        self.batch.scratch.pairs = near;
        self.batch.scratch.kept = pulp::cast(self.kept.packed);
    }

    /// Where the frames are in the middles, and how they move.
    #[inline(always)]
    fn place_frames(&mut self) {
        let simd = self.simd;
        let Batch {
            filter,
            space,
            segments,
            intervals,
            scratch,
            ..
        } = &mut self.batch;
        scratch.batch += 1;
        scratch.unproved.clear();
        if !CURVED {
            segments.fill(simd, space, intervals, &mut scratch.input);
        }
        filter
            .skeleton
            .update::<S, MOVING, CURVED>(simd, &scratch.input, &mut scratch.placed);
    }

    /// The broad phase: pairs that may come near.
    #[inline(always)]
    fn near(&mut self, with_remote: bool, near: &mut Vec<(u32, u8)>) {
        let filter = self.batch.filter;
        let lanes = self.batch.lanes;
        // What is left out keeps at least this within the limits.
        if !with_remote
            && filter
                .remote
                .iter()
                .any(|remote| !remote.is_empty())
        {
            self.kept = Lanes::splat(self.simd, REMOTE_M as f32);
        }
        for body in 0..filter.bodies.len() {
            self.near_objects(body, &filter.near[body], lanes, near);
            if with_remote {
                self.near_objects(body, &filter.remote[body], lanes, near);
            }
        }
        self.near_bodies(lanes, near);
    }

    /// The narrow phase.
    #[inline(always)]
    fn test(&mut self, near: &[(u32, u8)]) {
        let filter = self.batch.filter;
        for &(pair, lanes) in near {
            let entry = filter.pairs[pair as usize];
            match entry.partner {
                Partner::Object(object) => self.object(entry.body, pair, object, lanes),
                Partner::Body { body, hops } => self.own(pair, [entry.body, body], hops, lanes),
            }
        }
    }

    /// The broad phase of one body: obstacles that the ball around all of it may come near. Lanes
    /// that a node of the tree proves do not go on below it.
    #[inline(always)]
    fn near_objects(
        &mut self,
        body: usize,
        nodes: &[ObjectNode],
        lanes: u8,
        near: &mut Vec<(u32, u8)>,
    ) {
        if nodes.is_empty() {
            return;
        }
        let need = self.need_of(self.batch.highest_floor);
        let root = self.root(body);
        let bend = self.bend(body).0;
        let reach = root.speed + bend + root.radius;
        let mut open = std::mem::take(&mut self.batch.scratch.open);
        open.clear();
        let mut mask = lanes;
        let mut at = 0;
        while at < nodes.len() {
            while let Some((_, outer)) = open.pop_if(|(end, _)| *end as usize <= at) {
                mask = outer;
            }
            let node = &nodes[at];
            let (away, _) = self.away(&root, &node.hull);
            let fails = self.is_far(away, reach + node.hull.radius, need, mask);
            at += 1;
            match (fails, node.leaf) {
                (0, _) => at = node.skip as usize,
                (_, Some((pair, _))) => near.push((pair, fails)),
                (_, None) => {
                    open.push((node.skip, mask));
                    mask = fails;
                }
            }
        }
        self.batch.scratch.open = open;
    }

    /// The broad phase of the robot against itself.
    #[inline(always)]
    fn near_bodies(&mut self, lanes: u8, near: &mut Vec<(u32, u8)>) {
        let filter = self.batch.filter;
        for &pair in &*filter.own {
            let entry = &filter.pairs[pair as usize];
            let Partner::Body { body: b, .. } = entry.partner else {
                continue;
            };
            let root_a = self.root(entry.body);
            let root_b = self.root(b);
            // Seen from the world both move more than against each other; enough for most.
            let reach = root_a.speed + root_b.speed + self.bend(entry.body).0 + self.bend(b).0;
            let reach = reach + (root_a.radius + root_b.radius);
            let fails = self.is_far(root_a.center - root_b.center, reach, self.need(pair), lanes);
            if fails != 0 {
                near.push((pair, fails));
            }
        }
    }

    /// Lanes in which two balls this far away from each other, which reach this far together, may
    /// come too near. The comparison of squares does not wait for a root.
    #[inline(always)]
    fn is_far(&mut self, away: Vectors<S>, reach: Lanes<S>, need: Lanes<S>, lanes: u8) -> u8 {
        self.batch.scratch.far += 1;
        let square = away.dot(away);
        let least = reach + need;
        let passes = square.at_least(least * least);
        if MOVING {
            let passes = passes.and(Mask::from_bits(self.simd, lanes));
            self.kept = passes.select(self.kept.min(square.sqrt() - reach), self.kept);
        }
        lanes & !passes.bits()
    }

    #[inline(always)]
    fn need(&self, pair: u32) -> Lanes<S> {
        self.need_of(self.batch.floors[pair as usize])
    }

    /// A floor with the allowance that exact proofs make, rounded up.
    #[inline(always)]
    fn need_of(&self, floor: f64) -> Lanes<S> {
        let need = (floor + ROUNDING_M) * (1.0 + f64::from(f32::EPSILON));
        Lanes::splat(self.simd, if MOVING { need as f32 } else { 0.0 })
    }
}
