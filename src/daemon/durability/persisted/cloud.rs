//! Clouds, which other records name by their hash. They are no frames of a sensor, which nobody
//! keeps, but what somebody loaded.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use taut::shape::cloud::{CloudKind, CloudParts, Making, Provenance, Source, Unknown};
use taut::shape::{Cloud, PlacedShape};

use super::apart::{Apart, same};
use super::plain::WarningRecord;

/// A cloud as plain data.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct CloudRecord {
    /// Of points; voxels have none.
    radius: Option<f64>,
    origin: [f64; 3],
    rounding: f64,
    cells: Vec<[f32; 4]>,
    numbers: Vec<u32>,
    source: Option<SourceRecord>,
    unknown_from: Option<u64>,
    warnings: Vec<WarningRecord>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct SourceRecord {
    file: String,
    making: MakingRecord,
}

/// New kinds stand last: files name a kind by its number.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
enum MakingRecord {
    Points { radius: f64, thin: Option<f64> },
    Map { is_unknown_solid: bool },
}

impl From<&Source> for SourceRecord {
    fn from(source: &Source) -> Self {
        let making = match source.making {
            Making::Points { radius, thin } => MakingRecord::Points { radius, thin },
            Making::Map { unknown } => MakingRecord::Map {
                is_unknown_solid: unknown == Unknown::Obstacle,
            },
        };
        Self {
            file: source.file.clone(),
            making,
        }
    }
}

impl From<SourceRecord> for Source {
    fn from(record: SourceRecord) -> Self {
        let making = match record.making {
            MakingRecord::Points { radius, thin } => Making::Points { radius, thin },
            MakingRecord::Map { is_unknown_solid } => Making::Map {
                unknown: match is_unknown_solid {
                    true => Unknown::Obstacle,
                    false => Unknown::Free,
                },
            },
        };
        Self {
            file: record.file,
            making,
        }
    }
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
        let provenance = cloud.provenance();
        Self {
            radius,
            origin,
            rounding,
            cells,
            numbers,
            source: provenance
                .source
                .as_ref()
                .map(SourceRecord::from),
            unknown_from: provenance.unknown_from.map(|from| from as u64),
            warnings: WarningRecord::all(&provenance.warnings),
        }
    }
}

impl CloudRecord {
    fn cloud(self) -> Result<Cloud, String> {
        let kind = self
            .radius
            .map_or(CloudKind::Voxels, |radius| CloudKind::Points { radius });
        let parts = CloudParts {
            kind,
            origin: self.origin,
            rounding: self.rounding,
            cells: self.cells,
            numbers: self.numbers,
        };
        let cloud = Cloud::restore(&parts).map_err(|error| error.to_string())?;
        Ok(cloud.with_provenance(Provenance {
            source: self.source.map(Source::from),
            unknown_from: self.unknown_from.map(|from| from as usize),
            warnings: WarningRecord::restored(self.warnings),
        }))
    }
}

impl Apart for Cloud {
    type Record = CloudRecord;

    const FOLDER: &'static str = "clouds";

    fn hash(&self) -> u64 {
        Cloud::hash(self)
    }

    fn of(placed: &PlacedShape) -> Option<&Arc<Self>> {
        placed.shape.cloud()
    }

    fn record(&self) -> CloudRecord {
        CloudRecord::from(self)
    }

    fn restored(record: CloudRecord, hash: u64) -> Result<Self, String> {
        let cloud = record.cloud()?;
        same(cloud.hash(), hash)?;
        Ok(cloud)
    }
}
