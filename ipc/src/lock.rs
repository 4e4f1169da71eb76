//! The lock file that tells who is the daemon, and whether it still lives.

use crate::in_place::FileNumber;
use crate::instance::{Instance, InstanceError};
use crate::limits::{LOCK_PATIENCE, WIRE_VERSION};
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
        /// Of its services ([`crate::services::name`]); changes when ports of the last daemon's
        /// clients do not work with them.
        generation: u64,
        /// Of the wire that it speaks.
        wire_version: u32,
    },
}

/// The daemon's side: holds the instance until dropped.
#[derive(Debug)]
pub(crate) struct DaemonLock {
    file: File,
    path: PathBuf,
    /// Generation of the last daemon's services, if there was one.
    pub last_generation: Option<u64>,
}

impl DaemonLock {
    /// Takes the lock, or tells that somebody else has it.
    pub(crate) fn acquire(instance: &Instance) -> Result<Option<Self>, InstanceError> {
        let path = lock_path(instance);
        let failed = |source| instance.file_error(&path, source);
        let mut file = opened(&path).map_err(failed)?;
        loop {
            if !lock_with_patience(&file) {
                return Ok(None);
            }
            if names(&path, &file) {
                break;
            }
            // Removed in between: nobody would find it.
            file = opened(&path).map_err(failed)?;
        }
        let last_generation = generation(&file);
        file.set_len(0).map_err(failed)?;
        Ok(Some(Self {
            file,
            path,
            last_generation,
        }))
    }

    /// Lets clients in.
    pub(crate) fn announce(&mut self, boot_id: u64, generation: u64) -> std::io::Result<()> {
        let pid = std::process::id();
        let line = format!("{pid} {boot_id:016x} {generation:016x} {WIRE_VERSION}\n");
        self.file.write_all(line.as_bytes())
    }

    /// Whether clients and other daemons still find it.
    pub(crate) fn is_in_place(&self) -> bool {
        names(&self.path, &self.file)
    }
}

fn opened(path: &std::path::Path) -> std::io::Result<File> {
    OpenOptions::new()
        .read(true)
        .write(true)
        .create(true)
        .truncate(false)
        .mode(0o600)
        .open(path)
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

/// Whether a path names this open file, and not another one or none.
fn names(path: &std::path::Path, file: &File) -> bool {
    let number = FileNumber::of_open(file);
    number.is_some() && number == FileNumber::of(path)
}

/// The client's side.
#[derive(Debug)]
pub(crate) struct DaemonProbe {
    file: File,
    path: PathBuf,
}

impl DaemonProbe {
    /// Opens the lock file; `None` if there never was a daemon.
    pub(crate) fn open(instance: &Instance) -> Result<Option<Self>, InstanceError> {
        let path = lock_path(instance);
        match File::open(&path) {
            Ok(file) => Ok(Some(Self { file, path })),
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
        announced(&self.file).unwrap_or(DaemonState::Starting)
    }

    /// Whether the next daemon would take this file's lock.
    pub(crate) fn is_in_place(&self) -> bool {
        names(&self.path, &self.file)
    }
}

/// What a daemon that lives, or has lived, says of itself.
fn announced(file: &File) -> Option<DaemonState> {
    let mut bytes = [0; 96];
    let len = file.read_at(&mut bytes, 0).ok()?;
    let line = std::str::from_utf8(&bytes[..len])
        .ok()?
        .strip_suffix('\n')?;
    let mut words = line.split(' ');
    Some(DaemonState::Running {
        pid: words.next()?.parse().ok()?,
        boot_id: u64::from_str_radix(words.next()?, 16).ok()?,
        generation: u64::from_str_radix(words.next()?, 16).ok()?,
        wire_version: words.next()?.parse().ok()?,
    })
}

fn generation(file: &File) -> Option<u64> {
    match announced(file)? {
        DaemonState::Running { generation, .. } => Some(generation),
        DaemonState::Starting | DaemonState::Absent => None,
    }
}

/// What the lock file of `instance` says about its daemon.
///
/// # Errors
/// [`InstanceError::File`] if the lock file cannot be opened.
pub fn daemon_state(instance: &Instance) -> Result<DaemonState, InstanceError> {
    Ok(DaemonProbe::open(instance)?.map_or(DaemonState::Absent, |probe| probe.state()))
}

pub(crate) fn lock_path(instance: &Instance) -> PathBuf {
    instance.root().join("daemon.lock")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lock_whose_file_is_gone_is_nobodys_and_the_next_has_another_file() {
        let folder = tempfile::tempdir().unwrap();
        let instance = Instance::new("test", folder.path().join("i")).unwrap();
        instance.prepare().unwrap();
        let acquired = || DaemonLock::acquire(&instance).unwrap();
        let mut first = acquired().unwrap();
        first.announce(1, 7).unwrap();
        assert!(first.is_in_place() && acquired().is_none());
        let probe = DaemonProbe::open(&instance).unwrap().unwrap();
        std::fs::remove_file(lock_path(&instance)).unwrap();
        assert!(!first.is_in_place() && !probe.is_in_place());
        assert!(matches!(
            probe.state(),
            DaemonState::Running {
                boot_id: 1,
                generation: 7,
                ..
            }
        ));
        let second = acquired().unwrap();
        assert_eq!(second.last_generation, None, "a file of its own");
        assert!(second.is_in_place() && !first.is_in_place() && !probe.is_in_place());
        assert_eq!(daemon_state(&instance).unwrap(), DaemonState::Starting);
        drop(first);
        assert_eq!(probe.state(), DaemonState::Absent);
    }

    #[test]
    fn the_next_daemon_knows_the_generation_of_the_last() {
        let folder = tempfile::tempdir().unwrap();
        let instance = Instance::new("test", folder.path().join("i")).unwrap();
        instance.prepare().unwrap();
        let mut lock = DaemonLock::acquire(&instance).unwrap().unwrap();
        assert_eq!(lock.last_generation, None);
        lock.announce(1, u64::MAX).unwrap();
        drop(lock);
        let next = DaemonLock::acquire(&instance).unwrap().unwrap();
        assert_eq!(next.last_generation, Some(u64::MAX));
    }
}
