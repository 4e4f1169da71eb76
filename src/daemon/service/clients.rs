//! What each client has with the daemon: its requests, its quotas, and what it got.

use std::cmp::Reverse;
use std::collections::HashMap;

use taut_ipc::control::{ClientSummary, Refusal};
use taut_ipc::wire::{Code, ResponseHeader};

use super::client::Client;
use crate::daemon::config::Quota;
use crate::daemon::observe::metrics::Times;

/// A client that has nothing here is forgotten after this time.
const REMEMBERED_NS: u64 = 60_000_000_000;
/// Names of clients that are remembered, besides those of clients that have something here.
const MOST_NAMES: usize = 1024;
/// Computing time that a client may have had beyond its share.
const BURST_NS: i64 = 500_000_000;
/// When to try again after QUOTA, at least.
const RETRY_MS: u32 = 5;

/// Accounts of all clients.
pub(crate) struct Clients {
    quota: Quota,
    /// Computing time that there is for each second that passes (ns per ns).
    workers: f64,
    accounts: HashMap<u128, Account>,
    /// How clients call themselves; kept while they are away, too.
    names: HashMap<u128, String>,
}

/// One client's.
#[derive(Default)]
struct Account {
    pid: u32,
    in_flight: usize,
    bytes: usize,
    received: u64,
    served: u64,
    refused: u64,
    over_quota: u64,
    dropped: u64,
    computed_ns: u64,
    /// Computing time that it may still have (ns), where its share is limited; counted up as time
    /// passes.
    left_ns: i64,
    seen_ns: u64,
    latency: Times,
    newest: Rate,
}

/// Answers in the last whole second.
#[derive(Default)]
struct Rate {
    second: u64,
    count: u64,
    before: u64,
}

impl Rate {
    fn turn(&mut self, now_ns: u64) {
        let second = now_ns / 1_000_000_000;
        if second != self.second {
            self.before = if second == self.second + 1 {
                self.count
            } else {
                0
            };
            self.second = second;
            self.count = 0;
        }
    }

    fn count(&mut self, now_ns: u64) {
        self.turn(now_ns);
        self.count += 1;
    }

    fn per_second(&mut self, now_ns: u64) -> u64 {
        self.turn(now_ns);
        self.before
    }
}

impl Clients {
    /// Nobody yet.
    pub(crate) fn new(quota: Quota, workers: usize) -> Self {
        Self {
            quota,
            workers: workers as f64,
            accounts: HashMap::new(),
            names: HashMap::new(),
        }
    }

    /// A request came; it has this many bytes and is counted until [`Self::left`].
    ///
    /// # Errors
    /// QUOTA, with what is used up; the request is then not counted.
    pub(crate) fn enter(
        &mut self,
        client: Client,
        bytes: usize,
        now_ns: u64,
    ) -> Result<(), Refusal> {
        let quota = self.quota;
        let workers = self.workers;
        let account = self.account(client, now_ns);
        account.refill(quota.cpu_share * workers, now_ns);
        account.received += 1;
        let checked = account.check(&quota, workers, bytes);
        match &checked {
            Ok(()) => account.add(bytes),
            Err(_) => account.over_quota += 1,
        }
        checked
    }

    /// A request that was let in before and had [`Self::left`] is worked on again: it is counted,
    /// whatever the quota.
    pub(crate) fn enter_again(&mut self, client: Client, bytes: usize, now_ns: u64) {
        self.account(client, now_ns).add(bytes);
    }

    fn account(&mut self, client: Client, now_ns: u64) -> &mut Account {
        let accounts = self.accounts.entry(client.id);
        accounts.or_insert_with(|| Account::new(client.pid, now_ns))
    }

    /// A request that was let in has ended, however it ended.
    pub(crate) fn left(&mut self, client: u128, bytes: usize) {
        if let Some(account) = self.accounts.get_mut(&client) {
            account.in_flight -= 1;
            account.bytes -= bytes;
        }
    }

    /// A request of a client was refused at once.
    pub(crate) fn refused(&mut self, client: u128) {
        if let Some(account) = self.accounts.get_mut(&client) {
            account.refused += 1;
        }
    }

