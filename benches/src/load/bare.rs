//! Bare iceoryx2 with the service's own settings: a client for what no library would send, and the
//! services that it opens.

use std::fmt::{Debug, Display};
use std::time::{Duration, Instant};

use iceoryx2::config::Config;
use iceoryx2::node::{Node, NodeBuilder};
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::{
    AllocationStrategy, BackpressureStrategy, FileName, Path as IpcPath, SemanticString,
    ServiceName, SignalHandlingMode, ipc_threadsafe,
};
use iceoryx2::service::builder::{event, request_response};
use taut_ipc::limits::MAX_PAYLOAD;
use taut_ipc::wire::{RequestHeader, ResponseHeader, Status};
use taut_ipc::{DaemonState, Instance, daemon_state, services};

use crate::error::Error;

pub(super) type Variant = ipc_threadsafe::Service;
pub(super) type Builder =
    request_response::Builder<[u8], RequestHeader, [u8], ResponseHeader, Variant>;

/// What iceoryx2 says.
pub(super) fn text(error: impl Display) -> Error {
    Error::Bare(error.to_string())
}

fn unsaid(error: impl Debug) -> Error {
    Error::Bare(format!("{error:?}"))
}

/// A node of this instance, with the service's own settings.
pub(super) fn node(instance: &Instance) -> Result<Node<Variant>, Error> {
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
pub(super) const OF_ECHO: u64 = 0;

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

/// The service that requests go to.
pub(super) fn requests(node: &Node<Variant>, generation: u64) -> Builder {
    node.service_builder(&name(services::OPTIMIZE, generation))
        .request_response::<[u8], [u8]>()
        .request_user_header::<RequestHeader>()
        .response_user_header::<ResponseHeader>()
}

/// A service of this name that wakes somebody.
pub(super) fn wake(
    node: &Node<Variant>,
    service: &str,
    generation: u64,
) -> event::Builder<Variant> {
    node.service_builder(&name(service, generation))
        .event()
}

type ClientPort = client::Client<Variant, [u8], RequestHeader, [u8], ResponseHeader>;

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
