//! The theorem for balls and the cells of a cloud that stands still: a box around cells is convex, so
//! that one test proves all that is in it. Here the lanes of a test are not eight intervals but eight
//! boxes that stand together, or eight cells.
//!
//! # Rounding
//!
//! With u = 2⁻²⁴: the centre of a ball in the cloud's frame comes from a difference of two places and
//! products with axes that are rounded themselves; it is off by less than 14 u of the sum of both places'
//! coordinates, for which [`PLACES`] is added to the radius. Corners of boxes are where they are said
//! to be. A distance is off by less than 4 u of itself, the velocity along it by less than 15 u of the
//! speed: the one is taken shorter by [`LENGTHS`], and as large a part of the speed is added to the radius.
//! Squares of distances, off by less than 4 u of themselves, are compared with what is larger by
//! [`LENGTHS`] than the reach.

use super::Look;
use super::narrow::Failed;
use super::placed::Moving;
use crate::lanes::{Axes, Eight, LANES, Lanes, Vectors};
use crate::solid::cells::CellTree;
use crate::solid::hulls::PlacedCells;

/// Rounding of a place in the cloud's frame, relative to its coordinates in the world.
const PLACES: f32 = 1.0 / (1 << 20) as f32;
/// Rounding of distances and of velocities along them, relative to themselves and to the speed.
const LENGTHS: f32 = 1.0 / (1 << 20) as f32;
/// An octet waits for the smaller balls of a body where its members are smaller than this part of the
/// larger one.
const FINE: f32 = 0.5;

/// Eight boxes or, on level 0, cells of a cloud, by their place in the tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Octet {
    level: u32,
    place: u32,
    /// At most the distance of any of them (m).
    gap: f32,
}

/// Memory of the search.
#[derive(Debug, Default)]
pub(super) struct CellScratch {
    /// What the ball around a body leaves to its clusters, in each lane.
    of_body: [Vec<Octet>; LANES],
    /// What a cluster leaves to its balls.
    of_cluster: [Vec<Octet>; LANES],
    open: Vec<Octet>,
}

/// A ball in the frame of a cloud, in every lane.
struct Probe {
    center: [[f32; LANES]; 3],
    velocity: [[f32; LANES]; 3],
    /// Radii of ball and cells, with the rounding of places (m).
    radius: [f32; LANES],
    /// Bound of the velocity (m).
    speed: [f32; LANES],
    /// The ball's own (m).
    size: f32,
}

/// A ball in one lane, against eight boxes at once.
struct Arrow<S: Eight> {
    center: Vectors<S>,
    velocity: Vectors<S>,
    radius: Lanes<S>,
    bend: Lanes<S>,
    need: Lanes<S>,
    /// Square of the distance from which on a member is proved whatever its direction, and keeps no
    /// less than is kept already (m²).
    far: Lanes<S>,
}

/// What a pair comes to.
struct Found {
    /// Bend and distance to be proved, in each lane (m).
    bend: [f32; LANES],
    need: [f32; LANES],
    /// What is proved keeps this (m).
    kept: [f32; LANES],
    /// Lanes in which something is not proved.
    fails: u8,
    /// The nearest of that (m).
    gap: [f32; LANES],
    excess: [f32; LANES],
}

impl Found {
    /// Whether a lane is worth more tests: what overlaps in the middle is not proved by any.
    #[inline(always)]
    fn is_open(&self, lane: usize) -> bool {
        self.gap[lane] > 0.0
    }
}

#[inline(always)]
fn numbers<S: Eight>(lanes: Lanes<S>) -> [f32; LANES] {
    pulp::cast(lanes.packed)
}

#[inline(always)]
fn of_numbers<S: Eight>(simd: S, numbers: [f32; LANES]) -> Lanes<S> {
    Lanes::new(simd, pulp::cast(numbers))
}

