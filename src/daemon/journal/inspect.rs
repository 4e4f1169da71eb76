//! Looking at a journal without touching it, also while a daemon writes it.

use std::path::Path;

use super::{Content, JournalError, read};

/// What a state folder holds.
#[derive(Debug, Default)]
pub struct Found {
    /// Robots that a daemon would restore.
    pub robots: usize,
    /// Scenes that it would restore.
    pub scenes: usize,
    /// What it would not, by label, and why.
    pub wrong: Vec<(String, String)>,
    /// Bytes of all files.
    pub bytes: u64,
}

/// Reads a state folder as a daemon would.
///
/// # Errors
/// A file that is damaged or cannot be read.
pub fn inspect(folder: &Path) -> Result<Found, JournalError> {
    let kept = read::look(folder)?;
    let mut found = Found::default();
    for ((_, label), state) in kept.states {
        match state.map(|state| state.content) {
            Ok(Content::Robot(..)) => found.robots += 1,
            Ok(Content::Scene(..)) => found.scenes += 1,
            Ok(Content::Gone) => {}
            Err(why) => found.wrong.push((label, why)),
        }
    }
    for folder in [folder.to_owned(), read::meshes(folder)] {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        found.bytes += entries
            .filter_map(|entry| entry.metadata().ok())
            .map(|meta| meta.len())
            .sum::<u64>();
    }
    Ok(found)
}
