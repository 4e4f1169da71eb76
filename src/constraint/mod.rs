//! What must hold on a path besides clearance: where a point or a direction of a link may be.
//!
//! A constraint watches a vector: a point of a link, a direction fixed in it, or a joint's value, as a
//! frame sees it (the world, or another link). It must stay in a convex region. On an interval of half
//! width h about m, with velocity ẋ(m) and an acceleration of at most A, the vector stays within ½h²A
//! of the straight way between x± = x(m) ± h ẋ(m) (Taylor). So where both ends lie in the region, each
//! at least ½h²A deep, all of it does: a convex region less a margin is convex. One test, whatever the
//! region; along a straight way it is exact to second order.

pub mod region;
pub mod watched;

pub use region::{HalfSpace, Region};
pub use watched::{Vector, Watched};

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

impl Held {
    /// How deep a vector is in the region that it is deepest in: negative outside of all of them (m for
    /// a point; for a direction, as a point of the unit sphere; m or rad for a joint).
    pub fn depth(&self, at: crate::math::Vec3) -> f64 {
        let depths = self.regions.iter().map(|region| region.depth(at));
        depths.fold(f64::NEG_INFINITY, f64::max)
    }

    /// Depth that the vector keeps, in one region, on an interval between whose ends it goes nearly
    /// straight: `ends` are x(m) ± h ẋ(m), `bend` is ½h²A.
    pub fn kept(&self, ends: [crate::math::Vec3; 2], bend: f64) -> f64 {
        let kept = |region: &Region| region.depth(ends[0]).min(region.depth(ends[1])) - bend;
        self.regions
            .iter()
            .map(kept)
            .fold(f64::NEG_INFINITY, f64::max)
    }
}
