//! The connection of a client process, which can be made anew.

use std::sync::{Mutex, PoisonError};

use taut_ipc::{Client, ClientError, Instance};

/// A connection to the daemon of the environment's instance, shared by all that ask through it.
pub(super) struct Connection(Mutex<Client>);

impl Connection {
    /// Connects.
    pub(super) fn open(instance: &Instance) -> Result<Self, ClientError> {
        Ok(Self(Mutex::new(Client::connect(instance)?)))
    }

    /// The client to send with now.
    pub(super) fn client(&self) -> Client {
        self.lock().clone()
    }

    /// Connects anew where that can be done now, and only then gives the old ports back, as a
    /// planner does that puts a new client where the old one was.
    pub(super) fn renew(&self) {
        let client = Instance::from_environment()
            .map_err(ClientError::from)
            .and_then(|instance| Client::connect(&instance));
        if let Ok(client) = client {
            *self.lock() = client;
        }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Client> {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}
