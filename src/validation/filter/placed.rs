//! Where the filter's balls are and how they move, each computed once a batch.

use super::{Look, ZERO};
use crate::collision::filter::FilterBall;
use crate::lanes::{Eight, Lanes, Packed, Vectors};

/// What was computed of a body for batch number `batch`.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedBody {
    pub(super) bent_batch: u64,
    /// First entry of `balls`: the root, then the clusters, then the balls.
    pub(super) first: usize,
    /// First entry of `bends`, one for each hop.
    pub(super) first_bend: usize,
    /// Bend of the body relative to the world.
    pub(super) bend: Packed,
    /// Rounding of its places and velocities.
    pub(super) blur: Packed,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedBall {
    pub(super) batch: u64,
    pub(super) center: [Packed; 3],
    pub(super) velocity: [Packed; 3],
    pub(super) speed: Packed,
}

impl PlacedBody {
    /// Nothing is computed yet.
    pub(super) fn unknown(first: usize, first_bend: usize) -> Self {
        Self {
            bent_batch: 0,
            first,
            first_bend,
            bend: ZERO,
            blur: ZERO,
        }
    }
}

impl PlacedBall {
    /// Nothing is computed yet.
    pub(super) const UNKNOWN: Self = Self {
        batch: 0,
        center: [ZERO; 3],
        velocity: [ZERO; 3],
        speed: ZERO,
    };
}

/// A ball in all lanes.
#[derive(Clone, Copy)]
pub(super) struct Moving<S: Eight> {
    pub(super) center: Vectors<S>,
    pub(super) velocity: Vectors<S>,
    pub(super) speed: Lanes<S>,
    pub(super) radius: f32,
}

impl<S: Eight, const MOVING: bool, const CURVED: bool> Look<'_, S, MOVING, CURVED> {
    /// Where a body's ball is, computed once a batch.
    #[inline(always)]
    fn placed(&mut self, entry: usize, frame: usize, ball: FilterBall) -> Moving<S> {
        let simd = self.simd;
        let scratch = &mut *self.batch.scratch;
        let known = &mut scratch.balls[entry];
        if known.batch != scratch.batch {
            let (center, velocity) = scratch.placed.frames[frame].point(simd, ball.center);
            known.batch = scratch.batch;
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
    pub(super) fn root(&mut self, body: usize) -> Moving<S> {
        let shape = &self.batch.filter.bodies[body];
        self.placed(
            self.batch.scratch.bodies[body].first,
            shape.frame,
            shape.root,
        )
    }

    #[inline(always)]
    pub(super) fn cluster(&mut self, body: usize, index: usize) -> Moving<S> {
        let shape = &self.batch.filter.bodies[body];
        self.placed(
            self.batch.scratch.bodies[body].first + 1 + index,
            shape.frame,
            shape.clusters[index].0,
        )
    }

    #[inline(always)]
    pub(super) fn ball(&mut self, body: usize, index: usize) -> Moving<S> {
        let shape = &self.batch.filter.bodies[body];
        let entry = self.batch.scratch.bodies[body].first + 1 + shape.clusters.len() + index;
        self.placed(entry, shape.frame, shape.balls[index])
    }

    /// Of a body, computed once a batch: the bend of its path relative to the world ½ h² A = Σ s_l
    /// (ω_l / 2 + Σ_{i<l} ω_i), everything times h, and on curves what the joints bulge times their arms, with the blur of its velocity, and the blur
    /// alone: a share of Σ (s_l + ω_l · reach of the robot).
    #[inline(always)]
    pub(super) fn bend(&mut self, body: usize) -> (Lanes<S>, Lanes<S>) {
        let zero = Lanes::splat(self.simd, 0.0);
        if !MOVING {
            return (zero, zero);
        }
        let known = self.batch.scratch.bodies[body];
        let batch = self.batch.scratch.batch;
        if known.bent_batch == batch {
            return (
                Lanes::new(self.simd, known.bend),
                Lanes::new(self.simd, known.blur),
            );
        }
        let filter = self.batch.filter;
        let scratch = &mut *self.batch.scratch;
        let mut bend = zero;
        let mut speed = zero;
        let mut pushed = zero;
        let mut turned = zero;
        let bends = &mut scratch.bends[known.first_bend..];
        for (hop, below) in filter.bodies[body].hops.iter().zip(bends) {
            let motion = &scratch.placed.motions[hop.motion];
            let turn = Lanes::new(self.simd, motion.turn);
            let swing = turn * (pushed + hop.reach);
            bend = bend + turn * (speed + swing * 0.5);
            if CURVED {
                let bulge = &scratch.placed.bulges[hop.motion];
                bend = bend + Lanes::new(self.simd, bulge.turn) * (pushed + hop.reach);
                bend = bend + Lanes::new(self.simd, bulge.slide);
            }
            // Sums of at most some dozens of products: their own rounding is a few millionths.
            *below = (bend * (1.0 + 1e-5)).packed;
            speed = speed + swing + Lanes::new(self.simd, motion.slide);
            pushed = pushed + Lanes::new(self.simd, motion.shift);
            turned = turned + turn;
        }
        let blur = (speed + turned * (pushed + filter.skeleton.extent() as f32)) * filter.blur
            + self.drift;
        let bend = bend * (1.0 + 1e-5) + blur;
        let known = &mut scratch.bodies[body];
        known.bent_batch = batch;
        known.bend = bend.packed;
        known.blur = blur.packed;
        (bend, blur)
    }

    /// Bend of a body that counts only so many of the joints that carry it; after [`Self::bend`].
    #[inline(always)]
    pub(super) fn bend_below(&self, body: usize, hops: usize) -> Lanes<S> {
        let scratch = &*self.batch.scratch;
        let first = scratch.bodies[body].first_bend;
        Lanes::new(
            self.simd,
            if hops == 0 {
                ZERO
            } else {
                scratch.bends[first + hops - 1]
            },
        )
    }
}
