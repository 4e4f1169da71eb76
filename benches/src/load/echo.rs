//! The bare echo that the daemon is measured against: iceoryx2 with the service's own settings, a
//! process that sends back as many bytes as it is asked for, and clients of it.
//!
//! All wait for events, none polls, and an answer wakes no other client than its own, as with the
//! daemon. The echo takes requests as the port has them, which is the fastest. Bare, it computes
//! nothing; it can also keep its core busy for as long as the daemon computes.

use std::collections::HashMap;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, Stdio};
use std::time::Duration;

use iceoryx2::active_request::ActiveRequest;
use iceoryx2::node::Node;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::{ListenerKey, Notifier};
use iceoryx2::port::server;
use iceoryx2::prelude::{AllocationStrategy, BackpressureStrategy, CallbackProgression};
use taut_ipc::limits::{
    ACTIVE_REQUESTS_PER_CLIENT, BORROWED_RESPONSES, LISTENERS_PER_CLIENT, MAX_CLIENTS, MAX_NODES,
    MAX_PAYLOAD, RESPONSE_BUFFER,
};
use taut_ipc::own_daemon::{Folder, spawn};
use taut_ipc::wire::{RequestHeader, ResponseHeader, Status};
use taut_ipc::{Instance, monotonic_ns, services};

use super::bare::{Bare, OF_ECHO, Variant, node, requests, text, wake};
use super::orders::{Exchange, Window};
use super::process::{end_with_parent, sleep_until};
use super::rounds::Round;
use super::tally::Tally;
use crate::error::Error;
use crate::program;

type ServerPort = server::Server<Variant, [u8], RequestHeader, [u8], ResponseHeader>;
type Active = ActiveRequest<Variant, [u8], RequestHeader, [u8], ResponseHeader>;

const NAME: &str = "echo";
const PATIENCE: Duration = Duration::from_secs(20);

/// The process that answers, until this is dropped.
pub(super) struct Echo {
    child: Child,
    instance: Instance,
    // Last: the instance lies there.
    _folder: Folder,
}

impl Echo {
    /// Starts it in a folder of its own.
    pub(super) fn start() -> Result<Self, Error> {
        let folder = Folder::create(NAME)?;
        let instance = Instance::new(NAME, folder.path().join("run"))?;
        let mut command = program::again(&instance)?;
        command
            .arg("load-echo")
            .stdin(Stdio::null())
            .stdout(Stdio::piped());
        let mut echo = Self {
            child: spawn(command)?,
            instance,
            _folder: folder,
        };
        echo.wait_until_up()?;
        Ok(echo)
    }

    /// Where it answers.
    pub(super) fn instance(&self) -> &Instance {
        &self.instance
    }

    /// It says a line then.
    fn wait_until_up(&mut self) -> Result<(), Error> {
        let Some(out) = self.child.stdout.take() else {
            return Ok(());
        };
        let read = BufReader::new(out).read_line(&mut String::new());
        read.map(|_| ())
            .map_err(|source| Error::System {
                what: "echo process",
                source,
            })
    }
}

impl Drop for Echo {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        for file in taut_ipc::memory::shared_files(&self.instance) {
            let _ = std::fs::remove_file(file.path);
        }
    }
}

/// A client of the echo, without the client library.
pub(super) struct Caller(Bare);

impl Caller {
    /// Connects.
    pub(super) fn open(instance: &Instance) -> Result<Self, Error> {
        Bare::open(instance).map(Self)
    }

    /// One round trip after the other until the window is over.
    pub(super) fn run(&self, window: &Window) -> Result<Tally, Error> {
        let request = vec![1; window.exchange.there];
        let mut tally = Tally::default();
        sleep_until(window.start_ns);
        while monotonic_ns() < window.end_ns {
            tally
                .rounds
                .push(self.round(&request, window.exchange)?);
        }
        Ok(tally)
    }

    fn round(&self, request: &[u8], exchange: Exchange) -> Result<Round, Error> {
        let header = RequestHeader {
            work_budget: exchange.back as u64,
            seed: exchange.compute_ns,
            ..RequestHeader::default()
        };
        let sent_ns = monotonic_ns();
        match self.0.exchange(header, request, PATIENCE)? {
            Some((_, bytes)) if bytes == exchange.back => Ok(Round {
                sent_ns,
                ended_ns: monotonic_ns(),
                compute_ns: exchange.compute_ns,
            }),
            _ => Err(text("the echo does not answer as it was asked to")),
        }
    }
}

