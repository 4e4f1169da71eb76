//! What is large and stands apart: other records name it by its hash.

use std::sync::Arc;

use serde::Serialize;
use serde::de::DeserializeOwned;
use taut::shape::{Cloud, Mesh, PlacedShape};

/// A mesh or a cloud.
pub(crate) trait Apart: Sized {
    /// It as plain data.
    type Record: Serialize + DeserializeOwned;

    /// The folder of its kind's files.
    const FOLDER: &'static str;

    /// Hash of its content.
    fn hash(&self) -> u64;

    /// That of a shape, if it is one of this kind.
    fn of(placed: &PlacedShape) -> Option<&Arc<Self>>;

    /// It as plain data.
    fn record(&self) -> Self::Record;

    /// It again; one that has not this hash is refused.
    ///
    /// # Errors
    /// What is wrong with it.
    fn restored(record: Self::Record, hash: u64) -> Result<Self, String>;
}

/// Gives what stands apart by its hash.
pub(crate) trait Find {
    /// A mesh.
    ///
    /// # Errors
    /// There is none of this hash.
    fn mesh(&mut self, hash: u64) -> Result<Arc<Mesh>, String>;

    /// A cloud.
    ///
    /// # Errors
    /// There is none of this hash.
    fn cloud(&mut self, hash: u64) -> Result<Arc<Cloud>, String>;
}

/// Refuses a content of another hash than it should have.
pub(super) fn same(found: u64, hash: u64) -> Result<(), String> {
    match found == hash {
        true => Ok(()),
        false => Err(format!(
            "its content has hash {found:016x}, not {hash:016x}"
        )),
    }
}
