//! A client elsewhere: a port of the daemon, its requests, and the thread that answers it.

use super::controls::Controls;
use super::counts::{Counts, count};
use super::later::{Later, Sender, begin};
use super::runs::{Known, Run, Runs};
use crate::live::locked;
use crate::message::{self, Payload, Refused, UNKNOWN};
use crate::names::Wish;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use taut_ipc::client::{Client, ClientError, Relay, Response};
use taut_ipc::wire::{Envelope, RequestHeader, ResponseHeader, Termination};
use taut_ipc::{Instance, deadline_after};
use zenoh::Wait;
use zenoh::bytes::ZBytes;
use zenoh::query::Query;

/// How long the client's thread sleeps at most: then it sees whether the client is gone.
const LOOK_UP: Duration = Duration::from_millis(500);

/// A client elsewhere.
#[derive(Debug)]
pub(super) struct Remote {
    pub(super) id: u64,
    pub(super) name: String,
    pub(super) client: Client,
    pub(super) control: Controls,
    relay: Relay,
    runs: Mutex<Runs>,
    /// One thread at a time takes answers, so that they stay in order.
    pump: Mutex<()>,
    is_gone: AtomicBool,
    pub(super) later: Sender,
    pub(super) counts: Arc<Counts>,
}

/// What people see of a client.
fn shown(id: u64, name: &str) -> String {
    match name {
        "" => format!("client {id:016x}"),
        name => name.to_owned(),
    }
}

impl Remote {
    /// Opens its port and starts its thread.
    pub(super) fn open(
        id: u64,
        name: &str,
        instance: &Instance,
        counts: &Arc<Counts>,
    ) -> Result<Arc<Self>, ClientError> {
        let client = Client::connect(instance)?;
        let relay = client.relay()?;
        // Without its threads nobody would answer it.
        let later = Sender::start().map_err(|_| ClientError::TooManyClients)?;
        let remote = Arc::new(Self {
            id,
            name: shown(id, name),
            client,
            control: Controls::default(),
            relay,
            runs: Mutex::default(),
            pump: Mutex::default(),
            is_gone: AtomicBool::new(false),
            later,
            counts: counts.clone(),
        });
        remote.introduce();
        let for_thread = remote.clone();
        begin("taut-remote", move || for_thread.answer())
            .map_err(|_| ClientError::TooManyClients)?;
        tracing::info!(client = %remote.name, "client {id:016x} came");
        Ok(remote)
    }

    /// Whether a thread answers it, and its port is of services that are there.
    pub(super) fn is_served(&self) -> bool {
        !self.is_gone() && !self.relay.is_stale()
    }

    pub(super) fn is_gone(&self) -> bool {
        self.is_gone.load(Ordering::Relaxed)
    }

    /// Whether it has no requests, and no control messages that wait.
    pub(super) fn is_idle(&self) -> bool {
        !self.control.are_waiting() && locked(&self.runs).is_idle()
    }

    /// Sends a request on, unless it is known.
    pub(super) fn request(
        &self,
        envelope: &Envelope,
        header: RequestHeader,
        payload: &Payload,
        query: Query,
    ) {
        let mut runs = locked(&self.runs);
        if !matches!(runs.find(header.request_id), Known::Nothing) {
            count(&self.counts.known);
            drop(runs);
            return self.again(header.request_id, query);
        }
        let sent = self.send(header, payload);
        match sent {
            Ok(pending) => {
                count(&self.counts.requests);
                if envelope.attempt > 0 {
                    count(&self.counts.begun_again);
                }
                runs.begin(header.request_id, pending, query);
            }
            Err(error) => {
                drop(runs);
                self.not_sent(header.request_id, query, &error);
            }
        }
    }

    fn send(
        &self,
        header: RequestHeader,
        payload: &Payload,
    ) -> Result<taut_ipc::client::Relayed, ClientError> {
        // What is left, on this machine's clock.
        let deadline_ns = match header.deadline_ns {
            0 => 0,
            left => deadline_after(Duration::from_nanos(left)),
        };
        let header = RequestHeader {
            deadline_ns,
            ..header
        };
        let fill = |place: &mut [u8]| payload.copy_to(place);
        self.relay.send(header, payload.len(), fill)
    }

    fn not_sent(&self, request: u64, query: Query, error: &ClientError) {
        // A daemon that ends takes nothing more while it still holds its lock.
        if error.is_passing() {
            self.is_stranger_again();
            // The client asks another gateway, or this one later.
            return self.later.send(Later::LetGo(query));
        }
        let code = error.code();
        let retry_after_ms = if code.is_retryable() { 20 } else { 0 };
        let message = error.to_string();
        self.refuse(
            request,
            query,
            &Refused {
                code,
                message,
                retry_after_ms,
            },
        );
    }