    /// A client got a final answer, `latency_ns` after its request came.
    pub(crate) fn answered(
        &mut self,
        client: u128,
        header: &ResponseHeader,
        latency_ns: u64,
        now_ns: u64,
    ) {
        if let Some(account) = self.accounts.get_mut(&client) {
            account.ended(header.code);
            account.latency.push(latency_ns);
            account.newest.count(now_ns);
        }
    }

    /// A client cancelled a request, or is gone.
    pub(crate) fn cancelled(&mut self, client: u128) {
        if let Some(account) = self.accounts.get_mut(&client) {
            account.dropped += 1;
        }
    }

    /// A job of a client was computed for this time.
    pub(crate) fn computed(&mut self, client: u128, computed_ns: u64) {
        if let Some(account) = self.accounts.get_mut(&client) {
            account.computed_ns += computed_ns;
            account.left_ns -= computed_ns as i64;
        }
    }

    /// Forgets those that have been away for long.
    pub(crate) fn forget(&mut self, now_ns: u64) {
        self.accounts
            .retain(|_, account| account.in_flight > 0 || now_ns < account.seen_ns + REMEMBERED_NS);
    }

    /// A client says how it is called.
    pub(crate) fn introduced(&mut self, client: u128, name: String) {
        if self.names.len() >= MOST_NAMES {
            let accounts = &self.accounts;
            self.names
                .retain(|client, _| accounts.contains_key(client));
        }
        self.names.insert(client, name);
    }

    /// How a client calls itself; empty = it does not.
    pub(crate) fn name(&self, client: u128) -> &str {
        self.names
            .get(&client)
            .map_or("", String::as_str)
    }

    /// What people are shown, those that had most first.
    pub(crate) fn summaries(&mut self, now_ns: u64) -> Vec<ClientSummary> {
        let mut summaries = self.summed_up(now_ns);
        summaries.sort_by_key(|client| (Reverse(client.computed_ns), client.pid));
        summaries
    }

    fn summed_up(&mut self, now_ns: u64) -> Vec<ClientSummary> {
        let quota = self.quota;
        let names = &self.names;
        let accounts = self.accounts.iter_mut();
        accounts
            .map(|(id, account)| ClientSummary {
                name: names.get(id).cloned().unwrap_or_default(),
                ..account.summary(*id, &quota, now_ns)
            })
            .collect()
    }
}

impl Account {
    fn new(pid: u32, now_ns: u64) -> Self {
        Self {
            pid,
            left_ns: BURST_NS,
            seen_ns: now_ns,
            ..Self::default()
        }
    }

    /// A request of so many bytes is in flight.
    fn add(&mut self, bytes: usize) {
        self.in_flight += 1;
        self.bytes += bytes;
    }

    /// A request ended with this code.
    fn ended(&mut self, code: i32) {
        if code == i32::from(Code::Success) {
            self.served += 1;
        } else {
            self.refused += 1;
        }
    }

    fn refill(&mut self, share: f64, now_ns: u64) {
        let passed_ns = now_ns.saturating_sub(self.seen_ns);
        self.seen_ns = now_ns;
        self.left_ns = self
            .left_ns
            .saturating_add((passed_ns as f64 * share) as i64)
            .min(BURST_NS);
    }

    fn check(&self, quota: &Quota, workers: f64, bytes: usize) -> Result<(), Refusal> {
        self.check_in_flight(quota.in_flight)?;
        self.check_bytes(bytes, quota.bytes)?;
        self.check_share(quota.cpu_share, workers)
    }

    fn check_in_flight(&self, most: usize) -> Result<(), Refusal> {
        let held = self.in_flight;
        if held < most {
            return Ok(());
        }
        let text = format!("{held} requests of this client are in flight, as many as it may have");
        Err(over_quota(text, RETRY_MS))
    }

    fn check_bytes(&self, bytes: usize, most: usize) -> Result<(), Refusal> {
        let held = self.bytes;
        if held + bytes <= most {
            return Ok(());
        }
        let text = format!(
            "this request of {bytes} bytes and {held} in flight are more than the {most} of a client"
        );
        Err(over_quota(text, RETRY_MS))
    }

