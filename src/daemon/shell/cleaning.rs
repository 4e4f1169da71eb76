//! Whether the thread that cleans up after dead clients gets on.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use taut_ipc::server::Janitor;

/// How long a hanging janitor goes unmentioned.
const PATIENCE: Duration = Duration::from_secs(10);

/// The janitor, and whether it was slow when it was last looked at.
pub(crate) struct Cleaning {
    janitor: Janitor,
    was_slow: AtomicBool,
}

impl Cleaning {
    /// Watches over a janitor.
    pub(crate) fn new(janitor: Janitor) -> Self {
        Self {
            janitor,
            was_slow: AtomicBool::new(false),
        }
    }

    /// Has the janitor look for clients that are gone.
    pub(crate) fn look(&self) {
        self.janitor.look();
    }

    /// Dead clients that were cleaned up after.
    pub(crate) fn cleaned(&self) -> u64 {
        self.janitor.cleaned()
    }

    /// Says so once when the janitor begins to hang.
    pub(crate) fn warn_if_slow(&self) {
        let is_slow = self.janitor.busy_for() > PATIENCE;
        let was_slow = self.was_slow.swap(is_slow, Ordering::Relaxed);
        if is_slow && !was_slow {
            tracing::error!(
                "cleaning up after dead clients hangs; restart the daemon when convenient"
            );
        }
    }
}
