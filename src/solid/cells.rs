//! A tree of boxes over the cells of a cloud.
//!
//! Eight boxes that stand together enclose eight octets of the level below, those of the lowest the octets
//! of cells, so that neither has links: below box m of octet j is octet 8j + m. The filter looks at eight
//! boxes at once. Exact searches see the same boxes as the nodes of a binary tree, a pair or four of them as one.

use std::sync::Arc;

use super::ball::{Ball, Content};
use super::piece::Piece;
use crate::math::Vec3;
use crate::shape::Cloud;
use crate::shape::cloud::OCTET;

/// Eight boxes, by axis; places beyond the last box repeat it.
#[derive(Clone, Copy, Debug)]
pub struct Boxes {
    /// Least coordinates (m).
    pub low: [[f32; OCTET]; 3],
    /// Greatest coordinates (m).
    pub high: [[f32; OCTET]; 3],
}

/// The cells of a cloud, all of them swept by one ball, about the cloud's origin.
#[derive(Clone, Debug)]
pub struct CellTree {
    cloud: Arc<Cloud>,
    /// By level, the lowest first; the last is one octet. None over a single octet of cells.
    levels: Arc<[Vec<Boxes>]>,
    /// Mean half diagonal of the first members of octets, by level (m): that of cells first.
    sizes: Arc<[f32]>,
    radius: f64,
}

/// A node of the binary tree: cells `place << height` and on.
#[derive(Clone, Copy)]
struct Node {
    height: u32,
    place: usize,
}

/// Bits of a node's number that say its place.
const PLACE: u32 = 27;
/// log₂ of [`OCTET`].
const STEP: u32 = OCTET.trailing_zeros();
/// Relative, covers the rounding of a ball's radius.
const ROUNDING: f64 = 1e-12;

impl Boxes {
    const NONE: Self = Self {
        low: [[f32::INFINITY; OCTET]; 3],
        high: [[f32::NEG_INFINITY; OCTET]; 3],
    };

    /// The box around the cells of an octet.
    fn around_cells(cloud: &Cloud, octet: usize) -> [[f32; 3]; 2] {
        let centers = &cloud.centers()[octet];
        let Some(halves) = cloud.halves().get(octet) else {
            return [least, greatest].map(|end| centers.each_ref().map(end));
        };
        // A sum that is rounded must not be inside of its box.
        let ends = |toward: fn(f32, f32) -> f32| {
            centers.map(|axis| std::array::from_fn(|lane| toward(axis[lane], halves[lane])))
        };
        let lows: [[f32; OCTET]; 3] = ends(|center, half| (center - half).next_down());
        let highs: [[f32; OCTET]; 3] = ends(|center, half| (center + half).next_up());
        [lows.each_ref().map(least), highs.each_ref().map(greatest)]
    }

    /// The box around eight.
    fn around(&self) -> [[f32; 3]; 2] {
        [
            self.low.each_ref().map(least),
            self.high.each_ref().map(greatest),
        ]
    }

    fn set(&mut self, lane: usize, [low, high]: [[f32; 3]; 2]) {
        for axis in 0..3 {
            self.low[axis][lane] = low[axis];
            self.high[axis][lane] = high[axis];
        }
    }

    fn get(&self, lane: usize) -> [Vec3; 2] {
        [&self.low, &self.high]
            .map(|corner| Vec3::from_array(corner.map(|axis| f64::from(axis[lane]))))
    }
}

#[inline]
fn least(values: &[f32; OCTET]) -> f32 {
    values
        .iter()
        .copied()
        .fold(f32::INFINITY, f32::min)
}

#[inline]
fn greatest(values: &[f32; OCTET]) -> f32 {
    values
        .iter()
        .copied()
        .fold(f32::NEG_INFINITY, f32::max)
}

/// Boxes over so many octets, given by number.
fn level(count: usize, around: impl Fn(usize) -> [[f32; 3]; 2]) -> Vec<Boxes> {
    let mut boxes = vec![Boxes::NONE; count.div_ceil(OCTET)];
    let mut last = around(0);
    for place in 0..boxes.len() * OCTET {
        if place < count {
            last = around(place);
        }
        boxes[place / OCTET].set(place % OCTET, last);
    }
    boxes
}

/// Of one member of each octet: enough to know how fine they are.
fn half_diagonals(level: &[Boxes]) -> impl Iterator<Item = f32> {
    let first = level.iter().map(|boxes| boxes.get(0));
    first.map(|[low, high]| (high - low).length() as f32 / 2.0)
}

/// 0 of none.
fn mean(values: impl Iterator<Item = f32>) -> f32 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / f32::max(count, 1.0)
}

