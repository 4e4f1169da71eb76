//! What must not be sent where it comes up.
//!
//! Replying to a client that does not read waits, up to `wait_before_close`, and so does letting a
//! query go, which tells its end. Zenoh's threads serve all links and must not wait for one.

use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use zenoh::Wait;
use zenoh::bytes::ZBytes;
use zenoh::query::Query;

/// What waits at most; more is let go where it is.
const WAITING: usize = 256;
/// What is larger gets a thread of its own, so that whoever takes long to read it keeps nobody
/// waiting.
const SMALL: usize = 64 * 1024;

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
    fn is_large(&self) -> bool {
        matches!(self, Self::Reply(_, bytes) if bytes.len() > SMALL)
    }

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

/// A thread that sends.
#[derive(Debug)]
pub(super) struct Sender(SyncSender<Later>);

impl Sender {
    pub(super) fn start() -> Self {
        let (sender, receiver) = sync_channel(WAITING);
        start("taut-later", move || run(&receiver));
        Self(sender)
    }

    pub(super) fn send(&self, later: Later) {
        if later.is_large() {
            return start("taut-kept", move || later.run());
        }
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

/// Starts a thread; without one, what it was to do is dropped.
pub(super) fn start(name: &str, work: impl FnOnce() + Send + 'static) {
    let builder = std::thread::Builder::new().name(name.into());
    if let Err(error) = builder.spawn(work) {
        tracing::error!("no thread {name}: {error}");
    }
}
