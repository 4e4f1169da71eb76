//! The lock file that tells who is the daemon, and whether it still lives.

use crate::in_place::FileNumber;
use crate::instance::{Instance, InstanceError};
use crate::limits::{LOCK_PATIENCE, WIRE_VERSION};
use rustix::fs::{FlockOperation, flock};
use std::fs::{File, OpenOptions};
use std::os::unix::fs::{FileExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
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

/// Written over the first digit of a dead daemon's process id. Its generation is still read.
const STRUCK_OUT: &[u8] = b"-";

/// The daemon's side: holds the instance until dropped.
#[derive(Debug)]
pub(crate) struct DaemonLock {
    file: File,
    path: PathBuf,
    /// Generation of the last daemon's services, if there was one.
    pub last_generation: Option<u64>,
}

impl DaemonLock {
    /// Takes the lock, or tells that somebody else has it. A client that probes holds the lock for
    /// microseconds; that is no daemon.
    pub(crate) fn acquire(instance: &Instance) -> Result<Option<Self>, InstanceError> {
        let path = lock_path(instance);
        let end = Instant::now() + LOCK_PATIENCE;
        loop {
            let attempt = Self::attempt(&path);
            let lock = attempt.map_err(|source| instance.file_error(&path, source))?;
            if lock.is_some() || Instant::now() >= end {
                return Ok(lock);
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// Who probes must never read the last daemon's line under the lock of the next. So the line
    /// is struck out under a shared lock, as clients hold it: nobody is the daemon meanwhile. The
    /// change to the exclusive one is not atomic; another daemon that comes first has it.
    fn attempt(path: &Path) -> std::io::Result<Option<Self>> {
        let file = opened(path)?;
        let holds = |operation| flock(&file, operation).is_ok() && names(path, &file);
        if !holds(FlockOperation::NonBlockingLockShared) {
            return Ok(None);
        }
        let last_generation = generation(&file);
        file.write_all_at(STRUCK_OUT, 0)?;
        if !holds(FlockOperation::NonBlockingLockExclusive) {
            return Ok(None);
        }
        Ok(Some(Self {
            file,
            path: path.to_owned(),
            last_generation,
        }))
    }

    /// Lets clients in.
    pub(crate) fn announce(&mut self, boot_id: u64, generation: u64) -> std::io::Result<()> {
        let pid = std::process::id();
        let line = format!("{pid} {boot_id:016x} {generation:016x} {WIRE_VERSION}\n");
        self.file.set_len(0)?;
        self.file.write_all_at(line.as_bytes(), 0)
    }

    /// Whether clients and other daemons still find it.
    pub(crate) fn is_in_place(&self) -> bool {
        names(&self.path, &self.file)
    }
}

fn opened(path: &Path) -> std::io::Result<File> {
    OpenOptions::new()
        .read(true)
        .write(true)
        .create(true)
        .truncate(false)
        .mode(0o600)
        .open(path)
}

/// Whether a path names this open file, and not another one or none.
fn names(path: &Path, file: &File) -> bool {
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

/// What a daemon that lives says of itself.
fn announced(file: &File) -> Option<DaemonState> {
    let line = line(file)?;
    let mut words = line.split(' ');
    Some(DaemonState::Running {
        pid: words.next()?.parse().ok()?,
        boot_id: u64::from_str_radix(words.next()?, 16).ok()?,
        generation: u64::from_str_radix(words.next()?, 16).ok()?,
        wire_version: words.next()?.parse().ok()?,
    })
}

/// Of a daemon that lives, or has lived.
fn generation(file: &File) -> Option<u64> {
    let line = line(file)?;
    let word = line.split(' ').nth(2)?;
    u64::from_str_radix(word, 16).ok()
}

fn line(file: &File) -> Option<String> {
    let mut bytes = [0; 96];
    let len = file.read_at(&mut bytes, 0).ok()?;
    let line = std::str::from_utf8(&bytes[..len]).ok()?;
    line.strip_suffix('\n').map(str::to_owned)
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
    use std::sync::atomic::{AtomicU64, Ordering};

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
        // One that dies before it announces itself does not make it forgotten.
        for _ in 0..2 {
            let next = DaemonLock::acquire(&instance).unwrap().unwrap();
            assert_eq!(next.last_generation, Some(u64::MAX));
        }
    }

    #[test]
    fn a_dead_daemon_is_never_seen_under_the_lock_of_the_next() {
        const LIVES: u64 = 300;
        let folder = tempfile::tempdir().unwrap();
        let instance = Instance::new("test", folder.path().join("i")).unwrap();
        instance.prepare().unwrap();
        drop(DaemonLock::acquire(&instance).unwrap());
        let probe = DaemonProbe::open(&instance).unwrap().unwrap();
        let dead = AtomicU64::new(0);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                for boot_id in 1..=LIVES {
                    let mut lock = DaemonLock::acquire(&instance).unwrap().unwrap();
                    lock.announce(boot_id, 7).unwrap();
                    drop(lock);
                    dead.store(boot_id, Ordering::SeqCst);
                }
            });
            let mut last = 0;
            while last < LIVES {
                last = dead.load(Ordering::SeqCst);
                if let DaemonState::Running { boot_id, .. } = probe.state() {
                    assert!(boot_id > last, "{boot_id} is dead since {last}");
                }
            }
        });
    }
}
