//! Bare iceoryx2 with the service's own settings: an echo to compare with, and requests that no
//! library would send.
//!
//! One process answers, one asks; both wait for events, none polls.

use std::fmt::{Debug, Display};
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use iceoryx2::active_request::ActiveRequest;
use iceoryx2::config::Config;
use iceoryx2::node::{Node, NodeBuilder};
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::{client, server};
use iceoryx2::prelude::{
    AllocationStrategy, BackpressureStrategy, FileName, Path as IpcPath, SemanticString,
    ServiceName, SignalHandlingMode, ipc_threadsafe,
};
use iceoryx2::service::builder::{event, request_response};
use taut_ipc::limits::{
    ACTIVE_REQUESTS_PER_CLIENT, BORROWED_RESPONSES, LISTENERS_PER_CLIENT, MAX_CLIENTS, MAX_NODES,
    MAX_PAYLOAD, RESPONSE_BUFFER,
};
use taut_ipc::own_daemon::{Folder, spawn};
use taut_ipc::wire::{RequestHeader, ResponseHeader, Status};
use taut_ipc::{DaemonState, Instance, daemon_state, services};

use super::process::end_with_parent;
use crate::error::Error;
use crate::program;

type Variant = ipc_threadsafe::Service;
type Builder = request_response::Builder<[u8], RequestHeader, [u8], ResponseHeader, Variant>;

const NAME: &str = "echo";
const PATIENCE: Duration = Duration::from_secs(20);

fn text(error: impl Display) -> Error {
    Error::Bare(error.to_string())
}

fn unsaid(error: impl Debug) -> Error {
    Error::Bare(format!("{error:?}"))
}

fn node(instance: &Instance) -> Result<Node<Variant>, Error> {
    let builder = NodeBuilder::new()
        .config(&config(instance)?)
        .signal_handling_mode(SignalHandlingMode::Disabled);
    builder.create::<Variant>().map_err(text)
}

/// Names in shared memory and folders of the instance; nobody cleans up after others.
fn config(instance: &Instance) -> Result<Config, Error> {
    let root = instance.root().as_os_str().as_encoded_bytes();
    let mut config = Config::default();
    let global = &mut config.global;
    global.prefix = FileName::new(instance.prefix().as_bytes()).map_err(unsaid)?;
    global.set_root_path(&IpcPath::new(root).map_err(unsaid)?);
    global.node.cleanup_dead_nodes_on_creation = false;
    global.node.cleanup_dead_nodes_on_destruction = false;
    global.service.cleanup_dead_nodes_on_open = false;
    Ok(config)
}

/// Generation of the services of an echo, which has no lock file to tell it in.
const OF_ECHO: u64 = 0;

/// Generation of the services of an instance.
fn generation(instance: &Instance) -> Result<u64, Error> {
    match daemon_state(instance)? {
        DaemonState::Running { generation, .. } => Ok(generation),
        DaemonState::Starting | DaemonState::Absent => Ok(OF_ECHO),
    }
}

fn name(service: &str, generation: u64) -> ServiceName {
    let name = services::name(service, generation);
    ServiceName::new(&name).expect("a fixed, valid name")
}

fn requests(node: &Node<Variant>, generation: u64) -> Builder {
    node.service_builder(&name(services::OPTIMIZE, generation))
        .request_response::<[u8], [u8]>()
        .request_user_header::<RequestHeader>()
        .response_user_header::<ResponseHeader>()
}

fn wake(node: &Node<Variant>, service: &str, generation: u64) -> event::Builder<Variant> {
    node.service_builder(&name(service, generation))
        .event()
}

type ClientPort = client::Client<Variant, [u8], RequestHeader, [u8], ResponseHeader>;
type ServerPort = server::Server<Variant, [u8], RequestHeader, [u8], ResponseHeader>;

/// A client without the client library.
pub(super) struct Bare {
    port: ClientPort,
    notifier: Notifier<Variant>,
    listener: Listener<Variant>,
    // Last: the ports are its.
    _node: Node<Variant>,
}

impl Bare {
    /// Opens the services of an instance.
    pub(super) fn open(instance: &Instance) -> Result<Self, Error> {
        let node = node(instance)?;
        let generation = generation(instance)?;
        let server = wake(&node, services::WAKE_SERVER, generation)
            .open()
            .map_err(text)?;
        let client = wake(&node, services::WAKE_CLIENT, generation)
            .open()
            .map_err(text)?;
        Ok(Self {
            port: client_port(&node, generation)?,
            notifier: server
                .notifier_builder()
                .create()
                .map_err(text)?,
            listener: client
                .listener_builder()
                .create()
                .map_err(text)?,
            _node: node,
        })
    }