    fn check_share(&self, share: f64, workers: f64) -> Result<(), Refusal> {
        if share >= 1.0 || self.left_ns >= 0 {
            return Ok(());
        }
        let wait_ms = -self.left_ns as f64 / (share * workers) / 1e6;
        let percent = share * 100.0;
        let text = format!("this client has had its {percent:.0} % of the workers' time");
        Err(over_quota(text, wait_ms.ceil() as u32))
    }

    fn summary(&mut self, client_id: u128, quota: &Quota, now_ns: u64) -> ClientSummary {
        let [latency_p50_ns, latency_p99_ns] = self.latency.percentiles();
        ClientSummary {
            client_id: format!("{client_id:032x}"),
            pid: self.pid,
            name: String::new(),
            in_flight: self.in_flight as u32,
            in_flight_quota: quota.in_flight as u32,
            bytes: self.bytes as u64,
            received: self.received,
            served: self.served,
            refused: self.refused,
            over_quota: self.over_quota,
            cancelled: self.dropped,
            answered_per_second: self.newest.per_second(now_ns),
            computed_ns: self.computed_ns,
            latency_p50_ns,
            latency_p99_ns,
        }
    }
}

fn over_quota(message: String, retry_after_ms: u32) -> Refusal {
    Refusal {
        code: Code::Quota.into(),
        message,
        retry_after_ms: retry_after_ms.max(RETRY_MS),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: u64 = 1_000_000_000;

    fn client(id: u128) -> Client {
        Client { id, pid: 7 }
    }

    #[test]
    fn each_quota_refuses_at_its_bound_and_lets_in_again() {
        let mut clients = Clients::new(
            Quota {
                in_flight: 2,
                bytes: 100,
                cpu_share: 1.0,
            },
            1,
        );
        let enter = |clients: &mut Clients, id, bytes| clients.enter(client(id), bytes, SECOND);
        assert_eq!(enter(&mut clients, 1, 60), Ok(()));
        let refusal = enter(&mut clients, 1, 60).unwrap_err();
        assert_eq!(refusal.code, i32::from(Code::Quota));
        assert!(
            refusal.message.contains("60 bytes") && refusal.retry_after_ms > 0,
            "{refusal:?}"
        );
        assert_eq!(enter(&mut clients, 1, 40), Ok(()));
        assert!(
            enter(&mut clients, 1, 0)
                .unwrap_err()
                .message
                .starts_with("2 requests")
        );
        assert_eq!(enter(&mut clients, 2, 60), Ok(()), "another client's");
        clients.left(1, 60);
        assert_eq!(enter(&mut clients, 1, 0), Ok(()));
        let summary = clients
            .summaries(SECOND)
            .into_iter()
            .find(|client| client.client_id.ends_with('1'))
            .unwrap();
        assert_eq!(
            (
                summary.received,
                summary.over_quota,
                summary.in_flight,
                summary.bytes
            ),
            (5, 2, 2, 40)
        );
    }

    #[test]
    fn a_share_of_the_workers_comes_back_with_time() {
        let mut clients = Clients::new(
            Quota {
                in_flight: 2,
                bytes: 100,
                cpu_share: 0.25,
            },
            2,
        );
        clients.enter(client(1), 0, SECOND).unwrap();
        clients.left(1, 0);
        clients.computed(1, SECOND);
        let refusal = clients.enter(client(1), 0, SECOND).unwrap_err();
        assert_eq!(
            refusal.retry_after_ms, 1000,
            "half a second of computing at half a worker: {refusal:?}"
        );
        assert_eq!(clients.enter(client(1), 0, 2 * SECOND), Ok(()));
    }

    #[test]
    fn who_is_away_is_forgotten_unless_something_runs() {
        let mut clients = Clients::new(
            Quota {
                in_flight: 2,
                bytes: 100,
                cpu_share: 1.0,
            },
            1,
        );
        clients.enter(client(1), 0, 0).unwrap();
        clients.enter(client(2), 0, 0).unwrap();
        clients.left(2, 0);
        clients.forget(REMEMBERED_NS);
        assert_eq!(clients.summaries(0).len(), 1);
    }
}
