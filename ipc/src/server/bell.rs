//! Waking: the daemon wakes one client, anybody in the daemon wakes who waits at the port.

use crate::transport::{self, ServiceNode, Variant};
use iceoryx2::port::notifier::{ListenerKey, Notifier};
use iceoryx2::prelude::CallbackProgression;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Ends the wait at the port from any thread. Cheap to clone; a wake is one system call.
#[derive(Clone, Debug)]
pub struct Waker {
    notifier: Arc<Notifier<Variant>>,
}

impl Waker {
    pub(super) fn new(node: &ServiceNode) -> Result<Self, String> {
        let builder = transport::wake_server_settings(transport::wake_server(node));
        let service = builder
            .open_or_create()
            .map_err(|error| error.to_string())?;
        let notifier = service
            .notifier_builder()
            .create()
            .map_err(|error| error.to_string())?;
        Ok(Self {
            notifier: Arc::new(notifier),
        })
    }

    /// Ends the current or the next wait.
    pub fn wake(&self) {
        // Fails only if the listener is gone or its buffer is full: then nobody sleeps.
        let _ = self.notifier.notify();
    }
}

/// Wakes exactly the client that a request names.
#[derive(Debug)]
pub(super) struct ClientBell {
    notifier: Notifier<Variant>,
    keys: Mutex<HashMap<u128, ListenerKey>>,
}

impl ClientBell {
    pub(super) fn new(node: &ServiceNode) -> Result<Self, String> {
        let builder = transport::wake_client_settings(transport::wake_client(node));
        let service = builder
            .open_or_create()
            .map_err(|error| error.to_string())?;
        let notifier = service
            .notifier_builder()
            .create()
            .map_err(|error| error.to_string())?;
        Ok(Self {
            notifier,
            keys: Mutex::default(),
        })
    }

    /// Wakes the listener with this id; a listener that is gone needs no waking.
    pub(super) fn ring(&self, listener_id: [u64; 2]) {
        let id = u128::from(listener_id[0]) | u128::from(listener_id[1]) << 64;
        let mut keys = self
            .keys
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        if let Some(key) = keys.get(&id)
            && self
                .notifier
                .notify_single_listener(key)
                .is_ok()
        {
            return;
        }
        self.look_up_all(&mut keys);
        if let Some(key) = keys.get(&id) {
            let _ = self.notifier.notify_single_listener(key);
        }
    }

    fn look_up_all(&self, keys: &mut HashMap<u128, ListenerKey>) {
        keys.clear();
        self.notifier.for_each_listener(|one, details| {
            keys.insert(details.listener_id.value(), one.listener_key());
            CallbackProgression::Continue
        });
    }
}
