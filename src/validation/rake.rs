//! The filter: the theorem of [`motion`](super::motion) for balls, on eight intervals at once in f32.
//!
//! A ball moves like its centre, so only the velocity of the centre along the normal and the bend of its
//! path count. Everything that is rounded is paid for: places and boxes with larger radii, velocities with
//! a share of the plain bound V h, large values with a rounding of their own. What passes is proved; what
//! does not pass is only undecided.

use super::interval::ROUNDING_M;
use crate::collision::Filter;
use crate::collision::filter::{FilterBall, FilterBody, Hull, HullCore, ObjectNode, Partner, REMOTE_M};
use crate::lanes::{Axes, Eight, EightWide, LANES, Lanes, Mask, Packed, Vectors};
use crate::robot::ConfigurationSpace;
use crate::robot::lane_kinematics::{LaneFrame, LaneInput, LaneInterval, LaneMotion, LaneSegments};

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

/// Pairs that a rake looks at.
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
pub struct Rake<'a> {
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
    pub scratch: &'a mut RakeScratch,
}

/// Memory of the filter, and what came of the last rake.
#[derive(Debug, Default)]
pub struct RakeScratch {
    /// Values of the held variables, and room for the lanes' configurations.
    pub input: LaneInput,
    /// Pairs that are not proved.
    pub unproved: Vec<Unproved>,
    /// Distance that all that was proved in a lane keeps (m).
    pub kept: [f32; LANES],
    /// Tests made.
    pub looks: u64,
    frames: Vec<LaneFrame>,
    motions: Vec<LaneMotion>,
    bodies: Vec<PlacedBody>,
    balls: Vec<PlacedBall>,
    open: Vec<(u32, u8)>,
    near: Vec<(u32, u8)>,
    /// Bends of each body relative to the joints that carry it, from the body up.
    bends: Vec<Packed>,
    rake: u64,
}

/// What was computed of a body for rake number `rake`.
#[derive(Clone, Copy, Debug)]
struct PlacedBody {
    bent_rake: u64,
    /// First entry of `balls`: the root, then the clusters, then the balls.
    first: usize,
    /// First entry of `bends`, one for each hop.
    first_bend: usize,
    /// Bend of the body relative to the world.
    bend: Packed,
    /// Rounding of its places and velocities.
    blur: Packed,
}

#[derive(Clone, Copy, Debug)]
struct PlacedBall {
    rake: u64,
    center: [Packed; 3],
    velocity: [Packed; 3],
    speed: Packed,
}

const ZERO: Packed = Packed(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);

impl RakeScratch {
    /// Memory for the bodies of a model. What an earlier request left there is of an earlier rake and never read.
    pub fn reset(&mut self, filter: &Filter, space: &ConfigurationSpace, held: &[f64]) {
        self.input.reset(space, held);
        self.bodies.clear();
        let unknown = PlacedBall { rake: 0, center: [ZERO; 3], velocity: [ZERO; 3], speed: ZERO };
        let (mut first, mut first_bend) = (0, 0);
        for body in &filter.bodies {
            self.bodies.push(PlacedBody { bent_rake: 0, first, first_bend, bend: ZERO, blur: ZERO });
            first += 1 + body.clusters.len() + body.balls.len();
            first_bend += body.hops.len();
        }
        self.balls.resize(first, unknown);
        self.bends.resize(first_bend, ZERO);
        self.looks = 0;
    }

    /// Where the frames of the last rake are.
    #[cfg(test)]
    pub(crate) fn frames(&self) -> &[LaneFrame] {
        &self.frames
    }

    /// What comes of a filter that is switched off: everything is undecided, at no known distance.
    pub fn leave(&mut self, pairs: impl Iterator<Item = (u32, u8)>) {
        let (gap, excess) = ([f32::NEG_INFINITY; LANES], [f32::INFINITY; LANES]);
        self.unproved.clear();
        self.kept = [f32::INFINITY; LANES];
        self.unproved.extend(pairs.map(|(pair, lanes)| Unproved { pair, lanes, gap, excess }));
    }
}

/// Proves that bodies keep apart while they move.
pub struct Proving<'a>(pub Rake<'a>);
/// Looks only at the middles: bodies apart there pass. For comparison; it proves nothing of the interval.
pub struct Sampling<'a>(pub Rake<'a>);

impl EightWide for Proving<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Eight>(self, simd: S) {
        Look::<S, true>::new(simd, self.0).all();
    }
}

impl EightWide for Sampling<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Eight>(self, simd: S) {
        Look::<S, false>::new(simd, self.0).all();
    }
}

