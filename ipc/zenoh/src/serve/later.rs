//! What must not be sent where it comes up.
//!
//! Replying to a client that does not read waits, up to `wait_before_close`, and so does letting a
//! query go, which tells its end. Zenoh's threads serve all links and must not wait for one; nor does
//! a client wait for another: each has a sender of its own.

use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use zenoh::Wait;
use zenoh::bytes::ZBytes;
use zenoh::query::Query;

/// What waits at most; more is let go where it is.
const WAITING: usize = 256;
/// What is done with a query.
#[derive(Debug)]
pub(super) enum Later {
    /// It is let go without a reply.
    LetGo(Query),
    /// It gets this reply and is let go.
    Reply(Query, ZBytes),
    /// It gets this as an error and is let go.
    Fail(Query, ZBytes),
}

impl Later {
    fn run(self) {
        let sent = match self {
            Self::LetGo(query) => {
                drop(query);
                Ok(())
            }
            Self::Reply(query, bytes) => reply(&query, bytes),
            Self::Fail(query, bytes) => query.reply_err(bytes).wait(),
        };
        if let Err(error) = sent {
            tracing::debug!("a reply was not sent: {error}");
        }
    }
}

/// Replies to a query.
pub(super) fn reply(query: &Query, bytes: ZBytes) -> zenoh::Result<()> {
    query
        .reply(query.key_expr().clone(), bytes)
        .wait()
}

/// A thread that sends, for as long as this is there.
#[derive(Debug)]
pub(super) struct Sender(SyncSender<Later>);

impl Sender {
    pub(super) fn start() -> std::io::Result<Self> {
        let (sender, receiver) = sync_channel(WAITING);
        begin("taut-later", move || run(&receiver))?;
        Ok(Self(sender))
    }

    pub(super) fn send(&self, later: Later) {
        match self.0.try_send(later) {
            Ok(()) => {}
            Err(TrySendError::Full(later) | TrySendError::Disconnected(later)) => drop(later),
        }
    }
}

fn run(receiver: &Receiver<Later>) {
    while let Ok(later) = receiver.recv() {
        later.run();
    }
}

/// Starts a thread.
pub(super) fn begin(name: &str, work: impl FnOnce() + Send + 'static) -> std::io::Result<()> {
    let builder = std::thread::Builder::new().name(name.into());
    builder.spawn(work).map(drop)
}

/// The same; without one, what it was to do is dropped.
pub(super) fn start(name: &str, work: impl FnOnce() + Send + 'static) {
    if let Err(error) = begin(name, work) {
        tracing::error!("no thread {name}: {error}");
    }
}
