//! Threads by name.

use std::io::Result;
use std::thread::{Builder, JoinHandle};

/// Something that works on a thread of its own, and that thread.
pub(crate) type Started<T> = Result<(T, JoinHandle<()>)>;

/// Starts a thread; tools show its name.
pub(crate) fn spawn(name: &str, work: impl FnOnce() + Send + 'static) -> Result<JoinHandle<()>> {
    Builder::new().name(name.to_owned()).spawn(work)
}
