//! Shared memory: is there enough, and what did an instance leave there.

use crate::instance::Instance;
pub use crate::instance::SHM_FOLDER;
use crate::limits::{SHM_ALLOWANCE, SHM_RESERVE};
use std::fs::Permissions;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::Relaxed;
use std::time::{Duration, SystemTime};

/// Watches that shared memory never runs full: a write that does not fit would end the process
/// (SIGBUS).
///
/// Memory is reserved in name only and taken page by page when it is first written, so each message
/// asks before. The system is asked once in [`SHM_ALLOWANCE`] bytes.
#[derive(Debug, Default)]
pub struct Room {
    allowance: AtomicU64,
}

impl Room {
    /// Whether `bytes` more fit beside the reserve.
    pub fn take(&self, bytes: usize) -> bool {
        let bytes = bytes as u64;
        let taken = self
            .allowance
            .try_update(Relaxed, Relaxed, |left| left.checked_sub(bytes));
        if taken.is_ok() {
            return true;
        }
        let free = free_bytes();
        self.allowance
            .store(free.min(SHM_ALLOWANCE).saturating_sub(bytes), Relaxed);
        free >= bytes.max(1)
    }
}

/// Bytes of shared memory that are free beside the reserve.
pub fn free_bytes() -> u64 {
    let Ok(stat) = rustix::fs::statvfs(SHM_FOLDER) else {
        return u64::MAX;
    };
    let reserve = SHM_RESERVE.min(stat.f_blocks.saturating_mul(stat.f_frsize) / 8);
    stat.f_bavail
        .saturating_mul(stat.f_frsize)
        .saturating_sub(reserve)
}

/// A shared-memory file of an instance.
#[derive(Clone, Debug)]
pub struct SharedFile {
    /// Where it lies.
    pub path: PathBuf,
    /// Its size in bytes, not what it occupies.
    pub bytes: u64,
    /// Bytes it occupies.
    pub taken: u64,
    /// Its permission bits.
    pub mode: u32,
    /// Time since it was last written.
    pub age: Duration,
}

/// The shared-memory files of `instance`.
pub fn shared_files(instance: &Instance) -> Vec<SharedFile> {
    let ours = of_instance(instance, Path::new(SHM_FOLDER));
    ours.into_iter()
        .filter_map(|path| {
            let meta = path.symlink_metadata().ok()?;
            let age = SystemTime::now()
                .duration_since(meta.modified().ok()?)
                .unwrap_or_default();
            Some(SharedFile {
                path,
                bytes: meta.len(),
                taken: meta.blocks() * 512,
                mode: meta.mode() & 0o777,
                age,
            })
        })
        .collect()
}

/// What lies in a folder and has the name of something of `instance`.
pub(crate) fn of_instance(instance: &Instance, folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten();
    let ours = entries.filter(|entry| {
        entry
            .file_name()
            .to_string_lossy()
            .starts_with(instance.prefix())
    });
    ours.map(|entry| entry.path()).collect()
}

/// Removes everything `instance` left behind except its lock and configuration. Only for the holder
/// of the lock, and only while no process of the instance lives, or none of them can be served any
/// more.
pub(crate) fn wipe(instance: &Instance) {
    for folder in [Path::new(SHM_FOLDER), instance.root()] {
        for file in of_instance(instance, folder) {
            let _ = std::fs::remove_file(file);
        }
    }
    for folder in ["services", "nodes"] {
        let _ = std::fs::remove_dir_all(instance.root().join(folder));
    }
}

/// Takes the rights of others off files that iceoryx2 makes for everybody (its counter of nodes).
pub(crate) fn make_private(instance: &Instance) {
    for file in shared_files(instance) {
        if file.mode & 0o077 != 0 {
            let _ = std::fs::set_permissions(&file.path, Permissions::from_mode(0o600));
        }
    }
}
