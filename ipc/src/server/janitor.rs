//! Removes what killed processes left behind.
//!
//! iceoryx2 notices a killed client only when its node is cleaned up; until then its requests look connected.

use crate::instance::Instance;
use crate::limits::{EMPTY_FILE_AGE, JANITOR_INTERVAL};
use crate::memory::{shared_files, wipe};
use crate::time::monotonic_ns;
use crate::transport::{self, Variant};
use iceoryx2::node::{DeadNodeView, Node, NodeState};
use iceoryx2::prelude::CallbackProgression;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, mpsc};
use std::thread::JoinHandle;
use std::time::Duration;

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
    if alive == 0 {
        wipe(instance);
    } else {
        clean_dead_nodes(instance);
    }
}

fn nodes(instance: &Instance) -> (usize, Vec<DeadNodeView<Variant>>) {
    let (mut alive, mut dead) = (0, Vec::new());
    let _ = Node::<Variant>::list(&instance.config(), |state| {
        match state {
            NodeState::Dead(view) => dead.push(view),
            _ => alive += 1,
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

#[derive(Debug, Default)]
struct Progress {
    cleaned: AtomicU64,
    busy_since_ns: AtomicU64,
    stop: AtomicBool,
}

/// A thread that calls [`clean_dead_nodes`] four times a second until dropped.
#[derive(Debug)]
pub struct Janitor {
    progress: Arc<Progress>,
    // Dropping it ends the thread's sleep.
    bell: Option<mpsc::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Janitor {
    /// Starts the thread; `woken` is called after each pass that removed somebody.
    pub fn start(instance: &Instance, woken: impl Fn(CleanUp) + Send + 'static) -> std::io::Result<Self> {
        let progress = Arc::new(Progress::default());
        let (bell, sleep) = mpsc::channel();
        let (instance, shared) = (instance.clone(), progress.clone());
        let thread = std::thread::Builder::new().name("taut-janitor".into()).spawn(move || {
            while !shared.stop.load(Ordering::Relaxed) {
                shared.busy_since_ns.store(monotonic_ns(), Ordering::Relaxed);
                let done = clean_dead_nodes(&instance);
                shared.busy_since_ns.store(0, Ordering::Relaxed);
                shared.cleaned.fetch_add(done.cleaned as u64, Ordering::Relaxed);
                if done.cleaned > 0 {
                    woken(done);
                }
                let _ = sleep.recv_timeout(JANITOR_INTERVAL);
            }
        })?;
        Ok(Self { progress, bell: Some(bell), thread: Some(thread) })
    }

    /// Dead nodes removed since the start.
    pub fn cleaned(&self) -> u64 {
        self.progress.cleaned.load(Ordering::Relaxed)
    }

    /// How long the current pass has been running; zero between passes. More than some seconds means that it
    /// hangs: log it and, under a supervisor, restart.
    pub fn busy_for(&self) -> Duration {
        match self.progress.busy_since_ns.load(Ordering::Relaxed) {
            0 => Duration::ZERO,
            since => Duration::from_nanos(monotonic_ns().saturating_sub(since)),
        }
    }
}

impl Drop for Janitor {
    fn drop(&mut self) {
        self.progress.stop.store(true, Ordering::Relaxed);
        self.bell.take();
        // A hanging pass must not hang the daemon's end.
        if self.busy_for() < Duration::from_secs(1)
            && let Some(thread) = self.thread.take()
        {
            let _ = thread.join();
        }
    }
}
