//! A process of the lab's.

use std::process::{Child, ChildStdin, ChildStdout, Command};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};
use taut_ipc::own_daemon::spawn;

use crate::error::Error;

/// How often is looked whether something is so.
const TICK: Duration = Duration::from_millis(1);

/// A process; killed when dropped.
#[derive(Debug)]
pub(crate) struct Process {
    name: String,
    child: Child,
}

impl Process {
    /// Starts it; `name` is for errors.
    pub(crate) fn start(name: &str, command: Command) -> Result<Self, Error> {
        Ok(Self {
            name: name.to_owned(),
            child: spawn(command)?,
        })
    }

    /// Its number.
    pub(crate) fn pid(&self) -> u32 {
        self.child.id()
    }

    /// Both ends of a conversation, where it was started with pipes; once.
    pub(crate) fn pipes(&mut self) -> Option<(ChildStdin, ChildStdout)> {
        Some((self.child.stdin.take()?, self.child.stdout.take()?))
    }

    /// Sends it a signal.
    pub(crate) fn signal(&self, signal: Signal) {
        // A child that is not reaped yet keeps its number, so that this cannot meet another
        // process.
        let _ = kill_process(Pid::from_child(&self.child), signal);
    }

    /// Whether it runs.
    pub(crate) fn is_alive(&mut self) -> bool {
        matches!(self.child.try_wait(), Ok(None))
    }

    /// Ends it at once (SIGKILL).
    pub(crate) fn end(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }

    /// An error that says what is wrong with it.
    pub(crate) fn failed(&self, reason: impl Into<String>) -> Error {
        Error::Process {
            what: self.name.clone(),
            reason: reason.into(),
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.end();
    }
}

/// Asks until it is so, at most so long; tells how long it took.
pub(crate) fn until(within: Duration, mut so: impl FnMut() -> bool) -> Option<Duration> {
    let start = Instant::now();
    while !so() {
        if start.elapsed() > within {
            return None;
        }
        std::thread::sleep(TICK);
    }
    Some(start.elapsed())
}