    /// Sends these bytes under this header and waits for the final response: its header and its
    /// bytes. `None` if none comes in time.
    pub(super) fn exchange(
        &self,
        header: RequestHeader,
        payload: &[u8],
        patience: Duration,
    ) -> Result<Option<(ResponseHeader, usize)>, Error> {
        let pending = self.send(header, payload)?;
        let end = Instant::now() + patience;
        loop {
            if let Some(last) = last(&pending)? {
                return Ok(Some(last));
            }
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(None);
            }
            self.listener
                .timed_wait(|_| (), left)
                .map_err(text)?;
        }
    }

    fn send(&self, header: RequestHeader, payload: &[u8]) -> Result<Pending, Error> {
        let id = self.listener.id().value();
        let loan = self
            .port
            .loan_slice_uninit(payload.len())
            .map_err(text)?;
        let mut request = loan.write_from_slice(payload);
        *request.user_header_mut() = RequestHeader {
            listener_id: [id as u64, (id >> 64) as u64],
            ..header
        };
        let pending = request.send().map_err(text)?;
        self.notifier.notify().map_err(text)?;
        Ok(pending)
    }
}

type Pending = PendingResponse<Variant, [u8], RequestHeader, [u8], ResponseHeader>;
type Active = ActiveRequest<Variant, [u8], RequestHeader, [u8], ResponseHeader>;

fn client_port(node: &Node<Variant>, generation: u64) -> Result<ClientPort, Error> {
    let service = requests(node, generation)
        .open()
        .map_err(text)?;
    service
        .client_builder()
        .initial_max_slice_len(MAX_PAYLOAD)
        .allocation_strategy(AllocationStrategy::Static)
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        .create()
        .map_err(text)
}

/// The final response, where it has come: its header and its bytes.
fn last(pending: &Pending) -> Result<Option<(ResponseHeader, usize)>, Error> {
    while let Some(response) = pending.receive().map_err(text)? {
        let header = *response.user_header();
        if header.status == u32::from(Status::Final) {
            return Ok(Some((header, response.payload().len())));
        }
    }
    Ok(None)
}

/// The echo: another process that sends back as many bytes as the header's work budget says.
pub(super) struct Echo {
    child: Child,
    client: Option<Bare>,
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
            client: None,
            _folder: folder,
        };
        echo.wait_until_up()?;
        echo.client = Some(Bare::open(&instance)?);
        Ok(echo)
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

    /// One round trip.
    pub(super) fn round(&self, request: &[u8], response: usize) -> Result<Duration, Error> {
        let client = self
            .client
            .as_ref()
            .expect("there from the start to the drop");
        let header = RequestHeader {
            work_budget: response as u64,
            ..RequestHeader::default()
        };
        let start = Instant::now();
        match client.exchange(header, request, PATIENCE)? {
            Some((_, bytes)) if bytes == response => Ok(start.elapsed()),
            _ => Err(text("the echo does not answer as it was asked to")),
        }
    }
}

impl Drop for Echo {
    fn drop(&mut self) {
        drop(self.client.take());
        let _ = self.child.kill();
        let _ = self.child.wait();
        if let Ok(instance) = Instance::new(NAME, self._folder.path().join("run")) {
            for file in taut_ipc::memory::shared_files(&instance) {
                let _ = std::fs::remove_file(file.path);
            }
        }
    }
}

/// `taut-bench load-echo`, hidden: answers until its parent is gone.
pub(crate) fn serve() -> Result<u8, Error> {
    end_with_parent()?;
    let node = node(&Instance::from_environment()?)?;
    let port = server_port(&node)?;
    let listener = listener(&node)?;
    let notifier = notifier(&node)?;
    // A parent that is gone does not read.
    let _ = writeln!(std::io::stdout(), "ready");
    loop {
        listener
            .timed_wait(|_| (), PATIENCE)
            .map_err(text)?;
        while let Some(request) = port.receive().map_err(text)? {
            send_back(&request)?;
            notifier.notify().map_err(text)?;
        }
    }
}

fn send_back(request: &Active) -> Result<(), Error> {
    let bytes = request.user_header().work_budget as usize;
    let mut copy = request.payload().to_vec();
    copy.resize(bytes, 0);
    let mut response = request.loan_slice_uninit(bytes).map_err(text)?;
    response.user_header_mut().status = Status::Final.into();
    response
        .write_from_slice(&copy)
        .send()
        .map_err(text)
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

/// Wakes the clients.
fn notifier(node: &Node<Variant>) -> Result<Notifier<Variant>, Error> {
    let service = wake(node, services::WAKE_CLIENT, OF_ECHO)
        .max_listeners(MAX_CLIENTS * LISTENERS_PER_CLIENT)
        .max_notifiers(1)
        .max_nodes(MAX_NODES)
        .create()
        .map_err(text)?;
    service
        .notifier_builder()
        .create()
        .map_err(text)
}
