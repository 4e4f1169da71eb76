//! Reading: what the labels named when the daemon that wrote it ended.

use std::collections::BTreeMap;
use std::fs::{DirBuilder, File};
use std::io::ErrorKind;
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use rustix::fs::{FlockOperation, flock};
use taut_ipc::wire::Code;

use super::apart::Large;
use super::log::{self, Log, LogError};
use super::record::Record;
use super::write::Writer;
use super::{Content, Journal, Key, Kind, State};
use crate::daemon::durability::persisted::{Moves, RobotRecord, SceneRecord};

/// How long a folder may still be locked by a daemon that was killed.
const LOCK_PATIENCE: Duration = Duration::from_secs(1);

/// Why there is no journal.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// The folder cannot be made or opened.
    #[error(
        "cannot keep robots and scenes in {folder}: {source}; name another folder with --state, or use --no-state"
    )]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// Another daemon has it.
    #[error("another daemon keeps its robots and scenes in {0}; name another folder with --state")]
    Locked(PathBuf),
    /// The file in it.
    #[error("{0}")]
    Log(String),
}

impl JournalError {
    /// The code for the command line's exit.
    pub fn code(&self) -> Code {
        match self {
            Self::Folder { source, .. } if source.kind() == ErrorKind::StorageFull => {
                Code::ResourceExhausted
            }
            Self::Locked(_) => Code::DaemonLost,
            _ => Code::UnreadableFile,
        }
    }
}

impl From<LogError> for JournalError {
    fn from(error: LogError) -> Self {
        Self::Log(error.to_string())
    }
}

/// What was kept.
#[derive(Default)]
pub(crate) struct Kept {
    /// What every label named; for what cannot be restored, why.
    pub states: BTreeMap<Key, Result<State, String>>,
    /// Whether the daemon ended in order.
    pub ended: bool,
    /// Bytes of a change that was half written and never acknowledged.
    pub torn: usize,
}

/// Opens the journal of a folder, which is made where there is none.
///
/// # Errors
/// A folder that cannot be used, that another daemon uses, or whose file is damaged.
pub(crate) fn open(folder: &Path) -> Result<(Journal, Kept), JournalError> {
    let lock = locked(folder)?;
    let (large, kept) = replayed(folder)?;
    let writer = Writer::new(Log::new(super::file(folder)), large, lock);
    Ok((Journal { writer }, kept))
}

/// Opens it for a daemon that knows what was kept: whatever lies there is written anew.
///
/// # Errors
/// A folder that cannot be used, or that another daemon uses.
pub(crate) fn open_again(folder: &Path) -> Result<Journal, JournalError> {
    let lock = locked(folder)?;
    let writer = Writer::new(Log::new(super::file(folder)), Large::new(folder), lock);
    Ok(Journal { writer })
}

/// The folder's lock.
fn locked(folder: &Path) -> Result<File, JournalError> {
    let lock = lock_file(folder).map_err(|source| JournalError::Folder {
        folder: folder.to_owned(),
        source,
    })?;
    match is_locked(&lock) {
        true => Ok(lock),
        false => Err(JournalError::Locked(folder.to_owned())),
    }
}

/// The file whose lock a daemon holds, in a folder that is made where there is none.
fn lock_file(folder: &Path) -> std::io::Result<File> {
    let mut builder = DirBuilder::new();
    builder
        .recursive(true)
        .mode(0o700)
        .create(folder)?;
    File::create(folder.join("lock"))
}

