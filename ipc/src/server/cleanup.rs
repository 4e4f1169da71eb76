//! Removes what killed processes left behind.
//!
//! iceoryx2 notices a killed client only when its node is cleaned up; until then its requests look
//! connected. Its clean-up (0.10.0) stumbles over files that their process was about to finish when
//! it died, so those go first. They are told by their permissions: a finished file in shared memory
//! can be read, a finished tag of a node cannot be written.

use super::service_files::are_of_clients;
use crate::instance::Instance;
use crate::limits::UNFINISHED_FILE_AGE;
use crate::lock::DaemonLock;
use crate::memory::{SharedFile, shared_files, wipe};
use crate::time::unique_number;
use crate::transport::{self, Variant};
use iceoryx2::node::{DeadNodeView, Node, NodeState, NodeView};
use iceoryx2::prelude::CallbackProgression;
use std::collections::HashSet;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

/// Mode of a shared-memory file that is being made.
const SHARED_UNFINISHED: u32 = 0o200;
/// Mode of a node's tag that is being made.
const TAG_UNFINISHED: u32 = 0o600;

/// What one clean-up did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CleanUp {
    /// Nodes of living processes.
    pub alive: usize,
    /// Dead nodes removed.
    pub cleaned: usize,
    /// Dead nodes that could not be removed; the next pass tries again.
    pub failed: usize,
    /// Dead nodes left for the next pass, because a young empty file lies there.
    pub postponed: usize,
    /// Unfinished files removed.
    pub files: usize,
    /// Unfinished files too young to be told from those of living processes.
    pub young: usize,
}

impl CleanUp {
    /// Whether another pass soon would do more.
    pub fn is_incomplete(&self) -> bool {
        self.failed + self.postponed + self.young > 0
    }
}

/// Removes the nodes of processes that died, each in 2 to 13 ms, and the files they did not finish.
///
/// For the daemon's janitor thread. Opening an empty shared-memory file makes iceoryx2 wait without
/// end (as root, who may open it): so old ones are removed before, and while there are young ones
/// no node is cleaned up.
pub fn clean_dead_nodes(instance: &Instance) -> CleanUp {
    transport::quiet();
    let (alive, dead) = nodes(instance);
    clean(instance, alive.len(), dead)
}

/// As [`clean_dead_nodes`], of nodes that were listed already.
pub(super) fn clean(
    instance: &Instance,
    alive: usize,
    dead: Vec<DeadNodeView<Variant>>,
) -> CleanUp {
    let (files, young) = remove_unfinished(instance);
    let orphans = remove_orphans(instance);
    let mut done = CleanUp {
        alive,
        files,
        young: young.len() + orphans,
        ..CleanUp::default()
    };
    if young.iter().any(|file| file.bytes == 0) {
        done.postponed = dead.len();
        return done;
    }
    for node in dead {
        remove_unfinished_tags(&node_folder(instance, &node.id().value().to_string()));
        match node.try_remove_stale_resources() {
            Ok(()) => done.cleaned += 1,
            Err(_) => done.failed += 1,
        }
    }
    done
}

/// At the start of a daemon, which holds the lock: gives the generation of services to serve.
///
/// Where clients of the last daemon live and its services, of generation `last`, are whole, these go
/// on. Else everything is wiped, and clients that live all the same have to connect anew.
pub(super) fn clean_start(instance: &Instance, last: Option<u64>) -> u64 {
    match last {
        Some(last) if has_clients(instance) && are_of_clients(instance) => {
            clean_dead_nodes(instance);
            last
        }
        _ => {
            wipe(instance);
            unique_number()
        }
    }
}

fn has_clients(instance: &Instance) -> bool {
    !nodes(instance).0.is_empty()
}

/// At the end of a daemon, which still holds the lock: nothing stays if nobody lives.
pub(super) fn clean_end(instance: &Instance) {
    if !has_clients(instance) {
        wipe(instance);
    }
}

/// Removes what a daemon and its last clients left behind, unless a daemon or a client lives. For
/// whoever stopped the daemon: a client that lives longer than the daemon leaves files that the
/// daemon could not take along.
pub fn tidy(instance: &Instance) {
    if let Ok(Some(_lock)) = DaemonLock::acquire(instance) {
        clean_end(instance);
    }
}

