//! Who is there.

use super::remote::Remote;
use super::slot::Slot;
use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};
use taut_ipc::client::ClientError;

/// Clients of one gateway at most: the daemon has room for 128 of all kinds.
const MOST_CLIENTS: usize = 100;
/// Of them, clients that have no token: whoever sends under ever new numbers.
const MOST_UNANNOUNCED: usize = 32;
/// Tokens remembered at most, so that nobody fills the memory with them.
const MOST_TOKENS: usize = 4096;
/// A token that is gone comes again where a router was restarted.
const GRACE: Duration = Duration::from_millis(150);
/// How long a client may be idle that has never had a token.
const UNANNOUNCED: Duration = Duration::from_secs(10);

/// How long a request may take from its client's being found to its being known to run.
const ARRIVAL: Duration = Duration::from_secs(1);

/// The clients of a gateway.
#[derive(Debug, Default)]
pub(super) struct Clients {
    entries: HashMap<u64, Entry>,
    /// When each went; `None` = it is there.
    tokens: HashMap<u64, Option<Instant>>,
}

#[derive(Debug)]
struct Entry {
    slot: Arc<Slot<Remote>>,
    /// When it was last asked for.
    used: Instant,
}

impl Clients {
    /// The client of this number, if it is known.
    pub(super) fn find(&self, id: u64) -> Option<Arc<Remote>> {
        let entry = self.entries.get(&id)?;
        entry.slot.remote()
    }

    /// Where a client's port is, or is to be.
    pub(super) fn slot(&mut self, id: u64, now: Instant) -> Result<Arc<Slot<Remote>>, ClientError> {
        if let Some(entry) = self.entries.get_mut(&id) {
            entry.used = now;
            return Ok(entry.slot.clone());
        }
        if self.is_full(id) {
            return Err(ClientError::TooManyClients);
        }
        let slot = Arc::<Slot<Remote>>::default();
        let entry = Entry {
            slot: slot.clone(),
            used: now,
        };
        self.entries.insert(id, entry);
        Ok(slot)
    }

    /// Whether a client that is not known has no room.
    fn is_full(&self, id: u64) -> bool {
        let is_unannounced = |id: &u64| !self.tokens.contains_key(id);
        let has_no_place = || {
            let others = self.entries.keys();
            others.filter(|id| is_unannounced(id)).count() >= MOST_UNANNOUNCED
        };
        self.entries.len() >= MOST_CLIENTS || (is_unannounced(&id) && has_no_place())
    }

    /// Takes out those that are idle and have no token, where this one comes and has no room: they
    /// keep nobody out.
    pub(super) fn make_room(&mut self, id: u64, now: Instant) -> Vec<Arc<Remote>> {
        if self.entries.contains_key(&id) || !self.is_full(id) {
            return Vec::new();
        }
        let tokens = &self.tokens;
        let unannounced = self
            .entries
            .extract_if(|id, entry| !tokens.contains_key(id) && entry.is_left(now));
        unannounced
            .filter_map(|(_, entry)| entry.slot.close())
            .collect()
    }

    pub(super) fn changed(&mut self, id: u64, is_there: bool, now: Instant) {
        if self.tokens.len() < MOST_TOKENS || self.tokens.contains_key(&id) {
            let gone = (!is_there).then_some(now);
            self.tokens.insert(id, gone);
        }
    }

    pub(super) fn all(&self) -> Vec<Arc<Remote>> {
        self.entries
            .values()
            .filter_map(|entry| entry.slot.remote())
            .collect()
    }

    /// Takes out those that are gone for good.
    pub(super) fn gone(&mut self, now: Instant) -> Vec<Arc<Remote>> {
        let tokens = &self.tokens;
        let gone = self
            .entries
            .extract_if(|id, entry| entry.is_gone(tokens.get(id).copied(), now));
        let remotes = gone
            .filter_map(|(_, entry)| entry.slot.close())
            .collect();
        self.tokens
            .retain(|_, gone| gone.is_none_or(|since| now < since + GRACE));
        remotes
    }
}

