//! Why points or voxels are no cloud.

use super::MOST_CELLS;

/// What no cloud is made of.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CloudError {
    /// There is nothing.
    #[error("a cloud of 0 points: give at least 1, or leave the object out")]
    Empty,
    /// There is too much.
    #[error(
        "a cloud of {0} points, at most {MOST_CELLS} are taken: thin it, or give several objects"
    )]
    TooMany(usize),
    /// A coordinate is none.
    #[error("point {index} is {point:?}, it must be finite: leave out what the sensor did not see")]
    NotFinite {
        /// The first such point, from 0.
        index: usize,
        /// Its coordinates (m).
        point: [f64; 3],
    },
    /// A radius that no ball has.
    #[error(
        "the radius of a cloud's points is {0} m, it must be finite and greater than 0: half of the points' spacing closes a surface"
    )]
    Radius(f64),
    /// A size that no voxel has.
    #[error("the size of a voxel is {0} m, it must be finite and greater than 0")]
    Size(f64),
    /// Cells are small, and far apart.
    #[error(
        "coordinates about the middle of the cloud lose up to {rounding:.1e} m, too much for a radius or half size of {least} m: cut the cloud into several objects, or give a larger radius"
    )]
    Wide {
        /// What is lost (m).
        rounding: f64,
        /// The radius, or half the size of the smallest voxel (m).
        least: f64,
    },
}
