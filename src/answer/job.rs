//! What is to be computed.

use crate::optimize::Settings;
use crate::path::Path;
use crate::store::Snapshot;
use crate::translate::Timing;

/// What is to be computed.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    /// Robot and scene.
    pub snapshot: &'a Snapshot,
    /// The path, its numbers unchecked.
    pub path: &'a Path,
    /// What is asked for.
    pub settings: &'a Settings,
    /// What is asked of its times, if anything is.
    pub timing: Option<&'a Timing>,
}