    fn refuse(&self, request: u64, query: Query, refused: &Refused) {
        count(&self.counts.refused);
        let (header, payload) = refused.response(request);
        let bytes = message::copied(&header, &payload);
        self.later.send(Later::Reply(query, bytes));
    }

    /// The answers to a request that came before.
    pub(super) fn again(&self, request: u64, query: Query) {
        let known = locked(&self.runs).find(request);
        let later = match known {
            Known::Runs(run) => {
                let old = std::mem::replace(&mut *locked(&run.query), query);
                Later::LetGo(old)
            }
            Known::Ended(answer) => Later::Reply(query, answer),
            Known::Nothing => Later::Fail(query, UNKNOWN.into()),
        };
        self.later.send(later);
    }

    pub(super) fn wish(&self, wish: Wish, request: u64) {
        let mut runs = locked(&self.runs);
        match (wish, runs.find(request)) {
            (Wish::Cancel, _) => {
                let run = runs.remove(request);
                drop(runs);
                run.into_iter()
                    .for_each(|run| self.let_go(&run));
            }
            (Wish::Finish, Known::Runs(run)) => {
                if let Some(pending) = &*locked(&run.pending) {
                    pending.finish_early();
                }
            }
            (Wish::Finish, _) => {}
        }
    }

    /// The daemon stops at once; the query is let go where that may wait.
    fn let_go(&self, run: &Run) {
        count(&self.counts.cancelled);
        drop(locked(&run.pending).take());
        let query = locked(&run.query).clone();
        self.later.send(Later::LetGo(query));
    }

    /// The client is gone: so are its requests, and soon its port.
    pub(super) fn leave(&self) {
        self.is_gone.store(true, Ordering::Relaxed);
        let active = locked(&self.runs).active();
        for run in active {
            locked(&self.runs).remove(run.request);
            self.let_go(&run);
        }
        tracing::info!(client = %self.name, "client {:016x} left", self.id);
    }

    pub(super) fn forget(&self, now: Instant) {
        locked(&self.runs).forget(now);
    }

    /// On the client's thread: whoever waits for a client that does not read is this thread alone.
    fn answer(&self) {
        while !self.is_gone() {
            if let Err(error) = self.relay.wait(LOOK_UP) {
                tracing::error!(client = %self.name, "{error}");
                return self.leave();
            }
            self.pump();
            self.introduce();
        }
    }

    /// Takes what the daemon answered, unless somebody does so already.
    pub(super) fn pump(&self) {
        let Ok(_alone) = self.pump.try_lock() else {
            return;
        };
        let active = locked(&self.runs).active();
        for run in active {
            while self.pass_on(&run) {}
        }
    }

    /// Passes one answer on; whether there was one.
    fn pass_on(&self, run: &Run) -> bool {
        let next = match &mut *locked(&run.pending) {
            Some(pending) => pending.try_next(),
            None => return false,
        };
        match next {
            Ok(Some(response)) => self.reply(run, response),
            Ok(None) => false,
            Err(error) => self.failed(run, &error),
        }
    }

    fn reply(&self, run: &Run, response: Response) -> bool {
        let header = *response.header();
        let is_final = response.is_final();
        let bytes = message::copied(&header, response.payload());
        // Its memory goes back before anybody waits.
        drop(response);
        if is_final && !self.end(run, &header, &bytes) {
            return false;
        }
        let query = locked(&run.query).clone();
        let sent = query
            .reply(query.key_expr().clone(), bytes)
            .express(true)
            .wait();
        if let Err(error) = sent {
            tracing::debug!(client = %self.name, "an answer was not sent: {error}");
        }
        !is_final
    }

    /// A request has ended; gives false where it was cancelled meanwhile. A refusal is not kept: what
    /// was lacking may be there when the request comes again.
    fn end(&self, run: &Run, header: &ResponseHeader, answer: &ZBytes) -> bool {
        count(&self.counts.finished);
        let mut runs = locked(&self.runs);
        match header.termination == u32::from(Termination::Refused) {
            true => runs.remove(run.request).is_some(),
            false => runs.end(run.request, answer.clone(), Instant::now()),
        }
    }

    fn failed(&self, run: &Run, error: &ClientError) -> bool {
        locked(&self.runs).remove(run.request);
        drop(locked(&run.pending).take());
        let query = locked(&run.query).clone();
        self.not_sent(run.request, query, error);
        false
    }
}