impl CellTree {
    /// The tree over a cloud.
    pub fn new(cloud: Arc<Cloud>) -> Self {
        let mut levels: Vec<Vec<Boxes>> = Vec::new();
        let mut count = cloud.centers().len();
        while count > 1 {
            let next = match levels.last() {
                None => level(count, |octet| Boxes::around_cells(&cloud, octet)),
                Some(below) => level(count, |octet| below[octet].around()),
            };
            count = next.len();
            levels.push(next);
        }
        let halves = cloud.halves().as_flattened();
        let sizes = std::iter::once(mean(halves.iter().map(|half| half * 3.0_f32.sqrt())));
        let sizes = sizes.chain(
            levels
                .iter()
                .map(|level| mean(half_diagonals(level))),
        );
        Self {
            radius: cloud.radius(),
            cloud,
            sizes: sizes.collect(),
            levels: levels.into(),
        }
    }

    /// The same tree, its cells swept by a ball thicker by `padding` (m).
    #[must_use]
    pub fn padded(&self, padding: f64) -> Self {
        Self {
            radius: self.radius + padding,
            ..self.clone()
        }
    }

    /// Memory of cells and boxes (bytes).
    pub fn bytes(&self) -> usize {
        let boxes = self
            .levels
            .iter()
            .map(|level| size_of_val(&**level));
        self.cloud.bytes() + boxes.sum::<usize>()
    }

    /// Its cells.
    pub fn cloud(&self) -> &Cloud {
        &self.cloud
    }

    /// Boxes by level, the lowest first.
    pub fn levels(&self) -> &[Vec<Boxes>] {
        &self.levels
    }

    /// Mean half diagonal of the first members of octets (m), by level: of cells, then of boxes.
    pub fn sizes(&self) -> &[f32] {
        &self.sizes
    }

    /// Radius of the ball that sweeps every cell (m).
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Corners of the box around all cells, without the ball (m).
    pub fn bounds(&self) -> [Vec3; 2] {
        self.bounds_of(self.node(0))
    }

    /// One cell, by its place.
    pub fn piece(&self, place: u32) -> Piece {
        Piece::of_cell(self.cloud.cell(place as usize), self.radius)
    }

    /// The place of the cell nearest to a point.
    pub fn nearest(&self, point: Vec3) -> usize {
        let mut best = (f64::INFINITY, 0);
        let mut open = vec![0];
        let away = |index: u32| {
            let [low, high] = self.bounds_of(self.node(index));
            point.distance(point.clamp(low, high))
        };
        while let Some(index) = open.pop() {
            let distance = away(index);
            if distance >= best.0 {
                continue;
            }
            match self.content(self.node(index)) {
                Content::Piece(place) => best = (distance, place as usize),
                Content::Balls(left, right) if away(left) < away(right) => {
                    open.extend([right, left]);
                }
                Content::Balls(left, right) => open.extend([left, right]),
            }
        }
        best.1
    }

    /// The box of a node, swept by the ball: it is convex and holds all that is below.
    pub fn box_of(&self, index: u32) -> Piece {
        let node = self.node(index);
        match node.height {
            0 => self.piece(node.place as u32),
            _ => Piece::of_bounds(self.bounds_of(node), self.radius),
        }
    }

    /// A node as a ball, and what is below it.
    pub fn ball(&self, index: u32) -> Ball {
        let node = self.node(index);
        let [low, high] = self.bounds_of(node);
        Ball {
            center: (low + high) / 2.0,
            radius: (high - low).length() / 2.0 * (1.0 + ROUNDING) + self.radius,
            content: self.content(node),
        }
    }

    fn content(&self, node: Node) -> Content {
        if node.height == 0 {
            return Content::Piece(node.place as u32);
        }
        let halves = [2 * node.place, 2 * node.place + 1].map(|place| Node {
            height: node.height - 1,
            place,
        });
        let [left, right] = halves.map(|half| self.index(half));
        Content::Balls(left, right)
    }

    /// Height of the root.
    fn height(&self) -> u32 {
        self.cloud
            .len()
            .next_power_of_two()
            .trailing_zeros()
    }

    fn node(&self, index: u32) -> Node {
        Node {
            height: self.height() - (index >> PLACE),
            place: index as usize & ((1 << PLACE) - 1),
        }
    }

    /// The number of the lowest node with all that is below this one.
    fn index(&self, Node { height, place }: Node) -> u32 {
        let cells = self.cloud.len() - (place << height);
        let lower = height.min(cells.next_power_of_two().trailing_zeros());
        let place = place << (height - lower);
        (self.height() - lower) << PLACE | place as u32
    }

