//! The problem files below a folder.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use taut::files::{FileError, Kind};

use super::arguments::Arguments;
use super::loaded::Loaded;
use super::source::GeometryChoice;
use crate::error::Error;
use crate::output::progress_bar;

/// A problem to run.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Chosen {
    file: PathBuf,
    /// The model of the robot to take.
    geometry: GeometryChoice,
}

/// The problems to run: those of a list in its order, else in order of their names.
pub(super) fn find(arguments: &Arguments) -> Result<Vec<Chosen>, Error> {
    if let Some(list) = &arguments.named {
        return named(arguments, list);
    }
    let files = find_files(arguments)?.into_iter();
    let chosen = files.map(|file| Chosen {
        file,
        geometry: arguments.source.geometry,
    });
    Ok(chosen.collect())
}

/// The problems of a list.
fn named(arguments: &Arguments, list: &Path) -> Result<Vec<Chosen>, Error> {
    let text = std::fs::read_to_string(list).map_err(unreadable(list))?;
    let lines = text.lines().enumerate();
    let lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    lines
        .map(|(number, line)| {
            chosen(arguments, line).ok_or_else(|| Error::List {
                file: list.display().to_string(),
                line: number + 1,
                text: line.to_owned(),
            })
        })
        .collect()
}

/// The problem of a line.
fn chosen(arguments: &Arguments, line: &str) -> Option<Chosen> {
    let mut words = line.split_whitespace();
    let file = arguments
        .folder
        .join(format!("{}.json", words.next()?));
    let geometry = match words.next() {
        None => arguments.source.geometry,
        Some(word) => GeometryChoice::from_str(word, false).ok()?,
    };
    words
        .next()
        .is_none()
        .then_some(Chosen { file, geometry })
}

fn find_files(arguments: &Arguments) -> Result<Vec<PathBuf>, Error> {
    let mut files = Vec::new();
    collect(&arguments.folder, &mut files)?;
    files.sort();
    if let Some(text) = &arguments.filter {
        files.retain(|file| label(&arguments.folder, file).contains(text.as_str()));
    }
    // Bare paths lie about too; what cannot be read at all stays, to become a row.
    files.retain(|file| !matches!(Kind::of(file), Ok(Kind::BarePath)));
    if let Some(limit) = arguments.limit {
        keep_first(limit, &mut files);
    }
    match files.is_empty() {
        true => Err(no_file(&arguments.folder)),
        false => Ok(files),
    }
}

/// At most so many of each folder.
fn keep_first(limit: usize, files: &mut Vec<PathBuf>) {
    let mut taken: BTreeMap<PathBuf, usize> = BTreeMap::new();
    files.retain(|file| {
        let count = taken
            .entry(folder_of(file).to_owned())
            .or_default();
        *count += 1;
        *count <= limit
    });
}

fn no_file(folder: &Path) -> Error {
    let folder = folder.display();
    Error::Usage(format!(
        "no problem file (.json with a \"format\") below {folder}"
    ))
}

/// Reads one file after the other under a progress bar and keeps what `what` makes of its set, its name
/// and what was read.
pub(super) fn each<T>(
    arguments: &Arguments,
    chosen: &[Chosen],
    mut what: impl FnMut(String, String, Result<Loaded, Error>) -> Option<T>,
) -> Vec<T> {
    let mut reader = arguments.source.reader();
    let bar = progress_bar(chosen.len() as u64);
    let mut made = Vec::with_capacity(chosen.len());
    for Chosen { file, geometry } in chosen {
        bar.set_message(label(&arguments.folder, file));
        let source = arguments.source.with(*geometry);
        let loaded = Loaded::read(&mut reader, file, &source);
        made.extend(what(set_name(&arguments.folder, file), stem(file), loaded));
        bar.inc(1);
    }
    bar.finish_and_clear();
    made
}

/// The `.json` files below a folder; a symbolic link to a folder is not followed, for it may lead
/// in a circle.
fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), Error> {
    let entries = std::fs::read_dir(folder).map_err(unreadable(folder))?;
    for entry in entries {
        let entry = entry.map_err(unreadable(folder))?;
        let path = entry.path();
        if entry
            .file_type()
            .map_err(unreadable(folder))?
            .is_dir()
        {
            collect(&path, files)?;
        } else if path
            .extension()
            .is_some_and(|ending| ending == "json")
        {
            files.push(path);
        }
    }
    Ok(())
}

fn unreadable(folder: &Path) -> impl Fn(std::io::Error) -> Error + '_ {
    move |error| {
        Error::File(FileError::Unreadable {
            file: folder.to_owned(),
            reason: error.to_string(),
        })
    }
}

/// Set and name.
fn label(root: &Path, file: &Path) -> String {
    format!("{}/{}", set_name(root, file), stem(file))
}

/// Folder of a problem below the one given, which is the set that figures are taken of.
fn set_name(root: &Path, file: &Path) -> String {
    let folder = folder_of(file);
    let below = folder.strip_prefix(root).unwrap_or(folder);
    match below.as_os_str().is_empty() {
        true => text(folder.file_name()),
        false => below.display().to_string(),
    }
}

fn folder_of(file: &Path) -> &Path {
    file.parent().unwrap_or(Path::new(""))
}

/// File name without its ending.
pub(super) fn stem(file: &Path) -> String {
    text(file.file_stem())
}

fn text(name: Option<&OsStr>) -> String {
    name.unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}
