//! Meshes, which other records name by their hash.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use taut::math::Vec3;
use taut::shape::{Mesh, PlacedShape};

use super::apart::{Apart, same};
use super::plain::WarningRecord;

/// A mesh as plain data.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct MeshRecord {
    name: String,
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    warnings: Vec<WarningRecord>,
}

impl MeshRecord {
    /// The mesh again; one that has not this hash is refused.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn restore(self, hash: u64) -> Result<Mesh, String> {
        let mesh = self.mesh()?;
        same(mesh.hash(), hash)?;
        Ok(mesh)
    }

    fn mesh(self) -> Result<Mesh, String> {
        let vertices = self
            .vertices
            .into_iter()
            .map(Vec3::from_array)
            .collect();
        let warnings = WarningRecord::restored(self.warnings);
        Mesh::restore(self.name, vertices, self.triangles, warnings)
            .map_err(|error| error.to_string())
    }
}

impl From<&Mesh> for MeshRecord {
    fn from(mesh: &Mesh) -> Self {
        Self {
            name: mesh.name().to_owned(),
            vertices: mesh
                .vertices()
                .iter()
                .map(Vec3::to_array)
                .collect(),
            triangles: mesh.triangles().to_vec(),
            warnings: WarningRecord::all(mesh.warnings()),
        }
    }
}

impl Apart for Mesh {
    type Record = MeshRecord;

    const FOLDER: &'static str = "meshes";

    fn hash(&self) -> u64 {
        Mesh::hash(self)
    }

    fn of(placed: &PlacedShape) -> Option<&Arc<Self>> {
        placed.shape.mesh()
    }

    fn record(&self) -> MeshRecord {
        MeshRecord::from(self)
    }

    fn restored(record: MeshRecord, hash: u64) -> Result<Self, String> {
        record.restore(hash)
    }
}
