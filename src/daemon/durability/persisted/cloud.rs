//! Clouds. They are no frames of a sensor, which nobody keeps, but what somebody loaded.

use serde::{Deserialize, Serialize};
use taut::shape::Cloud;
use taut::shape::cloud::{CloudKind, CloudParts};

/// A cloud as plain data.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct CloudRecord {
    /// Of points; voxels have none.
    radius: Option<f64>,
    origin: [f64; 3],
    rounding: f64,
    cells: Vec<[f32; 4]>,
    numbers: Vec<u32>,
}

impl From<&Cloud> for CloudRecord {
    fn from(cloud: &Cloud) -> Self {
        let CloudParts {
            kind,
            origin,
            rounding,
            cells,
            numbers,
        } = cloud.parts();
        let radius = match kind {
            CloudKind::Points { radius } => Some(radius),
            CloudKind::Voxels => None,
        };
        Self {
            radius,
            origin,
            rounding,
            cells,
            numbers,
        }
    }
}

impl CloudRecord {
    /// The cloud again.
    ///
    /// # Errors
    /// What is wrong with it.
    pub(super) fn restore(&self) -> Result<Cloud, String> {
        let kind = self
            .radius
            .map_or(CloudKind::Voxels, |radius| CloudKind::Points { radius });
        let parts = CloudParts {
            kind,
            origin: self.origin,
            rounding: self.rounding,
            cells: self.cells.clone(),
            numbers: self.numbers.clone(),
        };
        Cloud::restore(&parts).map_err(|error| error.to_string())
    }
}
