//! Control requests that wait for another thread, and labels whose content is on its way.

use std::collections::{BTreeMap, HashSet};

use taut_ipc::server::IncomingControl;
use taut_ipc::wire::label_id;

use super::event::Purpose;
use super::loader::{Loader, Task, Work};

/// What other threads do for control requests.
pub(super) struct Loading {
    /// Gone once the daemon ends.
    loader: Option<Loader>,
    /// Control requests that wait, by token.
    waiting: BTreeMap<u64, IncomingControl>,
    /// Ids of the labels that these load.
    labels: HashSet<u64>,
}

impl Loading {
    /// Nothing is on its way.
    pub(super) fn new(loader: Loader) -> Self {
        Self {
            loader: Some(loader),
            waiting: BTreeMap::new(),
            labels: HashSet::new(),
        }
    }

    /// Has a control request wait for the thread that answers this token.
    pub(super) fn wait(&mut self, control: IncomingControl, token: u64) {
        self.waiting.insert(token, control);
    }

    /// Has the loader work on something under this token.
    pub(super) fn send(&self, token: u64, work: Work) {
        if let Some(loader) = &self.loader {
            loader.send(Task { token, work });
        }
    }

    /// The control request of a token, which waits no longer.
    pub(super) fn take(&mut self, token: u64) -> Option<IncomingControl> {
        self.waiting.remove(&token)
    }

    /// A label is read for this.
    pub(super) fn begin(&mut self, label: &str, purpose: Purpose) {
        if matches!(purpose, Purpose::Load { .. }) {
            self.labels.insert(label_id(label));
        }
    }

    /// A label has been read for this.
    pub(super) fn end(&mut self, label: &str, purpose: Purpose) {
        if matches!(purpose, Purpose::Load { .. }) {
            self.labels.remove(&label_id(label));
        }
    }

    /// Ids of the labels that are being loaded.
    pub(super) fn labels(&self) -> &HashSet<u64> {
        &self.labels
    }

    /// Lets the loader end.
    pub(super) fn close(&mut self) {
        self.loader = None;
    }
}
