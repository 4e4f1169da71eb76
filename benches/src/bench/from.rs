//! `--from`: the recorded path of a peer in place of the planner's.

use std::collections::BTreeSet;

use taut::files::FileError;
use taut::path::Path;

use super::loaded::Loaded;
use crate::error::Error;

/// A peer whose paths are to be shortened, and what the problems have of it.
#[derive(Debug)]
pub(super) struct From<'a> {
    peer: &'a str,
    /// Peers of the problems seen that have a path.
    valid: BTreeSet<String>,
    /// Problems without a path of this peer.
    pub skipped: usize,
}

impl<'a> From<'a> {
    /// Nothing seen yet.
    pub(super) fn new(peer: &'a str) -> Self {
        Self {
            peer,
            valid: BTreeSet::new(),
            skipped: 0,
        }
    }

    /// Puts the peer's path in the place of the problem's; false where none is recorded.
    ///
    /// # Errors
    /// A recorded path that is no path of this robot.
    pub(super) fn take(&mut self, loaded: &mut Loaded) -> Result<bool, Error> {
        let recorded = loaded
            .peers
            .iter()
            .filter_map(|(name, peer)| Some((name, peer.path.as_ref()?)));
        self.valid
            .extend(recorded.clone().map(|(name, _)| name.clone()));
        let mut wanted = recorded.filter(|(name, _)| *name == self.peer);
        let Some((_, rows)) = wanted.next() else {
            self.skipped += 1;
            return Ok(false);
        };
        loaded.path = self.path(loaded, rows)?;
        Ok(true)
    }

    /// The recorded rows as a path of this robot.
    fn path(&self, loaded: &Loaded, rows: &[Vec<f64>]) -> Result<Path, Error> {
        let columns = loaded.robot.space().nq();
        let whole = rows.iter().all(|row| row.len() == columns);
        let path = Path::from_rows(columns, rows.concat()).filter(|_| whole);
        path.ok_or_else(|| {
            Error::File(FileError::Content {
                file: loaded.name.clone().into(),
                text: format!("the path of {} is not rows of {columns} numbers", self.peer),
            })
        })
    }

    /// What is wrong where no problem has a path of this name.
    pub(super) fn unknown(&self) -> Error {
        let valid: Vec<&str> = self.valid.iter().map(String::as_str).collect();
        let valid = if valid.is_empty() {
            "none".to_owned()
        } else {
            valid.join(", ")
        };
        Error::Usage(format!(
            "--from {:?}: no problem has a path of that name; valid: {valid}",
            self.peer
        ))
    }
}
