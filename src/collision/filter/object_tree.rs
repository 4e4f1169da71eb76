//! Trees over many obstacles: what is far from a body as a whole is not looked at one by one.

use std::cmp::Ordering;

use crate::math::Vec3;
use crate::solid::hulls::{FilterObject, Hull, box_hull};

/// A node of a tree over obstacles, in preorder.
#[derive(Clone, Copy, Debug)]
pub struct ObjectNode {
    /// Encloses all below.
    pub hull: Hull,
    /// Where to go on when nothing below is near.
    pub skip: u32,
    /// The pair and the object that a leaf stands for.
    pub leaf: Option<(u32, u32)>,
}

/// Leaves below a node of a tree.
const BUNCH: usize = 6;

/// A tree over `(pair, object)` leaves, given by pair; a few leaves need none.
pub fn tree(leaves: &[(u32, u32)], objects: &[FilterObject]) -> Vec<ObjectNode> {
    let leaf = |&(pair, object): &(u32, u32)| Leaf {
        pair,
        object,
        middle: objects[object as usize].middle,
    };
    let mut leaves: Vec<_> = leaves.iter().map(leaf).collect();
    let mut nodes = Vec::with_capacity(leaves.len() * 3 / 2);
    grow(&mut leaves, objects, &mut nodes, Order::default());
    nodes
}

/// A leaf while the tree grows.
#[derive(Clone, Copy)]
struct Leaf {
    pair: u32,
    object: u32,
    middle: [f64; 3],
}

/// How leaves are in order below some splits: as if they had been sorted at each of them by the
/// middle along its axis, the last time last, and equal ones had stayed as they were.
#[derive(Clone, Copy, Default)]
struct Order {
    /// Axes of the splits, the last first, each once.
    axes: [usize; 3],
    count: usize,
}

impl Order {
    fn after(self, axis: usize) -> Self {
        let mut next = Self {
            axes: [axis; 3],
            count: 1,
        };
        for &other in self.axes[..self.count]
            .iter()
            .filter(|&&other| other != axis)
        {
            next.axes[next.count] = other;
            next.count += 1;
        }
        next
    }

    fn compare(&self, a: &Leaf, b: &Leaf) -> Ordering {
        let along = |&axis: &usize| a.middle[axis].total_cmp(&b.middle[axis]);
        let unequal = self.axes[..self.count]
            .iter()
            .map(along)
            .find(|order| order.is_ne());
        unequal.unwrap_or_else(|| a.pair.cmp(&b.pair))
    }
}

fn grow(leaves: &mut [Leaf], objects: &[FilterObject], nodes: &mut Vec<ObjectNode>, order: Order) {
    let is_root = order.count == 0;
    let few = if is_root { 2 * BUNCH } else { BUNCH };
    let bounds = leaves
        .iter()
        .map(|leaf| objects[leaf.object as usize].bounds);
    let [low, high] = bounds.fold(
        [Vec3::INFINITY, Vec3::NEG_INFINITY],
        |[low, high], [l, h]| [low.min(l), high.max(h)],
    );
    let own = nodes.len();
    if !is_root {
        nodes.push(ObjectNode {
            hull: box_hull([low, high]),
            skip: 0,
            leaf: None,
        });
    }
    if leaves.len() <= few {
        leaves.sort_unstable_by(|a, b| order.compare(a, b));
        for leaf in leaves {
            let hull = objects[leaf.object as usize].hull;
            nodes.push(ObjectNode {
                hull,
                skip: nodes.len() as u32 + 1,
                leaf: Some((leaf.pair, leaf.object)),
            });
        }
    } else {
        let axis = (0..3)
            .max_by(|&i, &j| (high - low)[i].total_cmp(&(high - low)[j]))
            .unwrap_or(0);
        let order = order.after(axis);
        let half = leaves.len() / 2;
        leaves.select_nth_unstable_by(half, |a, b| order.compare(a, b));
        let (near, far) = leaves.split_at_mut(half);
        grow(near, objects, nodes, order);
        grow(far, objects, nodes, order);
    }
    if !is_root {
        nodes[own].skip = nodes.len() as u32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Mat3;
    use crate::solid::core::Core;
    use crate::solid::hulls::SolidHulls;
    use crate::solid::piece::Piece;
    use crate::solid::transform::Transform;

    /// The same tree by the definition: leaves are sorted at every split, and equal ones stay in
    /// their order.
    fn by_sorting(
        leaves: &mut [(u32, u32)],
        objects: &[FilterObject],
        nodes: &mut Vec<ObjectNode>,
        is_root: bool,
    ) {
        let few = if is_root { 2 * BUNCH } else { BUNCH };
        let corners = leaves
            .iter()
            .map(|leaf| objects[leaf.1 as usize].bounds);
        let [low, high] = corners.fold(
            [Vec3::INFINITY, Vec3::NEG_INFINITY],
            |[low, high], [l, h]| [low.min(l), high.max(h)],
        );
        let own = nodes.len();
        if !is_root {
            nodes.push(ObjectNode {
                hull: box_hull([low, high]),
                skip: 0,
                leaf: None,
            });
        }
        if leaves.len() <= few {
            for leaf in leaves {
                let hull = objects[leaf.1 as usize].hull;
                nodes.push(ObjectNode {
                    hull,
                    skip: nodes.len() as u32 + 1,
                    leaf: Some(*leaf),
                });
            }
        } else {
            let axis = (0..3)
                .max_by(|&i, &j| (high - low)[i].total_cmp(&(high - low)[j]))
                .unwrap();
            leaves.sort_by(|a, b| {
                objects[a.1 as usize].middle[axis].total_cmp(&objects[b.1 as usize].middle[axis])
            });
            let (near, far) = leaves.split_at_mut(leaves.len() / 2);
            by_sorting(near, objects, nodes, false);
            by_sorting(far, objects, nodes, false);
        }
        if !is_root {
            nodes[own].skip = nodes.len() as u32;
        }
    }

    /// Objects on a coarse grid, many of which are equal along an axis or two.
    #[test]
    fn trees_are_those_that_sorting_makes() {
        let mut rng = fastrand::Rng::with_seed(12);
        let hulls = SolidHulls::new(&[Piece {
            core: Core::Point(Vec3::ZERO),
            radius: 0.1,
        }]);
        for count in (0..40).chain([100, 500]) {
            let mut on_grid = || f64::from(rng.i32(-3..4)) * 0.25;
            let mut object = || {
                let place = Transform {
                    rotation: Mat3::IDENTITY,
                    translation: Vec3::new(on_grid(), on_grid(), on_grid()),
                };
                FilterObject::new(&hulls, &place)
            };
            let objects: Vec<_> = (0..count).map(|_| object()).collect();
            let mut leaves: Vec<_> = (0..count)
                .filter(|object| object % 7 != 3)
                .map(|object| (object + 5, object))
                .collect();
            let grown = tree(&leaves, &objects);
            let mut sorted = Vec::new();
            by_sorting(&mut leaves, &objects, &mut sorted, true);
            assert!(
                format!("{grown:?}") == format!("{sorted:?}"),
                "{count} objects"
            );
        }
    }
}
