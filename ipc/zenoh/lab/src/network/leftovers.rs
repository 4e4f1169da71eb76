//! What labs that were killed left behind: namespaces, folders, and shared memory of their instances.

use std::fs;
use std::path::Path;

use taut_ipc::Instance;
use taut_ipc::memory::shared_files;

use super::ip::ip;
use crate::error::Error;

/// How names of namespaces begin; the process and the host follow.
pub(super) const NAMESPACES: &str = "taut-lab-";

/// Removes it.
pub(super) fn sweep() -> Result<(), Error> {
    for line in ip("netns list")?.lines() {
        let name = line.split(' ').next().unwrap_or_default();
        let maker = name
            .strip_prefix(NAMESPACES)
            .and_then(|rest| rest.split('-').next());
        if maker.is_some_and(is_dead) {
            // Another lab may sweep it as well.
            let _ = ip(&format!("netns delete {name}"));
        }
    }
    for folder in fs::read_dir(std::env::temp_dir())
        .into_iter()
        .flatten()
        .flatten()
    {
        let name = folder.file_name();
        let maker = name
            .to_str()
            .and_then(|name| name.strip_prefix(FOLDERS))
            .and_then(|rest| rest.rsplit('-').next());
        if maker.is_some_and(is_dead) {
            remove(&folder.path());
        }
    }
    Ok(())
}

/// How names of hosts' folders begin; the host and the process follow.
const FOLDERS: &str = "taut-lab-";

/// Of a lab's name, whether its process is gone.
fn is_dead(pid: &str) -> bool {
    pid.parse::<u32>().is_ok() && !Path::new("/proc").join(pid).exists()
}

/// A host's folder and what its instances, each a folder in it, have in shared memory.
fn remove(folder: &Path) {
    for entry in fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
    {
        let instance = entry
            .file_name()
            .to_str()
            .and_then(|name| Instance::new(name, entry.path()).ok());
        for file in instance.iter().flat_map(shared_files) {
            let _ = fs::remove_file(file.path);
        }
    }
    let _ = fs::remove_dir_all(folder);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_processes_that_are_gone_are_dead() {
        assert!(!is_dead(&std::process::id().to_string()));
        assert!(is_dead("4194999") && !is_dead("") && !is_dead("x"));
    }
}
