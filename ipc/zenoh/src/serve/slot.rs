//! Where the port of a client is, or is to be.

use crate::live::locked;
use std::sync::{Arc, Mutex, MutexGuard};

/// Where the port of a client is, or is to be.
#[derive(Debug)]
pub(super) struct Slot<R> {
    /// Held by whoever opens the port: other messages of this client wait for it, nobody else does.
    opening: Mutex<()>,
    port: Mutex<Port<R>>,
}

#[derive(Debug)]
enum Port<R> {
    None,
    Open(Arc<R>),
    /// The client was let go.
    Closed,
}

impl<R> Default for Slot<R> {
    fn default() -> Self {
        Self {
            opening: Mutex::default(),
            port: Mutex::new(Port::None),
        }
    }
}

impl<R> Slot<R> {
    /// Keeps others from opening the port.
    pub(super) fn alone(&self) -> MutexGuard<'_, ()> {
        locked(&self.opening)
    }

    /// Whose port is open. One that is being opened has no requests yet, and nobody waits for it.
    pub(super) fn remote(&self) -> Option<Arc<R>> {
        match &*locked(&self.port) {
            Port::Open(remote) => Some(remote.clone()),
            Port::None | Port::Closed => None,
        }
    }

    /// The port is open; gives false where its client was let go meanwhile.
    pub(super) fn open(&self, remote: &Arc<R>) -> bool {
        let mut port = locked(&self.port);
        let is_wanted = !matches!(*port, Port::Closed);
        if is_wanted {
            *port = Port::Open(remote.clone());
        }
        is_wanted
    }

    /// Lets the client go: its port, also one that is just being opened, is nobody's.
    pub(super) fn close(&self) -> Option<Arc<R>> {
        match std::mem::replace(&mut *locked(&self.port), Port::Closed) {
            Port::Open(remote) => Some(remote),
            Port::None | Port::Closed => None,
        }
    }

    #[cfg(test)]
    pub(super) fn is_closed(&self) -> bool {
        matches!(*locked(&self.port), Port::Closed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_client_that_goes_while_its_port_is_being_opened_has_none() {
        let slot = Slot::default();
        let _alone = slot.alone();
        assert!(slot.remote().is_none() && slot.close().is_none());
        assert!(!slot.open(&Arc::new(7)) && slot.remote().is_none());
    }

    #[test]
    fn a_port_is_found_while_another_is_opened_in_its_place() {
        let slot = Slot::default();
        assert!(slot.open(&Arc::new(7)));
        let _alone = slot.alone();
        assert_eq!(slot.remote().as_deref(), Some(&7));
        assert!(slot.open(&Arc::new(8)));
        assert_eq!(slot.close().as_deref(), Some(&8));
    }
}