    fn bounds_of(&self, Node { height, place }: Node) -> [Vec3; 2] {
        // Over the octet at the top there is no box: the whole is the eight together.
        let level = (height / STEP).min(self.levels.len() as u32);
        let shift = height - STEP * level;
        let first = place << shift;
        let last = (place + 1) << shift;
        let boxes = match level as usize {
            0 => return self.bounds_of_cells(first..last.min(self.cloud.len())),
            level => &self.levels[level - 1],
        };
        let last = last.min(boxes.len() * OCTET);
        let boxes = (first..last).map(|place| boxes[place / OCTET].get(place % OCTET));
        boxes
            .reduce(around_both)
            .unwrap_or([Vec3::ZERO; 2])
    }

    fn bounds_of_cells(&self, places: std::ops::Range<usize>) -> [Vec3; 2] {
        let cell = |place| {
            let cell = self.cloud.cell(place);
            [cell.center - cell.half, cell.center + cell.half]
        };
        places
            .map(cell)
            .reduce(around_both)
            .unwrap_or([Vec3::ZERO; 2])
    }
}

#[inline]
fn around_both([low, high]: [Vec3; 2], [l, h]: [Vec3; 2]) -> [Vec3; 2] {
    [low.min(l), high.max(h)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Voxel;
    use crate::testing::vector;

    fn clouds(rng: &mut fastrand::Rng, count: usize) -> [Cloud; 2] {
        let centers: Vec<_> = (0..count)
            .map(|_| vector(rng, 2.0).to_array())
            .collect();
        let voxel = |&center: &[f64; 3]| Voxel {
            center,
            size: 0.02 * f64::from(1 << rng.u32(..4)),
        };
        let voxels: Vec<_> = centers.iter().map(voxel).collect();
        [
            Cloud::of_points(centers, 0.01).unwrap(),
            Cloud::of_voxels(&voxels).unwrap(),
        ]
    }

    /// Places below a node.
    fn below(tree: &CellTree, index: u32, places: &mut Vec<u32>) {
        match tree.ball(index).content {
            Content::Piece(place) => places.push(place),
            Content::Balls(left, right) => {
                below(tree, left, places);
                below(tree, right, places);
            }
        }
    }

    fn check_node(tree: &CellTree, index: u32) {
        let mut places = Vec::new();
        below(tree, index, &mut places);
        let ball = tree.ball(index);
        let hull = tree.box_of(index);
        assert_eq!(hull.center(), ball.center);
        for &place in &places {
            let piece = tree.piece(place);
            assert!(piece.farthest(ball.center) <= ball.radius);
            for axis in [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z] {
                let beyond = (piece.core.support(axis) - hull.core.support(axis)).dot(axis);
                assert!(beyond <= 1e-15, "{beyond}");
            }
        }
        if let Content::Balls(left, right) = ball.content {
            check_node(tree, left);
            check_node(tree, right);
        }
    }

    #[test]
    fn every_node_holds_what_is_below_it_and_every_cell_is_below_the_root_once() {
        let mut rng = fastrand::Rng::with_seed(3);
        for count in [1, 2, 3, 8, 9, 63, 64, 65, 700] {
            for cloud in clouds(&mut rng, count) {
                let tree = CellTree::new(Arc::new(cloud));
                let mut places = Vec::new();
                below(&tree, 0, &mut places);
                assert!(places.into_iter().eq(0..count as u32), "{count} cells");
                check_node(&tree, 0);
            }
        }
    }

    #[test]
    fn the_nearest_cell_is_the_nearest() {
        let mut rng = fastrand::Rng::with_seed(6);
        for cloud in clouds(&mut rng, 300) {
            let tree = CellTree::new(Arc::new(cloud));
            let away = |point: Vec3, place: usize| {
                let cell = tree.cloud().cell(place);
                let half = Vec3::splat(cell.half);
                point.distance(point.clamp(cell.center - half, cell.center + half))
            };
            for _ in 0..100 {
                let point = vector(&mut rng, 3.0);
                let found = away(point, tree.nearest(point));
                let least = (0..300).map(|place| away(point, place));
                assert_eq!(found, least.fold(f64::INFINITY, f64::min));
            }
        }
    }

    #[test]
    fn a_tree_takes_less_than_twenty_bytes_for_a_point() {
        let mut rng = fastrand::Rng::with_seed(4);
        let [points, _] = clouds(&mut rng, 20_000);
        let bytes = CellTree::new(Arc::new(points)).bytes() as f64 / 20_000.0;
        assert!(bytes < 20.0, "{bytes}");
    }
}
