//! Bare iceoryx2 with the service's own settings: an echo to compare with, and requests that no
//! library would send.
//!
//! One process answers, one asks; both wait for events, none polls.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use iceoryx2::config::Config;
use iceoryx2::node::{Node, NodeBuilder};
use iceoryx2::port::client::Client as Port;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::{
    AllocationStrategy, BackpressureStrategy, FileName, Path as IpcPath, SemanticString,
    ServiceName, SignalHandlingMode, ipc_threadsafe,
};
use iceoryx2::service::builder::{event, request_response};
use taut_ipc::limits::{
    ACTIVE_REQUESTS_PER_CLIENT, BORROWED_RESPONSES, LISTENERS_PER_CLIENT, MAX_CLIENTS, MAX_NODES,
    MAX_PAYLOAD, RESPONSE_BUFFER,
};
use taut_ipc::wire::{RequestHeader, ResponseHeader, Status};
use taut_ipc::{Instance, services};

use super::error::LoadError;
use crate::cli::error::CliError;
use crate::cli::own_daemon::{self, Folder};

type Variant = ipc_threadsafe::Service;
type Builder = request_response::Builder<[u8], RequestHeader, [u8], ResponseHeader, Variant>;

const NAME: &str = "echo";
const PATIENCE: Duration = Duration::from_secs(20);

fn text(error: impl std::fmt::Display) -> LoadError {
    LoadError::Bare(error.to_string())
}

fn node(instance: &Instance) -> Result<Node<Variant>, LoadError> {
    let mut config = Config::default();
    config.global.prefix =
        FileName::new(instance.prefix().as_bytes()).map_err(|error| text(format!("{error:?}")))?;
    let root = IpcPath::new(instance.root().as_os_str().as_encoded_bytes());
    config
        .global
        .set_root_path(&root.map_err(|error| text(format!("{error:?}")))?);
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    config.global.service.cleanup_dead_nodes_on_open = false;
    let builder = NodeBuilder::new()
        .config(&config)
        .signal_handling_mode(SignalHandlingMode::Disabled);
    builder.create::<Variant>().map_err(text)
}

fn name(service: &str) -> ServiceName {
    ServiceName::new(service).expect("a fixed, valid name")
}

fn requests(node: &Node<Variant>) -> Builder {
    node.service_builder(&name(services::OPTIMIZE))
        .request_response::<[u8], [u8]>()
        .request_user_header::<RequestHeader>()
        .response_user_header::<ResponseHeader>()
}

fn wake(node: &Node<Variant>, service: &str) -> event::Builder<Variant> {
    node.service_builder(&name(service)).event()
}

/// A client without the client library.
pub(super) struct Bare {
    port: Port<Variant, [u8], RequestHeader, [u8], ResponseHeader>,
    notifier: Notifier<Variant>,
    listener: Listener<Variant>,
    // Last: the ports are its.
    _node: Node<Variant>,
}

impl Bare {
    /// Opens the services of an instance.
    pub(super) fn open(instance: &Instance) -> Result<Self, LoadError> {
        let node = node(instance)?;
        let service = requests(&node).open().map_err(text)?;
        let builder = service.client_builder().initial_max_slice_len(MAX_PAYLOAD);
        let builder = builder.allocation_strategy(AllocationStrategy::Static);
        let port = builder
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(text)?;
        let server = wake(&node, services::WAKE_SERVER).open().map_err(text)?;
        let client = wake(&node, services::WAKE_CLIENT).open().map_err(text)?;
        let listener = client.listener_builder().create().map_err(text)?;
        Ok(Self {
            port,
            notifier: server.notifier_builder().create().map_err(text)?,
            listener,
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
    ) -> Result<Option<(ResponseHeader, usize)>, LoadError> {
        let id = self.listener.id().value();
        let loan = self.port.loan_slice_uninit(payload.len()).map_err(text)?;
        let mut request = loan.write_from_slice(payload);
        *request.user_header_mut() = RequestHeader {
            listener_id: [id as u64, (id >> 64) as u64],
            ..header
        };
        let pending = request.send().map_err(text)?;
        self.notifier.notify().map_err(text)?;
        let end = Instant::now() + patience;
        loop {
            while let Some(response) = pending.receive().map_err(text)? {
                if response.user_header().status == u32::from(Status::Final) {
                    return Ok(Some((*response.user_header(), response.payload().len())));
                }
            }
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(None);
            }
            self.listener.timed_wait(|_| (), left).map_err(text)?;
        }
    }
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
    pub(super) fn start() -> Result<Self, CliError> {
        let folder = Folder::create(NAME)?;
        let instance = Instance::new(NAME, folder.path().join("run"))?;
        let system = |source| LoadError::System {
            what: "echo process",
            source,
        };
        let mut command = own_daemon::this_program(&instance)?;
        let mut child = own_daemon::spawn({
            command
                .arg("load-echo")
                .stdin(Stdio::null())
                .stdout(Stdio::piped());
            command
        })?;
        let mut line = String::new();
        if let Some(out) = child.stdout.take() {
            BufReader::new(out).read_line(&mut line).map_err(system)?;
        }
        let mut echo = Self {
            child,
            client: None,
            _folder: folder,
        };
        echo.client = Some(Bare::open(&instance)?);
        Ok(echo)
    }

    /// One round trip.
    pub(super) fn round(&self, request: &[u8], response: usize) -> Result<Duration, LoadError> {
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

/// `taut load-echo`, hidden: answers until its parent is gone.
pub(in crate::cli) fn serve() -> Result<u8, CliError> {
    super::process::end_with_parent()?;
    let instance = Instance::from_environment()?;
    let node = node(&instance)?;
    let service = requests(&node)
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
    let builder = service.server_builder().initial_max_slice_len(MAX_PAYLOAD);
    let builder = builder
        .allocation_strategy(AllocationStrategy::Static)
        .max_loaned_responses_per_request(1);
    let port = builder
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        .create()
        .map_err(text)?;
    let server = wake(&node, services::WAKE_SERVER)
        .max_listeners(1)
        .max_notifiers(MAX_NODES)
        .max_nodes(MAX_NODES);
    let listener = server
        .create()
        .map_err(text)?
        .listener_builder()
        .create()
        .map_err(text)?;
    let client =
        wake(&node, services::WAKE_CLIENT).max_listeners(MAX_CLIENTS * LISTENERS_PER_CLIENT);
    let client = client
        .max_notifiers(1)
        .max_nodes(MAX_NODES)
        .create()
        .map_err(text)?;
    let notifier = client.notifier_builder().create().map_err(text)?;
    // A parent that is gone does not read.
    let _ = writeln!(std::io::stdout(), "ready");
    loop {
        listener.timed_wait(|_| (), PATIENCE).map_err(text)?;
        while let Some(request) = port.receive().map_err(text)? {
            let bytes = request.user_header().work_budget as usize;
            let mut copy = request.payload().to_vec();
            copy.resize(bytes, 0);
            let mut response = request.loan_slice_uninit(bytes).map_err(text)?;
            response.user_header_mut().status = Status::Final.into();
            response.write_from_slice(&copy).send().map_err(text)?;
            notifier.notify().map_err(text)?;
        }
    }
}
