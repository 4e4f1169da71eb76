//! Daemons of other machines for a program that wants no helper beside it.

use crate::caller::{Caller, Client, Running, Sink};
use crate::live::locked;
use crate::message::Payload;
use crate::network::{Network, NetworkError};
use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex};
use std::thread::{Thread, ThreadId};
use std::time::Duration;
use taut_ipc::control::{ControlReply, ControlRequest};
use taut_ipc::monotonic_ns;
use taut_ipc::planner::{Ending, Service, Tell};
use taut_ipc::wire::{RequestView, ResponseBody, ResponseHeader, ResponseView, Status, WireError};
use zenoh::bytes::ZBytes;

/// Daemons through Zenoh, for [`taut_ipc::planner::Planner::in_process`].
///
/// ```no_run
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use taut_ipc::planner::Planner;
/// use taut_zenoh::{Network, Zenoh};
/// let planner = Planner::in_process(Zenoh::connect(&Network::to(&["tcp/cell-7:7447"]))?);
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Zenoh {
    caller: Arc<Caller>,
    client: Arc<Client>,
    sleepers: Arc<Sleepers>,
}

impl Zenoh {
    /// Connects, as a client that is called as this process is.
    ///
    /// # Errors
    /// [`NetworkError`]. Gateways that are not there yet are no error: requests wait a second for
    /// them.
    pub fn connect(network: &Network) -> Result<Self, NetworkError> {
        Self::to(network, &[])
    }

    /// The same, to these daemons alone, the best first.
    ///
    /// # Errors
    /// [`NetworkError`].
    pub fn to(network: &Network, daemons: &[String]) -> Result<Self, NetworkError> {
        let caller = Caller::open(network, daemons)?;
        let sleepers = Arc::new(Sleepers::default());
        let for_live = sleepers.clone();
        caller.live.wakes(move || for_live.wake());
        let client = Arc::new(caller.client(own_name())?);
        Ok(Self {
            caller,
            client,
            sleepers,
        })
    }

    /// Requests sent more than once, and final answers that came after the first and were dropped.
    pub fn counts(&self) -> (u64, u64) {
        self.caller.counts()
    }
}

/// `host/program[pid]`.
fn own_name() -> String {
    let read = |file| std::fs::read_to_string(file).unwrap_or_default();
    let host = read("/proc/sys/kernel/hostname");
    let program = read("/proc/self/comm");
    let pid = std::process::id();
    format!("{}/{}[{pid}]", host.trim_end(), program.trim_end())
}

impl Service for Zenoh {
    fn control(&self, message: ControlRequest) -> ControlReply {
        self.caller.control(&self.client, &message)
    }

    fn answer(&self, request: &RequestView<'_>, ending: &Ending, tell: &Tell<'_>) {
        let _asleep = self.sleepers.enter();
        ending.wakes_me();
        let thread = std::thread::current();
        let answers = Arc::new(Answers {
            waiting: Mutex::default(),
            thread: thread.clone(),
        });
        let payload = ZBytes::from(request.payload);
        let sink = Queue(answers.clone());
        let wake = move || thread.unpark();
        let call = self
            .caller
            .call(&self.client, request.header, payload, sink, wake);
        follow(&call, &answers, ending, tell);
    }
}

/// Drives a request until it ends, and tells of its answers.
fn follow(call: &Arc<Running<Queue>>, answers: &Answers, ending: &Ending, tell: &Tell<'_>) {
    let mut is_hinted = false;
    loop {
        match ending.asked() {
            Some(false) => return call.cancel(),
            Some(true) if !is_hinted => {
                is_hinted = true;
                call.finish_early();
            }
            _ => {}
        }
        let due = call.drive();
        while let Some(answer) = answers.next() {
            if answer.tell(tell) {
                return;
            }
        }
        let Some(due) = due else {
            return;
        };
        let left = due.saturating_sub(monotonic_ns());
        std::thread::park_timeout(Duration::from_nanos(left));
    }
}

/// An answer, aligned as the wire asks for.
struct Told {
    header: ResponseHeader,
    words: Vec<u64>,
    bytes: usize,
}

impl Told {
    fn view(&self) -> Result<ResponseView<'_>, WireError> {
        let payload: &[u8] = bytemuck::cast_slice(&self.words);
        ResponseView::parse(self.header, &payload[..self.bytes])
    }

    /// Tells of it; whether it is the last.
    fn tell(&self, tell: &Tell<'_>) -> bool {
        // It was checked when it came.
        let Ok(view) = self.view() else {
            return false;
        };
        let body = ResponseBody {
            path: view.path,
            certificate: view.certificate,
            lowered_floors: view.lowered_floors,
            holds: view.holds,
            stages: view.stages,
            pinched: view.pinched,
            refusal: view.refusal,
            certificate_head: view.certificate_head,
            reach: view.reach,
            turned_columns: view.turned_columns,
            warnings: view.warnings,
            names: view.names,
            message: view.message,
        };
        tell(&self.header, &body);
        view.status == Status::Final
    }
}

/// Answers that came and were not told yet.
struct Answers {
    waiting: Mutex<VecDeque<Told>>,
    thread: Thread,
}

impl Answers {
    fn next(&self) -> Option<Told> {
        locked(&self.waiting).pop_front()
    }
}

struct Queue(Arc<Answers>);

impl Sink for Queue {
    fn deliver(&mut self, header: &ResponseHeader, payload: &Payload) -> Result<(), WireError> {
        let told = Told {
            header: *header,
            words: payload.to_words(),
            bytes: payload.len(),
        };
        told.view()?;
        locked(&self.0.waiting).push_back(told);
        self.0.thread.unpark();
        Ok(())
    }
}

/// Threads that answer requests: a gateway that comes or goes concerns all of them.
#[derive(Debug, Default)]
struct Sleepers(Mutex<HashMap<ThreadId, Thread>>);

impl Sleepers {
    fn enter(&self) -> Asleep<'_> {
        let thread = std::thread::current();
        locked(&self.0).insert(thread.id(), thread);
        Asleep(self)
    }

    fn wake(&self) {
        for thread in locked(&self.0).values() {
            thread.unpark();
        }
    }
}

struct Asleep<'a>(&'a Sleepers);

impl Drop for Asleep<'_> {
    fn drop(&mut self) {
        locked(&self.0.0).remove(&std::thread::current().id());
    }
}