struct Look<'a, S: Eight, const MOVING: bool> {
    simd: S,
    rake: Rake<'a>,
    kept: Lanes<S>,
    drift: Lanes<S>,
}

/// What one test says of the lanes.
#[derive(Clone, Copy)]
struct Tested<S: Eight> {
    fails: u8,
    gap: Lanes<S>,
    kept: Lanes<S>,
}

/// What the failed tests of a pair have in common.
struct Failed<S: Eight> {
    lanes: u8,
    gap: Lanes<S>,
    excess: Lanes<S>,
}

impl<S: Eight> Failed<S> {
    #[inline(always)]
    fn none(simd: S) -> Self {
        Self { lanes: 0, gap: Lanes::splat(simd, f32::INFINITY), excess: Lanes::splat(simd, 0.0) }
    }

    #[inline(always)]
    fn add(&mut self, simd: S, tested: &Tested<S>, need: Lanes<S>) {
        let failed = Mask::from_bits(simd, tested.fails);
        // What may be moved is gap − need, what moves gap − kept.
        let room = (tested.gap - need).max(Lanes::splat(simd, f32::MIN_POSITIVE));
        self.lanes |= tested.fails;
        self.gap = failed.select(self.gap.min(tested.gap), self.gap);
        self.excess = failed.select(self.excess.max((tested.gap - tested.kept) / room), self.excess);
    }
}

/// A ball in all lanes.
#[derive(Clone, Copy)]
struct Moving<S: Eight> {
    center: Vectors<S>,
    velocity: Vectors<S>,
    speed: Lanes<S>,
    radius: f32,
}

impl<'a, S: Eight, const MOVING: bool> Look<'a, S, MOVING> {
    #[inline(always)]
    fn new(simd: S, rake: Rake<'a>) -> Self {
        let mut drift = [0.0_f32; LANES];
        for (drift, interval) in drift.iter_mut().zip(&rake.intervals) {
            *drift = rake.segments.rounding(interval.segment);
        }
        let drift = Lanes::new(simd, pulp::cast(drift));
        Self { simd, rake, kept: Lanes::splat(simd, f32::INFINITY), drift }
    }

    #[inline(always)]
    fn all(mut self) {
        let (simd, filter, lanes) = (self.simd, self.rake.filter, self.rake.lanes);
        let Rake { space, segments, intervals, scratch, .. } = &mut self.rake;
        scratch.rake += 1;
        scratch.unproved.clear();
        segments.fill(simd, space, intervals, &mut scratch.input);
        filter.skeleton.update::<S, MOVING>(simd, &scratch.input, &mut scratch.frames, &mut scratch.motions);
        let mut near = std::mem::take(&mut scratch.near);
        near.clear();
        match self.rake.pairs {
            Pairs::Of(pairs) => near.extend_from_slice(pairs),
            Pairs::All { with_remote } => {
                if !with_remote && filter.remote.iter().any(|remote| !remote.is_empty()) {
                    self.kept = Lanes::splat(simd, REMOTE_M as f32);
                }
                for body in 0..filter.bodies.len() {
                    self.near_objects(body, &filter.near[body], lanes, &mut near);
                    if with_remote {
                        self.near_objects(body, &filter.remote[body], lanes, &mut near);
                    }
                }
                self.near_bodies(lanes, &mut near);
            }
        }
        for &(pair, lanes) in &near {
            let entry = filter.pairs[pair as usize];
            match entry.partner {
                Partner::Object(object) => self.object(entry.body, pair, object, lanes),
                Partner::Body { body, hops } => self.own(pair, [entry.body, body], hops, lanes),
            }
        }
        self.rake.scratch.near = near;
        self.rake.scratch.kept = pulp::cast(self.kept.packed);
    }

    /// The broad phase of one body: obstacles that the ball around all of it may come near. Lanes that a node
    /// of the tree proves do not go on below it.
    #[inline(always)]
    fn near_objects(&mut self, body: usize, nodes: &[ObjectNode], lanes: u8, near: &mut Vec<(u32, u8)>) {
        if nodes.is_empty() {
            return;
        }
        let need = self.need_of(self.rake.highest_floor);
        let (root, bend) = (self.root(body), self.bend(body).0);
        let reach = root.speed + bend + root.radius;
        let mut open = std::mem::take(&mut self.rake.scratch.open);
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
        self.rake.scratch.open = open;
    }

