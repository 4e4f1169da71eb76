//! Signs of life for whoever watches over the daemon: systemd, or `taut serve --supervise`. Both
//! are told by the same messages (`sd_notify`).

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::thread::JoinHandle;
use std::time::Duration;

use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, bounded};
use sd_notify::NotifyState;

use crate::daemon::threads::spawn;

/// How often a sign of life is given.
const INTERVAL: Duration = Duration::from_millis(500);

/// Counts status messages. A thread of its own tells of them: a watcher that does not read may keep
/// that one waiting.
pub(crate) struct Pulse {
    beats: Arc<AtomicU64>,
    // Its end ends the thread.
    _until: Sender<()>,
}

impl Pulse {
    /// Tells that the daemon is ready and, as long as the crew beats, that it is alive.
    /// Without a watcher there is no thread.
    pub(crate) fn start() -> std::io::Result<(Self, Option<JoinHandle<()>>)> {
        let (until, ended) = bounded(0);
        let pulse = Self::new(until);
        let thread = pulse.telling(ended)?;
        Ok((pulse, thread))
    }

    fn new(until: Sender<()>) -> Self {
        Self {
            beats: Arc::default(),
            _until: until,
        }
    }

    fn telling(&self, ended: Receiver<()>) -> std::io::Result<Option<JoinHandle<()>>> {
        if std::env::var_os("NOTIFY_SOCKET").is_none() {
            return Ok(None);
        }
        let beats = self.beats.clone();
        spawn("taut-pulse", move || tell(&beats, &ended)).map(Some)
    }

    /// The crew is well.
    pub(crate) fn beat(&self) {
        self.beats.fetch_add(1, Relaxed);
    }
}

fn tell(beats: &AtomicU64, ended: &Receiver<()>) {
    let mut before = None;
    notify(NotifyState::Ready);
    while ended.recv_timeout(INTERVAL) == Err(RecvTimeoutError::Timeout) {
        let now = Some(beats.load(Relaxed));
        if now != before {
            notify(NotifyState::Watchdog);
        }
        before = now;
    }
}

fn notify(state: NotifyState) {
    if let Err(error) = sd_notify::notify(&[state]) {
        tracing::debug!("nobody was told that the daemon is alive: {error}");
    }
}