/// Process of each living node, if it can be told, and the dead nodes.
pub(super) fn nodes(instance: &Instance) -> (Vec<Option<i32>>, Vec<DeadNodeView<Variant>>) {
    let mut alive = Vec::new();
    let mut dead = Vec::new();
    let _ = Node::<Variant>::list(&transport::config(instance), |state| {
        match state {
            NodeState::Dead(view) => dead.push(view),
            other => alive.push(
                other
                    .node_id()
                    .pid::<Variant>()
                    .ok()
                    .map(|pid| pid.value()),
            ),
        }
        CallbackProgression::Continue
    });
    (alive, dead)
}

/// Where the nodes of an instance keep their files.
pub(super) fn nodes_folder(instance: &Instance) -> PathBuf {
    instance.root().join("nodes")
}

fn node_folder(instance: &Instance, id: &str) -> PathBuf {
    nodes_folder(instance).join(id)
}

/// Removes old unfinished files in shared memory; returns how many, and the young ones.
fn remove_unfinished(instance: &Instance) -> (usize, Vec<SharedFile>) {
    let unfinished = |file: &SharedFile| file.bytes == 0 || file.mode == SHARED_UNFINISHED;
    let files = shared_files(instance)
        .into_iter()
        .filter(unfinished);
    let (young, old): (Vec<_>, Vec<_>) = files.partition(|file| file.age < UNFINISHED_FILE_AGE);
    let removed = old
        .iter()
        .filter(|file| std::fs::remove_file(&file.path).is_ok())
        .count();
    (removed, young)
}

/// What an unfinished tag stands for was never made, so only the tag has to go.
fn remove_unfinished_tags(folder: &Path) {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    for entry in entries.flatten() {
        let mode = entry
            .metadata()
            .map_or(0, |meta| meta.permissions().mode() & 0o777);
        if mode == TAG_UNFINISHED {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Removes folders of nodes that died before they were known, and connections and data of ports
/// that no node has: their makers died before they registered them. Returns how many are too young
/// to tell.
fn remove_orphans(instance: &Instance) -> usize {
    let mut young = 0;
    let Ok(entries) = std::fs::read_dir(nodes_folder(instance)) else {
        return young;
    };
    let mut ports = HashSet::new();
    for entry in entries
        .flatten()
        .filter(|entry| entry.path().is_dir())
    {
        let id = entry.file_name().to_string_lossy().into_owned();
        let monitor = format!("{}{id}.node_monitor", instance.prefix());
        let age = entry
            .metadata()
            .and_then(|meta| meta.modified())
            .map(|at| at.elapsed().unwrap_or_default());
        let old = age.is_ok_and(|age| age >= UNFINISHED_FILE_AGE);
        let known = nodes_folder(instance).join(monitor).exists();
        if known || !old {
            young += usize::from(!known);
            ports.extend(ports_of(instance, &entry.path()));
        } else {
            let _ = std::fs::remove_dir_all(entry.path());
        }
    }
    for file in shared_files(instance) {
        if ports_in_name(&file.path)
            .iter()
            .all(|port| ports.contains(port))
        {
            continue;
        }
        if file.age < UNFINISHED_FILE_AGE {
            young += 1;
        } else {
            let _ = std::fs::remove_file(&file.path);
        }
    }
    young
}

/// Ids of the ports that a node has registered.
pub(super) fn ports_of(instance: &Instance, folder: &Path) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Vec::new();
    };
    let names = entries
        .flatten()
        .map(|entry| entry.file_name().to_string_lossy().into_owned());
    names
        .filter_map(|name| {
            Some(
                name.strip_prefix(instance.prefix())?
                    .strip_suffix(".port_tag")?
                    .to_owned(),
            )
        })
        .collect()
}

/// Ids of the ports that a connection or a data segment belongs to; none for any other file.
fn ports_in_name(path: &Path) -> Vec<String> {
    let is_of_ports = path
        .extension()
        .is_some_and(|extension| extension == "connection" || extension == "data");
    let stem = path
        .file_stem()
        .map(|stem| stem.to_string_lossy().into_owned())
        .filter(|_| is_of_ports);
    stem.iter()
        .flat_map(|stem| stem.split('_').skip(1))
        .map(str::to_owned)
        .collect()
}
