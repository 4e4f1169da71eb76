//! The problem files below a folder.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use taut::files::{FileError, Kind};

use super::Arguments;
use crate::cli::error::CliError;

/// The problem files to run, in order of their names.
pub(super) fn find(arguments: &Arguments) -> Result<Vec<PathBuf>, CliError> {
    let mut files = Vec::new();
    collect(&arguments.folder, &mut files)?;
    files.sort();
    if let Some(text) = &arguments.filter {
        files.retain(|file| {
            format!("{}/{}", set_name(&arguments.folder, file), stem(file)).contains(text.as_str())
        });
    }
    // Bare paths lie about too; what cannot be read at all stays, to become a row.
    files.retain(|file| !matches!(Kind::of(file), Ok(Kind::BarePath)));
    if let Some(limit) = arguments.limit {
        let mut taken: BTreeMap<PathBuf, usize> = BTreeMap::new();
        files.retain(|file| {
            let count = taken
                .entry(file.parent().unwrap_or(Path::new("")).to_owned())
                .or_default();
            *count += 1;
            *count <= limit
        });
    }
    if files.is_empty() {
        let text = format!(
            "no problem file (.json with a \"format\") below {}",
            arguments.folder.display()
        );
        return Err(CliError::Usage(text));
    }
    Ok(files)
}

/// The `.json` files below a folder; a symbolic link to a folder is not followed, for it may lead
/// in a circle.
fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), CliError> {
    let unreadable = |error: std::io::Error| {
        CliError::File(FileError::Unreadable {
            file: folder.to_owned(),
            reason: error.to_string(),
        })
    };
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?;
        let path = entry.path();
        if entry.file_type().map_err(unreadable)?.is_dir() {
            collect(&path, files)?;
        } else if path
            .extension()
            .is_some_and(|extension| extension == "json")
        {
            files.push(path);
        }
    }
    Ok(())
}

/// Folder of a problem below the one given, which is the set that figures are taken of.
pub(super) fn set_name(root: &Path, file: &Path) -> String {
    let folder = file.parent().unwrap_or(Path::new(""));
    let below = folder
        .strip_prefix(root)
        .unwrap_or(folder)
        .display()
        .to_string();
    if below.is_empty() {
        folder
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned()
    } else {
        below
    }
}

/// File name without its ending.
pub(super) fn stem(file: &Path) -> String {
    file.file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}