impl Entry {
    fn is_gone(&self, token: Option<Option<Instant>>, now: Instant) -> bool {
        match token {
            Some(None) => false,
            Some(Some(since)) => now >= since + GRACE,
            None => now >= self.used + UNANNOUNCED && self.is_idle(),
        }
    }

    /// Idle for so long that no request is just coming.
    fn is_left(&self, now: Instant) -> bool {
        now >= self.used + ARRIVAL && self.is_idle()
    }

    fn is_idle(&self) -> bool {
        let remote = self.slot.remote();
        remote.is_none_or(|remote| remote.is_idle())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_client_whose_token_comes_again_stays() {
        let mut clients = Clients::default();
        let now = Instant::now();
        clients.slot(7, now).unwrap();
        clients.changed(7, true, now);
        clients.changed(7, false, now);
        clients.gone(now + GRACE / 2);
        assert_eq!(clients.entries.len(), 1);
        clients.changed(7, true, now + GRACE / 2);
        clients.gone(now + 2 * GRACE);
        assert_eq!(clients.entries.len(), 1);
        clients.changed(7, false, now + 2 * GRACE);
        clients.gone(now + 3 * GRACE);
        assert!(clients.entries.is_empty() && clients.tokens.is_empty());
    }

    /// So many announced clients, then so many others.
    fn filled(announced: u64, others: u64, now: Instant) -> Clients {
        let mut clients = Clients::default();
        for id in 0..announced {
            clients.changed(id, true, now);
        }
        for id in 0..announced + others {
            clients.slot(id, now).unwrap();
        }
        clients
    }

    #[test]
    fn there_is_room_for_so_many_clients_and_tokens() {
        let now = Instant::now();
        let mut clients = filled(MOST_CLIENTS as u64, 0, now);
        assert!(clients.slot(1000, now).is_err() && clients.slot(1, now).is_ok());
        for id in 0..2 * MOST_TOKENS as u64 {
            clients.changed(id, true, now);
        }
        assert_eq!(clients.tokens.len(), MOST_TOKENS);
    }

    #[test]
    fn clients_without_a_token_have_few_places() {
        let now = Instant::now();
        let mut clients = filled(1, MOST_UNANNOUNCED as u64, now);
        assert!(clients.slot(1000, now).is_err());
        clients.changed(1000, true, now);
        assert!(clients.slot(1000, now).is_ok());
    }

    #[test]
    fn clients_without_a_token_keep_nobody_out() {
        let now = Instant::now();
        let others = MOST_UNANNOUNCED as u64;
        let mut clients = filled(MOST_CLIENTS as u64 - others, others, now);
        clients.changed(1000, true, now);
        clients.make_room(1000, now);
        assert_eq!(clients.entries.len(), MOST_CLIENTS);
        let used = MOST_CLIENTS as u64 - 1;
        clients.slot(used, now + ARRIVAL).unwrap();
        clients.make_room(1000, now + ARRIVAL);
        assert_eq!(clients.entries.len(), MOST_CLIENTS - MOST_UNANNOUNCED + 1);
        assert!(clients.slot(1000, now).is_ok() && clients.slot(used, now).is_ok());
    }

    #[test]
    fn a_port_that_is_being_opened_for_a_client_that_goes_is_closed() {
        let mut clients = Clients::default();
        let now = Instant::now();
        let slot = clients.slot(7, now).unwrap();
        clients.changed(7, true, now);
        clients.changed(7, false, now);
        clients.gone(now + GRACE);
        assert!(slot.is_closed());
        // What comes still is of a client that nobody knows.
        assert!(!Arc::ptr_eq(&slot, &clients.slot(7, now).unwrap()));
    }

    #[test]
    fn a_client_without_a_token_goes_when_it_is_idle() {
        let mut clients = Clients::default();
        let now = Instant::now();
        clients.slot(7, now).unwrap();
        clients.gone(now);
        assert_eq!(clients.entries.len(), 1);
        clients.gone(now + UNANNOUNCED);
        assert!(clients.entries.is_empty());
    }
}
