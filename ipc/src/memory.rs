//! Shared memory: is there enough, and what did an instance leave there.

use crate::instance::Instance;
use crate::limits::SHM_RESERVE;
use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Where POSIX shared memory lies on Linux.
pub const SHM_FOLDER: &str = "/dev/shm";

/// Whether `bytes` more fit beside the reserve. A write into a full shared memory would end the process
/// (SIGBUS), so ask before.
pub fn has_room_for(bytes: usize) -> bool {
    match rustix::fs::statvfs(SHM_FOLDER) {
        Ok(stat) => stat.f_bavail.saturating_mul(stat.f_frsize) >= SHM_RESERVE + bytes as u64,
        Err(_) => true,
    }
}

/// A shared-memory file of an instance.
#[derive(Clone, Debug)]
pub struct SharedFile {
    /// Where it lies.
    pub path: PathBuf,
    /// Its size in bytes, not what it occupies.
    pub bytes: u64,
    /// Time since it was last written.
    pub age: Duration,
}

/// The shared-memory files of `instance`.
pub fn shared_files(instance: &Instance) -> Vec<SharedFile> {
    let Ok(entries) = std::fs::read_dir(SHM_FOLDER) else { return Vec::new() };
    let ours = entries.flatten().filter(|entry| entry.file_name().to_string_lossy().starts_with(instance.prefix()));
    ours.filter_map(|entry| {
        let meta = entry.metadata().ok()?;
        let age = SystemTime::now().duration_since(meta.modified().ok()?).unwrap_or_default();
        Some(SharedFile { path: entry.path(), bytes: meta.len(), age })
    })
    .collect()
}

/// Removes everything `instance` left behind except its lock and configuration. Only for the holder of the
/// lock, and only while no process of the instance lives.
pub(crate) fn wipe(instance: &Instance) {
    for file in shared_files(instance) {
        let _ = std::fs::remove_file(file.path);
    }
    for folder in ["services", "nodes"] {
        let _ = std::fs::remove_dir_all(instance.root().join(folder));
    }
    let Ok(entries) = std::fs::read_dir(instance.root()) else { return };
    for entry in entries.flatten() {
        if is_socket_of(instance, &entry.path()) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Takes the rights of others off files that iceoryx2 makes for everybody (its counter of nodes).
pub(crate) fn make_private(instance: &Instance) {
    for file in shared_files(instance) {
        if let Ok(meta) = std::fs::metadata(&file.path)
            && meta.permissions().mode() & 0o077 != 0
        {
            let _ = std::fs::set_permissions(&file.path, Permissions::from_mode(0o600));
        }
    }
}

fn is_socket_of(instance: &Instance, path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(instance.prefix()))
}