    /// The broad phase of the robot against itself.
    #[inline(always)]
    fn near_bodies(&mut self, lanes: u8, near: &mut Vec<(u32, u8)>) {
        let filter = self.rake.filter;
        for &pair in &filter.own {
            let entry = &filter.pairs[pair as usize];
            let Partner::Body { body: b, .. } = entry.partner else { continue };
            let (root_a, root_b) = (self.root(entry.body), self.root(b));
            // Seen from the world both move more than against each other; enough for most.
            let reach = root_a.speed + root_b.speed + self.bend(entry.body).0 + self.bend(b).0;
            let reach = reach + (root_a.radius + root_b.radius);
            let fails = self.is_far(root_a.center - root_b.center, reach, self.need(pair), lanes);
            if fails != 0 {
                near.push((pair, fails));
            }
        }
    }

    /// Lanes in which two balls this far away from each other, which reach this far together, may come too
    /// near. The comparison of squares does not wait for a root.
    #[inline(always)]
    fn is_far(&mut self, away: Vectors<S>, reach: Lanes<S>, need: Lanes<S>, lanes: u8) -> u8 {
        self.rake.scratch.looks += 1;
        let (square, least) = (away.dot(away), reach + need);
        let passes = square.at_least(least * least);
        if MOVING {
            let passes = passes.and(Mask::from_bits(self.simd, lanes));
            self.kept = passes.select(self.kept.min(square.sqrt() - reach), self.kept);
        }
        lanes & !passes.bits()
    }

    /// A body against an obstacle: all of it, then its clusters, then its balls.
    #[inline(always)]
    fn object(&mut self, body: usize, pair: u32, object: usize, lanes: u8) {
        let filter = self.rake.filter;
        let (shape, object) = (&filter.bodies[body], &filter.objects[object]);
        let need = self.need(pair);
        let (root, bend) = (self.root(body), self.bend(body).0);
        let tested = self.near_hull(&root, &object.hull, bend, need, lanes);
        if tested.fails == 0 {
            return;
        }
        let mut failed = Failed::none(self.simd);
        if shape.balls.len() == 1 && object.boxes.is_empty() {
            failed.add(self.simd, &tested, need);
            return self.report(pair, &failed);
        }
        for (index, (_, range)) in shape.clusters.iter().enumerate() {
            let mut left = tested.fails;
            if shape.clusters.len() > 1 {
                let cluster = self.cluster(body, index);
                left = self.near_hull(&cluster, &object.hull, bend, need, left).fails;
            }
            if left == 0 {
                continue;
            }
            for index in range.clone() {
                let ball = self.ball(body, index);
                let tested = self.near_hull(&ball, &object.hull, bend, need, left);
                if tested.fails == 0 {
                    continue;
                }
                if object.boxes.is_empty() {
                    failed.add(self.simd, &tested, need);
                }
                for part in &object.boxes {
                    let tested = self.near_hull(&ball, part, bend, need, tested.fails);
                    failed.add(self.simd, &tested, need);
                }
            }
        }
        self.report(pair, &failed);
    }

    /// Two bodies of the robot.
    #[inline(always)]
    fn own(&mut self, pair: u32, [a, b]: [usize; 2], hops: [usize; 2], lanes: u8) {
        let filter = self.rake.filter;
        let (shape_a, shape_b) = (&filter.bodies[a], &filter.bodies[b]);
        let need = self.need(pair);
        let mut bend = Lanes::splat(self.simd, 0.0);
        if MOVING {
            let blur = self.bend(a).1 + self.bend(b).1;
            bend = self.bend_below(a, hops[0]) + self.bend_below(b, hops[1]) + blur;
        }
        let (root_a, root_b) = (self.root(a), self.root(b));
        let tested = self.near_ball(&root_a, &root_b, bend, need, lanes);
        if tested.fails == 0 {
            return;
        }
        let mut failed = Failed::none(self.simd);
        for (index_a, (_, range_a)) in shape_a.clusters.iter().enumerate() {
            let cluster_a = if shape_a.clusters.len() > 1 { self.cluster(a, index_a) } else { root_a };
            for (index_b, (_, range_b)) in shape_b.clusters.iter().enumerate() {
                let cluster_b = if shape_b.clusters.len() > 1 { self.cluster(b, index_b) } else { root_b };
                let left = self.near_ball(&cluster_a, &cluster_b, bend, need, tested.fails).fails;
                if left == 0 {
                    continue;
                }
                for i in range_a.clone() {
                    let ball_a = self.ball(a, i);
                    let left = self.near_ball(&ball_a, &cluster_b, bend, need, left).fails;
                    if left == 0 {
                        continue;
                    }
                    for j in range_b.clone() {
                        let ball_b = self.ball(b, j);
                        let tested = self.near_ball(&ball_a, &ball_b, bend, need, left);
                        failed.add(self.simd, &tested, need);
                    }
                }
            }
        }
        self.report(pair, &failed);
    }

