//! The theorem for balls: a body against an obstacle, and two bodies of the robot.

use super::placed::Moving;
use super::{Look, Unproved};
use crate::lanes::{Axes, Eight, Lanes, Mask, Vectors};
use crate::solid::hulls::{Hull, HullCore};

/// What one test says of the lanes.
#[derive(Clone, Copy)]
struct Tested<S: Eight> {
    fails: u8,
    gap: Lanes<S>,
    kept: Lanes<S>,
}

/// What the failed tests of a pair have in common.
pub(super) struct Failed<S: Eight> {
    pub(super) lanes: u8,
    pub(super) gap: Lanes<S>,
    pub(super) excess: Lanes<S>,
}

impl<S: Eight> Failed<S> {
    #[inline(always)]
    fn none(simd: S) -> Self {
        Self {
            lanes: 0,
            gap: Lanes::splat(simd, f32::INFINITY),
            excess: Lanes::splat(simd, 0.0),
        }
    }

    #[inline(always)]
    fn add(&mut self, simd: S, tested: &Tested<S>, need: Lanes<S>) {
        let failed = Mask::from_bits(simd, tested.fails);
        // What may be moved is gap − need, what moves gap − kept.
        let room = (tested.gap - need).max(Lanes::splat(simd, f32::MIN_POSITIVE));
        self.lanes |= tested.fails;
        self.gap = failed.select(self.gap.min(tested.gap), self.gap);
        self.excess = failed.select(
            self.excess
                .max((tested.gap - tested.kept) / room),
            self.excess,
        );
    }
}

