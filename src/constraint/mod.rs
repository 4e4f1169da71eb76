//! What must hold on a path besides clearance: where a point or a direction of a link may be.
//!
//! A constraint watches a vector: a point of a link, a direction fixed in it, or a joint's value, as a
//! frame sees it (the world, or another link). It must stay in a convex region. On an interval of half
//! width h about m, with velocity ẋ(m) and an acceleration of at most A, the vector stays within ½h²A
//! of the straight way between x± = x(m) ± h ẋ(m) (Taylor). So where both ends lie in the region, each
//! at least ½h²A deep, all of it does: a convex region less a margin is convex. One test, whatever the
//! region; along a straight way it is exact to second order.

mod build;
mod error;
mod joint;
mod place;
#[cfg(test)]
mod properties;
pub mod region;
mod short;
mod start;
#[cfg(test)]
mod tests;
pub mod watched;
mod words;

pub use build::{Constraint, constraints};
pub use error::ConstraintError;
pub use region::{Cylinder, HalfSpace, Region};
pub use watched::{JointValue, Stand, Vector, Watched};
pub use words::ConstraintsFile;

use crate::math::Vec3;
use region::least;

/// What a constraint is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConstraintKind {
    /// How something is turned (rad).
    Orientation,
    /// Where a point is (m).
    Position,
    /// The value of a joint that turns (rad).
    Angle,
    /// The value of a joint that slides (m).
    Slide,
}

/// A vector and the regions one of which it must be in.
///
/// A union holds where each part of a path lies in one of the regions; where two of them overlap, the
/// path may go from one to the other.
#[derive(Clone, Debug)]
pub struct Held {
    /// What is watched.
    pub watched: Watched,
    /// Where it may be; one at least.
    pub regions: Vec<Region>,
}

/// Part of the boundary of regions: a side of one of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Side {
    /// The region.
    pub region: usize,
    /// Its side.
    pub side: usize,
}

impl Held {
    /// How deep a vector is in the region that it is deepest in: negative outside of all of them (m for
    /// a point; for a direction, as a point of the unit sphere; m or rad for a joint).
    pub fn depth(&self, at: Vec3) -> f64 {
        let depths = self
            .regions
            .iter()
            .map(|region| region.depth(at));
        depths.fold(f64::NEG_INFINITY, f64::max)
    }

    /// How much of the tolerance is left, in its unit (rad for directions and turning joints, else m);
    /// negative outside.
    pub fn left(&self, at: Vec3) -> f64 {
        let left = self
            .regions
            .iter()
            .map(|region| region.left(at));
        left.fold(f64::NEG_INFINITY, f64::max)
    }

    /// The same with tolerances greater by this.
    #[must_use]
    pub fn widened(&self, by: f64) -> Self {
        Self {
            watched: self.watched.clone(),
            regions: self
                .regions
                .iter()
                .map(|region| region.widened(by))
                .collect(),
        }
    }

    /// The least tolerance of any region.
    pub fn tolerance(&self) -> f64 {
        let tolerances = self.regions.iter().map(Region::tolerance);
        tolerances.fold(f64::INFINITY, f64::min)
    }

    /// What is turned or away by, and how much may be, of what leaves so much: where one number says it.
    pub fn reading(&self, left: f64) -> Option<(f64, f64)> {
        match self.regions.as_slice() {
            [region @ (Region::Cone { .. } | Region::EulerZ { .. } | Region::Ball { .. })] => {
                let allowed = region.tolerance();
                Some((allowed - left, allowed))
            }
            _ => None,
        }
    }

    /// Whether a proof can rest on every region.
    pub fn is_convex(&self) -> bool {
        self.regions.iter().all(Region::is_convex)
    }

    /// Which part of the boundary is nearest to a vector: of the region that it is deepest in, or
    /// nearest to.
    pub fn side(&self, at: Vec3) -> Side {
        let regions = self.regions.iter().enumerate();
        let deepest = regions.max_by(|(_, a), (_, b)| a.depth(at).total_cmp(&b.depth(at)));
        deepest.map_or(Side::default(), |(region, it)| Side {
            region,
            side: it.side(at),
        })
    }

    /// Distance of a vector to a part of the boundary, negative beyond it, and the outward direction
    /// there, of length 1.
    pub fn beside(&self, Side { region, side }: Side, at: Vec3) -> (f64, Vec3) {
        self.regions[region].beside(side, at)
    }

    /// Depth that the vector keeps, in one region, on an interval between whose ends it goes nearly
    /// straight: `ends` are x(m) ± h ẋ(m), `bend` is ½h²A.
    pub fn kept(&self, ends: [Vec3; 2], bend: f64) -> f64 {
        let kept = |region: &Region| least(region.depth(ends[0]), region.depth(ends[1])) - bend;
        self.regions
            .iter()
            .map(kept)
            .fold(f64::NEG_INFINITY, f64::max)
    }
}