    #[inline(always)]
    fn report(&mut self, pair: u32, failed: &Failed<S>) {
        if failed.lanes != 0 {
            let (gap, excess) = (pulp::cast(failed.gap.packed), pulp::cast(failed.excess.packed));
            self.rake.scratch.unproved.push(Unproved { pair, lanes: failed.lanes, gap, excess });
        }
    }

    /// A ball against a hull that stands still.
    #[inline(always)]
    fn near_hull(&mut self, ball: &Moving<S>, object: &Hull, bend: Lanes<S>, need: Lanes<S>, lanes: u8) -> Tested<S> {
        let (away, velocity) = self.away(ball, object);
        let length = away.length();
        let gap = length - (ball.radius + object.radius);
        self.decide(gap, length, ball.speed, (away, velocity), bend, need, lanes)
    }

    /// From the nearest point of a hull's core to a ball's centre, and the centre's velocity; in the hull's axes.
    #[inline(always)]
    fn away(&self, ball: &Moving<S>, object: &Hull) -> (Vectors<S>, Vectors<S>) {
        let mut offset = ball.center - Vectors::splat(self.simd, object.center);
        let mut velocity = ball.velocity;
        if let Some(axes) = &object.axes {
            let axes = Axes::splat(self.simd, axes);
            offset = axes.coordinates(offset);
            if MOVING {
                velocity = axes.coordinates(velocity);
            }
        }
        let away = match object.core {
            HullCore::Box([x, y, z]) => {
                Vectors { x: outside(offset.x, x), y: outside(offset.y, y), z: outside(offset.z, z) }
            }
            HullCore::Cylinder { radius, half_height } => {
                let across = (offset.x * offset.x + offset.y * offset.y).sqrt();
                let tiny = Lanes::splat(self.simd, f32::MIN_POSITIVE);
                let share = outside(across, radius) / across.max(tiny);
                Vectors { x: offset.x * share, y: offset.y * share, z: outside(offset.z, half_height) }
            }
        };
        (away, velocity)
    }

    /// Two balls. What carries both may turn, but at right angles to the offset: only their own velocities
    /// count along it.
    #[inline(always)]
    fn near_ball(&mut self, a: &Moving<S>, b: &Moving<S>, bend: Lanes<S>, need: Lanes<S>, lanes: u8) -> Tested<S> {
        let away = a.center - b.center;
        let length = away.length();
        let gap = length - (a.radius + b.radius);
        let (va, vb) = (a.velocity, b.velocity);
        self.decide(gap, length, Lanes::splat(self.simd, f32::INFINITY), (away, va - vb), bend, need, lanes)
    }

