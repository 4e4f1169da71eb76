//! Threads by name, and what they share.

use std::io::Result;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};

use rustix::process::{getpriority_process, setpriority_process};
use rustix::thread::gettid;

/// Something that works on a thread of its own, and that thread.
pub(crate) type Started<T> = Result<(T, JoinHandle<()>)>;

/// Locks what threads share. A thread of the crew that panics ends the daemon, so that nobody goes
/// on for long with what it may have left half done.
pub(crate) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
}

/// Starts a thread; tools show its name.
pub(crate) fn spawn(name: &str, work: impl FnOnce() + Send + 'static) -> Result<JoinHandle<()>> {
    Builder::new().name(name.to_owned()).spawn(work)
}

/// The same for work that lasts: others on this machine go before it, as far as `niceness` says.
pub(crate) fn spawn_nice(
    name: &str,
    niceness: i32,
    work: impl FnOnce() + Send + 'static,
) -> Result<JoinHandle<()>> {
    spawn(name, move || {
        be_nice(niceness);
        work();
    })
}

/// Makes the calling thread, and no other, at least this nice. It cannot go back: that would take
/// a privilege. A daemon that was started nicer stays so.
pub(crate) fn be_nice(niceness: i32) {
    if let Err(error) = be_nicer(niceness) {
        tracing::warn!("a thread cannot have niceness {niceness}: {error}");
    }
}

fn be_nicer(niceness: i32) -> rustix::io::Result<()> {
    let thread = Some(gettid());
    match getpriority_process(thread)? {
        now if now >= niceness => Ok(()),
        _ => setpriority_process(thread, niceness),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn own() -> i32 {
        getpriority_process(Some(gettid())).unwrap()
    }

    #[test]
    fn a_nice_thread_is_alone_with_it_and_stays_so() {
        let before = own();
        let nicer = (before + 3).min(19);
        let (sender, receiver) = std::sync::mpsc::channel();
        let thread = spawn_nice("nice", nicer, move || {
            sender.send(own()).unwrap();
            be_nice(before);
            sender.send(own()).unwrap();
        });
        thread.unwrap().join().unwrap();
        assert_eq!(receiver.iter().collect::<Vec<_>>(), [nicer, nicer]);
        assert_eq!(own(), before);
    }
}
