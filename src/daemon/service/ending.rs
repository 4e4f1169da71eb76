//! The end: nothing new is let in, and what is open ends with the best so far. A daemon whose files
//! somebody removed ends in order to start anew with what it has.

use std::path::Path;

use taut::store::ModelStore;

use super::Service;
use super::job::StopCause;

impl Service {
    /// Ends because it was asked to, for good.
    pub(super) fn drain(&mut self) {
        self.is_removed = false;
        self.end_open();
    }

    /// Ends because nobody else can come any more. Where it ends already, that goes on.
    pub(super) fn drain_removed(&mut self, missing: &Path) {
        if self.is_draining {
            return;
        }
        tracing::warn!(
            "{} is gone, by which clients find this daemon: it ends what is open and starts anew with the same robots and scenes; if a cleaner of temporary files or RemoveIPC= of systemd-logind did that, except the instance from it",
            missing.display()
        );
        self.is_removed = true;
        self.end_open();
    }

    /// Whether it ends to start anew, because its files were removed.
    pub(crate) fn is_removed(&self) -> bool {
        self.is_removed
    }

    /// Whether the daemon is asked to end and has nothing to do any more.
    pub(crate) fn is_done(&self) -> bool {
        self.is_draining && self.open.is_empty() && self.keeping.is_idle()
    }

    /// What is loaded.
    pub(crate) fn into_store(self) -> ModelStore {
        self.store
    }

    fn end_open(&mut self) {
        if !std::mem::replace(&mut self.is_draining, true) {
            tracing::info!(open = self.open.worked_on(), "stopping");
            self.end_waiting();
            self.stop_jobs();
            self.end_watches();
        }
    }

    fn end_waiting(&mut self) {
        for job in self.schedule.take_all(self.now_ns) {
            self.answer_untouched(&job, StopCause::Shutdown);
        }
    }

    fn stop_jobs(&mut self) {
        let jobs: Vec<_> = self
            .open
            .jobs()
            .map(|(ticket, job)| (ticket, job.clone()))
            .collect();
        for (ticket, job) in jobs {
            self.stop(ticket, &job, StopCause::Shutdown);
        }
    }
}