    /// The theorem: what is kept is the gap less the velocity along the normal less the bend. The speed of
    /// the centre bounds the velocity along any normal and is there already; where it is enough in every
    /// lane the normal is not asked for.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    fn decide(
        &mut self,
        gap: Lanes<S>,
        length: Lanes<S>,
        speed: Lanes<S>,
        (away, velocity): (Vectors<S>, Vectors<S>),
        bend: Lanes<S>,
        need: Lanes<S>,
        lanes: u8,
    ) -> Tested<S> {
        self.rake.scratch.looks += 1;
        if !MOVING {
            return Tested { fails: lanes & !gap.at_least(need).bits(), gap, kept: gap };
        }
        let slack = gap - bend;
        let kept = slack - speed;
        let passes = kept.at_least(need);
        let infinite = Lanes::splat(self.simd, f32::INFINITY);
        let counted = Mask::from_bits(self.simd, lanes);
        if lanes & !passes.bits() == 0 {
            self.kept = self.kept.min(counted.select(kept, infinite));
            return Tested { fails: 0, gap, kept };
        }
        // A centre inside a hull is away from it in no direction; 0 / 0 would be treated differently by each machine.
        let length = length.max(Lanes::splat(self.simd, f32::MIN_POSITIVE));
        let directed = slack - away.dot(velocity).abs() / length;
        let kept = passes.select(kept, directed);
        let passes = kept.at_least(need);
        self.kept = self.kept.min(counted.and(passes).select(kept, infinite));
        Tested { fails: lanes & !passes.bits(), gap, kept }
    }

    #[inline(always)]
    fn need(&self, pair: u32) -> Lanes<S> {
        self.need_of(self.rake.floors[pair as usize])
    }

    /// A floor with the allowance that exact proofs make, rounded up.
    #[inline(always)]
    fn need_of(&self, floor: f64) -> Lanes<S> {
        let need = (floor + ROUNDING_M) * (1.0 + f64::from(f32::EPSILON));
        Lanes::splat(self.simd, if MOVING { need as f32 } else { 0.0 })
    }

    /// Where a body's ball is, computed once a rake.
    #[inline(always)]
    fn placed(&mut self, entry: usize, frame: usize, ball: FilterBall) -> Moving<S> {
        let (simd, scratch) = (self.simd, &mut *self.rake.scratch);
        let known = &mut scratch.balls[entry];
        if known.rake != scratch.rake {
            let (center, velocity) = scratch.frames[frame].point(simd, ball.center);
            known.rake = scratch.rake;
            known.center = center.packed();
            if MOVING {
                known.velocity = velocity.packed();
                known.speed = velocity.length().packed;
            }
        }
        Moving {
            center: Vectors::new(simd, known.center),
            velocity: Vectors::new(simd, known.velocity),
            speed: Lanes::new(simd, known.speed),
            radius: ball.radius,
        }
    }

    #[inline(always)]
    fn root(&mut self, body: usize) -> Moving<S> {
        let shape: &FilterBody = &self.rake.filter.bodies[body];
        self.placed(self.rake.scratch.bodies[body].first, shape.frame, shape.root)
    }

    #[inline(always)]
    fn cluster(&mut self, body: usize, index: usize) -> Moving<S> {
        let shape = &self.rake.filter.bodies[body];
        self.placed(self.rake.scratch.bodies[body].first + 1 + index, shape.frame, shape.clusters[index].0)
    }

    #[inline(always)]
    fn ball(&mut self, body: usize, index: usize) -> Moving<S> {
        let shape = &self.rake.filter.bodies[body];
        let entry = self.rake.scratch.bodies[body].first + 1 + shape.clusters.len() + index;
        self.placed(entry, shape.frame, shape.balls[index])
    }

    /// Of a body, computed once a rake: the bend of its path relative to the world ½ h² A =
    /// Σ s_l (ω_l / 2 + Σ_{i<l} ω_i), everything times h, with the blur of its velocity, and the blur alone: a
    /// share of Σ (s_l + ω_l · reach of the robot).
    #[inline(always)]
    fn bend(&mut self, body: usize) -> (Lanes<S>, Lanes<S>) {
        let zero = Lanes::splat(self.simd, 0.0);
        if !MOVING {
            return (zero, zero);
        }
        let (known, rake) = (self.rake.scratch.bodies[body], self.rake.scratch.rake);
        if known.bent_rake == rake {
            return (Lanes::new(self.simd, known.bend), Lanes::new(self.simd, known.blur));
        }
        let (filter, scratch) = (self.rake.filter, &mut *self.rake.scratch);
        let (mut bend, mut speed, mut pushed, mut turned) = (zero, zero, zero, zero);
        let bends = &mut scratch.bends[known.first_bend..];
        for (hop, below) in filter.bodies[body].hops.iter().zip(bends) {
            let motion = &scratch.motions[hop.motion];
            let turn = Lanes::new(self.simd, motion.turn);
            let swing = turn * (pushed + hop.reach);
            bend = bend + turn * (speed + swing * 0.5);
            // Sums of at most some dozens of products: their own rounding is a few millionths.
            *below = (bend * (1.0 + 1e-5)).packed;
            speed = speed + swing + Lanes::new(self.simd, motion.slide);
            pushed = pushed + Lanes::new(self.simd, motion.shift);
            turned = turned + turn;
        }
        let blur = (speed + turned * (pushed + filter.skeleton.extent() as f32)) * filter.blur + self.drift;
        let bend = bend * (1.0 + 1e-5) + blur;
        let known = &mut scratch.bodies[body];
        (known.bent_rake, known.bend, known.blur) = (rake, bend.packed, blur.packed);
        (bend, blur)
    }

    /// Bend of a body that counts only so many of the joints that carry it; after [`Self::bend`].
    #[inline(always)]
    fn bend_below(&self, body: usize, hops: usize) -> Lanes<S> {
        let scratch = &*self.rake.scratch;
        let first = scratch.bodies[body].first_bend;
        Lanes::new(self.simd, if hops == 0 { ZERO } else { scratch.bends[first + hops - 1] })
    }
}

/// The part of a coordinate that lies outside of [−half, half], with its sign.
#[inline(always)]
fn outside<S: Eight>(at: Lanes<S>, half: f32) -> Lanes<S> {
    at - at.clamp(half)
}

#[cfg(test)]
mod tests;
