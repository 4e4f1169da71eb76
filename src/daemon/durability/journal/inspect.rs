//! Looking at a journal without touching it, also while a daemon writes it.

use std::fs::DirEntry;
use std::path::Path;

use super::apart::Large;
use super::{Content, JournalError, State, read};

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
        found.count(label, state);
    }
    let beside = Large::new(folder).folders().map(bytes_in);
    found.bytes = bytes_in(folder) + beside.iter().sum::<u64>();
    Ok(found)
}

impl Found {
    fn count(&mut self, label: String, state: Result<State, String>) {
        match state.map(|state| state.content) {
            Ok(Content::Robot(..)) => self.robots += 1,
            Ok(Content::Scene(..)) => self.scenes += 1,
            Ok(Content::Gone) => {}
            Err(why) => self.wrong.push((label, why)),
        }
    }
}

/// Bytes of the files of a folder; none where there is no such folder.
fn bytes_in(folder: &Path) -> u64 {
    let entries = std::fs::read_dir(folder).into_iter().flatten();
    entries
        .flatten()
        .map(|entry| bytes_of(&entry))
        .sum()
}

fn bytes_of(entry: &DirEntry) -> u64 {
    entry.metadata().map_or(0, |meta| meta.len())
}
