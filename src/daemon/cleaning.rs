//! Whether the thread that cleans up after dead clients gets on.

use std::time::Duration;

use taut_ipc::server::Janitor;

/// How long a hanging janitor goes unmentioned.
const PATIENCE: Duration = Duration::from_secs(10);

/// The janitor, and whether it was slow when it was last looked at.
pub(super) struct Cleaning {
    janitor: Janitor,
    was_slow: bool,
}

impl Cleaning {
    /// Watches over a janitor.
    pub(super) fn new(janitor: Janitor) -> Self {
        Self {
            janitor,
            was_slow: false,
        }
    }

    /// Has the janitor look for clients that are gone.
    pub(super) fn look(&self) {
        self.janitor.look();
    }

    /// Dead clients that were cleaned up after.
    pub(super) fn cleaned(&self) -> u64 {
        self.janitor.cleaned()
    }

    /// Says so once when the janitor begins to hang.
    pub(super) fn warn_if_slow(&mut self) {
        let is_slow = self.janitor.busy_for() > PATIENCE;
        if is_slow && !self.was_slow {
            tracing::error!(
                "cleaning up after dead clients hangs; restart the daemon when convenient"
            );
        }
        self.was_slow = is_slow;
    }
}
