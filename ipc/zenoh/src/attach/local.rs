//! Planners of this machine: each is a client elsewhere.

use crate::caller::{Caller, Client};
use crate::live::locked;
use crate::network::NetworkError;
use std::collections::HashMap;
use std::sync::{Arc, Mutex};
use taut_ipc::server::{Peer, Server};

/// The planners, by connection.
pub(super) struct Locals {
    caller: Arc<Caller>,
    server: Arc<Server>,
    clients: Mutex<HashMap<u128, Local>>,
}

struct Local {
    client: Arc<Client>,
    /// A port of its, by which it is seen to be there.
    port: u128,
}

impl Locals {
    pub(super) fn new(caller: Arc<Caller>, server: Arc<Server>) -> Self {
        Self {
            caller,
            server,
            clients: Mutex::default(),
        }
    }

    /// Who sent something through this port.
    pub(super) fn client(&self, port: u128) -> Result<Arc<Client>, NetworkError> {
        // One that has gone already is a client for as long as its message takes.
        let peer = self.server.peer(port);
        let connection = peer.map_or(port, |peer| peer.connection);
        let mut clients = locked(&self.clients);
        if let Some(local) = clients.get(&connection) {
            return Ok(local.client.clone());
        }
        let client = Arc::new(self.caller.client(name(peer))?);
        let local = Local {
            client: client.clone(),
            port,
        };
        clients.insert(connection, local);
        Ok(client)
    }

    /// Lets those go that are not connected any more: with their tokens go what they had elsewhere.
    pub(super) fn forget_gone(&self) {
        locked(&self.clients).retain(|_, local| self.server.peer(local.port).is_some());
    }
}

/// `host/program[pid]`.
fn name(peer: Option<Peer>) -> String {
    let host = host();
    let Some(Peer { pid, .. }) = peer.filter(|peer| peer.pid > 0) else {
        return host;
    };
    let program = std::fs::read_to_string(format!("/proc/{pid}/comm")).unwrap_or_default();
    let program: String = program
        .trim_end()
        .chars()
        .filter(|c| !c.is_control())
        .collect();
    format!("{host}/{program}[{pid}]")
}

/// This machine's name.
pub fn host() -> String {
    let name = rustix::system::uname();
    let name = name.nodename().to_string_lossy();
    let known = name.chars().filter(|c| !c.is_control());
    known.collect()
}
