//! A thread that cleans up after clients as soon as they die.

use super::cleanup::{CleanUp, clean, nodes, nodes_folder};
use crate::instance::Instance;
use crate::limits::{JANITOR_FULL_PASS, JANITOR_INTERVAL, JANITOR_RETRY};
use crate::time::monotonic_ns;
use crate::transport;
use rustix::event::{EventfdFlags, PollFd, PollFlags, Timespec, eventfd, poll};
use rustix::process::{Pid, PidfdFlags, pidfd_open};
use std::os::fd::{AsFd, OwnedFd};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime};

#[derive(Debug)]
struct Progress {
    cleaned: AtomicU64,
    busy_since_ns: AtomicU64,
    /// Ends the sleep: to look at once, or to stop.
    call: OwnedFd,
    stops: AtomicBool,
}

/// A thread that removes what dead clients leave, on a thread of its own.
///
/// It sleeps on the client processes themselves, so a death wakes it at once and idling costs
/// nothing. Processes of another container, which it cannot watch, are looked at four times a
/// second.
#[derive(Debug)]
pub struct Janitor {
    progress: Arc<Progress>,
    thread: Option<JoinHandle<()>>,
}

impl Janitor {
    /// Starts the thread; `cleaned` is called after each pass that removed somebody.
    ///
    /// # Errors
    /// If the system has no thread or file descriptor left.
    pub fn start(
        instance: &Instance,
        cleaned: impl Fn(CleanUp) + Send + 'static,
    ) -> std::io::Result<Self> {
        let progress = Arc::new(Progress {
            cleaned: AtomicU64::new(0),
            busy_since_ns: AtomicU64::new(0),
            call: eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?,
            stops: AtomicBool::new(false),
        });
        let shared = progress.clone();
        let mut watch = Watch::new(instance);
        let thread = std::thread::Builder::new()
            .name("taut-janitor".into())
            .spawn(move || {
                transport::quiet();
                loop {
                    watch.sleep(&shared.call);
                    if shared.stops.load(Ordering::Relaxed) {
                        return;
                    }
                    if !watch.is_due() {
                        continue;
                    }
                    shared
                        .busy_since_ns
                        .store(monotonic_ns(), Ordering::Relaxed);
                    let done = watch.pass();
                    shared.busy_since_ns.store(0, Ordering::Relaxed);
                    shared
                        .cleaned
                        .fetch_add(done.cleaned as u64, Ordering::Relaxed);
                    if done.cleaned > 0 {
                        cleaned(done);
                    }
                }
            })?;
        Ok(Self {
            progress,
            thread: Some(thread),
        })
    }

    /// Looks at once whether clients came, so that their deaths wake it from now on.
    pub fn look(&self) {
        let _ = rustix::io::write(&self.progress.call, &1u64.to_ne_bytes());
    }

    /// Dead nodes removed since the start.
    pub fn cleaned(&self) -> u64 {
        self.progress.cleaned.load(Ordering::Relaxed)
    }

    /// How long the current pass has been running; zero between passes. More than some seconds
    /// means that it hangs: log it and, under a supervisor, restart.
    pub fn busy_for(&self) -> Duration {
        match self
            .progress
            .busy_since_ns
            .load(Ordering::Relaxed)
        {
            0 => Duration::ZERO,
            since => Duration::from_nanos(monotonic_ns().saturating_sub(since)),
        }
    }
}

impl Drop for Janitor {
    fn drop(&mut self) {
        self.progress
            .stops
            .store(true, Ordering::Relaxed);
        self.look();
        // A hanging pass must not hang the daemon's end.
        if self.busy_for() < Duration::from_secs(1)
            && let Some(thread) = self.thread.take()
        {
            let _ = thread.join();
        }
    }
}

/// What the thread knows of the clients.
struct Watch {
    instance: Instance,
    node_folder: PathBuf,
    /// When nodes last came or went, at the last full pass.
    seen: Option<SystemTime>,
    processes: Vec<OwnedFd>,
    /// Somebody died, or cannot be watched: look at the next tick.
    look: bool,
    /// Passes in a row that could not remove somebody.
    failures: u32,
    last_pass: Instant,
}

impl Watch {
    fn new(instance: &Instance) -> Self {
        Self {
            instance: instance.clone(),
            node_folder: nodes_folder(instance),
            seen: None,
            processes: Vec::new(),
            look: true,
            failures: 0,
            last_pass: Instant::now(),
        }
    }

    /// Sleeps until a process dies, somebody calls, or a tick passes.
    fn sleep(&mut self, call: &OwnedFd) {
        let all = std::iter::once(call).chain(&self.processes);
        let mut fds: Vec<_> = all
            .map(|fd| PollFd::from_borrowed_fd(fd.as_fd(), PollFlags::IN))
            .collect();
        let tick = match self.failures {
            0 => JANITOR_INTERVAL,
            failures => JANITOR_INTERVAL.min(JANITOR_RETRY * (1 << failures)),
        };
        let tick = Timespec {
            tv_sec: 0,
            tv_nsec: tick.as_nanos() as _,
        };
        if poll(&mut fds, Some(&tick)).is_err() {
            return;
        }
        let is_called = !fds[0].revents().is_empty();
        let died = fds[1..]
            .iter()
            .any(|fd| !fd.revents().is_empty());
        self.look |= died || is_called;
        if is_called {
            // Calls that came together are one.
            let _ = rustix::io::read(call, &mut [0; 8]);
        }
    }

    fn changed_at(&self) -> Option<SystemTime> {
        std::fs::metadata(&self.node_folder)
            .and_then(|meta| meta.modified())
            .ok()
    }

    fn is_due(&self) -> bool {
        self.look || self.changed_at() != self.seen || self.last_pass.elapsed() > JANITOR_FULL_PASS
    }

    fn pass(&mut self) -> CleanUp {
        let changed_at = self.changed_at();
        let (alive, dead) = nodes(&self.instance);
        let watched: Vec<_> = alive
            .iter()
            .copied()
            .filter(|pid| !is_own(*pid))
            .map(open_process)
            .collect();
        let blind = watched.iter().any(Option::is_none);
        self.processes = watched.into_iter().flatten().collect();
        let done = clean(&self.instance, alive.len(), dead);
        // The folder's clock is coarse: a change just before this pass may hide a later one.
        let recent = changed_at
            .and_then(|at| at.elapsed().ok())
            .is_some_and(|age| age < JANITOR_INTERVAL);
        self.seen = changed_at.filter(|_| !recent);
        self.look = blind || done.is_incomplete();
        // What fails soon works, when another clean-up of this process is done, or never.
        self.failures = if done.failed == 0 {
            0
        } else {
            (self.failures + 1).min(8)
        };
        self.last_pass = Instant::now();
        done
    }
}

fn is_own(pid: Option<i32>) -> bool {
    pid == i32::try_from(std::process::id()).ok()
}

fn open_process(pid: Option<i32>) -> Option<OwnedFd> {
    pidfd_open(Pid::from_raw(pid?)?, PidfdFlags::empty()).ok()
}