/// Locks a file; false where another daemon holds it and does not end.
fn is_locked(lock: &File) -> bool {
    let end = Instant::now() + LOCK_PATIENCE;
    while !try_lock(lock) {
        if Instant::now() > end {
            return false;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    true
}

fn try_lock(lock: &File) -> bool {
    flock(lock, FlockOperation::NonBlockingLockExclusive).is_ok()
}

/// What is kept in a folder, whoever writes it.
///
/// # Errors
/// A file that is damaged or cannot be read.
pub(super) fn look(folder: &Path) -> Result<Kept, JournalError> {
    replayed(folder).map(|(_, kept)| kept)
}

fn replayed(folder: &Path) -> Result<(Large, Kept), JournalError> {
    let contents = log::read(&super::file(folder))?;
    let mut large = Large::new(folder);
    let ended = matches!(contents.records.last(), Some(Record::Ended));
    let states = replay(contents.records, &mut large);
    let kept = Kept {
        states,
        ended,
        torn: contents.torn,
    };
    Ok((large, kept))
}

/// What a label names, before it is checked.
enum Unchecked {
    Robot(UncheckedRobot),
    Scene(UncheckedScene),
    Gone,
    Wrong(String),
}

struct UncheckedRobot {
    hash: u64,
    weights: Vec<f64>,
    configured: bool,
    robot: RobotRecord,
}

struct UncheckedScene {
    version: u64,
    hash: u64,
    configured: bool,
    scene: SceneRecord,
}

fn replay(records: Vec<Record>, large: &mut Large) -> BTreeMap<Key, Result<State, String>> {
    let mut named = BTreeMap::new();
    for record in records {
        take(&mut named, record);
    }
    let states = named.into_iter();
    states
        .map(|(key, unchecked)| (key, unchecked.check(large)))
        .collect()
}

fn take(named: &mut BTreeMap<Key, Unchecked>, record: Record) {
    match record {
        Record::Robot {
            label,
            hash,
            weights,
            configured,
            robot,
        } => {
            let robot = UncheckedRobot {
                hash,
                weights,
                configured,
                robot,
            };
            named.insert((Kind::Robot, label), Unchecked::Robot(robot));
        }
        Record::Scene {
            label,
            version,
            hash,
            configured,
            scene,
        } => {
            let scene = UncheckedScene {
                version,
                hash,
                configured,
                scene,
            };
            named.insert((Kind::Scene, label), Unchecked::Scene(scene));
        }
        Record::Moved {
            label,
            version,
            hash,
            moves,
        } => {
            let named = named
                .entry((Kind::Scene, label))
                .or_insert(Unchecked::Gone);
            named.moved(version, hash, &moves);
        }
        Record::RobotGone { label } => {
            named.insert((Kind::Robot, label), Unchecked::Gone);
        }
        Record::SceneGone { label } => {
            named.insert((Kind::Scene, label), Unchecked::Gone);
        }
        Record::Ended => {}
    }
}

impl Unchecked {
    /// The content, if it is what it was.
    fn check(self, large: &mut Large) -> Result<State, String> {
        match self {
            Self::Robot(robot) => robot.check(large),
            Self::Scene(scene) => scene.check(large),
            Self::Gone => Ok(State {
                content: Content::Gone,
                configured: false,
            }),
            Self::Wrong(reason) => Err(reason),
        }
    }

    /// A scene of which only something moved.
    fn moved(&mut self, version: u64, hash: u64, moves: &Moves) {
        let moved = match self {
            Self::Scene(scene) => scene.moved(version, hash, moves),
            Self::Wrong(reason) => Err(std::mem::take(reason)),
            Self::Robot(_) | Self::Gone => Err("it moves, and is not there".to_owned()),
        };
        if let Err(reason) = moved {
            *self = Self::Wrong(reason);
        }
    }
}

impl UncheckedRobot {
    fn check(self, large: &mut Large) -> Result<State, String> {
        let robot = self.robot.restore(large)?;
        same(robot.hash(), self.hash)?;
        if self.weights.len() != robot.space().nv() {
            return Err("its weights are not as many as it needs".to_owned());
        }
        Ok(State {
            content: Content::Robot(Arc::new(robot), self.weights.into()),
            configured: self.configured,
        })
    }
}

impl UncheckedScene {
    fn check(self, large: &mut Large) -> Result<State, String> {
        let scene = self.scene.restore(large)?;
        same(scene.hash(), self.hash)?;
        Ok(State {
            content: Content::Scene(self.version, Arc::new(scene)),
            configured: self.configured,
        })
    }

    fn moved(&mut self, version: u64, hash: u64, moves: &Moves) -> Result<(), String> {
        self.version = version;
        self.hash = hash;
        self.scene.apply(moves)
    }
}

fn same(found: u64, hash: u64) -> Result<(), String> {
    match found == hash {
        true => Ok(()),
        false => Err(format!("it has hash {found:016x}, it had {hash:016x}")),
    }
}
