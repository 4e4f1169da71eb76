//! Reading: what the labels named when the daemon that wrote it ended.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{DirBuilder, File};
use std::io::ErrorKind;
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use rustix::fs::{FlockOperation, flock};
use taut_ipc::wire::Code;

use super::log::{self, Log, LogError};
use super::meshes::Meshes;
use super::record::Record;
use super::write::Writer;
use super::{Content, Journal, Key, Kind, State};
use crate::daemon::persisted::{RobotRecord, SceneRecord};

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
pub(in crate::daemon) struct Kept {
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
pub(in crate::daemon) fn open(folder: &Path) -> Result<(Journal, Kept), JournalError> {
    let refuse = |source| JournalError::Folder {
        folder: folder.to_owned(),
        source,
    };
    DirBuilder::new()
        .recursive(true)
        .mode(0o700)
        .create(folder)
        .map_err(refuse)?;
    let lock = File::create(folder.join("lock")).map_err(refuse)?;
    let end = Instant::now() + LOCK_PATIENCE;
    while flock(&lock, FlockOperation::NonBlockingLockExclusive).is_err() {
        if Instant::now() > end {
            return Err(JournalError::Locked(folder.to_owned()));
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    let (meshes, kept) = replayed(folder)?;
    let log = Log::new(super::file(folder));
    let live = BTreeMap::new();
    let before = BTreeMap::new();
    let configured = BTreeSet::new();
    let writer = Writer {
        log,
        meshes,
        live,
        before,
        configured,
        _lock: lock,
    };
    Ok((Journal { writer }, kept))
}

/// What is kept in a folder, whoever writes it.
///
/// # Errors
/// A file that is damaged or cannot be read.
pub(super) fn look(folder: &Path) -> Result<Kept, JournalError> {
    replayed(folder).map(|(_, kept)| kept)
}

/// Where the meshes are.
pub(super) fn meshes(folder: &Path) -> PathBuf {
    folder.join("meshes")
}

fn replayed(folder: &Path) -> Result<(Meshes, Kept), JournalError> {
    let contents = log::read(&super::file(folder))?;
    let mut meshes = Meshes::new(meshes(folder));
    let (states, ended) = replay(contents.records, &mut meshes);
    Ok((
        meshes,
        Kept {
            states,
            ended,
            torn: contents.torn,
        },
    ))
}

/// What a label names, before it is checked.
enum Unchecked {
    Robot {
        hash: u64,
        weights: Vec<f64>,
        configured: bool,
        robot: RobotRecord,
    },
    Scene {
        version: u64,
        hash: u64,
        configured: bool,
        scene: SceneRecord,
    },
    Gone,
    Wrong(String),
}

fn replay(
    records: Vec<Record>,
    meshes: &mut Meshes,
) -> (BTreeMap<Key, Result<State, String>>, bool) {
    let mut named = BTreeMap::<Key, Unchecked>::new();
    let mut ended = false;
    for record in records {
        ended = matches!(record, Record::Ended);
        match record {
            Record::Robot {
                label,
                hash,
                weights,
                configured,
                robot,
            } => {
                named.insert(
                    (Kind::Robot, label),
                    Unchecked::Robot {
                        hash,
                        weights,
                        configured,
                        robot,
                    },
                );
            }
            Record::Scene {
                label,
                version,
                hash,
                configured,
                scene,
            } => {
                named.insert(
                    (Kind::Scene, label),
                    Unchecked::Scene {
                        version,
                        hash,
                        configured,
                        scene,
                    },
                );
            }
            Record::Moved {
                label,
                version,
                hash,
                moves,
            } => {
                let named = named.entry((Kind::Scene, label)).or_insert(Unchecked::Gone);
                let moved = match named {
                    Unchecked::Scene {
                        version: old,
                        hash: before,
                        scene,
                        ..
                    } => {
                        *old = version;
                        *before = hash;
                        scene.apply(&moves)
                    }
                    Unchecked::Wrong(reason) => Err(std::mem::take(reason)),
                    _ => Err("it moves, and is not there".to_owned()),
                };
                if let Err(reason) = moved {
                    *named = Unchecked::Wrong(reason);
                }
            }
            Record::RobotGone { label } => {
                drop(named.insert((Kind::Robot, label), Unchecked::Gone))
            }
            Record::SceneGone { label } => {
                drop(named.insert((Kind::Scene, label), Unchecked::Gone))
            }
            Record::Ended => {}
        }
    }
    (
        named
            .into_iter()
            .map(|(key, unchecked)| (key, unchecked.check(meshes)))
            .collect(),
        ended,
    )
}

impl Unchecked {
    /// The content, if it is what it was.
    fn check(self, meshes: &mut Meshes) -> Result<State, String> {
        let mut find = |hash| meshes.find(hash);
        let differs =
            |found: u64, hash: u64| Err(format!("it has hash {found:016x}, it had {hash:016x}"));
        match self {
            Self::Robot {
                hash,
                weights,
                configured,
                robot,
            } => {
                let robot = robot.restore(&mut find)?;
                match robot.hash() {
                    found if found != hash => differs(found, hash),
                    _ if weights.len() != robot.space().nv() => {
                        Err("its weights are not as many as it needs".to_owned())
                    }
                    _ => Ok(State {
                        content: Content::Robot(Arc::new(robot), weights.into()),
                        configured,
                    }),
                }
            }
            Self::Scene {
                version,
                hash,
                configured,
                scene,
            } => {
                let scene = scene.restore(&mut find)?;
                match scene.hash() {
                    found if found != hash => differs(found, hash),
                    _ => Ok(State {
                        content: Content::Scene(version, Arc::new(scene)),
                        configured,
                    }),
                }
            }
            Self::Gone => Ok(State {
                content: Content::Gone,
                configured: false,
            }),
            Self::Wrong(reason) => Err(reason),
        }
    }
}
