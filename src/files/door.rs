//! Where files come from: the disk, or what somebody gave.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{FileError, Packages};
use crate::math::Vec3;
use crate::shape::{Mesh, MeshError};

/// Files that were given, by the names that a robot or scene has for them.
pub type GivenFiles = BTreeMap<String, Arc<[u8]>>;

/// Where files come from.
#[derive(Debug, Default)]
pub(super) enum Door {
    /// The disk.
    #[default]
    Disk,
    /// Nowhere else than from here; with the names that were asked for and are not here.
    Given(GivenFiles, BTreeSet<String>),
}

impl Door {
    /// What was asked for and not given.
    pub fn wanted(&self) -> Vec<String> {
        match self {
            Self::Disk => Vec::new(),
            Self::Given(_, wanted) => wanted.iter().cloned().collect(),
        }
    }

    /// The bytes of a robot's own file.
    pub fn bytes(&mut self, file: &Path) -> Result<Cow<'_, [u8]>, FileError> {
        match self {
            Self::Disk => read(file)
                .map(Cow::Owned)
                .map_err(|reason| unreadable(file, reason)),
            Self::Given(files, wanted) => {
                let name = file.display().to_string();
                match files.get(&name) {
                    Some(bytes) => Ok(Cow::Borrowed(bytes)),
                    None => {
                        wanted.insert(name);
                        Err(FileError::NotGiven(file.to_owned()))
                    }
                }
            }
        }
    }

    /// The file of a mesh or cloud that a robot or scene of a folder calls so.
    pub fn find(&self, name: &str, packages: &Packages, folder: &Path) -> Result<PathBuf, String> {
        match self {
            Self::Disk => packages.resolve(name, folder),
            Self::Given(..) => Ok(PathBuf::from(name)),
        }
    }

    /// The bytes of such a file that was found; `None` where nobody gave it yet, which is noted.
    pub fn found(&mut self, name: &str, file: &Path) -> Result<Option<Cow<'_, [u8]>>, String> {
        match self {
            Self::Disk => {
                let bytes = read(file).map_err(|reason| format!("{}: {reason}", file.display()))?;
                Ok(Some(Cow::Owned(bytes)))
            }
            Self::Given(files, wanted) => {
                if !files.contains_key(name) {
                    wanted.insert(name.to_owned());
                }
                let bytes = files.get(name);
                Ok(bytes.map(|bytes| Cow::Borrowed(&**bytes)))
            }
        }
    }
}

fn read(file: &Path) -> Result<Vec<u8>, String> {
    std::fs::read(file).map_err(|error| error.to_string())
}

fn unreadable(file: &Path, reason: String) -> FileError {
    FileError::Unreadable {
        file: file.to_owned(),
        reason,
    }
}

/// Stands for a mesh that nobody gave yet, so that one look finds all of these. What is read with it
/// is thrown away.
pub(super) fn stand_in(name: &str) -> Result<Arc<Mesh>, MeshError> {
    let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let sides = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
    Mesh::new(name, corners, sides).map(Arc::new)
}
