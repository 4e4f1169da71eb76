//! Control requests that wait for another thread, and labels whose content is on its way.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use taut_ipc::server::IncomingControl;
use taut_ipc::wire::label_id;

use super::loader::{Loader, Task, Work};
use super::reading::Reading;

/// What other threads do for control requests.
pub(super) struct Loading {
    /// Gone once the daemon ends.
    loader: Option<Loader>,
    /// Control requests that wait, by token.
    waiting: BTreeMap<u64, IncomingControl>,
    /// What these load, by the ids of its labels.
    labels: HashMap<u64, Arc<Reading>>,
}

impl Loading {
    /// Nothing is on its way.
    pub(super) fn new(loader: Loader) -> Self {
        Self {
            loader: Some(loader),
            waiting: BTreeMap::new(),
            labels: HashMap::new(),
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

    /// What a label names is being read.
    pub(super) fn begin(&mut self, label: &str, reading: Arc<Reading>) {
        self.labels.insert(label_id(label), reading);
    }

    /// What a label names has been read.
    pub(super) fn end(&mut self, label: &str) {
        self.labels.remove(&label_id(label));
    }

    /// What is being loaded, by the ids of its labels.
    pub(super) fn labels(&self) -> &HashMap<u64, Arc<Reading>> {
        &self.labels
    }

    /// Lets the loader end.
    pub(super) fn close(&mut self) {
        self.loader = None;
    }
}