#[inline(always)]
fn vectors<S: Eight>(simd: S, [x, y, z]: &[[f32; LANES]; 3]) -> Vectors<S> {
    Vectors {
        x: of_numbers(simd, *x),
        y: of_numbers(simd, *y),
        z: of_numbers(simd, *z),
    }
}

/// The same vector in all lanes, that of one of them.
#[inline(always)]
fn lane_of<S: Eight>(simd: S, [x, y, z]: &[[f32; LANES]; 3], lane: usize) -> Vectors<S> {
    Vectors::splat(simd, [x[lane], y[lane], z[lane]])
}

/// All of a cloud, nothing of which was looked at.
#[inline(always)]
fn top(tree: &CellTree) -> Octet {
    Octet {
        level: tree.levels().len() as u32,
        place: 0,
        gap: f32::NEG_INFINITY,
    }
}

/// The level of octets that a ball leaves to the smaller ones in it.
#[inline(always)]
fn finest(tree: &CellTree, size: f32) -> u32 {
    let mut level = tree.levels().len();
    while level > 0 && tree.sizes()[level] > FINE * size {
        level -= 1;
    }
    level as u32
}

impl<S: Eight, const MOVING: bool, const CURVED: bool> Look<'_, S, MOVING, CURVED> {
    /// A body against a cloud: all of it, then its clusters, then its balls, each where the larger
    /// one left something.
    #[inline(always)]
    pub(super) fn cells(&mut self, body: usize, pair: u32, cells: &PlacedCells, lanes: u8) {
        let filter = self.batch.filter;
        let mut scratch = std::mem::take(&mut self.batch.scratch.cells);
        let mut found = self.nothing_found(body, pair);
        self.whole(body, cells, lanes, &mut scratch, &mut found);
        for (index, (_, balls)) in filter.bodies[body].clusters.iter().enumerate() {
            if self.cluster_of(body, index, cells, &mut scratch, &mut found) {
                self.balls(body, balls.clone(), cells, &mut scratch, &mut found);
            }
        }
        self.batch.scratch.cells = scratch;
        self.kept = of_numbers(self.simd, found.kept);
        let [gap, excess] = [found.gap, found.excess].map(|values| of_numbers(self.simd, values));
        let failed = Failed {
            lanes: found.fails,
            gap,
            excess,
        };
        self.report(pair, &failed);
    }

    #[inline(always)]
    fn nothing_found(&mut self, body: usize, pair: u32) -> Found {
        Found {
            bend: numbers(self.bend(body).0),
            need: numbers(self.need(pair)),
            kept: numbers(self.kept),
            fails: 0,
            gap: [f32::INFINITY; LANES],
            excess: [0.0; LANES],
        }
    }

    /// The ball around a body, from the top of the tree.
    #[inline(always)]
    fn whole(
        &mut self,
        body: usize,
        cells: &PlacedCells,
        lanes: u8,
        scratch: &mut CellScratch,
        found: &mut Found,
    ) {
        let root = self.root(body);
        let probe = self.probe(&root, cells);
        for lane in 0..LANES {
            let left = &mut scratch.of_body[lane];
            left.clear();
            if lanes >> lane & 1 == 1 {
                scratch.open.clear();
                scratch.open.push(top(&cells.tree));
                self.descend(&probe, cells, lane, &mut scratch.open, found, Some(left));
            }
        }
    }

    /// The ball around a cluster, where that around the body left something; whether it leaves
    /// something to its balls.
    #[inline(always)]
    fn cluster_of(
        &mut self,
        body: usize,
        index: usize,
        cells: &PlacedCells,
        scratch: &mut CellScratch,
        found: &mut Found,
    ) -> bool {
        let cluster = self.cluster(body, index);
        let probe = self.probe(&cluster, cells);
        let mut is_left = false;
        for lane in 0..LANES {
            let left = &mut scratch.of_cluster[lane];
            left.clear();
            if found.is_open(lane) && !scratch.of_body[lane].is_empty() {
                scratch.open.clear();
                scratch
                    .open
                    .extend_from_slice(&scratch.of_body[lane]);
                self.descend(&probe, cells, lane, &mut scratch.open, found, Some(left));
                is_left |= !left.is_empty();
            }
        }
        is_left
    }

    /// The balls of a cluster, down to the cells.
    #[inline(always)]
    fn balls(
        &mut self,
        body: usize,
        balls: std::ops::Range<usize>,
        cells: &PlacedCells,
        scratch: &mut CellScratch,
        found: &mut Found,
    ) {
        for index in balls {
            let ball = self.ball(body, index);
            let probe = self.probe(&ball, cells);
            for lane in 0..LANES {
                if found.is_open(lane) && !scratch.of_cluster[lane].is_empty() {
                    scratch.open.clear();
                    scratch
                        .open
                        .extend_from_slice(&scratch.of_cluster[lane]);
                    self.descend(&probe, cells, lane, &mut scratch.open, found, None);
                }
            }
        }
    }

    /// A ball as the cloud sees it.
    #[inline(always)]
    fn probe(&self, ball: &Moving<S>, cells: &PlacedCells) -> Probe {
        let simd = self.simd;
        let origin = Vectors::splat(simd, cells.origin);
        let mut center = ball.center - origin;
        let mut velocity = ball.velocity;
        if let Some(axes) = &cells.axes {
            let axes = Axes::splat(simd, axes);
            center = axes.coordinates(center);
            if MOVING {
                velocity = axes.coordinates(velocity);
            }
        }
        let places = ball.center.x.abs() + ball.center.y.abs() + ball.center.z.abs();
        let places =
            places + (cells.origin[0].abs() + cells.origin[1].abs() + cells.origin[2].abs());
        let mut radius = places * PLACES + (ball.radius + cells.radius);
        if MOVING {
            radius = radius + ball.speed * LENGTHS;
        }
        Probe {
            center: [center.x, center.y, center.z].map(numbers),
            velocity: [velocity.x, velocity.y, velocity.z].map(numbers),
            radius: numbers(radius),
            speed: numbers(ball.speed),
            size: ball.radius,
        }
    }

    /// A ball in one lane.
    #[inline(always)]
    fn arrow(&self, probe: &Probe, lane: usize, found: &Found) -> Arrow<S> {
        let simd = self.simd;
        let need = found.need[lane];
        let reach = match MOVING {
            true => f32::max(need, found.kept[lane]) + found.bend[lane] + probe.speed[lane],
            false => need,
        };
        let reach = (probe.radius[lane] + reach) * (1.0 + LENGTHS);
        Arrow {
            center: lane_of(simd, &probe.center, lane),
            velocity: lane_of(simd, &probe.velocity, lane),
            radius: Lanes::splat(simd, probe.radius[lane]),
            bend: Lanes::splat(simd, found.bend[lane]),
            need: Lanes::splat(simd, need),
            far: Lanes::splat(simd, reach * reach),
        }
    }

    /// Looks at octets in one lane, and below those of their members that it does not prove. Where a
    /// smaller ball follows, octets as fine as this one are `left` to it; else cells that are not proved
    /// are found.
    #[inline(always)]
    fn descend(
        &mut self,
        probe: &Probe,
        cells: &PlacedCells,
        lane: usize,
        open: &mut Vec<Octet>,
        found: &mut Found,
        mut left: Option<&mut Vec<Octet>>,
    ) {
        let simd = self.simd;
        let tree = &cells.tree;
        let finest = finest(tree, probe.size);
        let arrow = self.arrow(probe, lane, found);
        let infinite = Lanes::splat(simd, f32::INFINITY);
        let mut all_kept = infinite;
        while let Some(octet) = open.pop() {
            if octet.gap >= found.gap[lane] {
                continue;
            }
            self.batch.scratch.near += 1;
            let away = arrow.away(simd, tree, octet);
            let square = away.dot(away);
            // Most are far enough, and need no root.
            if !square.at_least(arrow.far).bits() == 0 {
                continue;
            }
            let length = square.sqrt();
            let gap = length * (1.0 - LENGTHS) - arrow.radius;
            let mut kept = gap;
            if MOVING {
                let tiny = Lanes::splat(simd, f32::MIN_POSITIVE);
                let along = away.dot(arrow.velocity).abs() / length.max(tiny);
                kept = gap - arrow.bend - along;
            }
            let passes = kept.at_least(arrow.need);
            all_kept = all_kept.min(passes.select(kept, infinite));
            let fails = !passes.bits();
            if fails == 0 {
                continue;
            }
            if let Some(left) = &mut left
                && octet.level <= finest
            {
                left.push(octet);
                continue;
            }
            let gap = numbers(gap);
            if octet.level == 0 {
                found.take(lane, fails, &gap, &numbers(kept));
            } else {
                push_members(tree, octet, fails, &gap, open);
            }
        }
        if MOVING {
            let all_kept = numbers(all_kept);
            for kept in all_kept {
                found.kept[lane] = if kept < found.kept[lane] {
                    kept
                } else {
                    found.kept[lane]
                };
            }
        }
    }
}

