//! The lock file that tells who is the daemon, and whether it still lives.

use crate::instance::{Instance, InstanceError};
use crate::limits::LOCK_PATIENCE;
use rustix::fs::{FlockOperation, flock};
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::os::unix::fs::{FileExt, OpenOptionsExt};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// What the lock file says about the daemon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DaemonState {
    /// Nobody holds the lock.
    Absent,
    /// Somebody holds it and has not announced itself yet.
    Starting,
    /// The daemon is up.
    Running {
        /// Its process id.
        pid: u32,
        /// Changes with every start.
        boot_id: u64,
    },
}

/// The daemon's side: holds the instance until dropped.
#[derive(Debug)]
pub(crate) struct DaemonLock {
    file: File,
}

impl DaemonLock {
    /// Takes the lock, or tells that somebody else has it.
    pub(crate) fn acquire(instance: &Instance) -> Result<Option<Self>, InstanceError> {
        let path = lock_path(instance);
        let open = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .mode(0o600)
            .open(&path);
        let file = open.map_err(|source| instance.file_error(&path, source))?;
        if !lock_with_patience(&file) {
            return Ok(None);
        }
        file.set_len(0)
            .map_err(|source| instance.file_error(&path, source))?;
        Ok(Some(Self { file }))
    }

    /// Lets clients in.
    pub(crate) fn announce(&mut self, boot_id: u64) -> std::io::Result<()> {
        writeln!(self.file, "{} {boot_id:016x}", std::process::id())
    }
}

/// A client that probes holds the lock for microseconds; that is no daemon.
fn lock_with_patience(file: &File) -> bool {
    let end = Instant::now() + LOCK_PATIENCE;
    loop {
        if flock(file, FlockOperation::NonBlockingLockExclusive).is_ok() {
            return true;
        }
        if Instant::now() >= end {
            return false;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// The client's side.
#[derive(Debug)]
pub(crate) struct DaemonProbe {
    file: File,
}

impl DaemonProbe {
    /// Opens the lock file; `None` if there never was a daemon.
    pub(crate) fn open(instance: &Instance) -> Result<Option<Self>, InstanceError> {
        let path = lock_path(instance);
        match File::open(&path) {
            Ok(file) => Ok(Some(Self { file })),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(source) => Err(instance.file_error(&path, source)),
        }
    }

    /// Who is the daemon now. Two system calls when it lives, three otherwise.
    pub(crate) fn state(&self) -> DaemonState {
        if flock(&self.file, FlockOperation::NonBlockingLockShared).is_ok() {
            let _ = flock(&self.file, FlockOperation::NonBlockingUnlock);
            return DaemonState::Absent;
        }
        self.announced()
            .unwrap_or(DaemonState::Starting)
    }

    fn announced(&self) -> Option<DaemonState> {
        let mut bytes = [0; 64];
        let len = self.file.read_at(&mut bytes, 0).ok()?;
        let line = std::str::from_utf8(&bytes[..len])
            .ok()?
            .strip_suffix('\n')?;
        let (pid, boot_id) = line.split_once(' ')?;
        Some(DaemonState::Running {
            pid: pid.parse().ok()?,
            boot_id: u64::from_str_radix(boot_id, 16).ok()?,
        })
    }
}

/// What the lock file of `instance` says about its daemon.
///
/// # Errors
/// [`InstanceError::File`] if the lock file cannot be opened.
pub fn daemon_state(instance: &Instance) -> Result<DaemonState, InstanceError> {
    Ok(DaemonProbe::open(instance)?.map_or(DaemonState::Absent, |probe| probe.state()))
}

fn lock_path(instance: &Instance) -> PathBuf {
    instance.root().join("daemon.lock")
}
