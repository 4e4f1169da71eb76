//! The files by which a daemon is found, and whether they are all in place.
//!
//! Anybody may remove them under a running daemon: a person, a cleaner of temporary files, systemd's
//! RemoveIPC when its user logs out. What is open or mapped works on, so that neither the daemon nor
//! its clients notice; but no new client finds it, and another daemon may take the instance.

use super::cleanup::{nodes_folder, ports_of};
use super::service_files::{are_all_there, dynamic_files, static_files};
use crate::in_place::FileNumber;
use crate::instance::Instance;
use crate::lock::lock_path;
use crate::memory::{SHM_FOLDER, of_instance};
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// The files that one daemon needs, as they were when it began to serve.
#[derive(Debug)]
pub(super) struct OwnFiles(Vec<(PathBuf, FileNumber)>);

impl OwnFiles {
    /// Those of the daemon that has just made them, with the node of this id; `None` where some are
    /// gone already.
    pub(super) fn of(instance: &Instance, node: u128) -> Option<Self> {
        let paths = paths(instance, &node.to_string());
        let numbered = paths
            .into_iter()
            .map(|path| FileNumber::of(&path).map(|number| (path, number)));
        let files: Vec<_> = numbered.collect::<Option<_>>()?;
        are_all_there(instance).then_some(Self(files))
    }

    /// One that its path does not name any more.
    pub(super) fn missing(&self) -> Option<&Path> {
        let mut files = self.0.iter();
        files
            .find(|(path, number)| FileNumber::of(path) != Some(*number))
            .map(|(path, _)| path.as_path())
    }
}

fn paths(instance: &Instance, node: &str) -> Vec<PathBuf> {
    let monitor = format!("{}{node}.node_monitor", instance.prefix());
    let mut paths = vec![lock_path(instance), nodes_folder(instance).join(monitor)];
    paths.extend(static_files(instance));
    paths.extend(dynamic_files(instance));
    let folder = nodes_folder(instance).join(node);
    let ports: HashSet<String> = ports_of(instance, &folder)
        .into_iter()
        .collect();
    paths.extend(of_instance(instance, &folder));
    for folder in [Path::new(SHM_FOLDER), instance.root()] {
        let files = of_instance(instance, folder);
        paths.extend(
            files
                .into_iter()
                .filter(|file| is_of(file, &ports)),
        );
    }
    paths
}

/// Whether this is the memory or the socket of one of these ports. A connection is its client's as
/// well, and goes with it.
fn is_of(file: &Path, ports: &HashSet<String>) -> bool {
    let name = file
        .file_name()
        .unwrap_or_default()
        .to_string_lossy();
    let is_connection = name.ends_with(".connection");
    let mut words = name.split(['.', '_']);
    !is_connection && words.any(|word| ports.contains(word))
}
