//! Patches of a surface: triangles that hang together by their edges and can be turned over as one.

use std::collections::HashMap;

use super::edges::{Edges, Side, Triangle};
use super::parts::Parts;
use super::volume::{bounds, corners_of, solid_angle, volume};
use crate::math::Vec3;

/// Triangles that hang together by edges.
pub(super) struct Patches {
    sides: Vec<Side>,
    /// The patch of each triangle: the first triangle of it.
    of: Vec<usize>,
}

impl Patches {
    /// Joined by the edges of two triangles.
    pub(super) fn of(triangles: &[Triangle]) -> Self {
        Self::by_edges(triangles, |count| count == 2)
    }

    /// Joined by the edges of as many triangles as `joins` says.
    pub(super) fn by_edges(triangles: &[Triangle], joins: impl Fn(usize) -> bool) -> Self {
        let sides = Side::all(triangles);
        let mut parts = Parts::apart(triangles.len());
        for edge in edges(&sides).filter(|edge| joins(edge.len())) {
            parts.join(edge.iter().map(|side| side.triangle));
        }
        let of = (0..triangles.len())
            .map(|at| parts.of(at))
            .collect();
        Self { sides, of }
    }

    /// For each triangle, whether its patch has no border.
    pub(super) fn closed(&self) -> Vec<bool> {
        let mut open = vec![false; self.of.len()];
        for edge in edges(&self.sides) {
            open[self.of[edge[0].triangle]] |= edge.len() % 2 == 1;
        }
        self.of
            .iter()
            .map(|patch| !open[*patch])
            .collect()
    }

    /// Turns triangles over so that those of a patch face the same way, as most of them did; a
    /// patch in which that cannot be stays as it is.
    pub(super) fn face_one_way(&self, triangles: &mut [Triangle]) {
        let mut walk = Walk::new(self.neighbours(triangles.len()));
        for first in 0..triangles.len() {
            if walk.turned[first].is_none() {
                let turned = walk.turned_from(first);
                turn_over(triangles, &turned);
            }
        }
    }

    /// For each triangle those beyond its edges, and whether the two face the same way.
    fn neighbours(&self, triangles: usize) -> Vec<Vec<(usize, bool)>> {
        let mut neighbours = vec![Vec::new(); triangles];
        for edge in edges(&self.sides) {
            if let [a, b] = edge {
                let agree = a.is_forward != b.is_forward;
                neighbours[a.triangle].push((b.triangle, agree));
                neighbours[b.triangle].push((a.triangle, agree));
            }
        }
        neighbours
    }

    /// Turns closed patches over that face the other way than the whole, unless they lie within it:
    /// cavities.
    pub(super) fn face_outwards(&self, vertices: &[Vec3], triangles: &mut [Triangle]) {
        let closed = self.closed_patches(vertices, triangles);
        let volumes = closed.iter().map(|patch| patch.volume);
        let sign = volumes.sum::<f64>().signum();
        let (facing, other): (Vec<Patch>, Vec<Patch>) = closed
            .into_iter()
            .partition(|patch| patch.volume * sign >= 0.0);
        for patch in other {
            if !patch.is_within(&facing, vertices, triangles) {
                turn_over(triangles, &patch.members);
            }
        }
    }

    fn closed_patches(&self, vertices: &[Vec3], triangles: &[Triangle]) -> Vec<Patch> {
        let members = self.members().into_values();
        let mut closed: Vec<Patch> = members
            .filter_map(|members| Patch::closed(vertices, triangles, members))
            .collect();
        closed.sort_by_key(|patch| patch.members[0]);
        closed
    }

    fn members(&self) -> HashMap<usize, Vec<usize>> {
        let mut members: HashMap<usize, Vec<usize>> = HashMap::new();
        for (triangle, patch) in self.of.iter().enumerate() {
            members
                .entry(*patch)
                .or_default()
                .push(triangle);
        }
        members
    }
}

/// Sides, edge by edge.
fn edges(sides: &[Side]) -> impl Iterator<Item = &[Side]> {
    sides.chunk_by(|a, b| a.edge == b.edge)
}

fn turn_over(triangles: &mut [Triangle], members: &[usize]) {
    members
        .iter()
        .for_each(|&at| triangles[at].swap(1, 2));
}

/// A walk over the triangles of a surface, from neighbour to neighbour.
struct Walk {
    neighbours: Vec<Vec<(usize, bool)>>,
    /// Whether a triangle that was reached must turn, to face as the first of its patch does.
    turned: Vec<Option<bool>>,
}

impl Walk {
    fn new(neighbours: Vec<Vec<(usize, bool)>>) -> Self {
        Self {
            turned: vec![None; neighbours.len()],
            neighbours,
        }
    }

    /// Walks one patch; those of its triangles that must turn, the fewer ones, if that can be.
    fn turned_from(&mut self, first: usize) -> Vec<usize> {
        self.turned[first] = Some(false);
        let mut patch = vec![first];
        let mut next = 0;
        let mut can_be = true;
        while let Some(&triangle) = patch.get(next) {
            next += 1;
            can_be &= self.reach_neighbours(triangle, &mut patch);
        }
        if can_be {
            self.fewer(patch)
        } else {
            Vec::new()
        }
    }

    /// Adds the neighbours that were not reached before; whether those that were face as they
    /// should.
    fn reach_neighbours(&mut self, triangle: usize, patch: &mut Vec<usize>) -> bool {
        let mut can_be = true;
        for &(other, agree) in &self.neighbours[triangle] {
            let wanted = (self.turned[triangle] == Some(true)) == agree;
            if self.turned[other].is_none() {
                patch.push(other);
            }
            can_be &= *self.turned[other].get_or_insert(wanted) == wanted;
        }
        can_be
    }

    /// Those that turn, or those that do not, whichever are fewer.
    fn fewer(&self, mut patch: Vec<usize>) -> Vec<usize> {
        let turns = |triangle: &usize| self.turned[*triangle] == Some(true);
        let count = patch
            .iter()
            .filter(|triangle| turns(triangle))
            .count();
        let most = 2 * count > patch.len();
        patch.retain(|triangle| turns(triangle) != most);
        patch
    }
}

/// A closed patch.
struct Patch {
    members: Vec<usize>,
    volume: f64,
    low: Vec3,
    high: Vec3,
}

impl Patch {
    fn closed(vertices: &[Vec3], triangles: &[Triangle], members: Vec<usize>) -> Option<Self> {
        let own: Vec<Triangle> = members
            .iter()
            .map(|&at| triangles[at])
            .collect();
        if !Edges::of(&own).are_closed() {
            return None;
        }
        let (low, high) = bounds(corners_of(vertices, &own));
        Some(Self {
            members,
            volume: volume(vertices, &own),
            low,
            high,
        })
    }

    /// Whether its box lies within the other's.
    fn fits_in(&self, outer: &Self) -> bool {
        outer.low.cmple(self.low).all() && self.high.cmple(outer.high).all()
    }

    /// Whether it lies inside of others: their winding number around one of its corners is not 0.
    fn is_within(&self, others: &[Self], vertices: &[Vec3], triangles: &[Triangle]) -> bool {
        let point = vertices[triangles[self.members[0]][0] as usize];
        let around = others
            .iter()
            .filter(|outer| self.fits_in(outer));
        let angle: f64 = around
            .flat_map(|outer| &outer.members)
            .map(|&at| solid_angle(triangles[at].map(|i| vertices[i as usize] - point)))
            .sum();
        angle.abs() >= 2.0 * std::f64::consts::PI
    }
}
