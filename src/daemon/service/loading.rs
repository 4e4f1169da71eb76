//! Labels whose content is on its way.

use std::collections::HashSet;

use taut_ipc::wire::label_id;

use super::event::Purpose;

/// What is being read.
#[derive(Default)]
pub(crate) struct Loading {
    /// Ids of the labels.
    labels: HashSet<u64>,
}

impl Loading {
    /// A label is read for this.
    pub(crate) fn begin(&mut self, label: &str, purpose: Purpose) {
        if matches!(purpose, Purpose::Load { .. }) {
            self.labels.insert(label_id(label));
        }
    }

    /// A label has been read for this.
    pub(crate) fn end(&mut self, label: &str, purpose: Purpose) {
        if matches!(purpose, Purpose::Load { .. }) {
            self.labels.remove(&label_id(label));
        }
    }

    /// Ids of the labels that are being loaded.
    pub(crate) fn labels(&self) -> &HashSet<u64> {
        &self.labels
    }
}
