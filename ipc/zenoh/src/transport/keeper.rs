//! The requests of a program: what their planners get and want, and the thread that keeps them going.
//!
//! A request is sent by the thread that asks, and its answers go to its planner on the thread that
//! they come on. The keeper's thread does what is due later.

use crate::call::Nanos;
use crate::caller::{Running, Sink};
use crate::live::locked;
use crate::message::Payload;
use std::collections::HashMap;
use std::sync::{Arc, Mutex};
use std::thread::Thread;
use std::time::Duration;
use taut_ipc::monotonic_ns;
use taut_ipc::planner::carrier::{Answered, Inbox};
use taut_ipc::wire::{ResponseHeader, Status, WireError};

/// Gets the answers to a request.
pub(super) struct Planner {
    /// Gone after the final answer.
    inbox: Option<Inbox>,
    /// Whether it was seen that the best so far is wanted.
    is_hinted: bool,
    requests: Arc<Requests>,
}

/// What a planner wants of its request.
enum Wants {
    Answers,
    TheBest,
    Nothing,
}

impl Planner {
    pub(super) fn new(inbox: Inbox, requests: &Arc<Requests>) -> Self {
        Self {
            inbox: Some(inbox),
            is_hinted: false,
            requests: requests.clone(),
        }
    }

    fn wants(&mut self) -> Wants {
        let asked = self
            .inbox
            .as_ref()
            .and_then(|inbox| inbox.ending().asked());
        match asked {
            Some(false) => Wants::Nothing,
            Some(true) if !std::mem::replace(&mut self.is_hinted, true) => Wants::TheBest,
            _ => Wants::Answers,
        }
    }
}

impl Sink for Planner {
    fn deliver(&mut self, header: &ResponseHeader, payload: &Payload) -> Result<(), WireError> {
        let Some(inbox) = &self.inbox else {
            return Ok(());
        };
        inbox.put(Answered {
            header: *header,
            words: payload.to_words(),
        })?;
        if header.status == u32::from(Status::Final) {
            self.inbox = None;
            self.requests.forget(header.request_id);
        }
        Ok(())
    }
}

/// Requests by their ids.
#[derive(Default)]
pub(super) struct Requests(Mutex<Kept>);

struct Kept {
    calls: HashMap<u64, Arc<Running<Planner>>>,
    /// Until when the keeper's thread sleeps.
    until: Nanos,
    is_over: bool,
}

impl Default for Kept {
    fn default() -> Self {
        Self {
            calls: HashMap::new(),
            until: Nanos::MAX,
            is_over: false,
        }
    }
}

impl Requests {
    fn forget(&self, request: u64) {
        let call = locked(&self.0).calls.remove(&request);
        drop(call);
    }

    /// Keeps them going until nobody asks any more.
    fn run(&self) {
        while !self.are_over() {
            self.drive();
            let until = locked(&self.0).until;
            let left = until.saturating_sub(monotonic_ns());
            std::thread::park_timeout(Duration::from_nanos(left));
        }
    }

    fn are_over(&self) -> bool {
        let kept = locked(&self.0);
        kept.is_over && kept.calls.is_empty()
    }

    /// Does what is due, without the lock: sending may have to wait for a link.
    fn drive(&self) {
        for (request, call) in self.begun() {
            match call.with_sink(Planner::wants) {
                Wants::Answers => {}
                Wants::TheBest => call.finish_early(),
                Wants::Nothing => call.cancel(),
            }
            match call.drive() {
                Some(due) => _ = self.is_earlier(due),
                None => self.forget(request),
            }
        }
    }

    /// Those to look at; what is due is found out anew.
    fn begun(&self) -> Vec<(u64, Arc<Running<Planner>>)> {
        let mut kept = locked(&self.0);
        kept.until = Nanos::MAX;
        let calls = kept.calls.iter();
        calls
            .map(|(request, call)| (*request, call.clone()))
            .collect()
    }

    /// Has the thread sleep no longer than this; gives whether it would.
    fn is_earlier(&self, due: Nanos) -> bool {
        let mut kept = locked(&self.0);
        let is_earlier = due < kept.until;
        kept.until = kept.until.min(due);
        is_earlier
    }
}

/// The thread, which goes on until what was asked is answered.
pub(super) struct Keeper {
    requests: Arc<Requests>,
    thread: Thread,
}

impl std::fmt::Debug for Keeper {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let requests = locked(&self.requests.0).calls.len();
        f.debug_struct("Keeper")
            .field("requests", &requests)
            .finish_non_exhaustive()
    }
}

impl Keeper {
    pub(super) fn start() -> std::io::Result<Self> {
        let requests = Arc::new(Requests::default());
        let for_thread = requests.clone();
        let started = std::thread::Builder::new()
            .name("taut-requests".into())
            .spawn(move || for_thread.run())?;
        let thread = started.thread().clone();
        Ok(Self { requests, thread })
    }

    pub(super) fn thread(&self) -> &Thread {
        &self.thread
    }

    pub(super) fn requests(&self) -> &Arc<Requests> {
        &self.requests
    }

    /// Sends a request, and wakes the thread only where it would sleep too long for it.
    pub(super) fn begin(&self, request: u64, call: Arc<Running<Planner>>) {
        locked(&self.requests.0)
            .calls
            .insert(request, call.clone());
        match call.drive() {
            Some(due) if self.requests.is_earlier(due) => self.thread.unpark(),
            Some(_) => {}
            None => self.requests.forget(request),
        }
    }
}

impl Drop for Keeper {
    fn drop(&mut self) {
        locked(&self.requests.0).is_over = true;
        self.thread.unpark();
    }
}