impl<S: Eight> Arrow<S> {
    /// From the nearest points of an octet's members to the ball's centre.
    #[inline(always)]
    fn away(&self, simd: S, tree: &CellTree, octet: Octet) -> Vectors<S> {
        let place = octet.place as usize;
        if octet.level > 0 {
            let boxes = &tree.levels()[octet.level as usize - 1][place];
            let low = vectors(simd, &boxes.low);
            let high = vectors(simd, &boxes.high);
            return Vectors {
                x: self.center.x - self.center.x.max(low.x).min(high.x),
                y: self.center.y - self.center.y.max(low.y).min(high.y),
                z: self.center.z - self.center.z.max(low.z).min(high.z),
            };
        }
        let away = self.center - vectors(simd, &tree.cloud().centers()[place]);
        match tree.cloud().halves().get(place) {
            None => away,
            Some(halves) => {
                let half = of_numbers(simd, *halves);
                Vectors {
                    x: away.x - away.x.max(-half).min(half),
                    y: away.y - away.y.max(-half).min(half),
                    z: away.z - away.z.max(-half).min(half),
                }
            }
        }
    }
}

/// Puts octets below those members of one that are not proved where they are looked at next, the nearest first.
#[inline(always)]
fn push_members(
    tree: &CellTree,
    octet: Octet,
    fails: u8,
    gap: &[f32; LANES],
    open: &mut Vec<Octet>,
) {
    let level = octet.level - 1;
    let count = match level {
        0 => tree.cloud().centers().len(),
        _ => tree.levels()[level as usize - 1].len(),
    };
    let first = open.len();
    let mut left = fails;
    while left != 0 {
        let member = left.trailing_zeros();
        left &= left - 1;
        let place = octet.place * LANES as u32 + member;
        // Places beyond the last repeat it.
        if (place as usize) < count {
            open.push(Octet {
                level,
                place,
                gap: gap[member as usize],
            });
        }
    }
    let mut nearest = first;
    for at in first..open.len() {
        if open[at].gap < open[nearest].gap {
            nearest = at;
        }
    }
    let last = open.len() - 1;
    open.swap(nearest, last);
}

impl Found {
    /// Takes in cells that are not proved.
    #[inline(always)]
    fn take(&mut self, lane: usize, fails: u8, gap: &[f32; LANES], kept: &[f32; LANES]) {
        let need = self.need[lane];
        self.fails |= 1 << lane;
        let mut left = fails;
        while left != 0 {
            let member = left.trailing_zeros() as usize;
            left &= left - 1;
            if gap[member] < self.gap[lane] {
                self.gap[lane] = gap[member];
            }
            // What may be moved is gap − need, what moves gap − kept.
            let room = f32::max(gap[member] - need, f32::MIN_POSITIVE);
            self.excess[lane] = f32::max(self.excess[lane], (gap[member] - kept[member]) / room);
        }
    }
}
