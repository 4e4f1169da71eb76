//! Removes what killed processes left behind.
//!
//! iceoryx2 notices a killed client only when its node is cleaned up; until then its requests look connected.

use crate::instance::Instance;
use crate::limits::EMPTY_FILE_AGE;
use crate::memory::{shared_files, wipe};
use crate::transport::{self, Variant};
use iceoryx2::node::{DeadNodeView, Node, NodeState};
use iceoryx2::prelude::CallbackProgression;

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
    /// Left-over empty files removed.
    pub files: usize,
}

/// Removes the nodes of processes that died, each in 2 to 13 ms. For the daemon's janitor thread.
///
/// Cleaning up opens the dead process's shared memory. iceoryx2 0.10.0 waits without end for a file that was
/// created but not given a size yet, if it may open it (as root): so such files go first once they are old, and
/// while there are young ones nothing is cleaned.
pub fn clean_dead_nodes(instance: &Instance) -> CleanUp {
    transport::quiet();
    let (alive, dead) = nodes(instance);
    clean(instance, alive.len(), dead)
}

/// As [`clean_dead_nodes`], of nodes that were listed already.
pub(super) fn clean(instance: &Instance, alive: usize, dead: Vec<DeadNodeView<Variant>>) -> CleanUp {
    let mut done = CleanUp { alive, ..CleanUp::default() };
    if dead.is_empty() {
        return done;
    }
    let (files, young) = remove_empty_files(instance);
    done.files = files;
    if young {
        done.postponed = dead.len();
        return done;
    }
    for node in dead {
        match node.try_remove_stale_resources() {
            Ok(()) => done.cleaned += 1,
            Err(_) => done.failed += 1,
        }
    }
    done
}

/// At the start of a daemon, which holds the lock: if nobody lives, everything is wiped, else cleaned up.
pub(super) fn clean_start(instance: &Instance) {
    let (alive, _) = nodes(instance);
    if alive.is_empty() {
        wipe(instance);
    } else {
        clean_dead_nodes(instance);
    }
}

/// At the end of a daemon, which still holds the lock.
pub(super) fn clean_end(instance: &Instance) {
    let (alive, dead) = nodes(instance);
    if alive.is_empty() && dead.is_empty() {
        wipe(instance);
    }
}

/// Process of each living node, if it can be told, and the dead nodes.
pub(super) fn nodes(instance: &Instance) -> (Vec<Option<i32>>, Vec<DeadNodeView<Variant>>) {
    let (mut alive, mut dead) = (Vec::new(), Vec::new());
    let _ = Node::<Variant>::list(&instance.config(), |state| {
        match state {
            NodeState::Dead(view) => dead.push(view),
            other => alive.push(other.node_id().pid::<Variant>().ok().map(|pid| pid.value())),
        }
        CallbackProgression::Continue
    });
    (alive, dead)
}

/// Removes old empty files; tells how many, and whether young ones are left.
fn remove_empty_files(instance: &Instance) -> (usize, bool) {
    let (mut removed, mut young) = (0, false);
    for file in shared_files(instance).into_iter().filter(|file| file.bytes == 0) {
        if file.age < EMPTY_FILE_AGE {
            young = true;
        } else if std::fs::remove_file(&file.path).is_ok() {
            removed += 1;
        }
    }
    (removed, young)
}