/// `taut-bench load-echo`, hidden: answers until its parent is gone.
pub(crate) fn serve() -> Result<u8, Error> {
    end_with_parent()?;
    let node = node(&Instance::from_environment()?)?;
    let port = server_port(&node)?;
    let listener = listener(&node)?;
    let mut bell = Bell::new(&node)?;
    // A parent that is gone does not read.
    let _ = writeln!(std::io::stdout(), "ready");
    loop {
        listener
            .timed_wait(|_| (), PATIENCE)
            .map_err(text)?;
        while let Some(request) = port.receive().map_err(text)? {
            send_back(&request)?;
            bell.ring(request.user_header().listener_id)?;
        }
    }
}

/// As many bytes as the header's work budget says.
fn send_back(request: &Active) -> Result<(), Error> {
    let bytes = request.user_header().work_budget as usize;
    let mut copy = request.payload().to_vec();
    copy.resize(bytes, 0);
    compute(request.user_header().seed);
    let mut response = request.loan_slice_uninit(bytes).map_err(text)?;
    response.user_header_mut().status = Status::Final.into();
    response
        .write_from_slice(&copy)
        .send()
        .map_err(text)
}

/// Keeps its core as busy as a worker of the daemon does.
fn compute(time_ns: u64) {
    let end_ns = monotonic_ns() + time_ns;
    while time_ns > 0 && monotonic_ns() < end_ns {
        std::hint::spin_loop();
    }
}

/// With the daemon's own settings.
fn server_port(node: &Node<Variant>) -> Result<ServerPort, Error> {
    let service = requests(node, OF_ECHO)
        .max_servers(1)
        .max_clients(MAX_CLIENTS)
        .max_nodes(MAX_NODES)
        .max_active_requests_per_client(ACTIVE_REQUESTS_PER_CLIENT)
        .max_loaned_requests(ACTIVE_REQUESTS_PER_CLIENT)
        .max_response_buffer_size(RESPONSE_BUFFER)
        .max_borrowed_responses_per_pending_response(BORROWED_RESPONSES)
        .enable_safe_overflow_for_requests(false)
        .enable_safe_overflow_for_responses(true)
        .enable_fire_and_forget_requests(false)
        .create()
        .map_err(text)?;
    service
        .server_builder()
        .initial_max_slice_len(MAX_PAYLOAD)
        .allocation_strategy(AllocationStrategy::Static)
        .max_loaned_responses_per_request(1)
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        .create()
        .map_err(text)
}

/// Wakes the server.
fn listener(node: &Node<Variant>) -> Result<Listener<Variant>, Error> {
    let service = wake(node, services::WAKE_SERVER, OF_ECHO)
        .max_listeners(1)
        .max_notifiers(MAX_NODES)
        .max_nodes(MAX_NODES)
        .create()
        .map_err(text)?;
    service
        .listener_builder()
        .create()
        .map_err(text)
}

/// Wakes the one client that an answer is for.
struct Bell {
    notifier: Notifier<Variant>,
    keys: HashMap<u128, ListenerKey>,
}

impl Bell {
    fn new(node: &Node<Variant>) -> Result<Self, Error> {
        let service = wake(node, services::WAKE_CLIENT, OF_ECHO)
            .max_listeners(MAX_CLIENTS * LISTENERS_PER_CLIENT)
            .max_notifiers(1)
            .max_nodes(MAX_NODES)
            .create()
            .map_err(text)?;
        let notifier = service
            .notifier_builder()
            .create()
            .map_err(text)?;
        Ok(Self {
            notifier,
            keys: HashMap::new(),
        })
    }

    fn ring(&mut self, [low, high]: [u64; 2]) -> Result<(), Error> {
        let id = u128::from(low) | u128::from(high) << 64;
        if !self.keys.contains_key(&id) {
            self.look_up_all();
        }
        match self.keys.get(&id) {
            Some(key) => self
                .notifier
                .notify_single_listener(key)
                .map_err(text),
            // A client that is gone needs no waking.
            None => Ok(()),
        }
    }

    fn look_up_all(&mut self) {
        let keys = &mut self.keys;
        self.notifier.for_each_listener(|one, details| {
            keys.insert(details.listener_id.value(), one.listener_key());
            CallbackProgression::Continue
        });
    }
}
