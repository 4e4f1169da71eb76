//! Labels whose content is on its way.

use std::collections::BTreeMap;
use std::sync::Arc;

use taut_ipc::wire::label_id;

use super::reading::Reading;

/// What is being read.
#[derive(Default)]
pub(crate) struct Loading {
    /// By the ids of the labels.
    labels: BTreeMap<u64, Arc<Reading>>,
}

impl Loading {
    /// What a label names is being read.
    pub(crate) fn begin(&mut self, label: &str, reading: Arc<Reading>) {
        self.labels.insert(label_id(label), reading);
    }

    /// What a label names has been read.
    pub(crate) fn end(&mut self, label: &str) {
        self.labels.remove(&label_id(label));
    }

    /// What is being loaded, by the ids of its labels.
    pub(crate) fn labels(&self) -> &BTreeMap<u64, Arc<Reading>> {
        &self.labels
    }
}
