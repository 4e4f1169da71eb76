//! What the rows of a set, or of several sets, amount to.
//!
//! An answer that is not proved is the path given, so it counts with the length 1 everywhere.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use super::meshes::Meshes;
use super::mode_summary::ModeSummary;
use super::peer_summary::PeerSummary;
use super::row::Row;
use crate::statistics::median;

/// Figures of a set or of several.
#[derive(Debug, Serialize)]
pub(super) struct Summary {
    /// Its name.
    pub set: String,
    /// Its problems, those that could not be run included.
    pub problems: usize,
    /// Median of the distance of the ends, as a part of the length.
    pub lower_bound: Option<f64>,
    /// Ours by mode.
    pub modes: BTreeMap<&'static str, ModeSummary>,
    /// Recorded peers by name.
    pub peers: BTreeMap<String, PeerSummary>,
    /// The best honest peer of each path, taken together.
    pub best_honest_peer: Option<PeerSummary>,
    /// Checks with the exact meshes, where recorded.
    pub mesh_check: Option<Meshes>,
}

impl Summary {
    /// Of rows, for modes at so many budgets.
    pub(super) fn of(set: &str, rows: &[&Row], modes: &[&'static str], budgets: usize) -> Self {
        let mode =
            |mode: &&'static str| Some((*mode, ModeSummary::of(rows, mode, modes, budgets)?));
        Self {
            set: set.to_owned(),
            problems: rows.len(),
            lower_bound: median(
                rows.iter()
                    .filter_map(|row| row.lower_bound_ratio()),
            ),
            modes: modes.iter().filter_map(mode).collect(),
            peers: peers(rows, modes),
            best_honest_peer: best_honest_peer(rows, modes),
            mesh_check: Meshes::of(rows, modes),
        }
    }
}

/// Each peer of any row.
fn peers(rows: &[&Row], modes: &[&'static str]) -> BTreeMap<String, PeerSummary> {
    let names: BTreeSet<&String> = rows
        .iter()
        .flat_map(|row| row.peers.keys())
        .collect();
    let peer = |name: &String| {
        let summary = PeerSummary::of(rows, modes, |row| row.peers.get(name))?;
        Some((name.clone(), summary))
    };
    names.into_iter().filter_map(peer).collect()
}

fn best_honest_peer(rows: &[&Row], modes: &[&'static str]) -> Option<PeerSummary> {
    PeerSummary::of(rows, modes, |row| {
        let (_, best) = row.best_honest_peer.as_ref()?;
        Some(best)
    })
}
