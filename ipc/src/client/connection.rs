//! The ports of a client, which may have to be opened anew.

use super::ClientError;
use super::Loss;
use super::link::Link;
use crate::instance::Instance;
use crate::time::unique_number;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// What a client and its requests share.
#[derive(Debug)]
pub(super) struct Connection {
    instance: Instance,
    link: Mutex<Arc<Link>>,
    first_id: u64,
    requests: AtomicU64,
}

impl Connection {
    pub(super) fn open(instance: &Instance) -> Result<Self, ClientError> {
        Ok(Self {
            instance: instance.clone(),
            link: Mutex::new(Arc::new(Link::open(instance)?)),
            first_id: unique_number(),
            requests: AtomicU64::new(0),
        })
    }

    /// An id that no other request has.
    pub(super) fn next_id(&self) -> u64 {
        self.first_id
            .wrapping_add(self.requests.fetch_add(1, Ordering::Relaxed))
    }

    /// The ports, opened anew where the services that they belong to were removed.
    pub(super) fn link(&self) -> Result<Arc<Link>, ClientError> {
        let mut link = self
            .link
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        if link.is_stale() {
            *link = Arc::new(self.open_again(&link)?);
        }
        Ok(link.clone())
    }

    fn open_again(&self, stale: &Link) -> Result<Link, ClientError> {
        Link::open(&self.instance).map_err(|error| match error {
            ClientError::DaemonLost {
                loss: Loss::NeverStarted,
                ..
            } => stale.lost(Loss::Removed),
            other => other,
        })
    }
}
