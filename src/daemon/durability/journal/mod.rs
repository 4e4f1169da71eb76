//! The journal: what every label names, on disk, so that a daemon that died goes on with what it
//! had.
//!
//! A folder with a file of records (`journal`), a file for each mesh (`meshes`) and each cloud (`clouds`), and a lock.
//! Records are handed to the system before a change is acknowledged, which a killed process cannot
//! undo; a machine that loses its power may lose the last seconds. Contents are kept, not names of
//! files, and each must have its hash when it is read.

mod apart;
mod inspect;
mod log;
mod read;
mod record;
#[cfg(test)]
mod tests;
mod write;

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;
use std::thread::JoinHandle;

use crossbeam_channel::{Receiver, Sender, unbounded};
use taut::robot::RobotModel;
use taut::scene::Scene;

pub use inspect::inspect;
pub use read::JournalError;
pub(crate) use read::{Kept, open, open_again};
use write::Writer;

use crate::daemon::threads::spawn;

/// What has labels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    /// Robots.
    Robot,
    /// Scenes.
    Scene,
}

/// A label of robots or of scenes.
pub(crate) type Key = (Kind, String);

/// What a label names.
#[derive(Clone, Debug)]
pub(crate) enum Content {
    /// A robot with its default weights.
    Robot(Arc<RobotModel>, Arc<[f64]>),
    /// A version of a scene.
    Scene(u64, Arc<Scene>),
    /// Nothing any more.
    Gone,
}

impl Content {
    /// Whether it is the same content under the same version.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Robot(a, _), Self::Robot(b, _)) => a.is_same(b),
            (Self::Scene(version, a), Self::Scene(other, b)) => {
                version == other && a.hash() == b.hash()
            }
            (Self::Gone, Self::Gone) => true,
            _ => false,
        }
    }
}

/// What a label names, and who said so.
#[derive(Clone, Debug)]
pub(crate) struct State {
    /// What it names.
    pub content: Content,
    /// Said by the configuration; no client has changed it.
    pub configured: bool,
}

/// Something to keep.
pub(crate) enum Entry {
    /// A label names this now. The ticket comes back in [`crate::daemon::service::event::Event::Kept`].
    Changed(u64, Key, State),
    /// The daemon ends in order.
    End,
}

/// A journal that nobody writes yet; holds the folder's lock.
pub(crate) struct Journal {
    writer: Writer,
}

/// Tells the ticket up to which everything is dealt with, and why the last of it is not kept.
pub(crate) type Told = dyn Fn(u64, Option<String>) + Send;

impl Journal {
    /// Starts the thread that writes, first `live`, what the labels name now; it ends when the
    /// sender is dropped. `configured` are the labels that the configuration names: of those, it is
    /// kept too that they are gone.
    pub(crate) fn start(
        self,
        live: BTreeMap<Key, State>,
        configured: BTreeSet<Key>,
        told: Box<Told>,
    ) -> std::io::Result<(Sender<Entry>, JoinHandle<()>)> {
        let (entries, receiver) = unbounded();
        let writer = Writer {
            live,
            configured,
            ..self.writer
        };
        let thread = spawn("taut-journal", move || work(writer, &receiver, &told))?;
        Ok((entries, thread))
    }
}

/// Of several states that wait for one label, only the newest is written.
fn work(mut writer: Writer, entries: &Receiver<Entry>, told: &Told) {
    if let Err(reason) = writer.write(false) {
        tracing::error!("what is loaded is not kept yet: {reason}");
    }
    while let Ok(first) = entries.recv() {
        let waiting = std::iter::once(first).chain(entries.try_iter());
        let taken = take(&mut writer, waiting);
        told(taken.last, failure(&mut writer, taken.ends));
    }
}

/// Writes what was taken; why it is not kept, if it is not.
fn failure(writer: &mut Writer, ends: bool) -> Option<String> {
    let failure = writer.write(ends).err();
    if let Some(reason) = &failure {
        tracing::error!("changes are made but not kept: {reason}");
    }
    failure
}

/// What was taken to be written at once.
#[derive(Default)]
struct Taken {
    /// The last ticket.
    last: u64,
    /// Whether the daemon ends in order.
    ends: bool,
}

fn take(writer: &mut Writer, entries: impl Iterator<Item = Entry>) -> Taken {
    let mut taken = Taken::default();
    for entry in entries {
        match entry {
            Entry::Changed(ticket, key, state) => {
                taken.last = taken.last.max(ticket);
                writer.take(key, state);
            }
            Entry::End => taken.ends = true,
        }
    }
    taken
}

/// Where the journal is.
fn file(folder: &std::path::Path) -> PathBuf {
    folder.join("journal")
}