impl<S: Eight, const MOVING: bool, const CURVED: bool> Look<'_, S, MOVING, CURVED> {
    /// A body against an obstacle: all of it, then its clusters, then its balls.
    #[inline(always)]
    pub(super) fn object(&mut self, body: usize, pair: u32, object: usize, lanes: u8) {
        let filter = self.batch.filter;
        let shape = &filter.bodies[body];
        let object = &filter.objects[object];
        let need = self.need(pair);
        let root = self.root(body);
        let bend = self.bend(body).0;
        let tested = self.near_hull(&root, &object.hull, bend, need, lanes);
        if tested.fails == 0 {
            return;
        }
        if let Some(cells) = &object.cells {
            return self.cells(body, pair, cells, tested.fails);
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
                left = self
                    .near_hull(&cluster, &object.hull, bend, need, left)
                    .fails;
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
    pub(super) fn own(&mut self, pair: u32, [a, b]: [usize; 2], hops: [usize; 2], lanes: u8) {
        let filter = self.batch.filter;
        let shape_a = &filter.bodies[a];
        let shape_b = &filter.bodies[b];
        let need = self.need(pair);
        let mut bend = Lanes::splat(self.simd, 0.0);
        if MOVING {
            let blur = self.bend(a).1 + self.bend(b).1;
            bend = self.bend_below(a, hops[0]) + self.bend_below(b, hops[1]) + blur;
        }
        let root_a = self.root(a);
        let root_b = self.root(b);
        let tested = self.near_ball(&root_a, &root_b, bend, need, lanes);
        if tested.fails == 0 {
            return;
        }
        let mut failed = Failed::none(self.simd);
        for (index_a, (_, range_a)) in shape_a.clusters.iter().enumerate() {
            let cluster_a = if shape_a.clusters.len() > 1 {
                self.cluster(a, index_a)
            } else {
                root_a
            };
            for (index_b, (_, range_b)) in shape_b.clusters.iter().enumerate() {
                let cluster_b = if shape_b.clusters.len() > 1 {
                    self.cluster(b, index_b)
                } else {
                    root_b
                };
                let left = self
                    .near_ball(&cluster_a, &cluster_b, bend, need, tested.fails)
                    .fails;
                if left == 0 {
                    continue;
                }
                for i in range_a.clone() {
                    let ball_a = self.ball(a, i);
                    let left = self
                        .near_ball(&ball_a, &cluster_b, bend, need, left)
                        .fails;
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
    pub(super) fn report(&mut self, pair: u32, failed: &Failed<S>) {
        if failed.lanes != 0 {
            let gap = pulp::cast(failed.gap.packed);
            let excess = pulp::cast(failed.excess.packed);
            self.batch.scratch.unproved.push(Unproved {
                pair,
                lanes: failed.lanes,
                gap,
                excess,
            });
        }
    }

    /// A ball against a hull that stands still.
    #[inline(always)]
    fn near_hull(
        &mut self,
        ball: &Moving<S>,
        object: &Hull,
        bend: Lanes<S>,
        need: Lanes<S>,
        lanes: u8,
    ) -> Tested<S> {
        let (away, velocity) = self.away(ball, object);
        let length = away.length();
        let gap = length - (ball.radius + object.radius);
        self.decide(gap, length, ball.speed, (away, velocity), bend, need, lanes)
    }

    /// From the nearest point of a hull's core to a ball's centre, and the centre's velocity; in
    /// the hull's axes.
    #[inline(always)]
    pub(super) fn away(&self, ball: &Moving<S>, object: &Hull) -> (Vectors<S>, Vectors<S>) {
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
            HullCore::Box([x, y, z]) => Vectors {
                x: outside(offset.x, x),
                y: outside(offset.y, y),
                z: outside(offset.z, z),
            },
            HullCore::Cylinder {
                radius,
                half_height,
            } => {
                let across = (offset.x * offset.x + offset.y * offset.y).sqrt();
                let tiny = Lanes::splat(self.simd, f32::MIN_POSITIVE);
                let share = outside(across, radius) / across.max(tiny);
                Vectors {
                    x: offset.x * share,
                    y: offset.y * share,
                    z: outside(offset.z, half_height),
                }
            }
        };
        (away, velocity)
    }

    /// Two balls. What carries both may turn, but at right angles to the offset: only their own
    /// velocities count along it.
    #[inline(always)]
    fn near_ball(
        &mut self,
        a: &Moving<S>,
        b: &Moving<S>,
        bend: Lanes<S>,
        need: Lanes<S>,
        lanes: u8,
    ) -> Tested<S> {
        let away = a.center - b.center;
        let length = away.length();
        let gap = length - (a.radius + b.radius);
        let va = a.velocity;
        let vb = b.velocity;
        self.decide(
            gap,
            length,
            Lanes::splat(self.simd, f32::INFINITY),
            (away, va - vb),
            bend,
            need,
            lanes,
        )
    }

    /// The theorem: what is kept is the gap less the velocity along the normal less the bend. The
    /// speed of the centre bounds the velocity along any normal and is there already; where it is
    /// enough in every lane the normal is not asked for.
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
        self.batch.scratch.near += 1;
        if !MOVING {
            return Tested {
                fails: lanes & !gap.at_least(need).bits(),
                gap,
                kept: gap,
            };
        }
        let slack = gap - bend;
        let kept = slack - speed;
        let passes = kept.at_least(need);
        let infinite = Lanes::splat(self.simd, f32::INFINITY);
        let counted = Mask::from_bits(self.simd, lanes);
        if lanes & !passes.bits() == 0 {
            self.kept = self.kept.min(counted.select(kept, infinite));
            return Tested {
                fails: 0,
                gap,
                kept,
            };
        }
        // A centre inside a hull is away from it in no direction: nothing moves along it.
        let length = length.max(Lanes::splat(self.simd, f32::MIN_POSITIVE));
        let directed = slack - away.dot(velocity).abs() / length;
        let kept = passes.select(kept, directed);
        let passes = kept.at_least(need);
        self.kept = self
            .kept
            .min(counted.and(passes).select(kept, infinite));
        Tested {
            fails: lanes & !passes.bits(),
            gap,
            kept,
        }
    }
}

/// The part of a coordinate that lies outside of [−half, half], with its sign.
#[inline(always)]
fn outside<S: Eight>(at: Lanes<S>, half: f32) -> Lanes<S> {
    at - at.clamp(half)
}
